// Any bytes as a glTF file: load_character() returns a sound character or throws Error, nothing else; and so is
// what other characters play of it.
//
// Input that starts with the byte 1 is a document and a binary chunk apart (two bytes of length, little-endian, then
// JSON, then data), wrapped in a sound GLB here, so that mutations get past the container.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "core/error.h"
#include "scene/gltf/gltf.h"
#include "scene/mannequin/mannequin.h"
#include "scene/pose/pose.h"
#include "scene/pose/retarget.h"

namespace {

void append_u32(std::vector<uint8_t>& out, size_t value) {
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<uint8_t>(value >> (8 * i)));
}

std::vector<uint8_t> wrapped(const uint8_t* data, size_t size) {
  const size_t json = std::min<size_t>(data[1] | data[2] << 8, size - 3);
  const size_t bin = size - 3 - json;
  const size_t json_padded = (json + 3) / 4 * 4;
  const size_t bin_padded = (bin + 3) / 4 * 4;
  std::vector<uint8_t> out;
  append_u32(out, 0x46546C67);
  append_u32(out, 2);
  append_u32(out, 28 + json_padded + bin_padded);
  append_u32(out, json_padded);
  append_u32(out, 0x4E4F534A);
  out.insert(out.end(), data + 3, data + 3 + json);
  out.resize(20 + json_padded, ' ');
  append_u32(out, bin_padded);
  append_u32(out, 0x004E4942);
  out.insert(out.end(), data + 3 + json, data + size);
  out.resize(28 + json_padded + bin_padded, 0);
  return out;
}

// Its clips on the mannequin: sound poses, or Error.
void play_elsewhere(const crowdbench::scene::Character& source, const crowdbench::scene::GltfLimits& limits) {
  using namespace crowdbench::scene;
  static const Character mannequin = make_mannequin({.triangles = 500, .joints = 20, .normalise = {}});
  Character target = mannequin;
  const size_t own = target.clips.size();
  try {
    add_clips_of(source, target, {.bones = {}, .keys = limits.keys, .clips = limits.clips});
  } catch (const crowdbench::Error&) {
    return;
  }
  for (size_t clip = own; clip < target.clips.size(); ++clip)
    for (const glm::dmat4& m : node_matrices(target, static_cast<int>(clip), target.clips[clip].end))
      for (int i = 0; i < 16; ++i)
        if (!std::isfinite(m[i / 4][i % 4])) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace crowdbench;
  const bool apart = size > 3 && data[0] == 1;
  const std::vector<uint8_t> bytes = apart ? wrapped(data, size) : std::vector<uint8_t>(data, data + size);
  scene::LoadOptions options;
  // Small limits: the fuzzer looks for faults, not for how long a large file takes.
  options.limits.vertices = 5000;
  options.limits.triangles = 5000;
  options.limits.keys = 20000;
  options.limits.clip_nodes = 500;
  options.limits.image_side = 64;
  options.limits.decoded_bytes = size_t{1} << 20;
  scene::Character character;
  try {
    character = scene::load_character(bytes, "fuzz.glb", {}, options);
  } catch (const Error& error) {
    if (error.wrong.empty()) std::abort();
    return 0;
  }
  for (const glm::dvec3& p :
       skin_positions(character.mesh, model_matrices(character, character.placement.default_clip, 0.3)))
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) std::abort();
  for (const uint32_t index : character.mesh.indices)
    if (index >= character.mesh.positions.size()) std::abort();
  play_elsewhere(character, options.limits);
  return 0;
}
