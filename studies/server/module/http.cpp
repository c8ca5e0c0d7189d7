// cpp-httplib behind the interface of http_api.h. The one source that includes it.
#include <httplib.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "studies/server/module/byte_range.h"
#include "studies/server/module/connection.h"
#include "studies/server/module/http_api.h"

namespace crowdbench::studies::http {
namespace {

// The library's own connections wait for each piece of a request anew, and take header fields without end.
class BoundedStream : public httplib::Stream {
 public:
  BoundedStream(int socket, const ConnectionLimits& limits) : connection_(socket, limits) {}
  bool is_readable() const override { return connection_.is_readable(); }
  bool is_writable() const override { return connection_.is_writable(); }
  ssize_t read(char* to, size_t size) override { return connection_.read(to, size); }
  ssize_t write(const char* from, size_t size) override { return connection_.write(from, size); }
  void get_remote_ip_and_port(std::string& ip, int& port) const override {
    name_of(connection_.socket(), false, ip, port);
  }
  void get_local_ip_and_port(std::string& ip, int& port) const override {
    name_of(connection_.socket(), true, ip, port);
  }
  socket_t socket() const override { return connection_.socket(); }

 private:
  Connection connection_;
};

// One request a connection: nothing that is left of a refused body is ever read as a request, and no idle browser holds
// a thread.
class BoundedServer : public httplib::Server {
 public:
  ConnectionLimits limits;

