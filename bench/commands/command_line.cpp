#include "bench/commands/command_line.h"

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <utility>

namespace crowdbench::bench {

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

Option* Option::range(double least, double most) {
  option_->check(CLI::Range(least, most));
  return this;
}

Option* Option::range(int least, int most) {
  option_->check(CLI::Range(least, most));
  return this;
}

Option* Option::delimiter(char separator) {
  option_->delimiter(separator);
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

Command* Command::add_subcommand(const std::string& name, const std::string& description) {
  return commands_.emplace_back(std::make_unique<Command>(*app_.add_subcommand(name, description))).get();
}

void Command::footer(const std::string& text) { app_.footer(text); }

void Command::callback(std::function<void()> run) { app_.callback(std::move(run)); }

template <typename T>
Option* Command::add_option(const std::string& name, T& target, const std::string& description) {
  return options_.emplace_back(std::make_unique<Option>(app_.add_option(name, target, description))).get();
}

Option* Command::add_flag(const std::string& name, bool& target, const std::string& description) {
  return options_.emplace_back(std::make_unique<Option>(app_.add_flag(name, target, description))).get();
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

}  // namespace crowdbench::bench
