#include "bench/sweep/character_files.h"

#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/files.h"
#include "core/hash.h"
#include "scene/cast/open_character.h"
#include "scene/gltf/gltf_files.h"

namespace crowdbench::bench::sweep {
namespace {

// Stands for a file that cannot be read: loading it says why, later and better.
constexpr std::string_view kMissing = "missing";

std::vector<uint8_t> contents_of(const std::filesystem::path& file) {
  try {
    return read_file(file);
  } catch (const Error&) {
    return {kMissing.begin(), kMissing.end()};
  }
}

}  // namespace

const std::string& CharacterFiles::hash(const std::string& source) {
  const auto [found, fresh] = known_.try_emplace(source);
  if (!fresh) return found->second;
  const std::filesystem::path file = folder_ / source;
  const std::vector<uint8_t> bytes = contents_of(file);
  Sha256 digest;
  digest.values(bytes);
  scene::each_gltf_file(bytes, file.parent_path(), [&](const std::string& uri, const auto& beside) {
    digest.text(uri);
    if (beside)
      digest.values(*beside);
    else
      digest.text(kMissing);
  });
  return found->second = digest.hex();
}

std::string CharacterFiles::fingerprint(const scene::Scenario& scenario) {
  std::string out;
  const auto add = [&](const std::string& source) {
    if (!scene::is_built_in(source)) out += hash(source);
  };
  for (const scene::CharacterEntry& character : scenario.characters) {
    add(character.source);
    for (const std::string& animation : character.animations) add(animation);
  }
  return out.empty() ? out : sha256_hex(out);
}

}  // namespace crowdbench::bench::sweep
