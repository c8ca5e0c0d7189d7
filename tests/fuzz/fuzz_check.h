// What every fuzzing target holds its parser to.
#pragma once
#include <cstdlib>

#include "core/error.h"

namespace crowdbench::fuzz {

// Runs it: it may end in one Error, of one line that says something. Whatever else it throws ends the program.
template <class Function>
bool answers(Function run) {
  try {
    run();
    return true;
  } catch (const Error& error) {
    const std::string line = error.what();
    if (line.empty() || line.find('\n') != std::string::npos) std::abort();
    return false;
  }
}

}  // namespace crowdbench::fuzz
