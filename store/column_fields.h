// How the columns of a table are told from the members of its row: for the files that describe tables (columns*.cpp).
#pragma once
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "store/columns.h"

namespace crowdbench::column_fields {

template <typename T>
struct OptionalOf {
  static constexpr bool value = false;
  using Type = T;
};
template <typename T>
struct OptionalOf<std::optional<T>> {
  static constexpr bool value = true;
  using Type = T;
};

template <typename T>
Value value_of(const T& member) {
  if constexpr (OptionalOf<T>::value)
    return member ? value_of(*member) : Value();
  else if constexpr (std::is_same_v<T, Status>)
    return std::string(status_name(member));
  else if constexpr (std::is_integral_v<T> && std::is_signed_v<T>)
    return int64_t{member};
  else if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>)
    return uint64_t{member};
  else
    return member;
}

// A column of integers is read as int64_t, whatever the sign of its members.
template <typename T>
T member_of(Value value) {
  if constexpr (std::is_same_v<T, Status>)
    return status_of(std::get<std::string>(value));
  else if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>)
    return std::holds_alternative<uint64_t>(value) ? static_cast<T>(std::get<uint64_t>(value))
                                                   : static_cast<T>(std::get<int64_t>(value));
  else
    return std::get<T>(std::move(value));
}

template <typename T>
constexpr ColumnType type_of() {
  if constexpr (std::is_same_v<T, bool>)
    return ColumnType::boolean;
  else if constexpr (std::is_integral_v<T>)
    return ColumnType::integer;
  else if constexpr (std::is_floating_point_v<T>)
    return ColumnType::real;
  else if constexpr (std::is_same_v<T, std::vector<uint8_t>>)
    return ColumnType::bytes;
  else
    return ColumnType::text;
}

// A member, or a member of a member, which may lie in an optional: absent together.
template <auto First, auto... Rest>
struct Member;
template <typename Class, typename T, T Class::*First, auto... Rest>
struct Member<First, Rest...> {
  using Row = Class;
  using Plain = typename OptionalOf<T>::Type;

  static constexpr ColumnType type() {
    if constexpr (sizeof...(Rest) == 0)
      return type_of<Plain>();
    else
      return Member<Rest...>::type();
  }
  static constexpr bool optional() {
    if constexpr (sizeof...(Rest) == 0)
      return OptionalOf<T>::value;
    else
      return OptionalOf<T>::value || Member<Rest...>::optional();
  }
  static Value get(const Row& row) {
    if constexpr (sizeof...(Rest) == 0)
      return value_of(row.*First);
    else if constexpr (OptionalOf<T>::value)
      return row.*First ? Member<Rest...>::get(*(row.*First)) : Value();
    else
      return Member<Rest...>::get(row.*First);
  }
  static void set(Row& row, Value value) {
    if (std::holds_alternative<std::monostate>(value)) return;
    if constexpr (sizeof...(Rest) == 0) {
      row.*First = member_of<Plain>(std::move(value));
    } else if constexpr (OptionalOf<T>::value) {
      if (!(row.*First)) (row.*First).emplace();
      Member<Rest...>::set(*(row.*First), std::move(value));
    } else {
      Member<Rest...>::set(row.*First, std::move(value));
    }
  }
};

template <auto... Path>
using RowOf = typename Member<Path...>::Row;

template <auto... Path>
Field<RowOf<Path...>> field(Column column) {
  using M = Member<Path...>;
  if (column.type != ColumnType::seed) column.type = M::type();
  column.optional = M::optional();
  return {std::move(column), &M::get, &M::set};
}

template <auto... Path>
Field<RowOf<Path...>> id_field() {
  return field<Path...>({.name = "id", .meaning = "number of the row, given by the store", .key = true});
}

template <auto... Path>
Field<RowOf<Path...>> run_field() {
  return field<Path...>({.name = "run", .meaning = "the run that this belongs to", .references = "run"});
}

template <auto Key>
std::vector<Field<RowOf<Key>>> point_fields() {
  return {
      field<Key, &PointKey::representation>(
          {.name = "representation", .meaning = "what was drawn: its canonical text, options included", .point = true}),
      field<Key, &PointKey::character>(
          {.name = "character", .meaning = "sources of the characters, joined by \" + \"", .point = true}),
      field<Key, &PointKey::agents>(
          {.name = "agents", .unit = "agents", .meaning = "size of the crowd", .point = true}),
      field<Key, &PointKey::width>(
          {.name = "width_px", .unit = "px", .meaning = "width of the picture", .point = true}),
      field<Key, &PointKey::height>(
          {.name = "height_px", .unit = "px", .meaning = "height of the picture", .point = true}),
      field<Key, &PointKey::requested_occupancy>(
          {.name = "requested_occupancy",
           .unit = "fraction",
           .meaning = "share of the picture that the reference shall cover; 0: the scenario's own camera",
           .point = true}),
  };
}

template <auto Time>
std::vector<Field<RowOf<Time>>> time_fields(const std::string& name, const std::string& what) {
  const auto column = [&](const char* suffix, const std::string& meaning) {
    return Column{.name = name + suffix, .unit = "ns", .meaning = meaning};
  };
  return {
      field<Time, &TimeSummary::median>(column("", what + ", median of the rounds")),
      field<Time, &TimeSummary::low>(column("_low", "lower end of the bootstrap 95 % interval of that median")),
      field<Time, &TimeSummary::high>(column("_high", "upper end of that interval")),
      field<Time, &TimeSummary::p05>(column("_p05", what + ", 5th percentile of the rounds")),
      field<Time, &TimeSummary::p95>(column("_p95", what + ", 95th percentile")),
      field<Time, &TimeSummary::p99>(column("_p99", what + ", 99th percentile")),
  };
}

template <typename Row>
void add(std::vector<Field<Row>>& all, Field<Row> one) {
  all.push_back(std::move(one));
}
template <typename Row>
void add(std::vector<Field<Row>>& all, std::vector<Field<Row>> several) {
  for (Field<Row>& one : several) all.push_back(std::move(one));
}

template <typename Row, typename... Fields>
Table<Row> make_table(TableDescription description, std::vector<Row> StoreContents::*rows, Fields... fields) {
  Table<Row> made{std::move(description), {}, rows};
  (add<Row>(made.fields, std::move(fields)), ...);
  for (const Field<Row>& one : made.fields) made.description.columns.push_back(one.column);
  return made;
}

}  // namespace crowdbench::column_fields
