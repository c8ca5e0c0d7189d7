// The interface of crowdbench_http.so, which brings cpp-httplib and with it OpenSSL: plain functions and structs, so
// that neither reaches a header of this project and nothing of C++ crosses the border. studies/server/http_server.h is
// what to use.
#pragma once
#include <cstdint>

namespace crowdbench::studies::http {

inline constexpr uint32_t kApiVersion = 1;
inline constexpr int kMessageBytes = 256;

// Texts end in NUL and live as long as the call; a header that was not sent is empty.
struct Request {
  const char* method;
  const char* path;  // decoded, without the query
  const char* host;
  const char* origin;
  const char* fetch_site;  // Sec-Fetch-Site
  const char* content_type;
  const char* transfer_encoding;
  const char* token;   // X-Study-Token
  uint64_t announced;  // Content-Length; 0 where there is none
  const char* body;    // null before it was read
  uint64_t body_bytes;
};

// What the owner answers; the module has copied or streamed it before it calls `release`.
struct Reply {
  int32_t status;
  const char* content_type;
  const char* body;
  uint64_t body_bytes;
  const char* file;  // streamed, with ranges, in place of the body; null: none
  uint64_t file_bytes;
  int32_t keep;  // browsers may keep it (a clip); otherwise never
  void* owner;   // of the texts; the module does not look at it
};

struct Settings {
  const char* address;
  int32_t port;  // 0: a free one
  int32_t threads;
  uint64_t most_body_bytes;  // more is refused with 413
  void* user;
  // Called from several threads; none may throw. refuse: before the body is read; nonzero: `reply` is the answer.
  int32_t (*refuse)(void* user, const Request* request, Reply* reply);
  void (*handle)(void* user, const Request* request, Reply* reply);
  void (*release)(Reply* reply);
};

struct Server;

struct Api {
  uint32_t version;
  // Listens, and says on which port; null on failure, with a one-line reason in `message` (kMessageBytes long).
  Server* (*open)(const Settings* settings, int32_t* port, char* message);
  void (*serve)(Server* server);  // until stop() is called, from another thread; then waits for what is being answered
  void (*stop)(Server* server);   // waits until serve(), which another thread calls, listens or has ended
  void (*close)(Server* server);
};

inline constexpr const char* kApiSymbol = "crowdbench_http_api";
using ApiFunction = const Api* (*)();

}  // namespace crowdbench::studies::http
