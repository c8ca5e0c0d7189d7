// The figure of tests/data/assimp, which is in both formats, read and changed by tests.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/files.h"
#include "gltf_builder.h"
#include "scene/assimp/assimp.h"
#include "scene/pose/pose.h"
#include "test_paths.h"

namespace crowdbench::scene::test {

inline const std::filesystem::path kData = std::filesystem::path(CROWDBENCH_TEST_DATA) / "assimp";

inline std::string text_of(AssimpFormat format) {
  const std::vector<uint8_t> bytes = read_file(kData / (format == AssimpFormat::fbx ? "walker.fbx" : "walker.dae"));
  return {bytes.begin(), bytes.end()};
}

// The file with one place of it written otherwise.
inline std::string changed(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

inline Character load_text(const std::string& text, AssimpFormat format, const LoadOptions& options = as_is(),
                           const std::filesystem::path& folder = kData) {
  const std::string name = format == AssimpFormat::fbx ? "walker.fbx" : "walker.dae";
  return load_assimp_character({text.begin(), text.end()}, format, name, folder, options);
}

inline std::string error_of(const auto& f) {
  try {
    f();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

inline bool has_warning(const Character& c, const std::string& fragment) {
  return std::any_of(c.warnings.begin(), c.warnings.end(),
                     [&](const std::string& warning) { return warning.find(fragment) != std::string::npos; });
}

inline std::vector<glm::dvec3> posed(const Character& c, int clip, double time) {
  return skin_positions(c.mesh, joint_matrices(c, clip, time));
}

}  // namespace crowdbench::scene::test
