#include "studies/analysis/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/error.h"
#include "core/files.h"

namespace crowdbench::studies {
namespace {

constexpr size_t kMostBytes = size_t{256} << 20U;
constexpr size_t kMostNameBytes = 200;

std::string place(const std::string& source, size_t line) { return fmt::format("{}:{}", source, line); }

// How many bytes the UTF-8 sequence takes that begins with `lead`; 0: none begins so.
size_t sequence_bytes(unsigned char lead) {
  if (lead < 0x80U) return 1;
  if (lead >= 0xc2U && lead < 0xe0U) return 2;
  if (lead >= 0xe0U && lead < 0xf0U) return 3;
  return lead >= 0xf0U && lead < 0xf5U ? 4 : 0;
}

// Whether a sequence is the shortest of its character, and that is one.
bool is_character(std::string_view bytes) {
  const auto lead = static_cast<unsigned char>(bytes[0]);
  for (size_t i = 1; i < bytes.size(); ++i)
    if ((static_cast<unsigned char>(bytes[i]) & 0xc0U) != 0x80U) return false;
  if (bytes.size() < 3) return true;
  const auto second = static_cast<unsigned char>(bytes[1]);
  if (lead == 0xe0U) return second >= 0xa0U;
  if (lead == 0xedU) return second < 0xa0U;  // surrogates
  if (lead == 0xf0U) return second >= 0x90U;
  return lead != 0xf4U || second < 0x90U;
}

void require_text(std::string_view text, const std::string& source) {
  size_t line = 1;
  for (size_t at = 0; at < text.size();) {
    const auto lead = static_cast<unsigned char>(text[at]);
    if (lead == 0)
      throw Error(place(source, line), "holds a NUL byte", "this is not a table of text: export it as CSV");
    const size_t bytes = sequence_bytes(lead);
    if (bytes == 0 || at + bytes > text.size() || !is_character(text.substr(at, bytes)))
      throw Error(place(source, line), "is not UTF-8", "export the table as CSV in UTF-8");
    if (lead == '\n') ++line;
    at += bytes;
  }
}

// Takes the text apart, record by record.
class Reader {
 public:
  Reader(std::string_view text, const std::string& source, char separator)
      : text_(text), source_(source), separator_(separator) {}

  // False at the end of the text. Empty lines are none.
  bool next(Table::Row& row) {
    while (at_ < text_.size() && end_of_line(at_)) take_line_end();
    if (at_ >= text_.size()) return false;
    row.line = line_;
    row.fields.clear();
    while (true) {
      row.fields.push_back(at_ < text_.size() && text_[skip_spaces()] == '"' ? quoted() : bare());
      if (row.fields.size() > kMostColumns)
        throw Error(place(source_, row.line), fmt::format("has more than {} fields", kMostColumns), "");
      if (at_ >= text_.size()) return true;
      if (text_[at_] == separator_) {
        ++at_;
        continue;
      }
      take_line_end();
      return true;
    }
  }

 private:
  bool end_of_line(size_t at) const {
    return text_[at] == '\n' || (text_[at] == '\r' && (at + 1 == text_.size() || text_[at + 1] == '\n'));
  }
  void take_line_end() {
    at_ += text_[at_] == '\r' ? 2 : 1;
    ++line_;
  }
  // Where the field begins behind spaces; the separator is none of them.
  size_t skip_spaces() const {
    size_t at = at_;
    while (at + 1 < text_.size() && text_[at] == ' ') ++at;
    return at;
  }
  std::string quoted() {
    const size_t began = line_;
    at_ = skip_spaces() + 1;
    std::string out;
    while (true) {
      if (at_ >= text_.size())
        throw Error(place(source_, began), "opens a quote that is not closed", "close it, or double it within a field");
      if (text_[at_] == '"' && at_ + 1 < text_.size() && text_[at_ + 1] == '"')
        ++at_;
      else if (text_[at_] == '"')
        break;
      if (text_[at_] == '\n') ++line_;
      out += text_[at_++];
    }
    ++at_;
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
    if (at_ < text_.size() && text_[at_] != separator_ && !end_of_line(at_))
      throw Error(place(source_, line_), "goes on after a closing quote", "double the quotes within a quoted field");
    return out;
  }
  std::string bare() {
    const size_t from = at_;
    while (at_ < text_.size() && text_[at_] != separator_ && !end_of_line(at_)) {
      if (text_[at_] == '"')
        throw Error(place(source_, line_), "has a quote within a bare field", "quote the whole field, and double it");
      ++at_;
    }
    std::string_view field = text_.substr(from, at_ - from);
    while (field.starts_with(' ')) field.remove_prefix(1);
    while (field.ends_with(' ')) field.remove_suffix(1);
    return std::string(field);
  }

