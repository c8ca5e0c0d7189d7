// A table of text: CSV as spreadsheets, statistics packages and experiment libraries write it. What is not a table is
// refused with its line; nothing is guessed.
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace crowdbench::studies {

struct Table {
  struct Row {
    size_t line = 0;  // of the file, from 1, on which it begins
    std::vector<std::string> fields;
  };
  std::string source;  // what messages call the file
  std::vector<std::string> columns;
  std::vector<Row> rows;  // each with as many fields as there are columns
};

constexpr size_t kMostColumns = 1000;
constexpr size_t kMostTableRows = 2'000'000;

// RFC 4180: fields apart by commas (tabs, where the first line has tabs and no comma), quoted where they hold a
// separator, a quote (doubled) or a line break; lines end in LF or CRLF; a byte-order mark is skipped, and so are empty
// lines. Fields lose spaces around them unless they are quoted. The first line names the columns. Throws Error at
// "source:line": no columns, an empty or doubled name, more or fewer fields than columns, a quote that is not closed or
// stands within a bare field, NUL, text that is not UTF-8, no rows, more columns or rows than above.
Table parse_table(std::string_view text, const std::string& source);
// Of a file of at most 256 MiB.
Table read_table(const std::filesystem::path& file);

// Keeps the rows whose field in `column` is `value`: an experiment library's file holds pages of instructions beside
// trials. Throws Error where there is no such column, or no such row.
void keep_rows(Table& table, const std::string& column, const std::string& value);

}  // namespace crowdbench::studies
