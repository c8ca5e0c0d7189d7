// An HTTP/1.1 server: one function answers what browsers ask. Without TLS: beyond this machine a proxy does that.
//
// cpp-httplib comes as a module at first use (core/module.h). One request a connection.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace crowdbench::studies {

struct HttpRequest {
  std::string_view method;  // "GET", "HEAD", "POST", ...
  std::string_view path;    // decoded, begins with '/', without the query, which is never looked at
  // Header fields; empty where they were not sent.
  std::string_view host, origin, fetch_site, content_type, transfer_encoding, token;
  uint64_t announced = 0;  // Content-Length
  std::string_view body;
};

struct HttpReply {
  int status = 200;
  std::string content_type = "application/json";
  std::string body;
  std::optional<std::filesystem::path> file;  // sent in place of the body, with ranges
  uint64_t file_bytes = 0;
  bool keep = false;  // browsers may keep it for a day; otherwise they may not
};

struct HttpHandlers {
  // Before the body is read: an answer that refuses the request, or nothing. Both are called from several threads.
  std::function<std::optional<HttpReply>(const HttpRequest&)> refuse;
  // GET, HEAD and POST. What it throws becomes status 500, without the reason.
  std::function<HttpReply(const HttpRequest&)> handle;
};

class HttpServer {
 public:
  // Listens on a name or number of an address; port 0: a free one. A longer body than most_body_bytes is answered with
  // 413. Throws Error: the address is taken or is none of this machine's.
  HttpServer(const std::string& address, int port, size_t most_body_bytes, HttpHandlers handlers);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  int port() const;
  void serve();  // until stop()
  void stop();   // from another thread than the one that calls serve(), for which it waits

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace crowdbench::studies
