#include "bench/commands/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/files.h"

namespace crowdbench::bench {
namespace {

// The whole text as a T, or nothing.
template <typename T>
std::optional<T> read_number(const std::string& text) {
  T value{};
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (fault != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

template <typename T>
CLI::Validator in_range(T low, T high, const char* kind) {
  const auto check = [low, high, kind](std::string& text) -> std::string {
    const std::optional<T> value = read_number<T>(text);
    if (!value || !(*value >= low && *value <= high))
      return fmt::format("'{}' is not a {} from {} to {}", printable(text, 60), kind, low, high);
    text = fmt::format("{}", *value);  // as it was read: CLI11 takes 010 for eight
    return {};
  };
  return {check, fmt::format("{}..{}", low, high)};
}

CLI::Validator writable(void (*require)(const std::filesystem::path&)) {
  const auto check = [require](std::string& text) -> std::string {
    try {
      require(text);
      return {};
    } catch (const Error& error) {
      return error.what();
    }
  };
  return {check, ""};
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

// "study analyze": the command and those that it belongs to, without the program.
std::string full_name(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  if (parent == nullptr) return "";
  const std::string before = full_name(*parent);
  return before.empty() ? command.get_name() : before + " " + command.get_name();
}

// app: the program, or a command of commands.
std::string wrong_command(const CLI::App& app, const std::string& given) {
  const std::vector<std::string> names = command_names(app);
  const std::string near = nearest_name(given, names);
  const std::string what = app.get_parent() == nullptr ? "a command" : fmt::format("a command of {}", full_name(app));
  if (!near.empty()) return fmt::format("'{}' is not {}; did you mean '{}'?", printable(given, 60), what, near);
  return fmt::format("'{}' is not {}; there are {}", printable(given, 60), what, fmt::join(names, ", "));
}

// What the first argument that nobody took should have been.
std::string unexpected(const CLI::App& app, const CLI::App* command, const std::string& given) {
  const std::string name = given.substr(0, given.find('='));
  const std::string help = fmt::format("crowdbench {}--help", command != nullptr ? full_name(*command) + " " : "");
  if (!name.starts_with("-") || name == "-") {
    if (command == nullptr) return wrong_command(app, given);
    if (!command_names(*command).empty()) return wrong_command(*command, given);
    return fmt::format("'{}' is one argument too many for {}; see {}", printable(given, 60), full_name(*command), help);
  }
  const std::vector<std::string> names = option_names(command != nullptr ? *command : app);
  const std::string whose = command != nullptr ? full_name(*command) : "crowdbench without a command";
  if (std::find(names.begin(), names.end(), name) != names.end())
    return fmt::format("{} belongs behind the command: crowdbench {} {} ...", name, full_name(*command), name);
  const std::string near = nearest_name(name, names);
  return fmt::format("{} has no option '{}'; {}", whose, printable(name, 60),
                     near.empty() ? "see " + help : fmt::format("did you mean {}?", near));
}

// What is wrong with a command line, one line without the program's name. `app` is the one whose parse() threw `error`.
std::string usage_message(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* command = nullptr;  // the innermost that was chosen
  for (std::vector<CLI::App*> chosen = app.get_subcommands(); !chosen.empty(); chosen = command->get_subcommands())
    command = chosen.front();
  const std::string help = fmt::format("see crowdbench {}--help", command != nullptr ? full_name(*command) + " " : "");
  const std::vector<std::string> left = app.remaining(true);
  if (!left.empty()) return unexpected(app, command, left.front());
  if (command == nullptr) return fmt::format("a command is missing; there are {}", fmt::join(command_names(app), ", "));
  if (const std::vector<std::string> names = command_names(*command); !names.empty())
    return fmt::format("{}: a command is missing; there are {}", full_name(*command), fmt::join(names, ", "));
  const std::string text = printable(error.what(), 1000);
  const std::string option = text.substr(0, text.find(':'));
  if (text.ends_with("flag override"))
    return fmt::format("--{}: takes no value; {}", text.substr(0, text.find(' ')), help);
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr)
    return text.find("missing") != std::string::npos || text.find("At least") != std::string::npos
               ? fmt::format("{}: its value is missing; {}", option, help)
               : fmt::format("{}: is given more than once; {}", option, help);
  return fmt::format("{}; {}", text, help);
}

}  // namespace

Option* Option::required() {
  option_->required();
  return this;
}

Option* Option::type_name(const std::string& name) {
  option_->type_name(name);
  return this;
}

Option* Option::capture_default_str() {
  option_->capture_default_str();
  return this;
}

Option* Option::number(double least, double most) {
  option_->check(in_range(least, most, "number"));
  return this;
}

Option* Option::whole_number(uint64_t least, uint64_t most) {
  option_->check(in_range(least, most, "whole number"));
  return this;
}

namespace {

// Whole numbers of a kind: "odd number".
CLI::Validator of_a_kind(uint64_t least, uint64_t most, const char* kind, bool (*is)(uint64_t)) {
  const auto check = [=](std::string& text) -> std::string {
    const auto value = read_number<uint64_t>(text);
    if (value && *value >= least && *value <= most && is(*value)) return {};
    return fmt::format("'{}' is not {} from {} to {}", printable(text, 60), kind, least, most);
  };
  return {check, fmt::format("{}..{}", least, most)};
}

}  // namespace

Option* Option::odd_number(uint64_t least, uint64_t most) {
  option_->check(of_a_kind(least, most, "an odd number", [](uint64_t v) { return v % 2 == 1; }));
  return this;
}

Option* Option::power_of_two(uint64_t least, uint64_t most) {
  option_->check(of_a_kind(least, most, "a power of two", [](uint64_t v) { return std::has_single_bit(v); }));
  return this;
}

namespace {

// Endings that say the same as the one that a type names.
const std::map<std::string, std::string>& other_endings() {
  static const std::map<std::string, std::string> map = {
      {".db", ".sqlite"}, {".sqlite3", ".sqlite"}, {".htm", ".html"}, {".jpeg", ".jpg"}, {".markdown", ".md"}};
  return map;
}

// Whether it could name a format: of a letter and up to seven more letters or digits. "run.2026" ends in none, and
// "x.part" says of a file of any format that it is not whole.
bool is_ending(const std::string& text) {
  static const std::set<std::string> states = {".part", ".tmp", ".temp", ".new", ".old", ".bak"};
  return !states.contains(text) && text.size() >= 2 && text.size() <= 9 &&
         std::isalpha(static_cast<unsigned char>(text[1])) != 0 &&
         std::all_of(text.begin() + 1, text.end(), [](unsigned char c) { return std::isalnum(c) != 0; });
}

// A name that ends as files of another format do is a mistake: nobody would find out before the file is opened.
CLI::Validator ends_as(const std::string& type) {
  const auto check = [type](std::string& text) -> std::string {
    std::string ending = std::filesystem::path(text).extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
    const auto same = other_endings().find(ending);
    if (same != other_endings().end() && type.find("FILE" + same->second) != std::string::npos) return {};
    if (!is_ending(ending) || type.find("FILE" + ending) != std::string::npos) return {};
    return fmt::format("'{}' ends in {}; what is written is {}", printable(text, 60), ending, type);
  };
  return {check, ""};
}

}  // namespace

Option* Option::output_file() {
  if (const std::string type = option_->get_type_name(); type.find("FILE.") != std::string::npos)
    option_->check(ends_as(type));
  option_->check(writable(require_writable_file));
  output_ = true;
  return this;
}

Option* Option::output_folder() {
  option_->check(writable(require_writable_folder));
  return this;
}

Option* Option::delimiter(char separator) {
  option_->delimiter(separator);
  separator_ = separator;
  return this;
}

Option* Option::expected(int arguments) {
  option_->expected(arguments);
  return this;
}

Option* Option::take_all() {
  option_->take_all();
  return this;
}

Option* Option::allow_extra_args(bool allow) {
  option_->allow_extra_args(allow);
  return this;
}

Option* Option::needs(const Option* other) {
  option_->needs(other->option_);
  return this;
}

Option* Option::excludes(const Option* other) {
  option_->excludes(other->option_);
  return this;
}

Option* Option::excludes(const std::string& name) {
  option_->excludes(name);
  return this;
}

namespace {

// Devices and pipes may be written to from several sides.
bool is_same_file(const std::string& a, const std::string& b) {
  namespace fs = std::filesystem;
  std::error_code fault;
  if (fs::exists(a, fault)) return fs::is_regular_file(a, fault) && fs::equivalent(a, b, fault);
  return fs::absolute(a).lexically_normal() == fs::absolute(b).lexically_normal();
}

}  // namespace

Command* Command::add_subcommand(const std::string& name, const std::string& description) {
  app_.require_subcommand(1);
  return commands_.emplace_back(std::make_unique<Command>(*app_.add_subcommand(name, description))).get();
}

void Command::footer(const std::string& text) { app_.footer(text); }

void Command::callback(std::function<void()> run) { app_.callback(std::move(run)); }

template <typename T>
Option* Command::add_option(const std::string& name, T& target, const std::string& description) {
  return options_.emplace_back(std::make_unique<Option>(app_.add_option(name, target, description))).get();
}

Option* Command::add_flag(const std::string& name, bool& target, const std::string& description) {
  return options_
      .emplace_back(std::make_unique<Option>(app_.add_flag(name, target, description)->disable_flag_override()))
      .get();
}

void Command::require_outputs_apart() const {
  for (const auto& command : commands_) command->require_outputs_apart();
  if (!app_.parsed()) return;
  for (const auto& output : options_) {
    if (!output->output_) continue;
    for (const std::string& file : output->option_->results()) {
      for (const auto& other : options_) {
        if (other == output) continue;
        for (const std::string& text : other->option_->results()) {
          if (!is_same_file(file, text)) continue;
          throw Error(output->option_->get_name(),
                      fmt::format("'{}' is also what {} names", printable(file, 80), other->option_->get_name()),
                      "choose another file to write");
        }
      }
    }
  }
}

std::string Command::empty_item(std::span<char* const> arguments) const {
  for (const auto& command : commands_)
    if (const std::string fault = command->empty_item(arguments); !fault.empty()) return fault;
  if (!app_.parsed()) return "";
  for (const auto& option : options_) {
    if (option->separator_ == 0) continue;
    const std::string name = option->option_->get_name();
    for (size_t i = 0; i < arguments.size(); ++i) {
      const std::string_view argument = arguments[i];
      std::string_view list;
      if (argument == name && i + 1 < arguments.size())
        list = arguments[i + 1];
      else if (argument.starts_with(name + "="))
        list = argument.substr(name.size() + 1);
      else
        continue;
      const char twice[] = {option->separator_, option->separator_, 0};
      if (list.starts_with(option->separator_) || list.ends_with(option->separator_) ||
          list.find(twice) != std::string_view::npos)
        return fmt::format("{}: '{}' leaves a value out; see crowdbench {} --help", name,
                           printable(std::string(list), 60), full_name(app_));
    }
  }
  return "";
}

#define CROWDBENCH_OPTION_TYPE(...) \
  template Option* Command::add_option(const std::string&, __VA_ARGS__&, const std::string&)
CROWDBENCH_OPTION_TYPE(std::string);
CROWDBENCH_OPTION_TYPE(int);
CROWDBENCH_OPTION_TYPE(uint32_t);
CROWDBENCH_OPTION_TYPE(uint64_t);
CROWDBENCH_OPTION_TYPE(double);
CROWDBENCH_OPTION_TYPE(std::optional<int>);
CROWDBENCH_OPTION_TYPE(std::optional<uint32_t>);
CROWDBENCH_OPTION_TYPE(std::optional<uint64_t>);
CROWDBENCH_OPTION_TYPE(std::optional<double>);
CROWDBENCH_OPTION_TYPE(std::vector<std::string>);
CROWDBENCH_OPTION_TYPE(std::vector<uint32_t>);
CROWDBENCH_OPTION_TYPE(std::vector<uint64_t>);
CROWDBENCH_OPTION_TYPE(std::vector<double>);
#undef CROWDBENCH_OPTION_TYPE

int run_command_line(int argc, char** argv, const About& about, const std::function<void(Command&)>& add,
                     const std::function<int()>& run) {
  CLI::App app{about.description, about.name};
  app.set_version_flag("--version", fmt::format("{} {}", about.name, about.version));
  Command program(app);
  add(program);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help, --version
      std::ostringstream text;
      const int status = app.exit(error, text, text);
      fmt::print("{}", text.str());
      return status;
    }
    fmt::print(stderr, "{}: {}\n", about.name, usage_message(app, error));
    return 2;
  }
  if (const std::string fault = program.empty_item({argv, static_cast<size_t>(argc)}); !fault.empty()) {
    fmt::print(stderr, "{}: {}\n", about.name, fault);
    return 2;
  }
  program.require_outputs_apart();
  return run();
}

}  // namespace crowdbench::bench
