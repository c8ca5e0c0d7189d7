// MeshDraw: a character's mesh on the GPU and the programs that draw it, shared by the representations that draw
// meshes: skinned where they are drawn, skinned before into a buffer, in one static pose, in stored poses, and for
// bakes.
#pragma once
#include <compare>
#include <map>
#include <span>
#include <vector>

#include "renderers/gl/objects.h"
#include "renderers/gl/program.h"
#include "renderers/mesh/mesh_data.h"
#include "renderers/representation.h"

namespace crowdbench::renderers {

// What is drawn: the skinned mesh; the mesh in one static pose (the skinned mesh's floor), in stored poses, in slots of
// a SkinnedBuffer (skinned_buffer.h) of which every agent has its own (`preskinned`, places in the world), all of a
// draw share one (`shared_pose`, in model space) or each blends two (`cached_poses`; uploaded so, it may be drawn
// skinned as well); skinned to tiles of a page (`tile`; uploaded as the skinned mesh is); or the maps that bakes are
// made of.
enum class MeshUse : uint8_t {
  skinned,
  static_pose,
  stored_poses,
  preskinned,
  shared_pose,
  cached_poses,
  tile,
  capture
};

// One character's mesh on the GPU.
struct CharacterMesh {
  gl::Buffer vertices, indices, uvs, colours, emissive_uvs, materials;
  gl::Buffer rest;  // RestVertex[], where a SkinnedBuffer is drawn
  gl::Texture rest_texels;
  gl::VertexArray vertex_array;
  std::vector<gl::Texture> textures;  // one a MeshData::arrays entry
  std::vector<gl::Sampler> samplers;
  gl::Texture material_texels;
  std::vector<MeshGroup> groups;
  uint32_t joints = 0;
  uint32_t vertex_count = 0;
  uint64_t triangles = 0;
  bool has_colours = false, has_emissive_uvs = false, has_emissive = false, has_flat = false;
  uint64_t texture_bytes() const;
  uint64_t buffer_bytes() const;
};

// One vertex of a stored pose; texture coordinates and the like are streams that all poses share.
struct PosedVertex {
  float position[3];
  float material;
  uint32_t normal;  // 10:10:10:2 signed normalised
};

// poses: palettes of the character's bank: none for what is skinned and captures, one for the static pose; the
// vertices of stored poses follow each other in the order given. peak: captures hold emissive light as fractions of
// this, and none where it is 0. Throws Error: more materials or images than can be addressed.
CharacterMesh upload_mesh(gl::Context& context, const scene::Character& character, int joints, MeshUse use,
                          std::span<const std::vector<scene::Mat3x4>> poses, float peak = 0);

class MeshDraw {
 public:
  // passes: above 1 each draw comes after passes - 1 others of the same triangles that write depth alone, as engines
  // draw a mesh again for depth pre-passes and shadows: colours then only pass where depth is equal. None of a pass
  // with `touched`.
  MeshDraw(gl::Context& context, MeshUse use, int passes = 1) : context_(context), use_(use), passes_(passes) {}
  // Draws `count` agents of the list from position `first` on (FrameResources::list(), within a draw callback). Leaves
  // face culling as the last group wants it: `done` puts that and the samplers back. pose: which of the stored ones;
  // of a SkinnedBuffer, which must be bound, the first slot. Of cached_poses `first` is 0, and instance i blends what
  // texel i of CB_TEXTURE_BLENDS says; tiles have four texels an instance of CB_TEXTURE_TILE_ROWS.
  void draw(const CharacterMesh& mesh, const Pass& pass, const gl::Buffer& list, uint32_t first, uint32_t count,
            uint32_t pose = 0);
  static void done();

 private:
  // What a compiled variant of the program depends on.
  struct Variant {
    bool ids = false, dithered = false, colours = false, emissive = false, emissive_uvs = false, textures = false,
         emissive_textures = false, double_sided = false, flat = false, masked = false, sampled = false, depth = false;
    auto operator<=>(const Variant&) const = default;
  };
  const gl::Program& program(const Variant& variant);
  void draw_group(const CharacterMesh& mesh, const MeshGroup& group, const Pass& pass, uint32_t count, uint32_t slot,
                  bool depth);

  gl::Context& context_;
  MeshUse use_;
  int passes_;
  std::map<Variant, gl::Program> programs_;
};

}  // namespace crowdbench::renderers
