#include "store/database.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cctype>
#include <charconv>
#include <cstring>

#include "core/error.h"

namespace crowdbench::store {

void Close::operator()(sqlite3* database) const { sqlite3_close_v2(database); }
void Close::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

void fail(const std::string& where, int code, const char* message) {
  switch (code & 0xff) {
    case SQLITE_NOTADB: throw Error(where, "not a SQLite file", "name a file that `crowdbench bench --out` made");
    case SQLITE_CORRUPT: throw Error(where, "the file is damaged", "measure again into a new file");
    case SQLITE_FULL:
      throw Error(where, "the disk is full", "what was finished before is kept; free some space and run again");
    case SQLITE_READONLY:
    case SQLITE_PERM: throw Error(where, "the file or its folder cannot be written", "choose another --out");
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      throw Error(where, "another program is writing to it", "wait until it has ended, or choose another --out");
    case SQLITE_CANTOPEN: throw Error(where, "cannot be opened", "check the path and its permissions");
    case SQLITE_IOERR:
      throw Error(where, fmt::format("cannot be read or written ({})", message),
                  "what was finished before is kept; check the disk");
    default: throw Error(where, fmt::format("SQLite says: {}", message));
  }
}

Database open(const std::string& name, const std::string& where, int flags) {
  sqlite3* raw = nullptr;
  const int code = sqlite3_open_v2(name.c_str(), &raw, flags, nullptr);
  Database database(raw);
  if (code != SQLITE_OK) fail(where, code, raw != nullptr ? sqlite3_errmsg(raw) : sqlite3_errstr(code));
  sqlite3_extended_result_codes(raw, 1);
  sqlite3_busy_timeout(raw, 2000);
  return database;
}

std::string uri_of(const std::filesystem::path& path, const char* query) {
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(path).string()) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || std::strchr("/-_.~", c) != nullptr;
    uri += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return uri + query;
}

void execute(sqlite3* database, const std::string& where, const std::string& sql) {
  const int code = sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) fail(where, code, sqlite3_errmsg(database));
}

int64_t pragma(sqlite3* database, const std::string& where, const char* name) {
  Statement statement(database, where, fmt::format("PRAGMA {}", name));
  return statement.step() ? statement.read_integer() : 0;
}

std::string identifier(const std::string& name) {
  const bool word = sqlite3_keyword_check(name.c_str(), static_cast<int>(name.size())) != 0;
  return word ? fmt::format("\"{}\"", name) : name;
}

Statement::Statement(sqlite3* database, const std::string& where, const std::string& sql)
    : database_(database), where_(where) {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v2(database, sql.c_str(), -1, &statement, nullptr);
  statement_.reset(statement);
  if (code != SQLITE_OK) fail(where_, code, sqlite3_errmsg(database_));
}

Statement& Statement::bind(ColumnType type, const Value& value) {
  sqlite3_stmt* statement = statement_.get();
  const int at = ++bound_;
  struct Bind {
    sqlite3_stmt* statement;
    int at;
    ColumnType type;
    int text(const std::string& text) const {
      return sqlite3_bind_text64(statement, at, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
    }
    int operator()(std::monostate) const { return sqlite3_bind_null(statement, at); }
    int operator()(bool value) const { return sqlite3_bind_int(statement, at, value ? 1 : 0); }
    int operator()(int64_t value) const { return sqlite3_bind_int64(statement, at, value); }
    int operator()(uint64_t value) const {
      return type == ColumnType::seed ? text(std::to_string(value)) : (*this)(static_cast<int64_t>(value));
    }
    int operator()(double value) const { return sqlite3_bind_double(statement, at, value); }
    int operator()(const std::string& value) const { return text(value); }
    int operator()(const std::vector<uint8_t>& value) const {
      return sqlite3_bind_blob64(statement, at, value.data(), value.size(), SQLITE_TRANSIENT);
    }
  };
  return check(std::visit(Bind{statement, at, type}, value));
}

bool Statement::step() {
  column_ = 0;
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) fail(where_, code, sqlite3_errmsg(database_));
  reset();
  return false;
}

void Statement::reset() {
  sqlite3_reset(statement_.get());
  bound_ = 0;
}

Value Statement::read(ColumnType type) {
  sqlite3_stmt* statement = statement_.get();
  const int at = column_++;
  if (sqlite3_column_type(statement, at) == SQLITE_NULL) return {};
  const auto text = [&] {
    const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement, at));
    return std::string(bytes, static_cast<size_t>(sqlite3_column_bytes(statement, at)));
  };
  // SQLite takes any text for a number, most for 0.
  const bool number = type == ColumnType::boolean || type == ColumnType::integer || type == ColumnType::real;
  const int kind = sqlite3_column_type(statement, at);
  if (number && kind != SQLITE_INTEGER && kind != SQLITE_FLOAT)
    throw Error(
        where_,
        fmt::format("'{}' in column {} is not a number", printable(text(), 60), sqlite3_column_name(statement, at)),
        "the file is damaged");
  switch (type) {
    case ColumnType::boolean: return sqlite3_column_int(statement, at) != 0;
    case ColumnType::integer: return int64_t{sqlite3_column_int64(statement, at)};
    case ColumnType::real: return sqlite3_column_double(statement, at);
    case ColumnType::text: return text();
    case ColumnType::seed: {
      const std::string digits = text();
      uint64_t value = 0;
      const auto [end, failed] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
      if (failed != std::errc() || end != digits.data() + digits.size())
        throw Error(where_, fmt::format("'{}' is not a seed", printable(digits)), "the file is damaged");
      return value;
    }
    case ColumnType::bytes: {
      const auto* data = static_cast<const uint8_t*>(sqlite3_column_blob(statement, at));
      return std::vector<uint8_t>(data, data + sqlite3_column_bytes(statement, at));
    }
  }
  return {};
}

int64_t Statement::read_integer() {
  const Value value = read(ColumnType::integer);
  return std::holds_alternative<int64_t>(value) ? std::get<int64_t>(value) : 0;
}

Statement& Statement::check(int code) {
  if (code != SQLITE_OK) fail(where_, code, sqlite3_errmsg(database_));
  return *this;
}

}  // namespace crowdbench::store
