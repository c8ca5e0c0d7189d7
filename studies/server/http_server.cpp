#include "studies/server/http_server.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/module.h"
#include "studies/server/module/http_api.h"

namespace crowdbench::studies {
namespace {

// Each waits most of its time, for the disk or for who says nothing: connections that were opened and left half said
// hold one until the module's time is up, and those of whom there are fewer than threads delay nobody.
constexpr int kThreads = 256;

const http::Api& api() {
  static const http::Api& loaded = [&]() -> const http::Api& {
    const auto function =
        reinterpret_cast<http::ApiFunction>(module_symbol("http", http::kApiSymbol, "serving a study"));
    const http::Api* found = function();
    if (found->version != http::kApiVersion)
      throw Error("crowdbench_http.so", "is of another version than the program", "rebuild with ./run build");
    return *found;
  }();
  return loaded;
}

HttpRequest seen(const http::Request& r) {
  return {r.method,
          r.path,
          r.host,
          r.origin,
          r.fetch_site,
          r.content_type,
          r.transfer_encoding,
          r.token,
          r.announced,
          r.body != nullptr ? std::string_view(r.body, r.body_bytes) : std::string_view()};
}

// The module reads the texts until it calls release().
void hand_over(HttpReply reply, http::Reply& to) {
  auto* owner = new HttpReply(std::move(reply));
  to.owner = owner;
  to.status = owner->status;
  to.content_type = owner->content_type.c_str();
  to.body = owner->body.data();
  to.body_bytes = owner->body.size();
  to.file = owner->file ? owner->file->c_str() : nullptr;
  to.file_bytes = owner->file_bytes;
  to.keep = owner->keep ? 1 : 0;
}

HttpReply broken() { return {.status = 500, .body = "{\"error\":\"the server cannot keep this now\"}\n"}; }

int32_t refuse(void* user, const http::Request* request, http::Reply* reply) {
  const auto& handlers = *static_cast<const HttpHandlers*>(user);
  try {
    std::optional<HttpReply> refusal = handlers.refuse(seen(*request));
    if (!refusal) return 0;
    hand_over(std::move(*refusal), *reply);
  } catch (const std::exception&) {
    hand_over(broken(), *reply);
  }
  return 1;
}

void handle(void* user, const http::Request* request, http::Reply* reply) {
  const auto& handlers = *static_cast<const HttpHandlers*>(user);
  try {
    hand_over(handlers.handle(seen(*request)), *reply);
  } catch (const std::exception&) {
    hand_over(broken(), *reply);
  }
}

void release(http::Reply* reply) { delete static_cast<HttpReply*>(reply->owner); }

}  // namespace

struct HttpServer::State {
  HttpHandlers handlers;
  http::Server* server = nullptr;
  int32_t port = 0;
};

HttpServer::HttpServer(const std::string& address, int port, size_t most_body_bytes, HttpHandlers handlers)
    : state_(new State{std::move(handlers)}) {
  const http::Settings settings = {.address = address.c_str(),
                                   .port = port,
                                   .threads = kThreads,
                                   .most_body_bytes = most_body_bytes,
                                   .user = &state_->handlers,
                                   .refuse = &refuse,
                                   .handle = &handle,
                                   .release = &release};
  char message[http::kMessageBytes] = {};
  state_->server = api().open(&settings, &state_->port, message);
  if (state_->server == nullptr)
    throw Error(fmt::format("{}:{}", printable(address, 80), port), fmt::format("cannot be listened on ({})", message),
                "choose another --port (0: a free one) or --address");
}

HttpServer::~HttpServer() {
  if (state_->server != nullptr) api().close(state_->server);
}

int HttpServer::port() const { return state_->port; }
void HttpServer::serve() { api().serve(state_->server); }
void HttpServer::stop() { api().stop(state_->server); }

}  // namespace crowdbench::studies
