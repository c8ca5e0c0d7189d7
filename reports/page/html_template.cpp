// Based on: mustache(5), the manual of the template language (variables, sections, inverted sections, standalone tags).
// Differs from the source as the header says; neither partials, comments nor changed delimiters are understood.
#include "reports/page/html_template.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "reports/page/escape.h"

namespace crowdbench::reports {
namespace {

struct Node {
  enum class Kind { text, value, section, inverted };
  Kind kind = Kind::text;
  std::string_view text;  // of a text; else the name
  std::vector<Node> nodes;
};

[[noreturn]] void mistake(const std::string& what) { throw std::logic_error("template: " + what); }

class Parser {
 public:
  explicit Parser(std::string_view html) : html_(html) {}

  std::vector<Node> parse() { return parse_until({}); }

 private:
  // Up to the end tag of the section `open`, or to the end of the text where it is empty.
  std::vector<Node> parse_until(std::string_view open) {
    std::vector<Node> nodes;
    while (true) {
      const size_t tag = html_.find("{{", at_);
      if (tag == std::string_view::npos) {
        if (!open.empty()) mistake(fmt::format("section {} has no end", open));
        nodes.push_back({Node::Kind::text, html_.substr(at_), {}});
        at_ = html_.size();
        return nodes;
      }
      const size_t end = html_.find("}}", tag);
      if (end == std::string_view::npos) mistake(fmt::format("tag at byte {} has no end", tag));
      std::string_view name = html_.substr(tag + 2, end - tag - 2);
      const char sign = name.empty() ? ' ' : name.front();
      const bool section = sign == '#' || sign == '^' || sign == '/';
      if (section) name.remove_prefix(1);
      check_name(name);
      const auto [text_end, next] = section ? without_own_line(tag, end + 2) : std::pair(tag, end + 2);
      nodes.push_back({Node::Kind::text, html_.substr(at_, text_end - at_), {}});
      at_ = next;
      if (sign == '/') {
        if (name != open) mistake(fmt::format("section {} is ended by {}", open.empty() ? "(none)" : open, name));
        return nodes;
      }
      if (sign == '#')
        nodes.push_back({Node::Kind::section, name, parse_until(name)});
      else if (sign == '^')
        nodes.push_back({Node::Kind::inverted, name, parse_until(name)});
      else
        nodes.push_back({Node::Kind::value, name, {}});
    }
  }

  static void check_name(std::string_view name) {
    const auto allowed = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
    if (name.empty() || !std::all_of(name.begin(), name.end(), allowed))
      mistake(fmt::format("'{}' is not a name (a-z, 0-9, _)", name));
  }

  // Where the text before a tag ends and the text behind it begins: the whole line goes where the tag has it for its
  // own.
  std::pair<size_t, size_t> without_own_line(size_t tag, size_t end) const {
    size_t begin = tag;
    while (begin > at_ && html_[begin - 1] == ' ') --begin;
    const bool opens = begin == 0 || html_[begin - 1] == '\n';
    size_t next = end;
    while (next < html_.size() && html_[next] == ' ') ++next;
    if (!opens || (next < html_.size() && html_[next] != '\n')) return {tag, end};
    return {begin, std::min(next + 1, html_.size())};
  }

  std::string_view html_;
  size_t at_ = 0;
};

void names_in(const std::vector<Node>& nodes, std::set<std::string_view>& names) {
  for (const Node& node : nodes) {
    if (node.kind != Node::Kind::text) names.insert(node.text);
    names_in(node.nodes, names);
  }
}

}  // namespace

class TemplateFiller {
 public:
  void fill(const std::vector<Node>& nodes, const TemplateValues& values, std::string& out) {
    std::set<std::string_view> names;
    names_in(nodes, names);
    for (const auto& [name, value] : values.values_)
      if (!names.contains(name)) mistake(fmt::format("value {} has no place", name));
    around_.push_back(&values);
    for (const Node& node : nodes) fill(node, out);
    around_.pop_back();
  }

 private:
  void fill(const Node& node, std::string& out) {
    if (node.kind == Node::Kind::text) {
      out += node.text;
      return;
    }
    const auto& value = find(node.text).value_;
    if (node.kind == Node::Kind::value) {
      if (const auto* text = std::get_if<std::string>(&value))
        out += html_escape(*text);
      else if (const auto* html = std::get_if<Html>(&value))
        out += html->text;
      else
        mistake(fmt::format("{} is a list or a condition, not a text", node.text));
      return;
    }
    if (const auto* rows = std::get_if<std::vector<TemplateValues>>(&value)) {
      if (node.kind == Node::Kind::inverted)
        shown_if(rows->empty(), node, out);
      else
        for (const TemplateValues& row : *rows) fill(node.nodes, row, out);
    } else if (const auto* holds = std::get_if<bool>(&value)) {
      shown_if(*holds == (node.kind == Node::Kind::section), node, out);
    } else {
      mistake(fmt::format("{} is a text, not a list or a condition", node.text));
    }
  }

  // What is not shown is filled all the same, so that its mistakes are found.
  void shown_if(bool holds, const Node& node, std::string& out) {
    std::string unseen;
    for (const Node& inner : node.nodes) fill(inner, holds ? out : unseen);
  }

  const TemplateValue& find(std::string_view name) const {
    for (auto values = around_.rbegin(); values != around_.rend(); ++values)
      if (const auto found = (*values)->values_.find(name); found != (*values)->values_.end()) return found->second;
    mistake(fmt::format("{} has no value", name));
  }

  std::vector<const TemplateValues*> around_;  // the innermost last
};

TemplateValue::TemplateValue(std::string text) : value_(std::move(text)) {}
TemplateValue::TemplateValue(const char* text) : value_(std::string(text)) {}
TemplateValue::TemplateValue(Html html) : value_(std::move(html)) {}
TemplateValue::TemplateValue(std::vector<TemplateValues> rows) : value_(std::move(rows)) {}

Html fill_template(std::string_view html, const TemplateValues& values) {
  Html filled;
  TemplateFiller().fill(Parser(html).parse(), values, filled.text);
  return filled;
}

}  // namespace crowdbench::reports
