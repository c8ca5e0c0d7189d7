#include "renderers/mesh/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>

#include "core/error.h"
#include "core/progress.h"
#include "renderers/frame/frame_resources.h"
#include "renderers/mesh/mesh_draw.h"
#include "renderers/mesh/mesh_level.h"
#include "renderers/mesh/mesh_lods.h"

namespace crowdbench::renderers {
namespace {

class MeshRepresentation : public Representation {
 public:
  MeshRepresentation(const MakeContext& make, MeshUse use, const MeshLevelOptions& level, int passes, float peak = 0)
      : floor_(use == MeshUse::static_pose), draw_(make.context, use, passes) {
    const auto start = std::chrono::steady_clock::now();
    if (!level.is_whole()) levels_ = load_mesh_levels(make.cast.characters, make.cast.banks, level, make.policy());
    for (size_t c = 0; c < make.cast.characters.size(); ++c) {
      const scene::PoseBank& bank = *make.cast.banks[c];
      std::vector<std::vector<scene::Mat3x4>> poses;
      if (floor_) poses.push_back(bank.palette(bank.sample(0, 0.0)));
      const auto upload = [&](const scene::Character& character) {
        meshes_.push_back(upload_mesh(make.context, character, bank.joints(), use, poses, peak));
      };
      const scene::Character& whole = *make.cast.characters[c];
      level.is_whole() ? upload(whole) : upload(scene::with_mesh(whole, levels_.levels[c].mesh));
    }
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
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
    out.disk_bytes = disk_bytes_of(levels_.records);
    return out;
  }

  BakeInfo bake_info() const override {
    if (levels_.levels.empty()) return {};
    BakeInfo info = bake_info_of(levels_);
    info.seconds = seconds_;
    return info;
  }

  uint64_t triangles(size_t character) const override { return meshes_[character].triangles; }

 private:
  bool floor_;
  MeshDraw draw_;
  double seconds_ = 0;
  std::vector<CharacterMesh> meshes_;
  MeshLevels levels_;  // by character; none where the characters' own meshes are drawn
};

bool has_lods(const Spec& spec) { return OptionReader(mesh_type, spec).text("lods") != "none"; }

MeshLevelOptions level_options(const Spec& spec) {
  const OptionReader reader(mesh_type, spec);
  MeshLevelOptions out;
  out.request.triangles = static_cast<size_t>(reader.integer("triangles", 0, 4'000'000));
  out.request.ratio = reader.number("ratio", 0, 1);
  out.request.error = reader.number("error", 0, 100);
  out.lod = static_cast<size_t>(reader.integer("lod", 0, 63));
  if ((out.request.triangles > 0) + (out.request.ratio > 0) + (out.request.error > 0) + (out.lod > 0) +
          (has_lods(spec) ? 1 : 0) >
      1)
    throw Error("representation 'mesh'", "more than one of triangles, ratio, error, lod and lods is given",
                "give the one that says how coarse");
  return out;
}

}  // namespace

std::unique_ptr<Representation> make_mesh_capture(const MakeContext& make, float peak) {
  return std::make_unique<MeshRepresentation>(make, MeshUse::capture, MeshLevelOptions{}, 1, peak);
}

const RepresentationType mesh_type = {
    .name = "mesh",
    .summary = "the reference: the skinned mesh, posed on the GPU, instanced; or a level of detail of it",
    .options =
        {{"triangles", "0..4000000", "0", "a level of detail: at most so many triangles a character; 0: all"},
         {"ratio", "0..1", "0", "instead: at most this share of the character's triangles; 0: all"},
         {"error", "0..100", "0",
          "instead: as few as stay within so many metres of the whole mesh in the poses of the clips in use; 0: all"},
         {"lod", "0..63", "0", "instead: the level that the character's file holds (MSFT_lod, or names in _LOD1)"},
         {"lods", "LEVEL/LEVEL/...", "none",
          "instead: the whole mesh near by, and the coarsest of these whose error spans at most `pixels` elsewhere; "
          "from "
          "fine to coarse, triangles, shares below 1, or own: those of the file",
          check_lods},
         {"pixels", "0.01..100", "1",
          "with lods: pixels that the error of what is drawn may span, by its stated largest"},
         {"passes", "1..16", "1", "times that a frame draws the triangles: all but the last write depth alone"}},
    .make = [](const MakeContext& context, const Spec& spec) -> std::unique_ptr<Representation> {
      const OptionReader reader(mesh_type, spec);
      const MeshLevelOptions level = level_options(spec);
      const double pixels = reader.number("pixels", 0.01, 100);
      if (has_lods(spec)) return make_mesh_lods(context, spec, pixels);
      return std::make_unique<MeshRepresentation>(context,
                                                  reader.flag("floor") ? MeshUse::static_pose : MeshUse::skinned, level,
                                                  static_cast<int>(reader.integer("passes", 1, 16)));
    },
    .reference = true,
    .level = [](const Spec& spec, const std::shared_ptr<const scene::Character>& character,
                const std::shared_ptr<const scene::PoseBank>& bank,
                const BakePolicy& policy) -> std::optional<LevelMesh> {
      const MeshLevelOptions options = level_options(spec);
      if (has_lods(spec))
        throw Error("representation 'mesh'", "lods is several levels", "ask for one: triangles, ratio, error or lod");
      if (options.is_whole()) return std::nullopt;
      return std::move(load_mesh_levels({character}, {bank}, options, policy).levels.front());
    },
    .floor = "the same triangles in one pose, without skinning",
    .suits = {.new_clips = "yes: skinned when it is drawn",
              .close_by = "yes",
              .from_above = "yes",
              .shadows = "its depth is its own; passes=N draws it again, as shadow maps do"},
};

}  // namespace crowdbench::renderers
