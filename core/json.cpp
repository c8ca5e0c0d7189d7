#include "core/json.h"

#include <algorithm>
#include <cassert>
#include <deque>
#include <nlohmann/json.hpp>
#include <variant>

namespace crowdbench {
namespace {

struct Array {
  std::vector<Json> elements;
};
// keys[i] names elements[i]. A member stays where it is while others come: in out["a"] = out["b"] = x the right side is
// made first and read after the left one is.
struct Object {
  std::vector<std::string> keys;
  std::deque<Json> elements;
};

template <typename... Fs>
struct Overloaded : Fs... {
  using Fs::operator()...;
};
template <typename... Fs>
Overloaded(Fs...) -> Overloaded<Fs...>;  // clang 14 wants to be told

}  // namespace

struct Json::Value {
  std::variant<bool, int64_t, uint64_t, double, std::string, Array, Object> held;

  // The value is, or becomes from null, an Array or an Object.
  template <typename T>
  static T& made(std::unique_ptr<Value>& value) {
    if (!value) value = std::make_unique<Value>(Value{T{}});
    assert(std::holds_alternative<T>(value->held));
    return std::get<T>(value->held);
  }
  template <typename T>
  static const T& get(const std::unique_ptr<Value>& value) {
    assert(value && std::holds_alternative<T>(value->held));
    return std::get<T>(value->held);
  }
  template <typename T>
  static bool is(const std::unique_ptr<Value>& value) {
    return value && std::holds_alternative<T>(value->held);
  }

  static nlohmann::ordered_json to_nlohmann(const Json& json);
  static Json from_nlohmann(const nlohmann::ordered_json& json);
};

Json::Json() noexcept = default;
Json::Json(std::nullptr_t) noexcept {}
Json::Json(Truth truth) : value_(new Value{truth.value}) {}
Json::Json(int value) : Json(static_cast<long long>(value)) {}
Json::Json(unsigned value) : Json(static_cast<unsigned long long>(value)) {}
Json::Json(long value) : Json(static_cast<long long>(value)) {}
Json::Json(unsigned long value) : Json(static_cast<unsigned long long>(value)) {}
Json::Json(long long value) : value_(new Value{int64_t{value}}) {}
Json::Json(unsigned long long value) : value_(new Value{uint64_t{value}}) {}
Json::Json(double value) : value_(new Value{value}) {}
Json::Json(const char* text) : Json(std::string(text)) {}
Json::Json(std::string_view text) : Json(std::string(text)) {}
Json::Json(std::string text) : value_(new Value{std::move(text)}) {}

Json::Json(std::initializer_list<Json> list) {
  const bool members = std::all_of(list.begin(), list.end(), [](const Json& element) {
    return Value::is<Array>(element.value_) && element.elements().size() == 2 && element.elements()[0].is_string();
  });
  if (!members) {
    *this = array(list);
    return;
  }
  *this = object();
  for (const Json& element : list) (*this)[element.elements()[0].text()] = element.elements()[1];
}

Json::Json(const Json& other) : value_(other.value_ ? new Value(*other.value_) : nullptr) {}
Json::Json(Json&& other) noexcept = default;
Json& Json::operator=(const Json& other) {
  Json copy(other);
  return *this = std::move(copy);
}
Json& Json::operator=(Json&& other) noexcept = default;
Json::~Json() = default;

Json Json::array() { return array({}); }

Json Json::array(std::initializer_list<Json> elements) {
  Json json;
  Value::made<Array>(json.value_).elements = elements;
  return json;
}

Json Json::object() {
  Json json;
  Value::made<Object>(json.value_);
  return json;
}

Json& Json::operator[](std::string_view key) {
  auto& [keys, elements] = Value::made<Object>(value_);
  const auto place = static_cast<size_t>(std::find(keys.begin(), keys.end(), key) - keys.begin());
  if (place == keys.size()) {
    keys.emplace_back(key);
    elements.emplace_back();
  }
  return elements[place];
}

const Json& Json::at(std::string_view key) const {
  const auto& [keys, elements] = Value::get<Object>(value_);
  const auto place = static_cast<size_t>(std::find(keys.begin(), keys.end(), key) - keys.begin());
  assert(place < keys.size());
  return elements[place];
}

Json& Json::operator[](size_t index) {
  Array& array = Value::made<Array>(value_);
  assert(index < array.elements.size());
  return array.elements[index];
}

const std::vector<Json>& Json::elements() const { return Value::get<Array>(value_).elements; }

size_t Json::size() const {
  if (is_null()) return 0;
  return Value::is<Object>(value_) ? Value::get<Object>(value_).elements.size() : elements().size();
}

Json& Json::back() { return (*this)[elements().size() - 1]; }

void Json::push_back(Json element) { Value::made<Array>(value_).elements.push_back(std::move(element)); }

void Json::update(const Json& object) {
  const auto& [keys, elements] = Value::get<Object>(object.value_);
  for (size_t i = 0; i < keys.size(); ++i) (*this)[keys[i]] = elements[i];
}

bool Json::is_null() const { return !value_; }
bool Json::is_string() const { return Value::is<std::string>(value_); }
bool Json::is_number() const {
  return Value::is<int64_t>(value_) || Value::is<uint64_t>(value_) || Value::is<double>(value_);
}

bool Json::truth() const { return Value::get<bool>(value_); }
const std::string& Json::text() const { return Value::get<std::string>(value_); }

double Json::number() const {
  assert(is_number());
  if (Value::is<int64_t>(value_)) return static_cast<double>(Value::get<int64_t>(value_));
  if (Value::is<uint64_t>(value_)) return static_cast<double>(Value::get<uint64_t>(value_));
  return Value::get<double>(value_);
}

int64_t Json::integer() const {
  if (Value::is<uint64_t>(value_)) return static_cast<int64_t>(Value::get<uint64_t>(value_));
  return Value::get<int64_t>(value_);
}

nlohmann::ordered_json Json::Value::to_nlohmann(const Json& json) {
  using nlohmann::ordered_json;
  if (!json.value_) return nullptr;
  return std::visit(Overloaded{[](const Array& array) {
                                 ordered_json out = ordered_json::array();
                                 for (const Json& element : array.elements) out.push_back(to_nlohmann(element));
                                 return out;
                               },
                               [](const Object& object) {
                                 ordered_json out = ordered_json::object();
                                 for (size_t i = 0; i < object.keys.size(); ++i)
                                   out[object.keys[i]] = to_nlohmann(object.elements[i]);
                                 return out;
                               },
                               [](const auto& value) { return ordered_json(value); }},
                    json.value_->held);
}

Json Json::Value::from_nlohmann(const nlohmann::ordered_json& json) {
  if (json.is_boolean()) return json.get<bool>();
  if (json.is_number_unsigned()) return json.get<uint64_t>();
  if (json.is_number_integer()) return json.get<int64_t>();
  if (json.is_number()) return json.get<double>();
  if (json.is_string()) return json.get<std::string>();
  if (json.is_array()) {
    Json out = array();
    for (const auto& element : json) out.push_back(from_nlohmann(element));
    return out;
  }
  if (!json.is_object()) return nullptr;
  Json out = object();
  for (const auto& [key, value] : json.items()) out[key] = from_nlohmann(value);
  return out;
}

std::string Json::dump(int indent) const {
  return Value::to_nlohmann(*this).dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

Json Json::parse(std::string_view text) {
  const auto json = nlohmann::ordered_json::parse(text, nullptr, false);
  assert(!json.is_discarded());
  return Value::from_nlohmann(json);
}

}  // namespace crowdbench
