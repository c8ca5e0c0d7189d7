// Based on: Khronos Group, "glTF 2.0 Specification", sections 2.7 (uris) and 4 (GLB container); RFC 4648 (base64).
// Differs from the source: the specification leaves "unsafe" uris to the client; here whatever is not a plain relative
// path below the asset's folder is refused.
#include "scene/gltf/gltf_source.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "core/files.h"
#include "scene/gltf/gltf_files.h"

namespace crowdbench::scene {
namespace fs = std::filesystem;
namespace {

constexpr const char* kDamaged = "the file is damaged; export it again";

constexpr uint32_t kGlbMagic = 0x46546C67;   // "glTF"
constexpr uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr uint32_t kBinChunk = 0x004E4942;   // "BIN\0"

uint32_t read_u32(std::span<const uint8_t> bytes, size_t offset) {
  uint32_t value = 0;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

bool is_data_uri(std::string_view uri) { return uri.starts_with("data:"); }

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

// Percent decoding, once; std::nullopt on a broken escape.
std::optional<std::string> percent_decoded(std::string_view uri) {
  std::string out;
  out.reserve(uri.size());
  for (size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') {
      out += uri[i];
      continue;
    }
    if (i + 2 >= uri.size()) return std::nullopt;
    const int high = hex_digit(uri[i + 1]);
    const int low = hex_digit(uri[i + 2]);
    if (high < 0 || low < 0) return std::nullopt;
    out += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return out;
}

constexpr std::array<int16_t, 256> kBase64 = [] {
  std::array<int16_t, 256> table{};
  table.fill(-1);
  constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (size_t i = 0; i < alphabet.size(); ++i) table[static_cast<uint8_t>(alphabet[i])] = static_cast<int16_t>(i);
  return table;
}();

// Padding may be absent, as some exporters leave it out; std::nullopt on any other irregularity.
std::optional<std::vector<uint8_t>> base64_decoded(std::string_view text) {
  size_t padding = 0;
  while (padding < 2 && !text.empty() && text.back() == '=') {
    text.remove_suffix(1);
    ++padding;
  }
  if (text.size() % 4 == 1 || (padding != 0 && (text.size() + padding) % 4 != 0)) return std::nullopt;
  std::vector<uint8_t> out;
  out.reserve(text.size() / 4 * 3 + 2);
  uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const int value = kBase64[static_cast<uint8_t>(c)];
    if (value < 0) return std::nullopt;
    bits = bits << 6 | static_cast<uint32_t>(value);
    count += 6;
    if (count >= 8) {
      count -= 8;
      out.push_back(static_cast<uint8_t>(bits >> count));
    }
  }
  return out;
}

}  // namespace

GltfSource::GltfSource(std::span<const uint8_t> bytes, std::string where, fs::path folder, const GltfLimits& limits)
    : where_(std::move(where)), folder_(std::move(folder)), limits_(limits), bytes_left_(limits.file_bytes) {
  if (bytes.empty()) throw Error(where_, "is empty", "name a glTF 2.0 file (.glb or .gltf)");
  if (bytes.size() > bytes_left_)
    throw Error(where_, fmt::format("is {} bytes, more than the limit of {}", bytes.size(), limits.file_bytes),
                "use a smaller character");
  bytes_left_ -= bytes.size();
  if (bytes.size() < 4 || read_u32(bytes, 0) != kGlbMagic) {
    json_ = {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    // Before any parser speaks of "unexpected characters": say what the file is not.
    const size_t first = json_.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
    if (first == std::string_view::npos || json_[first] != '{')
      throw Error(where_, "is neither a GLB container nor a JSON object", "name a glTF 2.0 file (.glb or .gltf)");
    scan_json();
    return;
  }
  glb_ = true;
  if (bytes.size() < 12) throw Error(where_, "GLB header is cut short", "the file is truncated; get it again");
  const uint32_t glb_version = read_u32(bytes, 4);
  if (glb_version != 2)
    throw Error(where_, fmt::format("GLB container version is {}, not 2", glb_version), "convert it to glTF 2.0");
  const uint32_t length = read_u32(bytes, 8);
  if (length < 12 || length > bytes.size())
    throw Error(where_, fmt::format("GLB header says {} bytes, the file has {}", length, bytes.size()),
                "the file is truncated or damaged; get it again");
  size_t at = 12;
  bool have_json = false;
  bool have_bin = false;
  while (at < length) {
    if (length - at < 8) throw Error(where_, fmt::format("GLB chunk header at byte {} is cut short", at), kDamaged);
    const uint32_t size = read_u32(bytes, at);
    const uint32_t type = read_u32(bytes, at + 4);
    at += 8;
    if (size > length - at)
      throw Error(where_, fmt::format("GLB chunk at byte {} says {} bytes, {} are left", at - 8, size, length - at),
                  "the file is truncated or damaged; get it again");
    if (size % 4 != 0)
      throw Error(where_, fmt::format("GLB chunk at byte {} has length {}, not a multiple of 4", at - 8, size),
                  kDamaged);
    const std::span<const uint8_t> chunk = bytes.subspan(at, size);
    if (!have_json) {
      if (type != kJsonChunk) throw Error(where_, "first GLB chunk is not JSON", kDamaged);
      json_ = {reinterpret_cast<const char*>(chunk.data()), chunk.size()};
      have_json = true;
    } else if (type == kBinChunk && !have_bin) {
      bin_ = chunk;
      have_bin = true;
    } else if (type == kJsonChunk || type == kBinChunk) {
      throw Error(where_, fmt::format("GLB has a second {} chunk", type == kJsonChunk ? "JSON" : "BIN"), kDamaged);
    }
    at += size;
  }
  if (!have_json) throw Error(where_, "GLB has no JSON chunk", "the file is truncated; get it again");
  scan_json();
}

void GltfSource::fail(const std::string& path, const std::string& wrong, const std::string& advice) const {
  throw Error(where_ + ": " + path, wrong,
              advice.empty()
                  ? "export the file again; the Khronos glTF validator says where else it departs from glTF 2.0"
                  : advice);
}

void GltfSource::scan_json() const {
  if (json_.size() > limits_.json_bytes)
    throw Error(where_, fmt::format("JSON is {} bytes, more than the limit of {}", json_.size(), limits_.json_bytes),
                "keep buffers and pictures out of the JSON, and save fewer nodes and keys");
  int depth = 0;
  size_t values = 1;
  bool in_string = false;
  for (size_t i = 0; i < json_.size(); ++i) {
    const char c = json_[i];
    // Some exporters pad the chunk with NUL instead of blanks; inside, a NUL would hide the rest from the parser.
    if (c == '\0' && json_.find_first_not_of('\0', i) != std::string_view::npos)
      throw Error(where_, fmt::format("JSON holds a NUL byte at {}", i), kDamaged);
    if (in_string) {
      if (c == '\\')
        ++i;
      else if (c == '"')
        in_string = false;
      continue;
    }
    switch (c) {
      case '"': in_string = true; break;
      case '[':
      case '{':
        ++values;
        if (++depth > limits_.json_depth)
          throw Error(where_, fmt::format("JSON nests deeper than {} levels at byte {}", limits_.json_depth, i),
                      kDamaged);
        break;
      case ']':
      case '}': --depth; break;
      case ',':
      case ':': ++values; break;
      default: break;
    }
    if (values > limits_.json_values)
      throw Error(where_, fmt::format("JSON has more than {} values", limits_.json_values), "use a simpler character");
  }
}

void GltfSource::check_uri(std::string_view uri, const std::string& path) const {
  if (is_data_uri(uri)) return;
  const std::string shown = printable(uri, 80);
  const std::string advice = "keep every file of the asset in its folder or embed it";
  if (uri.empty()) fail(path, "is an empty uri");
  const std::optional<std::string> decoded = percent_decoded(uri);
  if (!decoded) fail(path, "has a broken percent escape: " + shown);
  for (const char c : *decoded)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) fail(path, "holds a control character: " + shown);
  if (decoded->find('\\') != std::string::npos) fail(path, "holds a backslash: " + shown, advice);
  const size_t colon = decoded->find(':');
  if (colon != std::string::npos && decoded->find('/') >= colon)
    fail(path, "is not a relative path: " + shown, "only data uris and files in the asset's folder are read");
  if (decoded->front() == '/') fail(path, "is an absolute path: " + shown, advice);
  if (uri.find('?') != std::string_view::npos || uri.find('#') != std::string_view::npos)
    fail(path, "has a query or a fragment: " + shown);
  for (const fs::path& part : fs::path(*decoded))
    if (part == "..") fail(path, "leaves the asset's folder: " + shown, advice);
}

std::vector<uint8_t> GltfSource::fetch(std::string_view uri, const std::string& path) {
  check_uri(uri, path);
  if (is_data_uri(uri)) {
    const size_t comma = uri.find(',');
    if (comma == std::string_view::npos || !uri.substr(0, comma).ends_with(";base64"))
      fail(path, "is a data uri without base64 data", "embed data as data:application/octet-stream;base64,...");
    const std::string_view text = uri.substr(comma + 1);
    if (text.size() / 4 * 3 > bytes_left_)
      fail(path, fmt::format("brings the asset above the limit of {} bytes", limits_.file_bytes));
    std::optional<std::vector<uint8_t>> decoded = base64_decoded(text);
    if (!decoded) fail(path, "holds broken base64 data");
    bytes_left_ -= std::min(bytes_left_, decoded->size());
    return std::move(*decoded);
  }
  const std::string shown = printable(uri, 80);
  if (folder_.empty()) fail(path, "names the file " + shown + ", which cannot be read without a folder");
  std::error_code error;
  const fs::path root = fs::canonical(folder_, error);
  if (error) fail(path, "cannot resolve the asset's folder: " + error.message());
  const fs::path real = fs::canonical(root / *percent_decoded(uri), error);
  if (error) fail(path, fmt::format("cannot open {}: {}", shown, error.message()), "put the file beside the asset");
  const auto [end, unused] = std::mismatch(root.begin(), root.end(), real.begin(), real.end());
  if (end != root.end())
    fail(path, "leaves the asset's folder through a link: " + shown, "keep every file of the asset in its folder");
  try {
    std::vector<uint8_t> bytes = read_file(real, bytes_left_);
    bytes_left_ -= bytes.size();
    return bytes;
  } catch (const Error& e) {
    fail(path, fmt::format("{}: {}", shown, e.wrong), e.advice);
  }
}

namespace {

// In the order of the document, each once.
std::vector<std::string> uris_named(std::string_view text) {
  while (!text.empty() && text.back() == '\0') text.remove_suffix(1);
  const nlohmann::json document = nlohmann::json::parse(text, nullptr, false);
  std::vector<std::string> out;
  std::set<std::string> known;
  for (const char* kind : {"buffers", "images"}) {
    const auto list = document.is_object() ? document.find(kind) : document.end();
    if (list == document.end() || !list->is_array()) continue;
    for (const nlohmann::json& one : *list) {
      const auto uri = one.is_object() ? one.find("uri") : one.end();
      if (uri == one.end() || !uri->is_string()) continue;
      const auto& name = uri->get_ref<const std::string&>();
      if (!is_data_uri(name) && known.insert(name).second) out.push_back(name);
    }
  }
  return out;
}

}  // namespace

void each_gltf_file(std::span<const uint8_t> bytes, const std::filesystem::path& folder, const GltfFileFound& found) {
  const GltfLimits limits;
  std::optional<GltfSource> source;
  try {
    source.emplace(bytes, "asset", folder.empty() ? fs::path(".") : folder, limits);
  } catch (const Error&) {
    return;
  }
  for (const std::string& uri : uris_named(source->json())) {
    std::optional<std::vector<uint8_t>> read;
    try {
      read = source->fetch(uri, "uri");
    } catch (const Error&) {
      read = std::nullopt;
    }
    found(uri, read);
  }
}

}  // namespace crowdbench::scene
