// The command line as commands see it. CLI11 is header-only and costs 5 s of compilation a file that includes it; it is
// compiled once, behind these two handles, whose functions are CLI11's of the same names.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace crowdbench::bench {

// One option or flag. A command owns it; pointers to it stay valid as long as the command.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option* required();
  Option* type_name(const std::string& name);  // what --help calls its value
  Option* capture_default_str();               // --help shows the value that the target has now
  // What values it takes; others are refused before anything is loaded or drawn, and the range stands in --help.
  Option* number(double least, double most);
  Option* whole_number(uint64_t least, uint64_t most);
  Option* odd_number(uint64_t least, uint64_t most);
  Option* power_of_two(uint64_t least, uint64_t most);
  // A file that can be written: its folder exists, none is made (core/files.h). After type_name(): a name that ends as
  // another format's files do is refused.
  Option* output_file();
  Option* output_folder();            // a folder that can be written, or made within one that exists
  Option* delimiter(char separator);  // one argument holds several values
  Option* expected(int arguments);    // how many arguments follow each time it is given
  Option* take_all();                 // may be given several times, each adds
  Option* allow_extra_args(bool allow);
  Option* needs(const Option* other);
  Option* excludes(const Option* other);
  Option* excludes(const std::string& name);

 private:
  friend class Command;
  CLI::Option* option_;
  bool output_ = false;  // output_file()
  char separator_ = 0;   // delimiter()
};

// A program or one of its commands.
class Command {
 public:
  explicit Command(CLI::App& app) : app_(app) {}

  // A command that has commands of its own needs one of them.
  Command* add_subcommand(const std::string& name, const std::string& description);
  void footer(const std::string& text);
  void callback(std::function<void()> run);

  // `name`: "--long,-s", or a bare word for a positional argument. `target` is written when the line is parsed and must
  // live until then. T is one of the types at the end of command_line.cpp; another fails to link until it is named
  // there.
  template <typename T>
  Option* add_option(const std::string& name, T& target, const std::string& description);
  Option* add_flag(const std::string& name, bool& target, const std::string& description);

  // Throws Error: a file to be written, of the command that was given, is one that it reads too, or that another option
  // writes.
  void require_outputs_apart() const;
  // What is wrong where a list (delimiter()) of the command that was given has an item without text, as in "1,,3";
  // empty: nothing. CLI11 leaves such items out. arguments: of the program, all.
  std::string empty_item(std::span<char* const> arguments) const;

 private:
  CLI::App& app_;
  std::vector<std::unique_ptr<Option>> options_;
  std::vector<std::unique_ptr<Command>> commands_;
};

// What --help and --version say of the program.
struct About {
  std::string name, description, version;
};

// Parses a command line for the commands that `add` adds, then calls `run`, which the callback of one of them has set,
// and returns what it returns. 0 after --help and --version; 2 where the command line is wrong, said in one line on
// stderr: an unknown command or option with the nearest that there is, a missing value, a value out of its range, each
// with where to look it up. What `run` throws passes through.
int run_command_line(int argc, char** argv, const About& about, const std::function<void(Command&)>& add,
                     const std::function<int()>& run);

}  // namespace crowdbench::bench
