// Based on: POSIX.1-2017, fork(), setrlimit(); Linux, prctl(PR_SET_PDEATHSIG) and proc(5), statm.
#include "scene/assimp/isolated.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <fstream>
#include <new>

#include "core/error.h"
#include "core/progress.h"

namespace crowdbench::scene {
namespace {

constexpr int kOutOfMemory = 71;
constexpr int kFailed = 70;

// Address space of this process; it may be large before any work (a GPU's driver, a sanitizer).
uint64_t address_space() {
  std::ifstream file("/proc/self/statm");
  uint64_t pages = 0;
  file >> pages;
  return pages * static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
}

void limit(int resource, uint64_t most) {
  rlimit value{};
  if (::getrlimit(static_cast<__rlimit_resource_t>(resource), &value) != 0) return;
  value.rlim_cur = value.rlim_max == RLIM_INFINITY ? most : std::min<rlim_t>(most, value.rlim_max);
  ::setrlimit(static_cast<__rlimit_resource_t>(resource), &value);
}

[[noreturn]] void run_child(const std::function<void(int)>& work, int fd, const IsolationLimits& limits,
                            uint64_t memory) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int signal : {SIGINT, SIGTERM, SIGPIPE, SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGXCPU, SIGALRM})
    std::signal(signal, SIG_DFL);
  const int nowhere = ::open("/dev/null", O_RDWR);
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) ::dup2(nowhere, stream);
  limit(RLIMIT_AS, memory);
  limit(RLIMIT_CPU, limits.cpu_seconds);
  limit(RLIMIT_CORE, 0);
  int status = 0;
  try {
    work(fd);
  } catch (const std::bad_alloc&) {
    status = kOutOfMemory;
  } catch (...) {
    status = kFailed;
  }
  ::_exit(status);
}

class Child {
 public:
  explicit Child(pid_t pid) : pid_(pid) {}
  ~Child() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    wait();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  int wait() {
    int status = 0;
    while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = 0;
    return status;
  }

 private:
  pid_t pid_;
};

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }
  void close() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }

 private:
  int fd_;
};

// Whether a process uses no CPU time. A child has one thread, and what another held when it was forked (a lock of a
// sanitizer's allocator, say) is never let go there.
class Standstill {
 public:
  explicit Standstill(pid_t pid) { known_ = ::clock_getcpuclockid(pid, &clock_) == 0; }
  // To be asked again and again: how often in a row there was nothing new.
  int count() {
    timespec now{};
    if (!known_ || ::clock_gettime(clock_, &now) != 0) return 0;
    const bool same = now.tv_sec == last_.tv_sec && now.tv_nsec == last_.tv_nsec;
    last_ = now;
    return times_ = same ? times_ + 1 : 0;
  }

 private:
  clockid_t clock_{};
  bool known_ = false;
  timespec last_{};
  int times_ = 0;
};

constexpr int kPollMilliseconds = 100;

// What the child writes until its end; what is wrong with it, empty: nothing.
std::string read_all(int fd, pid_t child, const IsolationLimits& limits, Progress& progress,
                     std::vector<uint8_t>& out) {
  std::array<uint8_t, 65536> buffer{};
  Standstill idle(child);
  while (true) {
    pollfd ready{fd, POLLIN, 0};
    const int count = ::poll(&ready, 1, kPollMilliseconds);
    progress.advance(0);
    if (count == 0 && idle.count() >= limits.idle_seconds * 1000 / kPollMilliseconds)
      return "stands still in its reader";
    if (count <= 0) continue;
    const ssize_t size = ::read(fd, buffer.data(), buffer.size());
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return {};
    if (out.size() + static_cast<size_t>(size) > limits.output_bytes)
      return fmt::format("becomes more than {} MiB", limits.output_bytes >> 20);
    out.insert(out.end(), buffer.begin(), buffer.begin() + size);
  }
}

std::string failure_of(int status, const IsolationLimits& limits) {
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  if (WIFEXITED(status) && WEXITSTATUS(status) == kOutOfMemory)
    return fmt::format("needs more than {} MiB to be read", limits.memory_bytes >> 20);
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU)
    return fmt::format("takes more than {} s to be read", limits.cpu_seconds);
  if (WIFSIGNALED(status)) return fmt::format("crashes its reader (signal {})", WTERMSIG(status));
  return fmt::format("ends its reader (status {})", WEXITSTATUS(status));
}

}  // namespace

IsolatedOutput run_isolated(const std::string& what, const std::function<void(int fd)>& work,
                            const IsolationLimits& limits) {
  int ends[2] = {-1, -1};
  if (::pipe2(ends, O_CLOEXEC) != 0) throw Error("pipe", std::strerror(errno), "close other programs");
  const Descriptor from(ends[0]);
  Descriptor to(ends[1]);
  const uint64_t memory = address_space() + limits.memory_bytes;
  const pid_t pid = ::fork();
  if (pid < 0) throw Error("fork", std::strerror(errno), "close other programs");
  if (pid == 0) run_child(work, to.get(), limits, memory);
  Child child(pid);
  to.close();
  Progress progress(what, 0);  // after the fork: it may begin a thread
  IsolatedOutput out;
  out.failure = read_all(from.get(), pid, limits, progress, out.bytes);
  if (out.failure.empty()) out.failure = failure_of(child.wait(), limits);
  return out;
}

}  // namespace crowdbench::scene
