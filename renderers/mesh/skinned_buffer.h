// SkinnedBuffer: vertices skinned on the GPU before they are drawn, for draws that show one posed mesh several times:
// in passes of the same frame, or for several agents.
#pragma once
#include <cstdint>

#include "renderers/gl/objects.h"
#include "renderers/gl/program.h"
#include "renderers/mesh/mesh_draw.h"

namespace crowdbench::renderers {

// Bytes of a skinned vertex: three floats of place, an octahedral normal of 2 x 16 bits (within 0.004 degrees).
inline constexpr uint64_t kSkinnedVertexBytes = 16;

class SkinnedBuffer {
 public:
  // block: bytes that it grows to at most; fewer where the driver's limits ask for it.
  explicit SkinnedBuffer(gl::Context& context, uint64_t block = uint64_t{128} << 20);
  // Slots, each one posed mesh, that fit: at least 1.
  uint32_t capacity(const CharacterMesh& mesh) const;
  // Makes room for so many slots at once, so that those skinned stay until they are skinned anew: growing forgets them
  // all. 0 < slots <= capacity(mesh).
  void reserve(const CharacterMesh& mesh, uint32_t slots);
  // Skins slots slot .. slot + count - 1 by palettes first, first + 1, ... of those bound to CB_TEXTURE_PALETTE, and
  // binds the result to CB_TEXTURE_SKINNED until the next call. Places are where the palettes put them. mesh: uploaded
  // for MeshUse::preskinned, shared_pose or cached_poses. 0 < count, slot + count <= capacity(mesh).
  void skin(const CharacterMesh& mesh, uint32_t first, uint32_t count, uint32_t slot = 0);
  // Binds what was skinned to CB_TEXTURE_SKINNED.
  void bind() const;
  // Grows with what is skinned and never shrinks.
  uint64_t bytes() const { return buffer_.size(); }

 private:
  gl::Context& context_;
  uint64_t block_;
  gl::Program program_;
  gl::Buffer buffer_;
  gl::Texture texels_;
};

}  // namespace crowdbench::renderers
