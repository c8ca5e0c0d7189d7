// Progress of long work, said on stderr, and the user's wish to stop.
#pragma once
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace crowdbench {

// Where progress is said and what time it is; tests give their own.
struct ProgressOutput {
  bool terminal = false;  // one line that is rewritten in place; otherwise a line of its own every 10 s
  size_t columns = 80;    // of the terminal: a longer line ends in "..." there
  std::function<void(std::string_view)> write;
  std::function<std::chrono::nanoseconds()> now;  // monotonic, from any origin
};

// What is going on now, the outermost work first: "bench: 3/12, 2 min 5 s left; baking flat: 120/306, 4 s left". Safe
// to use from several threads.
class ProgressBoard {
 public:
  explicit ProgressBoard(ProgressOutput output);
  ~ProgressBoard();
  ProgressBoard(const ProgressBoard&) = delete;
  ProgressBoard& operator=(const ProgressBoard&) = delete;
  // The process's own, on stderr. Its lines also come while the work itself reports nothing.
  static ProgressBoard& on_stderr();
  // Writes a line when one is due: on a terminal at most ten a second, otherwise one every 10 s, the first 10 s after
  // the board was made (the process's own: after the program began), whatever pieces of work follow each other.
  void show();

 private:
  friend class Progress;
  struct State;
  std::unique_ptr<State> state_;
};

// One piece of work, from construction to destruction. Pieces nest.
class Progress {
 public:
  // total: steps, 0 where nobody knows.
  Progress(std::string label, size_t total, ProgressBoard& board = ProgressBoard::on_stderr());
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void end();  // before its destruction: results are about to be printed
  // Also throws Interrupted when Ctrl-C was pressed (from the thread that calls).
  void advance(size_t steps = 1);
  void set_done(size_t done);          // the same, as the number of steps done so far
  void say(const std::string& line);   // a line of its own, which stays
  void note(const std::string& text);  // what is being worked on now; may be empty
  void expect(double seconds);         // time left as the work itself knows it; otherwise it is as the steps so far

 private:
  struct Job;
  ProgressBoard::State& board_;
  std::shared_ptr<Job> job_;
  friend class ProgressBoard;
};

// "8 s", "3 min 20 s", "2 h 5 min"; whole seconds, never below one.
std::string duration_text(double seconds);

// Thrown at the next check after SIGINT or SIGTERM; the driver ends with interrupt_status() and one line. Destructors
// run, so nothing half-written stays. Where no check comes within kInterruptGrace (a driver's draw call, a library), a
// thread of the handler's removes what is half-written and ends the process with the same line and status.
struct Interrupted {};
inline constexpr std::chrono::milliseconds kInterruptGrace{1500};

void install_interrupt_handler();  // by the driver, once; a second signal kills at once
bool interrupted();
void throw_if_interrupted();
// 128 + the signal's number: 130 after SIGINT, 143 (or as core/term_status.h says) after SIGTERM; 0 before.
int interrupt_status();
// What the line says of the work done so far, instead of "nothing was left half-written".
void say_when_interrupted(const std::string& kept);
std::string interrupt_line();  // "crowdbench: interrupted; ...\n"

}  // namespace crowdbench
