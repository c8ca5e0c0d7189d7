// One HTTP request over a socket of its own, byte for byte as the test wants it.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

namespace crowdbench::support {

struct HttpAnswer {
  int status = 0;  // 0: no connection, or no answer
  std::string head, body;
};

// A connection to 127.0.0.1:port that stays open until it is destroyed.
class OpenConnection {
 public:
  OpenConnection() = default;
  OpenConnection(const OpenConnection&) = delete;
  OpenConnection& operator=(const OpenConnection&) = delete;
  ~OpenConnection() {
    if (socket_ >= 0) ::close(socket_);
  }
  // Sends `bytes` and reads nothing. False: there is no connection.
  bool open(int port, const std::string& bytes) {
    socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return ::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0 &&
           ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
  }

 private:
  int socket_ = -1;
};

// Sends `bytes` to 127.0.0.1:port and reads until the other side closes.
inline HttpAnswer http_bytes(int port, const std::string& bytes) {
  HttpAnswer answer;
  const int socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<uint16_t>(port));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const timeval patience{10, 0};
  setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  std::string got;
  if (::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0) {
    size_t sent = 0;
    while (sent < bytes.size()) {
      const ssize_t n = ::send(socket_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
      if (n <= 0) break;
      sent += static_cast<size_t>(n);
    }
    char buffer[4096];
    for (ssize_t n = 0; (n = ::recv(socket_, buffer, sizeof buffer, 0)) > 0;)
      got.append(buffer, static_cast<size_t>(n));
  }
  ::close(socket_);
  const size_t end = got.find("\r\n\r\n");
  if (got.rfind("HTTP/1.1 ", 0) == 0 && end != std::string::npos) {
    answer.status = std::stoi(got.substr(9, 3));
    answer.head = got.substr(0, end);
    answer.body = got.substr(end + 4);
  }
  return answer;
}

// headers: whole lines, each with its "\r\n". Where they name no host it is 127.0.0.1:port.
inline HttpAnswer http_request(int port, const std::string& method, const std::string& path,
                               const std::string& headers = "", const std::string& body = "") {
  std::string all = method + " " + path + " HTTP/1.1\r\n" + headers;
  if (headers.find("Host:") == std::string::npos) all += "Host: 127.0.0.1:" + std::to_string(port) + "\r\n";
  if (!body.empty() && headers.find("Content-Length:") == std::string::npos)
    all += "Content-Length: " + std::to_string(body.size()) + "\r\n";
  return http_bytes(port, all + "\r\n" + body);
}

inline HttpAnswer http_post(int port, const std::string& path, const std::string& body, const std::string& token = "",
                            const std::string& headers = "") {
  return http_request(
      port, "POST", path,
      "Content-Type: application/json\r\n" + (token.empty() ? "" : "X-Study-Token: " + token + "\r\n") + headers, body);
}

}  // namespace crowdbench::support
