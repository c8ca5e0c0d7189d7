// toml11 behind a scan that refuses what would overflow its stack or confuse its lexer. The only file that includes it.
#include "scene/scenario/toml_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <toml.hpp>

#include "core/error.h"
#include "scene/scenario/scenario_keys.h"

namespace crowdbench::scene {
namespace {

using Toml = toml::basic_value<toml::discard_comments, std::map, std::vector>;

constexpr int kDepth = 16;           // open brackets at once, outside of texts
constexpr int kDotsPerLine = 256;    // dotted keys nest without brackets
constexpr size_t kLineBytes = 8192;  // its time grows with the square of a line's length

std::string line_place(const std::string& where, size_t line) { return fmt::format("{}:{}", where, line); }

// Length of the UTF-8 sequence at `at`, 0 when it is not one (overlong, surrogate, beyond U+10FFFF, cut off).
size_t utf8_length(const std::string& text, size_t at) {
  const auto byte = [&](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const unsigned first = byte(at);
  if (first < 0x80) return 1;
  const size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4) return 0;
  for (size_t i = 1; i < length; ++i)
    if ((byte(at + i) & 0xc0) != 0x80) return 0;
  const unsigned second = byte(at + 1);
  if ((first == 0xe0 && second < 0xa0) || (first == 0xed && second > 0x9f) || (first == 0xf0 && second < 0x90) ||
      (first == 0xf4 && second > 0x8f))
    return 0;
  return length;
}

// What a character of TOML means depends on what it stands in.
enum class In : uint8_t { plain, comment, basic, literal, basic_block, literal_block };

struct Scan {
  In in = In::plain;
  int depth = 0;  // of brackets
  int dots = 0;   // on this line
};

// One character outside of texts and comments. Whether it opens a block of text, which takes three quotes.
bool take_plain(Scan& scan, char c, bool triple) {
  if (c == '#') {
    scan.in = In::comment;
  } else if (triple) {
    scan.in = c == '"' ? In::basic_block : In::literal_block;
    return true;
  } else if (c == '"') {
    scan.in = In::basic;
  } else if (c == '\'') {
    scan.in = In::literal;
  } else if (c == '[' || c == '{') {
    ++scan.depth;
  } else if (c == ']' || c == '}') {
    scan.depth = std::max(0, scan.depth - 1);
  } else if (c == '.') {
    ++scan.dots;
  }
  return false;
}

// One character of `length` bytes; how many bytes it takes with it: those of three quotes that open or close a block,
// and a quote or backslash that is escaped. next: the byte after it; 0: none.
size_t take(Scan& scan, char c, size_t length, bool triple, bool line_end, char next) {
  const bool block = scan.in == In::basic_block || scan.in == In::literal_block;
  const bool escapes = scan.in == In::basic || scan.in == In::basic_block;
  if (scan.in == In::plain) return take_plain(scan, c, triple) ? 3 : length;
  if (scan.in == In::comment) return length;
  // Other escaped bytes may end a line or begin a longer character: they are looked at in their turn.
  if (escapes && c == '\\') return next == '"' || next == '\\' ? 2 : 1;
  const bool quote = c == (escapes ? '"' : '\'');
  if (block ? quote && triple : quote || line_end) {
    scan.in = In::plain;
    return block ? 3 : length;
  }
  return length;
}

void refuse_bytes(char c, size_t length, bool line_end, const std::string& where, size_t line) {
  const auto byte = static_cast<unsigned char>(c);
  if (length == 0) throw Error(line_place(where, line), "is not valid UTF-8", "save the file as UTF-8");
  if ((byte < 0x20 && c != '\t' && !line_end) || byte == 0x7f)
    throw Error(line_place(where, line),
                fmt::format("holds the control character 0x{:02x}", static_cast<unsigned>(byte)),
                "remove it, or write it as \\u00XX inside double quotes");
}

void refuse_excess(const Scan& scan, size_t line_bytes, const std::string& where, size_t line) {
  if (scan.depth > kDepth)
    throw Error(line_place(where, line), fmt::format("brackets nest deeper than {}", kDepth),
                "no key needs more than a few");
  if (scan.dots > kDotsPerLine)
    throw Error(line_place(where, line), fmt::format("has more than {} dots", kDotsPerLine), "break the line up");
  if (line_bytes > kLineBytes)
    throw Error(line_place(where, line), fmt::format("is longer than {} bytes", kLineBytes), "break the line up");
}

// Refuses, with its line, what toml11 must not see: it recurses once a bracket and once a dot, and takes any byte.
void scan_text(const std::string& text, const std::string& where) {
  if (text.size() > kScenarioBytes)
    throw Error(where, fmt::format("is {} bytes, more than the limit of {}", text.size(), kScenarioBytes),
                "scenarios and plans are short texts; is this the right file?");
  Scan scan;
  size_t line = 1;
  size_t line_start = 0;
  for (size_t i = 0; i < text.size();) {
    const char c = text[i];
    const char next = i + 1 < text.size() ? text[i + 1] : '\0';
    const size_t length = utf8_length(text, i);
    const bool line_end = c == '\n' || (c == '\r' && next == '\n');
    refuse_bytes(c, length, line_end, where, line);
    const bool triple = (c == '"' || c == '\'') && text.compare(i, 3, std::string(3, c)) == 0;
    const size_t step = take(scan, c, length, triple, line_end, next);
    refuse_excess(scan, i - line_start, where, line);
    if (c == '\n') {
      ++line;
      scan.dots = 0;
      line_start = i;
      if (scan.in == In::comment) scan.in = In::plain;
    }
    i += step;
  }
}

// toml11 says "[error] toml::parse_x: what went wrong" and then several lines of source: the middle is what we want.
std::string first_line(const std::string& message) {
  std::string line = message.substr(0, message.find('\n'));
  if (const size_t at = line.rfind("toml::"); at != std::string::npos) {
    const size_t colon = line.find(": ", at);
    if (colon != std::string::npos) line = line.substr(colon + 2);
  }
  return line.empty() ? "is not TOML" : line;
}

// Two of its refusals are of the order in which tables stand, which its words do not say.
const char* advice_on(std::string_view what) {
  return what.find("already exists") != std::string_view::npos
             ? "give a table's head once, [axes] above the [[axes.name]] that belong to it; the syntax is at "
               "https://toml.io"
             : "see https://toml.io for the syntax";
}

Toml parse_text(const std::string& text, const std::string& where) {
  std::istringstream stream(text);
  try {
    return toml::parse<toml::discard_comments, std::map, std::vector>(stream, where);
  } catch (const toml::exception& error) {
    const size_t lines = 1 + static_cast<size_t>(std::count(text.begin(), text.end(), '\n'));
    throw Error(line_place(where, std::clamp<size_t>(error.location().line(), 1, lines)), first_line(error.what()),
                advice_on(error.what()));
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {  // its lexer lets std::out_of_range and std::runtime_error through
    throw Error(where, first_line(error.what()), "see https://toml.io for the syntax");
  }
}

// By where they stand in the text: toml11 keeps tables by name.
void keep_order(std::vector<std::pair<std::pair<size_t, size_t>, TomlNode::Entry>>& placed, TomlNode& out) {
  std::stable_sort(placed.begin(), placed.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (auto& [place, entry] : placed) out.table.push_back(std::move(entry));
}

TomlNode node_of(const Toml& value) {
  TomlNode out;
  out.line = std::max<size_t>(1, value.location().line());
  switch (value.type()) {
    case toml::value_t::boolean:
      out.type = TomlNode::Type::boolean;
      out.boolean = value.as_boolean();
      break;
    case toml::value_t::integer:
      out.type = TomlNode::Type::integer;
      out.integer = value.as_integer();
      break;
    case toml::value_t::floating:
      out.type = TomlNode::Type::number;
      out.number = value.as_floating();
      break;
    case toml::value_t::string:
      out.type = TomlNode::Type::text;
      out.text = value.as_string().str;
      break;
    case toml::value_t::array:
      out.type = TomlNode::Type::list;
      for (const Toml& entry : value.as_array()) out.list.push_back(node_of(entry));
      break;
    case toml::value_t::table: {
      std::vector<std::pair<std::pair<size_t, size_t>, TomlNode::Entry>> placed;
      for (const auto& [name, entry] : value.as_table())
        placed.push_back({{entry.location().line(), entry.location().column()}, {name, node_of(entry)}});
      keep_order(placed, out);
      break;
    }
    default: out.type = TomlNode::Type::time; break;
  }
  return out;
}

}  // namespace

std::string TomlNode::place(const std::string& where) const { return line_place(where, line); }

const TomlNode* TomlNode::find(const std::string& name) const {
  for (const Entry& entry : table)
    if (entry.first == name) return &entry.second;
  return nullptr;
}

const char* TomlNode::type_name() const {
  switch (type) {
    case Type::boolean: return "a truth value";
    case Type::integer: return "an integer";
    case Type::number: return "a number";
    case Type::text: return "a text";
    case Type::list: return "a list";
    case Type::table: return "a table";
    case Type::time: break;
  }
  return "a date or time";
}

TomlNode parse_toml(const std::string& text, const std::string& where) {
  scan_text(text, where);
  return node_of(parse_text(text, where));
}

}  // namespace crowdbench::scene
