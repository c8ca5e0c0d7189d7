#include <fmt/format.h>

#include "studies/analysis/analysis_output.h"
#include "studies/analysis/analysis_text.h"

namespace crowdbench::studies {
namespace {

enum class Form { markdown, terminal };

// Text that stands as it is, whatever it holds: Markdown's marks are escaped, of a terminal nothing is.
std::string plain(const std::string& text, Form form) {
  if (form == Form::terminal) return text;
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    // A tag begins with a letter, / or !; "p < 0.001" does not.
    const bool tag = c == '<' && i + 1 < text.size() && text[i + 1] != ' ';
    if (tag || c == '|' || c == '`' || c == '[' || c == '*' || c == '_' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

std::string markdown_row(const std::vector<std::string>& cells, Form form) {
  std::string out = "|";
  for (const std::string& cell : cells) out += fmt::format(" {} |", plain(cell, form));
  return out + "\n";
}

std::string markdown(const TextTable& table, Form form) {
  std::string out = markdown_row(table.columns, form) + "|";
  for (size_t i = 0; i < table.columns.size(); ++i) out += i < table.words ? "---|" : "--:|";
  out += "\n";
  for (const auto& row : table.rows) out += markdown_row(row, form);
  return out;
}

std::string list_of(const std::vector<std::string>& items, Form form) {
  std::string out;
  for (const std::string& item : items) out += fmt::format("- {}\n", plain(item, form));
  return out;
}

std::string markdown(const Section& s, Form form) {
  std::string out = fmt::format("\n### {}\n", s.heading);
  if (!s.lead.empty()) out += "\n" + plain(s.lead, form) + "\n";
  if (s.table) out += "\n" + markdown(*s.table, form);
  if (!s.list.empty()) out += "\n" + list_of(s.list, form);
  if (!s.note.empty()) out += "\n" + plain(s.note, form) + "\n";
  return out;
}

std::string told(const Analysis& a, const std::vector<std::string>& standing, Form form) {
  const AnalysisText text = analysis_text(a);
  std::string out = "# What " + text.who + " answered\n";
  for (const std::string& sentence : standing) out += "\n" + plain(sentence, form) + "\n";
  for (const std::string& sentence : text.lead) out += "\n" + plain(sentence, form) + "\n";
  for (const TaskText& task : text.tasks) {
    out += fmt::format("\n## {}\n\n", plain(task.name, form)) + list_of(task.verdicts, form);
    for (const Section& section : task.sections) out += markdown(section, form);
  }
  return out;
}

}  // namespace

std::string analysis_markdown(const Analysis& a, const std::vector<std::string>& standing) {
  return told(a, standing, Form::markdown);
}

std::string analysis_plain(const Analysis& a, const std::vector<std::string>& standing) {
  return told(a, standing, Form::terminal);
}

}  // namespace crowdbench::studies
