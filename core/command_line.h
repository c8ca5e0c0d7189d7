// The command line that this process was started with: main() says it, result rows keep it.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace crowdbench {

// The text as one word of a POSIX shell: as it is where no character means anything to a shell, else in single quotes.
std::string shell_quoted(std::string_view text);
std::string shell_quoted(const std::vector<std::string>& words);  // joined by spaces

// To be called once, by main() before anything else.
void set_command_line(int argc, const char* const* argv);
// All words, quoted, so that a shell runs the same again; the program without its folder. Empty where main() is not
// ours (tests).
const std::string& command_line();

}  // namespace crowdbench
