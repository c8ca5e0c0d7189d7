#include "core/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <mutex>

namespace crowdbench {
namespace {

volatile std::sig_atomic_t stop_requested = 0;

void on_signal(int signal_number) {
  stop_requested = 1;
  std::signal(signal_number, SIG_DFL);
}

}  // namespace

struct Progress::State {
  std::string label;
  std::string note;
  size_t total = 0;
  std::atomic<size_t> done{0};
  std::mutex mutex;
  bool terminal = false;
  std::chrono::steady_clock::time_point drawn{};

  void draw(bool force) {
    if (!terminal) return;
    const std::scoped_lock lock(mutex);
    const auto now = std::chrono::steady_clock::now();
    if (!force && now - drawn < std::chrono::milliseconds(100)) return;
    drawn = now;
    const size_t count = done.load();
    const auto line = total > 0 ? fmt::format("{}: {}/{} {}", label, count, total, note)
                                : fmt::format("{}: {} {}", label, count, note);
    fmt::print(stderr, "\r\x1b[K{}", line.substr(0, 100));
    std::fflush(stderr);
  }
};

Progress::Progress(std::string label, size_t total) : state_(new State) {
  state_->label = std::move(label);
  state_->total = total;
  state_->terminal = ::isatty(STDERR_FILENO) == 1;
}

Progress::~Progress() {
  if (state_->terminal) fmt::print(stderr, "\r\x1b[K");
  delete state_;
}

void Progress::advance(size_t steps) {
  throw_if_interrupted();
  state_->done += steps;
  state_->draw(false);
}

void Progress::note(const std::string& text) {
  {
    const std::scoped_lock lock(state_->mutex);
    state_->note = text;
  }
  state_->draw(true);
}

void install_interrupt_handler() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  std::signal(SIGPIPE, SIG_IGN);
}

bool interrupted() { return stop_requested != 0; }

void throw_if_interrupted() {
  if (interrupted()) throw Interrupted{};
}

}  // namespace crowdbench
