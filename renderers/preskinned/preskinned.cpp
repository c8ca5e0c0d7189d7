// Based on: J. Turanszki, "Skinning in a compute shader" (Wicked Engine, 2017); renderers/mesh/skinned_buffer.h says
// what differs.
#include "renderers/preskinned/preskinned.h"

#include <algorithm>

#include "renderers/frame/frame_resources.h"
#include "renderers/mesh/mesh_draw.h"
#include "renderers/mesh/skinned_buffer.h"
#include "scene/cast/cast.h"

namespace crowdbench::renderers {
namespace {

struct PreskinnedOptions {
  int passes = 1;
  uint64_t block = 0;  // bytes of skinned vertices at a time
  bool floor = false;
};

class PreskinnedRepresentation : public Representation {
 public:
  PreskinnedRepresentation(const MakeContext& make, const PreskinnedOptions& options)
      : floor_(options.floor),
        draw_(make.context, use(options), options.passes),
        skinned_(make.context, options.block) {
    for (size_t c = 0; c < make.cast.characters.size(); ++c) {
      const scene::PoseBank& bank = *make.cast.banks[c];
      std::vector<std::vector<scene::Mat3x4>> poses;
      if (floor_) poses.push_back(bank.palette(bank.sample(0, 0.0)));
      meshes_.push_back(upload_mesh(make.context, *make.cast.characters[c], bank.joints(), use(options), poses));
    }
  }

  void draw(const scene::Frame&, const FrameResources& resources, const AgentLists& agents, const Pass& pass) override {
    for (size_t c = 0; c < meshes_.size(); ++c) {
      const CharacterMesh& mesh = meshes_[c];
      if (mesh.groups.empty()) continue;
      if (floor_)
        resources.draw_listed(c, agents[c],
                              [&](uint32_t count) { draw_.draw(mesh, pass, resources.list(), 0, count); });
      else
        resources.draw_posed(c, agents[c], [&](uint32_t first, uint32_t count) {
          draw_batch(mesh, pass, resources.list(), first, count);
        });
    }
    MeshDraw::done();
  }

  Footprint footprint() const override {
    Footprint out;
    out.buffer_bytes = skinned_.bytes();
    for (const CharacterMesh& m : meshes_) {
      out.texture_bytes += m.texture_bytes();
      out.buffer_bytes += m.buffer_bytes();
    }
    return out;
  }

  uint64_t triangles(size_t character) const override { return meshes_[character].triangles; }

 private:
  static MeshUse use(const PreskinnedOptions& options) {
    return options.floor ? MeshUse::static_pose : MeshUse::preskinned;
  }

  // Agents whose palettes are bound, as many at a time as the buffer holds.
  void draw_batch(const CharacterMesh& mesh, const Pass& pass, const gl::Buffer& list, uint32_t first, uint32_t count) {
    const uint32_t most = skinned_.capacity(mesh);
    for (uint32_t from = 0; from < count; from += most) {
      const uint32_t some = std::min(most, count - from);
      skinned_.skin(mesh, from, some);
      draw_.draw(mesh, pass, list, first + from, some);
    }
  }

  bool floor_;
  MeshDraw draw_;
  SkinnedBuffer skinned_;
  std::vector<CharacterMesh> meshes_;
};

}  // namespace

const RepresentationType preskinned_type = {
    .name = "preskinned",
    .summary = "the mesh, skinned once a frame by a compute pass into a buffer that all passes draw",
    .options = {{"passes", "1..16", "1", "times that a frame draws the triangles: all but the last write depth alone"},
                {"block", "1..2048", "128", "MiB of skinned vertices at a time; more agents are drawn in batches"}},
    .make = [](const MakeContext& context, const Spec& spec) -> std::unique_ptr<Representation> {
      const OptionReader reader(preskinned_type, spec);
      PreskinnedOptions options;
      options.passes = static_cast<int>(reader.integer("passes", 1, 16));
      options.block = static_cast<uint64_t>(reader.integer("block", 1, 2048)) << 20;
      options.floor = reader.flag("floor");
      return std::make_unique<PreskinnedRepresentation>(context, options);
    },
    .floor = "the same triangles and passes in one pose, without skinning",
    .suits = {.new_clips = "yes: skinned once a frame",
              .close_by = "yes",
              .from_above = "yes",
              .shadows = "skinned once for all passes: passes=N draws it again"},
};

}  // namespace crowdbench::renderers
