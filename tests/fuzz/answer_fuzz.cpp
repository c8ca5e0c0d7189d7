// Whatever a browser posts, a study's server answers with a status and one JSON object, and keeps what it acknowledged.
// The first byte chooses the request.
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/json.h"
#include "studies/server/study_service.h"
#include "tests/fuzz/fuzz_check.h"

namespace {

using namespace crowdbench;
using namespace crowdbench::studies;

StudyFolder folder() {
  StudyFolder out;
  out.study = std::string(64, 'a');
  out.task = "2afc";
  out.answers = {"top", "bottom"};
  out.lists = {"l1"};
  out.trials["l1"]["t001"] = {"t001", "s001", "main", 1};
  out.trials["l1"]["t002"] = {"t002", "s001", "catch", 1};
  return out;
}

struct Server {
  std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("crowdbench-fuzz-answers-" + std::to_string(getpid()) + ".sqlite");
  StudyFolder study = folder();
  AnswerStore store{file};
  StudyService service{study, store, {"127.0.0.1:1"}, {}, [] { return std::string("2026-01-01T00:00:00Z"); }};
  std::string token;

  Server() { start(); }
  ~Server() { std::filesystem::remove(file); }
  void start() {
    const HttpReply reply =
        post("/api/start", R"({"study": ")" + study.study + R"(", "participant": ")" + std::string(64, 'b') + R"("})");
    if (reply.status != 200) std::abort();
    token = Json::parse(reply.body).at("token").text();
  }
  HttpReply post(std::string_view path, std::string_view body) {
    HttpRequest request;
    request.method = "POST";
    request.path = path;
    request.host = "127.0.0.1:1";
    request.content_type = "application/json";
    request.token = token;
    request.announced = body.size();
    request.body = body;
    if (const auto refused = service.refuse(request)) return *refused;
    return service.handle(request);
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static Server server;
  if (size == 0) return 0;
  constexpr std::array kPaths{"/api/answer", "/api/answer", "/api/answer", "/api/start"};
  const HttpReply reply =
      server.post(kPaths[data[0] % kPaths.size()], {reinterpret_cast<const char*>(data) + 1, size - 1});
  if (reply.status < 200 || reply.status > 499 || reply.status == 404) std::abort();
  Json::parse(reply.body);
  if (reply.status == 200 && data[0] % kPaths.size() == 3) server.start();  // another window took over
  return 0;
}
