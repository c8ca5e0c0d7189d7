// Json: a JSON value to be filled and printed. The program's outputs are built of it; files of other origin are read
// with nlohmann-json itself, by whoever checks them.
#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace crowdbench {

// null, a truth, a number, a text, an array, or an object whose members keep the order in which they were added.
// Nothing of nlohmann-json is seen here: its templates take a compiler longer than all else in a source that uses them.
//
// Braces make values as nlohmann-json's do: a list whose elements are all pairs that begin with a text is an object,
// any other list an array. Member access to what has no such member, or is no object, is a bug and asserts.
class Json {
 public:
  Json() noexcept;  // null
  Json(std::nullptr_t) noexcept;
  Json(std::initializer_list<Json> list);
  Json(std::same_as<bool> auto truth) : Json(Truth{truth}) {}  // a pointer is not a truth
  Json(int value);
  Json(unsigned value);
  Json(long value);
  Json(unsigned long value);
  Json(long long value);
  Json(unsigned long long value);
  Json(double value);  // not finite: printed as null
  Json(const char* text);
  Json(std::string_view text);
  Json(std::string text);
  // A range of values becomes an array.
  template <typename Range>
  requires(requires(const Range& r) { Json(*r.begin()); } && !std::convertible_to<const Range&, std::string_view> &&
           !std::same_as<Range, Json>) Json(const Range& values)
      : Json(array()) {
    for (const auto& value : values) push_back(Json(value));
  }

  Json(const Json& other);
  Json(Json&& other) noexcept;
  Json& operator=(const Json& other);
  Json& operator=(Json&& other) noexcept;
  ~Json();

  static Json array();
  static Json array(std::initializer_list<Json> elements);
  static Json object();
  // text: JSON that this program has written. Other text is a bug and asserts.
  static Json parse(std::string_view text);

  // The member, added as null where there is none; null becomes an object. Members added later leave it where it is.
  Json& operator[](std::string_view key);
  // The member; there is one.
  const Json& at(std::string_view key) const;
  // The element; there is one.
  Json& operator[](size_t index);
  // Of an array.
  const std::vector<Json>& elements() const;
  Json& back();
  // Of elements or members; null has none.
  size_t size() const;
  bool empty() const { return size() == 0; }

  // null becomes an array.
  void push_back(Json element);
  // Adds the members of an object, in place of those of the same name.
  void update(const Json& object);

  bool is_null() const;
  bool is_string() const;
  bool is_number() const;
  // What it holds; it holds that. number: of any kind of number.
  bool truth() const;
  double number() const;
  int64_t integer() const;
  const std::string& text() const;

  // As text: on one line where indent is negative, else by so many spaces a depth. Bytes that are not UTF-8 become
  // U+FFFD.
  std::string dump(int indent = -1) const;

 private:
  struct Truth {
    bool value;
  };
  struct Value;
  explicit Json(Truth truth);

  std::unique_ptr<Value> value_;  // none: null
};

}  // namespace crowdbench
