// A SIGTERM that waits for the end of a piece of work (core/progress.h handles all others).
#pragma once

namespace crowdbench {

// While one lives, the first SIGTERM stops nothing: a scheduler that takes its machine back gives time to end the piece
// of work in hand. A second one, and Ctrl-C, stop as always. One at a time.
class TermWaits {
 public:
  TermWaits();
  ~TermWaits();
  TermWaits(const TermWaits&) = delete;
  TermWaits& operator=(const TermWaits&) = delete;
  bool came() const;  // the first one
};

}  // namespace crowdbench
