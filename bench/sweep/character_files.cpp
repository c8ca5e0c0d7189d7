#include "bench/sweep/character_files.h"

#include <regex>
#include <vector>

#include "core/error.h"
#include "core/files.h"
#include "core/hash.h"
#include "scene/cast/open_character.h"

namespace crowdbench::bench::sweep {
namespace {

// "missing" where it cannot be read: loading it says why, later and better.
std::vector<uint8_t> contents_of(const std::filesystem::path& file) {
  try {
    return read_file(file);
  } catch (const Error&) {
    const std::string missing = "missing";
    return {missing.begin(), missing.end()};
  }
}

// What a glTF file in JSON names beside itself; data that it holds itself is left out.
std::vector<std::string> files_named_by(const std::vector<uint8_t>& gltf) {
  static const std::regex uri(R"re("uri"\s*:\s*"([^"]{1,400})")re");
  const std::string text(gltf.begin(), gltf.end());
  std::vector<std::string> out;
  for (auto match = std::sregex_iterator(text.begin(), text.end(), uri); match != std::sregex_iterator(); ++match)
    if (const std::string name = (*match)[1]; !name.starts_with("data:")) out.push_back(name);
  return out;
}

}  // namespace

const std::string& CharacterFiles::hash(const std::string& source) {
  const auto [found, fresh] = known_.try_emplace(source);
  if (!fresh) return found->second;
  const std::filesystem::path file = folder_ / source;
  const std::vector<uint8_t> bytes = contents_of(file);
  Sha256 digest;
  digest.values(bytes);
  if (file.extension() == ".gltf")
    for (const std::string& name : files_named_by(bytes))
      digest.text(name).values(contents_of(file.parent_path() / name));
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
