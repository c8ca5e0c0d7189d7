// Progress of long work on a terminal, and the user's wish to stop.
#pragma once
#include <cstddef>
#include <string>

namespace crowdbench {

// One line on stderr, rewritten in place; nothing at all when stderr is not a terminal. Safe to advance from several
// threads.
class Progress {
 public:
  Progress(std::string label, size_t total);
  ~Progress();  // clears the line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  // Also throws Interrupted when Ctrl-C was pressed (from the thread that calls).
  void advance(size_t steps = 1);
  void note(const std::string& text);  // what is being worked on now

 private:
  struct State;
  State* state_;
};

// Thrown at the next check after SIGINT or SIGTERM; the driver ends with status 130 and one line. Destructors run, so
// nothing half-written stays.
struct Interrupted {};

void install_interrupt_handler();  // by the driver, once; a second signal kills at once
bool interrupted();
void throw_if_interrupted();

}  // namespace crowdbench
