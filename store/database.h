// SQLite behind the result store: an open file, one prepared statement, and its failures as Errors that say what to do.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "store/columns.h"

struct sqlite3;
struct sqlite3_stmt;

namespace crowdbench::store {

struct Close {
  void operator()(sqlite3* database) const;
  void operator()(sqlite3_stmt* statement) const;
};
using Database = std::unique_ptr<sqlite3, Close>;

// Throws the Error for a result code of SQLite. where: the file.
[[noreturn]] void fail(const std::string& where, int code, const char* message);

// name: a path or a URI; flags: of sqlite3_open_v2. Throws Error.
Database open(const std::string& name, const std::string& where, int flags);
// A path as a SQLite URI: everything but plain characters is escaped.
std::string uri_of(const std::filesystem::path& path, const char* query);
// Throws Error.
void execute(sqlite3* database, const std::string& where, const std::string& sql);
int64_t pragma(sqlite3* database, const std::string& where, const char* name);
// A name as SQL takes it: in quotes where it is a word of SQL.
std::string identifier(const std::string& name);

// One prepared statement, bound from left to right and read from left to right. All throw Error.
class Statement {
 public:
  Statement(sqlite3* database, const std::string& where, const std::string& sql);

  Statement& bind(ColumnType type, const Value& value);
  Statement& bind(int64_t value) { return bind(ColumnType::integer, value); }
  Statement& bind(const std::string& text) { return bind(ColumnType::text, text); }
  // Whether there is a row; after the last the statement can be bound anew.
  bool step();
  void reset();

  // The next column of the row.
  Value read(ColumnType type);
  int64_t read_integer();

 private:
  Statement& check(int code);

  sqlite3* database_;
  std::string where_;
  std::unique_ptr<sqlite3_stmt, Close> statement_;
  int bound_ = 0;
  int column_ = 0;
};

}  // namespace crowdbench::store
