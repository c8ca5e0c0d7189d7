#include "core/progress.h"

#include <fmt/format.h>
#include <semaphore.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <condition_variable>
#include <csignal>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "core/files.h"
#include "core/term_status.h"

namespace crowdbench {
namespace {

using Nanoseconds = std::chrono::nanoseconds;

constexpr Nanoseconds kTerminalInterval = std::chrono::milliseconds(100);
constexpr Nanoseconds kLineInterval = std::chrono::seconds(10);
const Nanoseconds kProgramBegan = std::chrono::steady_clock::now().time_since_epoch();
constexpr Nanoseconds kFirstEstimate = std::chrono::seconds(1);

double seconds_of(Nanoseconds time) { return std::chrono::duration<double>(time).count(); }

volatile std::sig_atomic_t stop_requested = 0;  // the signal's number
sem_t stop_wanted;
std::mutex kept_mutex;
std::string kept_text = "nothing was left half-written";

std::atomic<int> status_after_term = 0;

void on_signal(int signal_number) {
  stop_requested = signal_number;
  std::signal(signal_number, SIG_DFL);
  sem_post(&stop_wanted);
}

void write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t put = ::write(fd, text.data(), text.size());
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) return;
    text.remove_prefix(static_cast<size_t>(put));
  }
}

// Not _exit(): the memory of a process is released by its last thread to die, and Mesa keeps one of the lowest priority
// (its shader cache's), which on a busy machine takes tens of seconds to release a gigabyte (20 s seen). Where another
// program takes the process over, this thread releases it.
[[noreturn]] void end_at_once(int status) {
  static std::array<char, 16> command{};
  fmt::format_to_n(command.data(), command.size() - 1, "exit {}", status);
  static const char* const arguments[] = {"sh", "-c", command.data(), nullptr};
  ::execv("/bin/sh", const_cast<char* const*>(arguments));
  ::_exit(status);
}

// Ends a process whose threads do not come to a check.
void end_when_stuck() {
  while (sem_wait(&stop_wanted) != 0) {
  }
  std::this_thread::sleep_for(kInterruptGrace);
  remove_pending_files();
  if (::isatty(STDERR_FILENO) == 1) write_all(STDERR_FILENO, "\r\x1b[K");
  write_all(STDERR_FILENO, interrupt_line());
  end_at_once(interrupt_status());
}

}  // namespace

struct Progress::Job {
  std::string label;
  std::string note;
  size_t total = 0;
  size_t done = 0;
  Nanoseconds begun{};
  std::optional<double> expected;  // seconds left at `expected_at`
  Nanoseconds expected_at{};

  // Seconds; nothing where nobody can say.
  std::optional<double> left(Nanoseconds now) const {
    if (expected) return std::max(0.0, *expected - seconds_of(now - expected_at));
    if (total == 0 || done == 0 || done >= total || now - begun < kFirstEstimate) return std::nullopt;
    return seconds_of(now - begun) / static_cast<double>(done) * static_cast<double>(total - done);
  }

  // at_least: seconds that pieces within it have left.
  std::string text(Nanoseconds now, double at_least = 0) const {
    std::string out = label;
    std::string separator = ": ";
    const auto add = [&](const std::string& piece) {
      out += separator + piece;
      separator = ", ";
    };
    if (total > 0)
      add(fmt::format("{}/{}", done, total));
    else if (done > 0)
      add(fmt::format("{}", done));
    if (!note.empty()) add(note);
    if (const std::optional<double> own = left(now)) {
      if (const double most = std::max(*own, at_least); most > 0) add(duration_text(most) + " left");
    } else if (done < total || total == 0) {
      add(duration_text(seconds_of(now - begun)) + " so far");
    }
    return out;
  }
};

struct ProgressBoard::State {
  explicit State(ProgressOutput output_) : output(std::move(output_)) {
    if (!output.terminal) written = output.now();
  }

  ProgressOutput output;
  std::mutex mutex;
  std::vector<std::shared_ptr<Progress::Job>> jobs;  // the outermost first
  Nanoseconds written{};                             // when the last line came; off a terminal, at first the begin
  bool line_stands = false;                          // on a terminal

  // Only the process's own board has a thread that shows it.
  bool ticks = false;
  std::jthread ticker;
  std::condition_variable_any ended;

  void show(bool force) {
    const Nanoseconds now = output.now();
    if (jobs.empty() || (!force && now - written < (output.terminal ? kTerminalInterval : kLineInterval))) return;
    written = now;
    std::string line;
    // The outermost holds all others: an estimate of its own that knows nothing of a long piece is no less than that.
    double within = 0;
    for (size_t i = 1; i < jobs.size(); ++i) within = std::max(within, jobs[i]->left(now).value_or(0));
    for (const auto& job : jobs) line += (line.empty() ? "" : "; ") + job->text(now, job == jobs.front() ? within : 0);
    if (!output.terminal) {
      output.write(line + "\n");
      return;
    }
    if (line.size() >= output.columns && output.columns > 4) line = line.substr(0, output.columns - 4) + "...";
    output.write("\r\x1b[K" + line);
    line_stands = true;
  }

