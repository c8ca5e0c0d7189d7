// The SQL that the description of the columns (store/columns.h) amounts to, and how older files are brought to it.
#pragma once
#include <string>

#include "store/columns.h"

struct sqlite3;

namespace crowdbench::store {

// Every table, index and the view `results` (one row a measurement, what is known of its run included).
std::string create_sql();

// What a SELECT names to get the columns of one table, in order and in their present meaning, from a file of this
// schema or an older one. With an owner, its id comes first.
std::string selected(const TableDescription& table, int schema);
// Whether files of that schema have the table.
bool has_table(const TableDescription& table, int schema);

std::string insert_sql(const TableDescription& table);

// Brings an open file of an older schema to this one: tables whose columns changed are made anew and filled from the
// old ones, all others stay as they are. To be called within a transaction, with foreign keys off. Throws Error.
void migrate(sqlite3* database, const std::string& where, int from);

}  // namespace crowdbench::store
