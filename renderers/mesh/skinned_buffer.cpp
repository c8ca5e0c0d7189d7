// Based on: J. Turanszki, "Skinning in a compute shader" (Wicked Engine, 2017).
// Differs from the source: one dispatch poses all agents of a character, each into a slot of its own, and draws fetch
// vertices by slot instead of binding a vertex buffer an agent.
#include "renderers/mesh/skinned_buffer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cassert>

#include "renderers/shaders/bindings.shared.h"

namespace crowdbench::renderers {
namespace {

constexpr uint32_t kGroup = 64;         // local_size_x of skin.comp
constexpr uint64_t kMostSlots = 65535;  // work groups along y that every driver takes

}  // namespace

SkinnedBuffer::SkinnedBuffer(gl::Context& context, uint64_t block)
    : context_(context),
      block_(std::min({block, static_cast<uint64_t>(context.limits().storage_block),
                       static_cast<uint64_t>(context.limits().texel_buffer) * kSkinnedVertexBytes})),
      program_(context, {"renderers/mesh/skin.comp"}) {}

uint32_t SkinnedBuffer::capacity(const CharacterMesh& mesh) const {
  const uint64_t slot = std::max<uint64_t>(mesh.vertex_count, 1) * kSkinnedVertexBytes;
  return static_cast<uint32_t>(std::clamp<uint64_t>(block_ / slot, 1, kMostSlots));
}

void SkinnedBuffer::reserve(const CharacterMesh& mesh, uint32_t slots) {
  assert(slots > 0 && slots <= capacity(mesh));
  const size_t bytes = size_t{slots} * mesh.vertex_count * kSkinnedVertexBytes;
  if (buffer_.size() >= bytes) return;
  texels_ = gl::Texture();
  buffer_ = gl::Buffer();
  buffer_ = gl::Buffer(context_, bytes);
  texels_ = gl::Texture::make_buffer(context_, GL_RGBA32UI, buffer_);
}

void SkinnedBuffer::bind() const { texels_.bind(CB_TEXTURE_SKINNED); }

void SkinnedBuffer::skin(const CharacterMesh& mesh, uint32_t first, uint32_t count, uint32_t slot) {
  assert(count > 0);
  reserve(mesh, slot + count);
  mesh.rest_texels.bind(CB_TEXTURE_REST);
  buffer_.bind(GL_SHADER_STORAGE_BUFFER, CB_STORAGE_SKINNED);
  program_.use();
  program_.set(CB_LOCATION_FIRST, first);
  program_.set(CB_LOCATION_JOINTS, mesh.joints);
  program_.set(CB_LOCATION_VERTICES, mesh.vertex_count);
  program_.set(CB_LOCATION_SLOT, slot);
  // Draws of an earlier call may still read this buffer.
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  glDispatchCompute((mesh.vertex_count + kGroup - 1) / kGroup, count, 1);
  glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
  bind();
}

}  // namespace crowdbench::renderers
