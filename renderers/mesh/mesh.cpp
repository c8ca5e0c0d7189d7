#include "renderers/mesh/mesh.h"

#include "renderers/frame/frame_resources.h"
#include "renderers/mesh/mesh_draw.h"

namespace crowdbench::renderers {
namespace {

class MeshRepresentation : public Representation {
 public:
  MeshRepresentation(const MakeContext& make, MeshUse use, float peak = 0)
      : floor_(use == MeshUse::static_pose), draw_(make.context, use) {
    for (size_t c = 0; c < make.cast.characters.size(); ++c) {
      const scene::PoseBank& bank = *make.cast.banks[c];
      std::vector<std::vector<scene::Mat3x4>> poses;
      if (floor_) poses.push_back(bank.palette(bank.sample(0, 0.0)));
      meshes_.push_back(upload_mesh(make.context, *make.cast.characters[c], bank.joints(), use, poses, peak));
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
          draw_.draw(mesh, pass, resources.list(), first, count);
        });
    }
    MeshDraw::done();
  }

  Footprint footprint() const override {
    Footprint out;
    for (const CharacterMesh& m : meshes_) {
      out.texture_bytes += m.texture_bytes();
      out.buffer_bytes += m.buffer_bytes();
    }
    return out;
  }

  uint64_t triangles(size_t character) const override { return meshes_[character].triangles; }

 private:
  bool floor_;
  MeshDraw draw_;
  std::vector<CharacterMesh> meshes_;
};

}  // namespace

std::unique_ptr<Representation> make_mesh_capture(const MakeContext& make, float peak) {
  return std::make_unique<MeshRepresentation>(make, MeshUse::capture, peak);
}

const RepresentationType mesh_type = {
    .name = "mesh",
    .summary = "the reference: the skinned mesh, posed on the GPU, instanced",
    .make = [](const MakeContext& context, const Spec& spec) -> std::unique_ptr<Representation> {
      return std::make_unique<MeshRepresentation>(
          context, OptionReader(mesh_type, spec).flag("floor") ? MeshUse::static_pose : MeshUse::skinned);
    },
    .reference = true,
    .floor = "the same triangles in one pose, without skinning",
};

}  // namespace crowdbench::renderers
