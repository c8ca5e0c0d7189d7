#include "renderers/representation.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <numeric>

#include "core/error.h"

namespace crowdbench::renderers {
namespace {

constexpr size_t kMaxSpecLength = 4096;
constexpr int kMaxSpecDepth = 4;

// Stands for the reference's name in a spec.
constexpr std::string_view kReferenceAlias = "reference";

const RepresentationType* find_type(const std::string& name, const std::vector<RepresentationType>& types) {
  for (const RepresentationType& t : types)
    if (t.name == name || (t.reference && name == kReferenceAlias)) return &t;
  return nullptr;
}

const RepresentationType& require_type(const std::string& name, const std::vector<RepresentationType>& types) {
  if (const RepresentationType* type = find_type(name, types)) return *type;
  std::vector<std::string> names;
  for (const RepresentationType& t : types) names.push_back(t.name);
  const std::string near = nearest_name(name, names);
  throw Error("", fmt::format("there is no representation '{}'", printable(name)),
              near.empty() ? "crowdbench info --representations lists them" : fmt::format("did you mean '{}'?", near));
}

const OptionDoc& floor_option() {
  static const OptionDoc doc = {"floor", "0|1", "0",
                                "1 draws the floor: the same draw with the work removed, for the efficiency figure"};
  return doc;
}

const OptionDoc* find_option(const RepresentationType& type, const std::string& key) {
  for (const OptionDoc& o : type.options)
    if (o.key == key) return &o;
  return key == floor_option().key ? &floor_option() : nullptr;
}

std::vector<std::string> option_keys(const RepresentationType& type) {
  std::vector<std::string> keys;
  for (const OptionDoc& o : type.options) keys.push_back(o.key);
  if (std::find(keys.begin(), keys.end(), floor_option().key) == keys.end()) keys.push_back(floor_option().key);
  return keys;
}

[[noreturn]] void bad_value(const RepresentationType& type, const std::string& key, const std::string& value,
                            const std::string& want) {
  throw Error(fmt::format("representation '{}'", type.name),
              fmt::format("option {}={} is not a {}", key, printable(value), want));
}

[[noreturn]] void bad_word(const RepresentationType& type, const std::string& key, const std::string& value,
                           const std::vector<std::string>& words) {
  const std::string near = nearest_name(value, words);
  throw Error(fmt::format("representation '{}'", type.name),
              fmt::format("option {}={} is not one of {}", key, printable(value), fmt::join(words, ", ")),
              near.empty() ? "" : fmt::format("did you mean '{}'?", near));
}

std::vector<std::string> split_words(const std::string& text) {
  std::vector<std::string> words;
  for (size_t at = 0; at <= text.size();) {
    const size_t end = std::min(text.find('|', at), text.size());
    words.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return words;
}

std::optional<double> whole_text_number(std::string_view text) {
  double number = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  return fault == std::errc{} && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

// Whether a value is a word of the table or lies within one of its ranges; true where the table says values in another
// form (a list of names, "LINEAR+BINARY").
bool is_in_table(const std::vector<std::string>& alternatives, const std::string& value) {
  const auto is_plain = [](const std::string& word) {
    return word.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_-") == std::string::npos;
  };
  const std::optional<double> number = whole_text_number(value);
  bool found = false;
  for (const std::string& one : alternatives) {
    const size_t dots = one.find("..");
    if (dots == std::string::npos) {
      if (!is_plain(one)) return true;
      found = found || value == one;
      continue;
    }
    const auto low = whole_text_number(std::string_view(one).substr(0, dots));
    const auto high = whole_text_number(std::string_view(one).substr(dots + 2));
    if (!low || !high) return true;
    found = found || (number && *number >= *low && *number <= *high);
  }
  return found;
}

// What the table of options says of its values is checked as the text is read, before a device is opened. The rest is
// for the type's make().
void check_value(const RepresentationType& type, const OptionDoc& option, const std::string& value) {
  if (option.check) return option.check(value, fmt::format("representation '{}', option '{}'", type.name, option.key));
  const std::vector<std::string> alternatives = split_words(option.values);
  if (value == option.default_value || is_in_table(alternatives, value)) return;
  const bool ranges = option.values.find("..") != std::string::npos;
  if (!ranges) bad_word(type, option.key, value, alternatives);
  if (alternatives.size() > 1)
    throw Error(fmt::format("representation '{}'", type.name),
                fmt::format("option {}={} is not one of {}", option.key, printable(value), option.values));
  const size_t dots = option.values.find("..");
  bad_value(type, option.key, value,
            fmt::format("number from {} to {}", option.values.substr(0, dots), option.values.substr(dots + 2)));
}

class Parser {
 public:
  Parser(const std::string& text, const std::vector<RepresentationType>& types) : text_(text), types_(types) {}

  Spec parse() {
    if (text_.size() > kMaxSpecLength) fail("it is too long");
    Spec spec = parse_one(0);
    if (at_ < text_.size()) fail(fmt::format("'{}' is left over", printable(text_.substr(at_))));
    return spec;
  }

 private:
  [[noreturn]] void fail(const std::string& wrong) const {
    throw Error(
        fmt::format("representation '{}'", printable(text_)), wrong,
        "write name, name:key=value,... or, of one that has components, name(component,component,key=value,...)");
  }

  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  bool take(char c) {
    if (peek() != c) return false;
    ++at_;
    return true;
  }
  // Up to the next character of the grammar.
  std::string word() {
    const size_t end = std::min(text_.find_first_of(":,=()", at_), text_.size());
    std::string out = text_.substr(at_, end - at_);
    at_ = end;
    return out;
  }
  // Whether a key=value comes next.
  bool option_ahead() const {
    const size_t end = text_.find_first_of(":,=()", at_);
    return end != std::string::npos && text_[end] == '=';
  }
  std::string key_ahead() const { return text_.substr(at_, text_.find('=', at_) - at_); }

  void parse_option(Spec& spec, const RepresentationType& type) {
    const std::string key = word();
    if (key.empty() || !take('=')) fail(fmt::format("'{}' is not key=value", printable(key)));
    const std::string value = word();
    const std::string where = fmt::format("representation '{}'", type.name);
    const OptionDoc* option = find_option(type, key);
    if (option == nullptr) {
      const std::string near = nearest_name(key, option_keys(type));
      throw Error(
          where, fmt::format("there is no option '{}'", printable(key)),
          near.empty() ? "crowdbench info --representations lists them" : fmt::format("did you mean '{}'?", near));
    }
    if (value.empty()) throw Error(where, fmt::format("option '{}' has no value", key));
    for (const auto& [k, v] : spec.options)
      if (k == key) throw Error(where, fmt::format("option '{}' is given twice", key));
    check_value(type, *option, value);
    spec.options.emplace_back(key, value);
  }

  // One component inside brackets.
  Spec parse_component(int depth) {
    if (!take('(')) return parse_one(depth, true);
    Spec component = parse_one(depth);
    if (!take(')')) fail("a ')' is missing");
    return component;
  }

  // `inside`: in another's brackets without brackets of its own, where a comma may end this spec.
  Spec parse_one(int depth, bool inside = false) {
    if (depth > kMaxSpecDepth) fail("the brackets go too deep");
    Spec spec;
    spec.name = word();
    if (spec.name.empty()) fail("a name is missing");
    const RepresentationType& type = require_type(spec.name, types_);
    spec.name = type.name;
    if (take('(')) {
      do {
        if (option_ahead())
          parse_option(spec, type);
        else if (!spec.options.empty())
          fail("a component follows an option");
        else
          spec.components.push_back(parse_component(depth + 1));
      } while (take(','));
      if (!take(')')) fail("a ')' is missing");
    } else if (take(':')) {
      parse_option(spec, type);
      while (peek() == ',') {
        if (inside) {
          ++at_;
          const bool mine = option_ahead() && find_option(type, key_ahead());
          --at_;
          if (!mine) break;
        }
        ++at_;
        parse_option(spec, type);
      }
    }
    if (spec.components.size() != type.components)
      fail(type.components == 0 ? fmt::format("'{}' takes no components in brackets", type.name)
                                : fmt::format("'{}' takes {} components in brackets, {} given", type.name,
                                              type.components, spec.components.size()));
    return spec;
  }

  const std::string& text_;
  const std::vector<RepresentationType>& types_;
  size_t at_ = 0;
};

}  // namespace

Spec parse_spec(const std::string& text) { return parse_spec(text, representation_types()); }

Spec parse_spec(const std::string& text, const std::vector<RepresentationType>& types) {
  return Parser(text, types).parse();
}

std::vector<Spec> parse_specs(const std::string& text) {
  std::vector<std::string> pieces(1);
  int depth = 0;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    depth += c == '(' ? 1 : c == ')' ? -1 : 0;
    if (c == ',' && depth == 0) {
      const size_t mark = text.find_first_of("=:(,", i + 1);
      if (mark == std::string::npos || text[mark] != '=') {
        pieces.emplace_back();
        continue;
      }
    }
    pieces.back() += c;
  }
  std::vector<Spec> specs;
  specs.reserve(pieces.size());
  for (const std::string& piece : pieces) specs.push_back(parse_spec(piece));
  return specs;
}

std::string canonical_text(const Spec& spec, const std::vector<RepresentationType>& types) {
  const RepresentationType& type = require_type(spec.name, types);
  std::vector<std::string> options;
  // Of a type made of others the first option, which says where one takes over from the other, is what its rows and
  // labels are told apart by: it stays where it was given, though it be the default.
  const auto kept = [&](const std::string& key) { return type.components > 0 && key == type.options.front().key; };
  for (const std::string& key : option_keys(type))
    for (const auto& [k, value] : spec.options)
      if (k == key && (value != find_option(type, key)->default_value || kept(key)))
        options.push_back(key + "=" + value);
  if (spec.components.empty()) {
    std::string out = spec.name;
    for (size_t i = 0; i < options.size(); ++i) out += (i == 0 ? ":" : ",") + options[i];
    return out;
  }
  std::string out = spec.name + "(";
  for (size_t i = 0; i < spec.components.size(); ++i) {
    const std::string component = canonical_text(spec.components[i], types);
    // Brackets keep a component's options its own.
    const bool brackets = component.find(':') != std::string::npos && spec.components[i].components.empty();
    out += (i == 0 ? "" : ",") + (brackets ? "(" + component + ")" : component);
  }
  for (const std::string& o : options) out += "," + o;
  return out + ")";
}

std::string Spec::text() const { return canonical_text(*this, representation_types()); }

const RepresentationType& representation_type(const std::string& name) {
  return require_type(name, representation_types());
}

const RepresentationType& reference_type() {
  const auto& types = representation_types();
  const auto found = std::find_if(types.begin(), types.end(), [](const auto& type) { return type.reference; });
  assert(found != types.end());
  return *found;
}

Spec reference_spec() { return {reference_type().name, {}, {}}; }

Spec default_impostor() {
  const auto& types = representation_types();
  const auto found = std::find_if(types.begin(), types.end(), [](const auto& type) { return type.view_sampling; });
  assert(found != types.end());
  return {found->name, {}, {}};
}

bool stands_alone(const RepresentationType& type) { return type.components == 0; }

std::string example_spec(const RepresentationType& type) {
  if (stands_alone(type)) return type.name + (type.example_options.empty() ? "" : ":" + type.example_options);
  std::vector<std::string> inside;
  for (size_t i = 0; i < type.components; ++i)
    inside.push_back(i == 0 ? reference_spec().name : default_impostor().name);
  if (!type.example_options.empty()) inside.push_back(type.example_options);
  return fmt::format("{}({})", type.name, fmt::join(inside, ","));
}

std::map<std::string, std::string> floors_by_name() {
  std::map<std::string, std::string> out;
  for (const RepresentationType& type : representation_types()) out[type.name] = type.floor;
  return out;
}

bool honours_required_by(const Spec& spec) {
  return representation_type(spec.name).required_by ||
         std::any_of(spec.components.begin(), spec.components.end(), honours_required_by);
}

void require_option_value(const RepresentationType& type, const std::string& key, const std::string& value) {
  if (const OptionDoc* option = find_option(type, key)) check_value(type, *option, value);
}

std::vector<OptionDoc> option_docs(const RepresentationType& type) {
  std::vector<OptionDoc> docs;
  for (const std::string& key : option_keys(type)) docs.push_back(*find_option(type, key));
  return docs;
}

namespace {
constexpr const char* kDebug = "debug";
constexpr const char* kNoDebug = "none";

void set_option(Spec& spec, const std::string& key, const std::string& value) {
  std::erase_if(spec.options, [&](const auto& option) { return option.first == key; });
  spec.options.emplace_back(key, value);
}
}  // namespace

Spec with_floor(Spec spec) {
  set_option(spec, floor_option().key, "1");
  return spec;
}

bool is_floor(const Spec& spec) {
  return std::any_of(spec.options.begin(), spec.options.end(),
                     [](const auto& option) { return option.first == floor_option().key && option.second == "1"; });
}

std::vector<std::string> debug_views(const RepresentationType& type) {
  const OptionDoc* option = find_option(type, kDebug);
  if (!option) return {};
  std::vector<std::string> views = split_words(option->values);
  std::erase(views, kNoDebug);
  return views;
}

std::string debug_views_of_all() {
  std::string out;
  for (const RepresentationType& type : representation_types())
    if (const std::vector<std::string> views = debug_views(type); !views.empty())
      out += fmt::format("{}{} has {}", out.empty() ? "" : "; ", type.name, fmt::join(views, ", "));
  return out;
}

namespace {
// Debug views that a type, or one of the components, offers.
void add_debug_views(const Spec& spec, std::vector<std::string>& views) {
  for (const Spec& component : spec.components) add_debug_views(component, views);
  for (const std::string& view : debug_views(representation_type(spec.name)))
    if (std::find(views.begin(), views.end(), view) == views.end()) views.push_back(view);
}

// "none" is known to everybody who has any.
bool knows(const std::vector<std::string>& views, const std::string& view) {
  return !views.empty() && (view == kNoDebug || std::find(views.begin(), views.end(), view) != views.end());
}

void set_where_known(Spec& spec, const std::string& view) {
  for (Spec& component : spec.components) set_where_known(component, view);
  if (knows(debug_views(representation_type(spec.name)), view)) set_option(spec, kDebug, view);
}
}  // namespace

void set_debug_view(Spec& spec, const std::string& view) {
  std::vector<std::string> views;
  add_debug_views(spec, views);
  if (views.empty())
    throw Error("--debug", fmt::format("'{}' has no debug views", spec.name),
                "crowdbench info --representations names those of the others");
  if (!knows(views, view)) {
    const std::string near = nearest_name(view, views);
    throw Error(
        "--debug", fmt::format("'{}' has no debug view '{}'", spec.name, printable(view)),
        near.empty() ? fmt::format("it has {}", fmt::join(views, ", ")) : fmt::format("did you mean '{}'?", near));
  }
  set_where_known(spec, view);
}

AgentLists all_agents(const scene::Frame& frame) {
  AgentLists lists(frame.agents.size());
  for (size_t c = 0; c < lists.size(); ++c) {
    lists[c].resize(frame.agents[c].size());
    std::iota(lists[c].begin(), lists[c].end(), 0U);
  }
  return lists;
}

std::unique_ptr<Representation> make_representation(const MakeContext& context, const Spec& spec) {
  return representation_type(spec.name).make(context, spec);
}

OptionReader::OptionReader(const RepresentationType& type, const Spec& spec) : type_(type) {
  for (const std::string& key : option_keys(type)) values_[key] = find_option(type, key)->default_value;
  for (const auto& [key, value] : spec.options) values_[key] = value;
}

std::string OptionReader::text(const std::string& key) const {
  const auto found = values_.find(key);
  assert(found != values_.end());
  return found->second;
}

size_t OptionReader::choice(const std::string& key, const std::vector<std::string>& words) const {
  const std::string value = text(key);
  const auto found = std::find(words.begin(), words.end(), value);
  if (found != words.end()) return static_cast<size_t>(found - words.begin());
  bad_word(type_, key, value, words);
}

int64_t OptionReader::integer(const std::string& key, int64_t low, int64_t high) const {
  const std::string value = text(key);
  int64_t number = 0;
  const auto [end, fault] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (fault != std::errc{} || end != value.data() + value.size() || number < low || number > high)
    bad_value(type_, key, value, fmt::format("whole number from {} to {}", low, high));
  return number;
}

double OptionReader::number(const std::string& key, double low, double high) const {
  const std::string value = text(key);
  double number = 0;
  const auto [end, fault] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (fault != std::errc{} || end != value.data() + value.size() || !(number >= low && number <= high))
    bad_value(type_, key, value, fmt::format("number from {} to {}", low, high));
  return number;
}

bool OptionReader::flag(const std::string& key) const {
  const std::string value = text(key);
  if (value != "0" && value != "1") bad_value(type_, key, value, "flag: 0 or 1");
  return value == "1";
}

std::string OptionReader::where(const std::string& key) const {
  return fmt::format("representation '{}', option '{}'", type_.name, key);
}

}  // namespace crowdbench::renderers
