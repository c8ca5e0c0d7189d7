// Any bytes as an FBX or COLLADA file: load_assimp_character() returns a sound character or throws Error, nothing else.
//
// Assimp runs in a child process, where its own faults end the child alone, as they would in the driver; here too they
// are no findings. Nothing of the child is measured: mutations are guided by what is done with its answer.
#include <pthread.h>
#include <sanitizer/common_interface_defs.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "scene/assimp/assimp.h"
#include "scene/pose/pose.h"

namespace {

// libFuzzer would keep the input of a child that dies, as if this process had.
void forget_fuzzer() {
  __sanitizer_set_death_callback([] {});
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  ::pthread_atfork(nullptr, nullptr, forget_fuzzer);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace crowdbench;
  const bool collada = std::string_view(reinterpret_cast<const char*>(data), size).find('<') < 16;
  scene::LoadOptions options;
  // Small limits: the fuzzer looks for faults, not for how long a large file takes.
  options.limits.vertices = 5000;
  options.limits.triangles = 5000;
  options.limits.keys = 20000;
  options.limits.clip_nodes = 500;
  options.limits.image_side = 64;
  scene::Character character;
  try {
    character = scene::load_assimp_character(
        {data, data + size}, collada ? scene::AssimpFormat::collada : scene::AssimpFormat::fbx, "fuzz", {}, options);
  } catch (const Error& error) {
    const std::string_view line = error.what();
    if (error.wrong.empty() || line.find('\n') != std::string_view::npos) std::abort();
    return 0;
  }
  for (const glm::dvec3& p :
       skin_positions(character.mesh, model_matrices(character, character.placement.default_clip, 0.3)))
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) std::abort();
  for (const uint32_t index : character.mesh.indices)
    if (index >= character.mesh.positions.size()) std::abort();
  return 0;
}