 private:
  bool process_and_close_socket(socket_t socket) override {
    BoundedStream stream(socket, limits);
    bool closed = false;
    // Ranges are ours (send()): the library's may lie outside of the file.
    const bool answered = process_request(stream, true, closed, [](httplib::Request& r) { r.ranges.clear(); });
    ::shutdown(socket, SHUT_RDWR);
    ::close(socket);
    return answered;
  }
};

}  // namespace

struct Server {
  BoundedServer server;
  Settings settings;
  std::atomic<bool> ended{false};  // serve() has returned
  int socket = -1;                 // that was bound last
};

namespace {

uint64_t announced(const httplib::Request& request) {
  const std::string text = request.get_header_value("Content-Length");
  if (text.empty()) return 0;
  char* end = nullptr;
  errno = 0;
  const uint64_t value = std::strtoull(text.c_str(), &end, 10);
  // What is not a length is refused as one that is too long.
  return *end == '\0' && errno == 0 && text[0] != '-' ? value : UINT64_MAX;
}

// The header fields outlive what points at them.
struct Fields {
  std::string host, origin, site, type, encoding, token;
  explicit Fields(const httplib::Request& r)
      : host(r.get_header_value("Host")),
        origin(r.get_header_value("Origin")),
        site(r.get_header_value("Sec-Fetch-Site")),
        type(r.get_header_value("Content-Type")),
        encoding(r.get_header_value("Transfer-Encoding")),
        token(r.get_header_value("X-Study-Token")) {}
  Request request(const httplib::Request& r, bool with_body) const {
    // A path that holds NUL names nothing; as a C string it would name its beginning.
    const char* const path = r.path.find('\0') == std::string::npos ? r.path.c_str() : "";
    return {r.method.c_str(),
            path,
            host.c_str(),
            origin.c_str(),
            site.c_str(),
            type.c_str(),
            encoding.c_str(),
            token.c_str(),
            announced(r),
            with_body ? r.body.data() : nullptr,
            with_body ? r.body.size() : 0};
  }
};

// Reads up to 1 MiB of the file for each call, so that a clip never lies in memory as a whole.
bool send_part(const std::string& path, size_t offset, size_t length, httplib::DataSink& sink) {
  const std::unique_ptr<FILE, int (*)(FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file || std::fseek(file.get(), static_cast<long>(offset), SEEK_SET) != 0) return false;
  char buffer[1 << 16];
  size_t left = std::min(length, size_t{1} << 20);
  while (left > 0) {
    const size_t got = std::fread(buffer, 1, std::min(left, sizeof buffer), file.get());
    if (got == 0 || !sink.write(buffer, got)) return false;
    left -= got;
  }
  return true;
}

// A file, or the part of it that the field Range asks for.
void send_file(const Reply& reply, const std::string& wanted, httplib::Response& response) {
  response.set_header("Accept-Ranges", "bytes");
  ByteRange part{0, reply.file_bytes};
  if (!wanted.empty()) {
    const std::optional<ByteRange> found = byte_range(wanted, reply.file_bytes);
    response.status = found ? 206 : 416;
    response.set_header("Content-Range", found ? "bytes " + std::to_string(found->offset) + "-" +
                                                     std::to_string(found->offset + found->length - 1) + "/" +
                                                     std::to_string(reply.file_bytes)
                                               : "bytes */" + std::to_string(reply.file_bytes));
    if (!found) return;
    part = *found;
  }
  response.set_content_provider(
      part.length, reply.content_type,
      [path = std::string(reply.file), begin = part.offset](size_t offset, size_t length, httplib::DataSink& sink) {
        return send_part(path, begin + offset, length, sink);
      });
}

void send(const Reply& reply, const httplib::Request& request, httplib::Response& response) {
  if (reply.status != 200) response.status = reply.status;
  response.set_header("X-Content-Type-Options", "nosniff");
  response.set_header("Referrer-Policy", "no-referrer");
  response.set_header("X-Frame-Options", "DENY");
  response.set_header("Cross-Origin-Resource-Policy", "same-origin");
  response.set_header("Cache-Control", reply.keep != 0 ? "private, max-age=86400" : "no-store");
  if (reply.file != nullptr)
    send_file(reply, request.get_header_value("Range"), response);
  else
    response.set_content(reply.body, reply.body_bytes, reply.content_type);
}

void answer(const Server& of, const httplib::Request& request, httplib::Response& response) {
  Reply reply{};
  const Fields fields(request);
  const Request seen = fields.request(request, true);
  of.settings.handle(of.settings.user, &seen, &reply);
  send(reply, request, response);
  of.settings.release(&reply);
}

bool refused(const Server& of, const httplib::Request& request, httplib::Response& response) {
  Reply reply{};
  const Fields fields(request);
  const Request seen = fields.request(request, false);
  if (of.settings.refuse(of.settings.user, &seen, &reply) == 0) return false;
  send(reply, request, response);
  of.settings.release(&reply);
  return true;
}

void set_up(Server& made) {
  httplib::Server& server = made.server;
  const int threads = made.settings.threads;
  server.new_task_queue = [threads] { return new httplib::ThreadPool(static_cast<size_t>(threads)); };
  // Browsers send some 2 KiB of header fields.
  constexpr size_t kMostHeadBytes = 32 << 10;
  made.server.limits.most_received = kMostHeadBytes + made.settings.most_body_bytes;
  server.set_payload_max_length(made.settings.most_body_bytes);
  server.set_tcp_nodelay(true);
  // Not SO_REUSEPORT, by which two servers would share one port in silence.
  server.set_socket_options([&made](int socket) {
    made.socket = socket;
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  server.set_pre_routing_handler([&made](const httplib::Request& request, httplib::Response& response) {
    return refused(made, request, response) ? httplib::Server::HandlerResponse::Handled
                                            : httplib::Server::HandlerResponse::Unhandled;
  });
  const auto handler = [&made](const httplib::Request& request, httplib::Response& response) {
    answer(made, request, response);
  };
  server.Get(".*", handler);
  server.Post(".*", handler);
}

Server* open(const Settings* settings, int32_t* port, char* message) {
  auto made = std::make_unique<Server>();
  made->settings = *settings;
  set_up(*made);
  errno = 0;
  const int got = settings->port == 0 ? made->server.bind_to_any_port(settings->address)
                  : made->server.bind_to_port(settings->address, settings->port) ? settings->port
                                                                                 : -1;
  if (got <= 0) {
    std::snprintf(message, kMessageBytes, "%s", errno != 0 ? std::strerror(errno) : "the address cannot be resolved");
    return nullptr;
  }
  // The library lets five connections wait. The sixth of browsers that come at once is dropped and tried again by its
  // system a second later.
  constexpr int kWaiting = 128;
  listen(made->socket, kWaiting);
  *port = got;
  return made.release();
}

void serve(Server* server) {
  server->server.listen_after_bind();
  server->ended = true;
}

// The library takes no notice of a stop before it listens.
void stop(Server* server) {
  while (!server->server.is_running() && !server->ended) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  server->server.stop();
}

const Api kApi = {kApiVersion, &open, &serve, &stop, [](Server* server) { delete server; }};

}  // namespace
}  // namespace crowdbench::studies::http

extern "C" __attribute__((visibility("default"))) const crowdbench::studies::http::Api* crowdbench_http_api() {
  return &crowdbench::studies::http::kApi;
}
