// The bytes of a glTF asset: the container (GLB chunks or plain JSON), data uris and files beside it. Internal to the
// loader. Nothing here trusts a length, an offset or a name from the file.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scene/gltf/gltf.h"

namespace crowdbench::scene {

class GltfSource {
 public:
  // bytes must outlive the source. folder: where relative uris are looked up; empty refuses them. Throws Error on a
  // broken container and on JSON that is too large, too deep or has too many values to be parsed in bounded memory.
  GltfSource(std::span<const uint8_t> bytes, std::string where, std::filesystem::path folder, const GltfLimits& limits);

  std::string_view json() const { return json_; }
  bool is_glb() const { return glb_; }
  // The BIN chunk; empty when there is none.
  std::span<const uint8_t> bin() const { return bin_; }
  const std::string& where() const { return where_; }

  // Refuses a uri that leaves the asset's folder (parents, absolute paths, schemes, backslashes, percent-encoded forms
  // of these) without touching the disk. path: the JSON path of the uri, for the message.
  void check_uri(std::string_view uri, const std::string& path) const;
  // The bytes behind a checked uri: a base64 data uri, or a regular file whose real place (links resolved) lies in the
  // folder. All fetched bytes and the asset itself count towards GltfLimits::file_bytes.
  std::vector<uint8_t> fetch(std::string_view uri, const std::string& path);

  [[noreturn]] void fail(const std::string& path, const std::string& wrong, const std::string& advice = {}) const;

 private:
  void scan_json() const;
  std::string where_;
  std::filesystem::path folder_;
  const GltfLimits& limits_;
  std::string_view json_;
  std::span<const uint8_t> bin_;
  bool glb_ = false;
  size_t bytes_left_ = 0;
};

}  // namespace crowdbench::scene
