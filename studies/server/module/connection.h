// One connection of the server, with bounds on what it may take: a client that says little at a time, without end, or
// that does not take its answer, holds a thread for seconds and no longer. POSIX sockets alone.
#pragma once
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/types.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string>

namespace crowdbench::studies::http {

struct ConnectionLimits {
  size_t most_received = 0;                      // bytes of the whole request: line, header fields and body
  std::chrono::milliseconds pause{4000};         // between two pieces of a request
  std::chrono::milliseconds request{10000};      // of the whole request, from the connection's construction
  std::chrono::milliseconds write_pause{30000};  // until the client takes more of the answer
  // An answer may take write_grace, and as long as it takes at write_bytes_per_second.
  std::chrono::milliseconds write_grace{60000};
  size_t write_bytes_per_second = 8192;
};

class Connection {
 public:
  // socket: of a stream, connected; stays the caller's.
  Connection(int socket, const ConnectionLimits& limits);
  // Whether something can be read, or written, before a limit is reached; waits for it.
  bool is_readable() const;
  bool is_writable() const;
  // As recv() and send(): bytes, 0 at the end, -1 on failure or at a limit.
  ssize_t read(char* to, size_t size);
  ssize_t write(const char* from, size_t size);
  int socket() const { return socket_; }

 private:
  using Clock = std::chrono::steady_clock;
  bool wait(short events, std::chrono::milliseconds at_most) const;

  int socket_;
  ConnectionLimits limits_;
  Clock::time_point begun_ = Clock::now();
  Clock::time_point write_begun_{};
  size_t received_ = 0;
  size_t written_ = 0;
  std::array<char, 4096> buffer_;
  size_t at_ = 0;
  size_t filled_ = 0;
};

// An address as text ("127.0.0.1") and its port; empty and 0 where there is none. local: of this end, else of the
// other.
void name_of(int socket, bool local, std::string& address, int& port);

inline Connection::Connection(int socket, const ConnectionLimits& limits) : socket_(socket), limits_(limits) {}

inline bool Connection::wait(short events, std::chrono::milliseconds at_most) const {
  const Clock::time_point end = Clock::now() + at_most;
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    if (left.count() <= 0) return false;
    pollfd waited{socket_, events, 0};
    const int got = ::poll(&waited, 1, static_cast<int>(left.count()));
    if (got > 0) return true;
    if (got == 0 || errno != EINTR) return false;
  }
}

inline bool Connection::is_readable() const {
  if (at_ < filled_) return true;
  if (received_ >= limits_.most_received) return false;
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(begun_ + limits_.request - Clock::now());
  return wait(POLLIN, std::min(left, limits_.pause));
}

inline bool Connection::is_writable() const {
  std::chrono::milliseconds left = limits_.write_pause;
  if (written_ > 0) {
    const std::chrono::milliseconds granted =
        limits_.write_grace + std::chrono::milliseconds(1000 * written_ / limits_.write_bytes_per_second);
    left = std::min(left, std::chrono::duration_cast<std::chrono::milliseconds>(write_begun_ + granted - Clock::now()));
  }
  return wait(POLLOUT, left);
}

inline ssize_t Connection::read(char* to, size_t size) {
  if (at_ == filled_) {
    if (!is_readable()) return -1;
    const size_t most = std::min(buffer_.size(), limits_.most_received - received_);
    const ssize_t got = ::recv(socket_, buffer_.data(), most, 0);
    if (got <= 0) return got;
    at_ = 0;
    filled_ = static_cast<size_t>(got);
    received_ += filled_;
  }
  const size_t given = std::min(size, filled_ - at_);
  std::memcpy(to, buffer_.data() + at_, given);
  at_ += given;
  return static_cast<ssize_t>(given);
}

inline ssize_t Connection::write(const char* from, size_t size) {
  if (written_ == 0) write_begun_ = Clock::now();
  if (!is_writable()) return -1;
  // Without waiting: what does not fit waits in is_writable(), where the limits are.
  const ssize_t put = ::send(socket_, from, size, MSG_NOSIGNAL | MSG_DONTWAIT);
  if (put > 0) written_ += static_cast<size_t>(put);
  return put;
}

// An address as text ("127.0.0.1") and its port; empty and 0 where there is none. local: of this end, else of the
// other.
inline void name_of(int socket, bool local, std::string& address, int& port) {
  address.clear();
  port = 0;
  sockaddr_storage name{};
  socklen_t length = sizeof name;
  auto* const at = reinterpret_cast<sockaddr*>(&name);
  if ((local ? ::getsockname(socket, at, &length) : ::getpeername(socket, at, &length)) != 0) return;
  char host[NI_MAXHOST] = {};
  char service[NI_MAXSERV] = {};
  if (::getnameinfo(at, length, host, sizeof host, service, sizeof service, NI_NUMERICHOST | NI_NUMERICSERV) != 0)
    return;
  address = host;
  port = std::atoi(service);
}

}  // namespace crowdbench::studies::http
