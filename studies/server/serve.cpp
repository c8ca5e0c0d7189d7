#include "studies/server/serve.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <regex>
#include <set>
#include <thread>

#include "core/error.h"
#include "core/progress.h"
#include "store/answer_store.h"
#include "studies/server/http_server.h"
#include "studies/server/study_folder.h"
#include "studies/server/study_service.h"

namespace crowdbench::studies {
namespace {

std::string now_utc() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(now));
}

bool is_loopback(const std::string& address) {
  return address == "localhost" || address == "::1" || address.starts_with("127.");
}

void require_origin(const std::string& origin) {
  static const std::regex shape(R"(https?://([A-Za-z0-9.\-]+|\[[0-9a-fA-F:]+\])(:[0-9]{1,5})?)");
  if (!std::regex_match(origin, shape))
    throw Error("--origin", fmt::format("'{}' is not an origin", printable(origin, 100)),
                "say https://HOST or https://HOST:PORT, without a path");
}

std::string with_port(const std::string& address, int port) {
  return fmt::format("{}:{}", address.find(':') != std::string::npos ? "[" + address + "]" : address, port);
}

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return text;
}

// As browsers say it: small letters, and the scheme's own port left out. Both forms, as what stands between may say it.
void add_origin(ServedNames& to, const std::string& origin) {
  const std::string small = lower_case(origin);
  const std::string own = small.starts_with("https:") ? ":443" : ":80";
  for (const std::string& each : {small, small.ends_with(own) ? small.substr(0, small.size() - own.size()) : small}) {
    to.hosts.insert(each.substr(each.find("//") + 2));
    to.origins.insert(each);
  }
}

}  // namespace

ServedNames served_names(const ServeSettings& settings, int port) {
  ServedNames out;
  std::set<std::string> addresses = {settings.address};
  if (is_loopback(settings.address)) addresses.insert({"localhost", "127.0.0.1", "::1"});
  for (const std::string& each : addresses) add_origin(out, "http://" + with_port(each, port));
  if (settings.origin) add_origin(out, *settings.origin);
  return out;
}

void serve_study(const ServeSettings& settings, const std::function<void(const std::string& url)>& ready) {
  if (settings.origin) require_origin(*settings.origin);
  if (!settings.origin && !is_loopback(settings.address))
    throw Error(
        "--address", fmt::format("{} is reached from other machines", printable(settings.address, 80)),
        "say with --origin under which address participants open the page, or serve on 127.0.0.1 behind a proxy");
  const StudyFolder folder = read_study_folder(settings.out);
  AnswerStore store(settings.answers);
  std::unique_ptr<StudyService> service;  // made when the port is known, before anything is answered
  HttpServer server(settings.address, settings.port, kMostRecordBytes,
                    {[&](const HttpRequest& request) { return service->refuse(request); },
                     [&](const HttpRequest& request) { return service->handle(request); }});
  const ServedNames names = served_names(settings, server.port());
  service = std::make_unique<StudyService>(folder, store, names.hosts, names.origins, &now_utc);
  say_when_interrupted(fmt::format("every answer that was acknowledged is in {}", settings.answers.string()));
  // It listens: who comes from here on waits until it serves.
  ready(settings.origin.value_or("http://" + with_port(settings.address, server.port())) + "/");
  std::exception_ptr failed;
  std::atomic<bool> ended{false};
  std::thread serving([&] {
    try {
      server.serve();
    } catch (...) {
      failed = std::current_exception();
    }
    ended = true;
  });
  while (!interrupted() && !ended) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  server.stop();
  serving.join();
  if (failed) std::rethrow_exception(failed);
  if (!interrupted())
    throw Error(with_port(settings.address, server.port()), "stopped listening",
                "start it again: every answer that was acknowledged is kept");
  throw Interrupted{};
}

}  // namespace crowdbench::studies
