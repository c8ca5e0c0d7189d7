// `crowdbench study serve`: an exported study, shown to participants, whose answers are kept.
#pragma once
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>

namespace crowdbench::studies {

struct ServeSettings {
  std::filesystem::path out;      // what `study export` made
  std::filesystem::path answers;  // result store; made where it does not exist
  std::string address = "127.0.0.1";
  int port = 8000;  // 0: a free one
  // Under which participants reach it, "https://study.example.org": needed where that is not the address and port
  // above, that is, behind a proxy and beyond this machine.
  std::optional<std::string> origin;
};

// What a browser that shows the study says as Host and as Origin, in small letters; with the scheme's own port (80,
// 443) also without it, as browsers say it. port: that is listened on.
struct ServedNames {
  std::set<std::string> hosts, origins;
};
ServedNames served_names(const ServeSettings& settings, int port);

// Serves until Ctrl-C or SIGTERM, then throws Interrupted. ready: told the URL once it listens. Throws Error: no
// exported study, answers that cannot be kept, an address that cannot be listened on, an address beyond this machine
// without an origin, a socket that stopped listening.
void serve_study(const ServeSettings& settings, const std::function<void(const std::string& url)>& ready);

}  // namespace crowdbench::studies
