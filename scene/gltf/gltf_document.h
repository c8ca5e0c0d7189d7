// The members of a glTF document, each of a checked type: what is missing, of another type or out of range is an Error
// that names the file, the JSON path and the fault. Internal to the loader.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "scene/gltf/gltf_source.h"

namespace crowdbench::scene {

class GltfDocument {
 public:
  using json = nlohmann::json;

  // Parses. Both arguments must outlive the document. Throws Error on what is not one JSON object, on a member that an
  // object has twice and on a top-level list that is not an array.
  GltfDocument(const GltfSource& source, const GltfLimits& limits);
  ~GltfDocument();
  GltfDocument(const GltfDocument&) = delete;
  GltfDocument& operator=(const GltfDocument&) = delete;

  const json& root() const { return *root_; }
  [[noreturn]] void fail(const std::string& path, const std::string& wrong, const std::string& advice = {}) const;

  // The path of an element: "/nodes" and 3 make "/nodes/3".
  static std::string item(const std::string& path, size_t index);
  // Null when the object has no such member.
  static const json* member(const json& object, const char* key);

  void require_object(const json& value, const std::string& path) const;
  // low..high, both included; 3.0 counts as 3.
  uint64_t integer(const json& value, const std::string& path, uint64_t low, uint64_t high) const;
  uint64_t integer_or(const json& object, const std::string& path, const char* key, uint64_t fallback, uint64_t low,
                      uint64_t high) const;
  uint64_t required_integer(const json& object, const std::string& path, const char* key, uint64_t low,
                            uint64_t high) const;
  // Elements of a top-level array; 0 when there is none.
  size_t count_of(const char* array) const;
  // An index into a top-level array, below its count.
  int index(const json& value, const std::string& path, const char* array) const;
  std::optional<int> index_or_none(const json& object, const std::string& path, const char* key,
                                   const char* array) const;
  int required_index(const json& object, const std::string& path, const char* key, const char* array) const;
  // Finite, of at most GltfLimits::magnitude.
  double number(const json& value, const std::string& path) const;
  // Exactly count of them.
  std::vector<double> numbers(const json& value, const std::string& path, size_t count) const;
  bool boolean_or(const json& object, const std::string& path, const char* key, bool fallback) const;
  const std::string* text_or_none(const json& object, const std::string& path, const char* key) const;
  // Empty when there is none; it has a limit of its own.
  std::string name_of(const json& object, const std::string& path) const;
  // Null when the object does not have the extension.
  const json* extension(const json& object, const std::string& path, const char* name) const;

  // Calls visit(object, path) for each object of a top-level array.
  void each(const char* array, const std::function<void(const json& object, const std::string& path)>& visit) const;

 private:
  // The same with path() called only where it is to be named.
  template <typename Path>
  uint64_t integer_at(const json& value, const Path& path, uint64_t low, uint64_t high) const;
  template <typename Path>
  int index_at(const json& value, const Path& path, const char* array) const;
  template <typename Path>
  double number_at(const json& value, const Path& path) const;

  const GltfSource& source_;
  const GltfLimits& limits_;
  std::unique_ptr<json> root_;
};

}  // namespace crowdbench::scene
