#include "scene/gltf/gltf_document.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"

namespace crowdbench::scene {
namespace {

constexpr const char* kAdvice = "export it again; the Khronos glTF validator says where else it departs from glTF 2.0";

using nlohmann::json;

constexpr size_t kNameBytes = 1024;

// Builds a document in one pass, and stops at the first member whose name its object has already: two members of one
// name mean different things to different parsers. (nlohmann's parse with a callback takes quadratic time on long
// arrays of objects.) GltfSource has limited the depth and the number of values.
class DocumentBuilder : public nlohmann::json_sax<json> {
 public:
  json root;
  std::optional<std::string> twice;  // the member's name
  std::string wrong;                 // why it does not parse

  bool null() override { return add(nullptr) != nullptr; }
  bool boolean(bool value) override { return add(value) != nullptr; }
  bool number_integer(number_integer_t value) override { return add(value) != nullptr; }
  bool number_unsigned(number_unsigned_t value) override { return add(value) != nullptr; }
  bool number_float(number_float_t value, const string_t&) override { return add(value) != nullptr; }
  bool string(string_t& value) override { return add(std::move(value)) != nullptr; }
  bool binary(binary_t&) override { return false; }  // text has none
  bool start_object(size_t) override { return open(json::object()); }
  bool start_array(size_t) override { return open(json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    const auto [place, fresh] = opened_.back()->get_ref<json::object_t&>().try_emplace(std::move(name));
    if (!fresh) twice = place->first;
    member_ = &place->second;
    return fresh;
  }
  bool parse_error(size_t, const std::string&, const nlohmann::detail::exception& e) override {
    wrong = e.what();
    return false;
  }

 private:
  json* add(json value) {
    json* place = &root;
    if (!opened_.empty() && opened_.back()->is_array()) {
      opened_.back()->push_back(nullptr);
      place = &opened_.back()->back();
    } else if (!opened_.empty()) {
      place = member_;
    }
    *place = std::move(value);
    return place;
  }
  bool open(json empty) {
    opened_.push_back(add(std::move(empty)));  // stays where it is: what holds it only grows once it is closed
    return true;
  }
  bool close() {
    opened_.pop_back();
    return true;
  }

  std::vector<json*> opened_;
  json* member_ = nullptr;  // whose value comes next
};

}  // namespace

std::string GltfDocument::item(const std::string& path, size_t index) { return fmt::format("{}/{}", path, index); }

const json* GltfDocument::member(const json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

GltfDocument::GltfDocument(const GltfSource& source, const GltfLimits& limits) : source_(source), limits_(limits) {
  std::string_view text = source_.json();
  while (!text.empty() && text.back() == '\0') text.remove_suffix(1);
  DocumentBuilder built;
  if (!json::sax_parse(text.begin(), text.end(), &built)) {
    if (built.twice)
      throw Error(source_.where(),
                  fmt::format("JSON has the member {} twice in one object",
                              built.twice->empty() ? "\"\"" : printable(*built.twice, 60)),
                  kAdvice);
    std::string reason = built.wrong;
    const size_t bracket = reason.find("] ");
    if (bracket != std::string::npos) reason.erase(0, bracket + 2);
    throw Error(source_.where(), "JSON does not parse: " + printable(reason, 160), kAdvice);
  }
  root_ = std::make_unique<json>(std::move(built.root));
  if (!root_->is_object()) throw Error(source_.where(), "JSON is not an object", kAdvice);
  static constexpr std::array<const char*, 14> kArrays = {
      "accessors", "animations", "bufferViews", "buffers", "images",   "materials", "meshes",
      "nodes",     "samplers",   "scenes",      "skins",   "textures", "cameras",   "extensionsUsed"};
  for (const char* name : kArrays)
    if (const json* array = member(*root_, name); array && !array->is_array())
      fail(std::string("/") + name, fmt::format("is {}, not an array", array->type_name()));
}

GltfDocument::~GltfDocument() = default;

void GltfDocument::fail(const std::string& path, const std::string& wrong, const std::string& advice) const {
  source_.fail(path, wrong, advice);
}

void GltfDocument::require_object(const json& value, const std::string& path) const {
  if (!value.is_object()) fail(path, fmt::format("is {}, not an object", value.type_name()));
}

template <typename Path>
uint64_t GltfDocument::integer_at(const json& value, const Path& path, uint64_t low, uint64_t high) const {
  // 3.0 is an integer to JSON Schema and to some exporters.
  uint64_t number = 0;
  if (value.is_number_unsigned()) {
    number = value.get<uint64_t>();
  } else if (value.is_number_integer()) {
    fail(path(), fmt::format("is {}, must not be negative", value.get<int64_t>()));
  } else if (value.is_number_float()) {
    const double real = value.get<double>();
    if (!(std::floor(real) == real) || real < 0 || real > 9e15) fail(path(), fmt::format("is {}, not an index", real));
    number = static_cast<uint64_t>(real);
  } else {
    fail(path(), fmt::format("is {}, not a number", value.type_name()));
  }
  if (number < low || number > high) fail(path(), fmt::format("is {}, outside {}..{}", number, low, high));
  return number;
}

uint64_t GltfDocument::integer(const json& value, const std::string& path, uint64_t low, uint64_t high) const {
  return integer_at(
      value, [&] { return path; }, low, high);
}

uint64_t GltfDocument::integer_or(const json& object, const std::string& path, const char* key, uint64_t fallback,
                                  uint64_t low, uint64_t high) const {
  const json* value = member(object, key);
  return value ? integer_at(
                     *value, [&] { return path + "/" + key; }, low, high)
               : fallback;
}

uint64_t GltfDocument::required_integer(const json& object, const std::string& path, const char* key, uint64_t low,
                                        uint64_t high) const {
  const json* value = member(object, key);
  if (!value) fail(path, fmt::format("has no {}", key));
  return integer_at(
      *value, [&] { return path + "/" + key; }, low, high);
}

size_t GltfDocument::count_of(const char* array) const {
  const json* value = member(*root_, array);
  return value ? value->size() : 0;
}

template <typename Path>
int GltfDocument::index_at(const json& value, const Path& path, const char* array) const {
  const size_t count = count_of(array);
  const uint64_t number = integer_at(value, path, 0, UINT64_MAX);
  if (number >= count) fail(path(), fmt::format("is {}, but there are {} {}", number, count, array));
  return static_cast<int>(number);
}

int GltfDocument::index(const json& value, const std::string& path, const char* array) const {
  return index_at(
      value, [&] { return path; }, array);
}

std::optional<int> GltfDocument::index_or_none(const json& object, const std::string& path, const char* key,
                                               const char* array) const {
  const json* value = member(object, key);
  if (!value) return std::nullopt;
  return index_at(
      *value, [&] { return path + "/" + key; }, array);
}

int GltfDocument::required_index(const json& object, const std::string& path, const char* key,
                                 const char* array) const {
  const std::optional<int> found = index_or_none(object, path, key, array);
  if (!found) fail(path, fmt::format("has no {}", key));
  return *found;
}

template <typename Path>
double GltfDocument::number_at(const json& value, const Path& path) const {
  if (!value.is_number()) fail(path(), fmt::format("is {}, not a number", value.type_name()));
  const double v = value.get<double>();
  if (!std::isfinite(v) || std::abs(v) > limits_.magnitude)
    fail(path(), fmt::format("is {}, beyond the limit of {}", v, limits_.magnitude));
  return v;
}

double GltfDocument::number(const json& value, const std::string& path) const {
  return number_at(value, [&] { return path; });
}

std::vector<double> GltfDocument::numbers(const json& value, const std::string& path, size_t count) const {
  if (!value.is_array()) fail(path, fmt::format("is {}, not an array", value.type_name()));
  if (value.size() != count) fail(path, fmt::format("has {} numbers, not {}", value.size(), count));
  std::vector<double> out;
  out.reserve(count);
  for (size_t i = 0; i < count; ++i) out.push_back(number_at(value[i], [&] { return item(path, i); }));
  return out;
}

bool GltfDocument::boolean_or(const json& object, const std::string& path, const char* key, bool fallback) const {
  const json* value = member(object, key);
  if (!value) return fallback;
  if (!value->is_boolean()) fail(path + "/" + key, fmt::format("is {}, not true or false", value->type_name()));
  return value->get<bool>();
}

const std::string* GltfDocument::text_or_none(const json& object, const std::string& path, const char* key) const {
  const json* value = member(object, key);
  if (!value) return nullptr;
  if (!value->is_string()) fail(path + "/" + key, fmt::format("is {}, not a string", value->type_name()));
  return &value->get_ref<const std::string&>();
}

std::string GltfDocument::name_of(const json& object, const std::string& path) const {
  const std::string* name = text_or_none(object, path, "name");
  if (!name) return {};
  if (name->size() > kNameBytes) fail(path + "/name", fmt::format("is longer than {} bytes", kNameBytes));
  return *name;
}

const json* GltfDocument::extension(const json& object, const std::string& path, const char* name) const {
  const json* all = member(object, "extensions");
  if (!all) return nullptr;
  require_object(*all, path + "/extensions");
  const json* one = member(*all, name);
  if (one) require_object(*one, path + "/extensions/" + name);
  return one;
}

void GltfDocument::each(const char* array, const std::function<void(const json&, const std::string&)>& visit) const {
  const json* all = member(*root_, array);
  if (!all) return;
  for (size_t i = 0; i < all->size(); ++i) {
    const std::string path = fmt::format("/{}/{}", array, i);
    require_object((*all)[i], path);
    visit((*all)[i], path);
  }
}

}  // namespace crowdbench::scene
