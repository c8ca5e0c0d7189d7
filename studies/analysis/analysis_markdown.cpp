#include <fmt/format.h>

#include "studies/analysis/analysis_output.h"
#include "studies/analysis/analysis_text.h"

namespace crowdbench::studies {
namespace {

// Text that stands as it is, whatever it holds.
std::string plain(const std::string& text) {
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

std::string markdown_row(const std::vector<std::string>& cells) {
  std::string out = "|";
  for (const std::string& cell : cells) out += fmt::format(" {} |", plain(cell));
  return out + "\n";
}

std::string markdown(const TextTable& table) {
  std::string out = markdown_row(table.columns) + "|";
  for (size_t i = 0; i < table.columns.size(); ++i) out += i < table.words ? "---|" : "--:|";
  out += "\n";
  for (const auto& row : table.rows) out += markdown_row(row);
  return out;
}

std::string list_of(const std::vector<std::string>& items) {
  std::string out;
  for (const std::string& item : items) out += fmt::format("- {}\n", plain(item));
  return out;
}

std::string markdown(const Section& s) {
  std::string out = fmt::format("\n### {}\n", s.heading);
  if (!s.lead.empty()) out += "\n" + plain(s.lead) + "\n";
  if (s.table) out += "\n" + markdown(*s.table);
  if (!s.list.empty()) out += "\n" + list_of(s.list);
  if (!s.note.empty()) out += "\n" + plain(s.note) + "\n";
  return out;
}

}  // namespace

std::string analysis_markdown(const Analysis& a, const std::vector<std::string>& standing) {
  const AnalysisText text = analysis_text(a);
  std::string out = "# Answers\n";
  for (const std::string& sentence : standing) out += "\n" + plain(sentence) + "\n";
  for (const std::string& sentence : text.lead) out += "\n" + plain(sentence) + "\n";
  for (const TaskText& task : text.tasks) {
    out += fmt::format("\n## {}\n\n", plain(task.name)) + list_of(task.verdicts);
    for (const Section& section : task.sections) out += markdown(section);
  }
  return out;
}

}  // namespace crowdbench::studies