  std::string_view text_;
  const std::string& source_;
  char separator_;
  size_t at_ = 0;
  size_t line_ = 1;
};

void require_columns(const Table& table, size_t line) {
  if (table.columns.size() == 1 && table.columns[0].find(';') != std::string::npos)
    throw Error(place(table.source, line), "separates columns by semicolons, as spreadsheets with decimal commas do",
                "export the table with commas (or tabs) between columns and points in numbers");
  std::set<std::string> seen;
  for (size_t i = 0; i < table.columns.size(); ++i) {
    const std::string& name = table.columns[i];
    if (name.empty())
      throw Error(place(table.source, line), fmt::format("column {} has no name", i + 1),
                  "the first line names the columns");
    if (name.size() > kMostNameBytes)
      throw Error(place(table.source, line),
                  fmt::format("the name of column {} is longer than {} bytes", i + 1, kMostNameBytes),
                  "the first line names the columns");
    if (!seen.insert(name).second)
      throw Error(place(table.source, line), fmt::format("two columns are named '{}'", printable(name)),
                  "rename one of them");
  }
}

}  // namespace

Table parse_table(std::string_view text, const std::string& source) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  require_text(text, source);
  const std::string_view first = text.substr(0, text.find('\n'));
  const bool tabs = first.find('\t') != std::string_view::npos && first.find(',') == std::string_view::npos;
  Reader reader(text, source, tabs ? '\t' : ',');
  Table out;
  out.source = source;
  Table::Row row;
  if (!reader.next(row)) throw Error(place(source, 1), "the file is empty", "its first line is to name the columns");
  const size_t header = row.line;
  out.columns = std::move(row.fields);
  require_columns(out, header);
  while (reader.next(row)) {
    if (row.fields.size() != out.columns.size())
      throw Error(place(source, row.line),
                  fmt::format("has {} fields where there are {} columns", row.fields.size(), out.columns.size()),
                  "quote fields that hold a separator");
    if (out.rows.size() == kMostTableRows)
      throw Error(place(source, row.line), fmt::format("the table has more than {} rows", kMostTableRows), "");
    out.rows.push_back(std::move(row));
    row = {};
  }
  if (out.rows.empty()) throw Error(place(source, header), "there are no rows below the names of the columns", "");
  return out;
}

Table read_table(const std::filesystem::path& file) { return parse_table(read_text(file, kMostBytes), file.string()); }

void keep_rows(Table& table, const std::string& column, const std::string& value) {
  const auto found = std::find(table.columns.begin(), table.columns.end(), column);
  if (found == table.columns.end())
    throw Error(table.source + ":1", fmt::format("there is no column '{}'", printable(column)),
                fmt::format("there are {}", nearest_first(column, table.columns)));
  const auto at = static_cast<size_t>(found - table.columns.begin());
  std::erase_if(table.rows, [&](const Table::Row& row) { return row.fields[at] != value; });
  if (table.rows.empty())
    throw Error(table.source,
                fmt::format("no row has '{}' in column '{}'", printable(value, 60), printable(column, 60)),
                "see --where");
}

}  // namespace crowdbench::studies