  void begin(const std::shared_ptr<Progress::Job>& job) {
    const std::scoped_lock lock(mutex);
    job->begun = output.now();
    jobs.push_back(job);
    if (ticks && !ticker.joinable()) ticker = std::jthread([this](const std::stop_token& stop) { tick(stop); });
  }

  void end(const std::shared_ptr<Progress::Job>& job) {
    std::jthread finished;  // joined once the lock is open again
    {
      const std::scoped_lock lock(mutex);
      if (std::erase(jobs, job) == 0 || !jobs.empty()) return;
      if (line_stands) output.write("\r\x1b[K");
      line_stands = false;
      finished = std::move(ticker);
    }
  }

  void tick(const std::stop_token& stop) {
    std::unique_lock lock(mutex);
    while (!stop.stop_requested()) {
      ended.wait_for(lock, stop, std::chrono::milliseconds(500), [] { return false; });
      if (!stop.stop_requested()) show(false);
    }
  }
};

ProgressBoard::ProgressBoard(ProgressOutput output) : state_(new State(std::move(output))) {}
ProgressBoard::~ProgressBoard() = default;

ProgressBoard& ProgressBoard::on_stderr() {
  static ProgressBoard* const board = [] {  // never destroyed: work may still be going on when the process ends
    ProgressOutput output;
    output.terminal = ::isatty(STDERR_FILENO) == 1;
    winsize size{};
    if (output.terminal && ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0)
      output.columns = size.ws_col;
    output.write = [](std::string_view text) { write_all(STDERR_FILENO, text); };
    output.now = [] { return Nanoseconds(std::chrono::steady_clock::now().time_since_epoch()); };
    auto* made = new ProgressBoard(std::move(output));
    made->state_->ticks = true;
    if (!made->state_->output.terminal) made->state_->written = kProgramBegan;
    return made;
  }();
  return *board;
}

void ProgressBoard::show() {
  const std::scoped_lock lock(state_->mutex);
  state_->show(false);
}

Progress::Progress(std::string label, size_t total, ProgressBoard& board)
    : board_(*board.state_), job_(std::make_shared<Job>()) {
  job_->label = std::move(label);
  job_->total = total;
  board_.begin(job_);
}

Progress::~Progress() { end(); }

void Progress::end() { board_.end(job_); }

void Progress::advance(size_t steps) {
  throw_if_interrupted();
  const std::scoped_lock lock(board_.mutex);
  job_->done += steps;
  board_.show(false);
}

void Progress::set_done(size_t done) {
  throw_if_interrupted();
  const std::scoped_lock lock(board_.mutex);
  job_->done = done;
  board_.show(false);
}

void Progress::say(const std::string& line) {
  const std::scoped_lock lock(board_.mutex);
  board_.output.write((board_.line_stands ? "\r\x1b[K" : "") + line + "\n");
  board_.show(board_.line_stands);
}

void Progress::note(const std::string& text) {
  const std::scoped_lock lock(board_.mutex);
  job_->note = text;
  board_.show(board_.output.terminal);
}

void Progress::expect(double seconds) {
  const std::scoped_lock lock(board_.mutex);
  job_->expected = seconds;
  job_->expected_at = board_.output.now();
}

std::string duration_text(double seconds) {
  const auto whole = static_cast<long long>(std::clamp(std::round(seconds), 1.0, 1e9));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600)
    return whole % 60 == 0 ? fmt::format("{} min", whole / 60) : fmt::format("{} min {} s", whole / 60, whole % 60);
  const long long minutes = (whole + 30) / 60;
  return minutes % 60 == 0 ? fmt::format("{} h", minutes / 60) : fmt::format("{} h {} min", minutes / 60, minutes % 60);
}

void install_interrupt_handler() {
  sem_init(&stop_wanted, 0, 0);
  std::thread(end_when_stuck).detach();
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  std::signal(SIGPIPE, SIG_IGN);
}

bool interrupted() { return stop_requested != 0; }

void throw_if_interrupted() {
  if (interrupted()) throw Interrupted{};
}

int interrupt_status() {
  if (stop_requested == 0) return 0;
  const int given = status_after_term;
  return stop_requested == SIGTERM && given != 0 ? given : 128 + stop_requested;
}

void set_term_status(int status) { status_after_term = status; }

void say_when_interrupted(const std::string& kept) {
  const std::scoped_lock lock(kept_mutex);
  kept_text = kept;
}

std::string interrupt_line() {
  const std::scoped_lock lock(kept_mutex);
  return fmt::format("crowdbench: interrupted; {}\n", kept_text);
}

}  // namespace crowdbench
