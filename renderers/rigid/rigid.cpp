// Based on: Maim et al. 2009: three levels, deformable mesh, rigid mesh and impostor, of which the middle one is a mesh
// in stored poses. Differs from the source: the poses are the nearest of a clip's, evenly over its phases.
#include "renderers/rigid/rigid.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include "core/error.h"
#include "renderers/bake/bake_loader.h"
#include "renderers/frame/frame_resources.h"
#include "renderers/impostor/tiles/stored_frames.h"
#include "renderers/mesh/mesh_draw.h"
#include "renderers/mesh/mesh_level.h"
#include "scene/cast/cast.h"
#include "scene/pose/lod_mesh.h"

namespace crowdbench::renderers {
namespace {

// One character: its mesh in the poses of all clips, one after the other.
struct CharacterPoses {
  CharacterMesh mesh;
  struct Clip {
    uint32_t first = 0;   // into the stored poses
    uint32_t frames = 1;  // at phases 0, 1 / frames, ...
  };
  std::vector<Clip> clips;
  uint32_t poses = 0;
};

struct RigidOptions {
  int64_t poses = 0;     // a clip; 0: as many as the budget holds
  uint64_t budget = 0;   // bytes of posed vertices, all characters together
  size_t triangles = 0;  // of the level of detail that is posed, a character; 0: all
  bool floor = false;
};

// Of a clip of `samples` samples in the bank: a still pose is stored once.
uint32_t frames_of(const scene::BankClip& clip, uint32_t poses) { return clip.samples <= 1 ? 1 : poses; }

// Bytes of posed vertices with `poses` a clip.
uint64_t posed_bytes(const scene::Cast& cast, const std::vector<size_t>& vertices, uint32_t poses, bool cut) {
  uint64_t bytes = 0;
  for (size_t c = 0; c < cast.banks.size(); ++c)
    for (const scene::BankClip& clip : cast.banks[c]->clips()) {
      const uint32_t frames = frames_of(clip, cut ? std::min(poses, clip.samples) : poses);
      bytes += uint64_t{frames} * vertices[c] * sizeof(PosedVertex);
    }
  return bytes;
}

// What there is to do about a clip of which few poses are stored.
std::string more_poses_text(const scene::BankClip& clip) {
  return fmt::format("{:.0f} would be {:g}: raise poses or budget (MiB), or shorten the clip",
                     std::ceil(kFewFramesASecond * clip.seconds), kFewFramesASecond);
}

class RigidRepresentation : public Representation {
 public:
  RigidRepresentation(const MakeContext& make, const RigidOptions& options)
      : floor_(options.floor), draw_(make.context, MeshUse::stored_poses) {
    const auto start = std::chrono::steady_clock::now();
    const scene::Cast& cast = make.cast;
    const auto characters = posed_characters(make, options.triangles);
    std::vector<size_t> vertices;  // those that triangles use
    uint32_t most = 1;
    for (size_t c = 0; c < cast.characters.size(); ++c) {
      vertices.push_back(make_mesh_data(*characters[c]).vertices.size());
      for (const scene::BankClip& clip : cast.banks[c]->clips()) most = std::max(most, clip.samples);
    }
    const uint64_t budget = std::min(options.budget, make.bake_budget);
    // Without a number: the largest that fits, no clip with more poses than the bank has samples of it.
    const bool automatic = options.poses == 0;
    uint32_t poses = automatic ? most : static_cast<uint32_t>(options.poses);
    if (automatic)
      while (poses > 1 && posed_bytes(cast, vertices, poses, true) > budget) --poses;
    const uint64_t bytes = posed_bytes(cast, vertices, poses, automatic);
    if (bytes > budget)
      throw Error("rigid meshes",
                  fmt::format("{:.1f} MiB of posed vertices are more than the budget of {:.1f}",
                              static_cast<double>(bytes) / (1 << 20), static_cast<double>(budget) / (1 << 20)),
                  "lower poses, use fewer clips or characters, or raise budget (MiB)");
    const BakeProgress progress = bake_progress(make.policy(), "posing rigid meshes");
    for (size_t c = 0; c < cast.characters.size(); ++c) {
      progress(c, cast.characters.size());
      const scene::PoseBank& bank = *cast.banks[c];
      const auto stored = [&](const scene::BankClip& clip) {
        return frames_of(clip, automatic ? std::min(poses, clip.samples) : poses);
      };
      warn_of_bake("rigid meshes",
                   coarse_clip_text(
                       *characters[c], bank,
                       [&](const scene::BankClip& clip) { return static_cast<int>(stored(clip)); }, more_poses_text));
      CharacterPoses& out = characters_.emplace_back();
      std::vector<std::vector<scene::Mat3x4>> palettes;
      for (size_t k = 0; k < bank.clips().size(); ++k) {
        const scene::BankClip& clip = bank.clips()[k];
        const uint32_t frames = stored(clip);
        out.clips.push_back({static_cast<uint32_t>(palettes.size()), frames});
        for (uint32_t f = 0; f < frames; ++f)
          palettes.push_back(bank.palette(bank.sample(static_cast<int>(k), static_cast<double>(f) / frames)));
      }
      out.poses = static_cast<uint32_t>(palettes.size());
      out.mesh = upload_mesh(make.context, *characters[c], bank.joints(), MeshUse::stored_poses, palettes);
    }
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  void draw(const scene::Frame& frame, const FrameResources& resources, const AgentLists& agents,
            const Pass& pass) override {
    for (size_t c = 0; c < characters_.size(); ++c) {
      const CharacterPoses& character = characters_[c];
      if (agents[c].empty() || character.mesh.groups.empty()) continue;
      if (floor_) {
        resources.draw_listed(c, agents[c],
                              [&](uint32_t count) { draw_.draw(character.mesh, pass, resources.list(), 0, count); });
        continue;
      }
      sort_by_pose(character, frame.agents[c], agents[c]);
      resources.draw_listed(c, sorted_, [&](uint32_t) {
        for (uint32_t pose = 0; pose < character.poses; ++pose)
          if (const uint32_t count = first_[pose + 1] - first_[pose]; count > 0)
            draw_.draw(character.mesh, pass, resources.list(), first_[pose], count, pose);
      });
    }
    MeshDraw::done();
  }

  Footprint footprint() const override {
    Footprint out;
    for (const CharacterPoses& c : characters_) {
      out.texture_bytes += c.mesh.texture_bytes();
      out.buffer_bytes += c.mesh.buffer_bytes();
    }
    return out;
  }

  BakeInfo bake_info() const override {
    BakeInfo info;
    info.seconds = seconds_;
    double poses = 0;
    double bytes = 0;
    for (const CharacterPoses& c : characters_) {
      poses += c.poses;
      bytes += static_cast<double>(c.mesh.vertices.size());
    }
    info.facts = {{"poses", poses}, {"posed_mib", bytes / (1 << 20)}};
    info.levels = levels_;
    return info;
  }

  uint64_t triangles(size_t character) const override { return characters_[character].mesh.triangles; }

  double shown_phase(size_t character, int bank_clip, double phase) const override {
    const CharacterPoses::Clip& clip = characters_[character].clips[static_cast<size_t>(bank_clip)];
    return static_cast<double>(nearest_frame(clip, static_cast<float>(phase))) / clip.frames;
  }

 private:
  // The characters as they are posed: with fewer triangles where that was asked for.
  std::vector<std::shared_ptr<const scene::Character>> posed_characters(const MakeContext& make, size_t triangles) {
    auto out = make.cast.characters;
    if (triangles == 0) return out;
    MeshLevels made = load_mesh_levels(out, make.cast.banks, {.request = {.triangles = triangles}}, make.policy());
    for (size_t c = 0; c < out.size(); ++c) {
      out[c] = std::make_shared<const scene::Character>(scene::with_mesh(*out[c], std::move(made.levels[c].mesh)));
      levels_.push_back(std::move(made.levels[c].info));
    }
    return out;
  }

  static uint32_t nearest_frame(const CharacterPoses::Clip& clip, float phase) {
    return static_cast<uint32_t>(std::floor(phase * static_cast<float>(clip.frames) + 0.5F)) % clip.frames;
  }

  // Counting sort by stored pose; agents of one pose keep their order.
  void sort_by_pose(const CharacterPoses& character, const std::vector<scene::FrameAgent>& all,
                    const std::vector<uint32_t>& chosen) {
    first_.assign(character.poses + 1, 0);
    poses_.resize(chosen.size());
    for (size_t i = 0; i < chosen.size(); ++i) {
      const scene::FrameAgent& a = all[chosen[i]];
      const CharacterPoses::Clip& clip = character.clips[static_cast<size_t>(a.bank_clip)];
      poses_[i] = clip.first + nearest_frame(clip, a.phase);
      ++first_[poses_[i] + 1];
    }
    for (size_t p = 1; p < first_.size(); ++p) first_[p] += first_[p - 1];
    next_.assign(first_.begin(), first_.end() - 1);
    sorted_.resize(chosen.size());
    for (size_t i = 0; i < chosen.size(); ++i) sorted_[next_[poses_[i]]++] = chosen[i];
  }

  bool floor_;
  MeshDraw draw_;
  double seconds_ = 0;
  std::vector<LevelInfo> levels_;  // by character; none where whole meshes are posed
  std::vector<CharacterPoses> characters_;
  // Of the character being drawn.
  std::vector<uint32_t> first_, next_, poses_, sorted_;
};

}  // namespace

const RepresentationType rigid_type = {
    .name = "rigid",
    .summary = "pre-posed meshes: stored poses of each clip as vertex buffers, no skinning",
    .options = {{"poses", "0..1024", "0",
                 "stored a clip; 0: as many as the budget holds, at most the bank's samples of the clip"},
                {"budget", "1..65536", "16", "MiB of posed vertices, all clips and characters together"},
                {"triangles", "0..4000000", "0", "of a level of detail that is posed, a character; 0: all"}},
    .make = [](const MakeContext& context, const Spec& spec) -> std::unique_ptr<Representation> {
      const OptionReader reader(rigid_type, spec);
      RigidOptions options;
      options.poses = reader.integer("poses", 0, 1024);
      options.budget = static_cast<uint64_t>(reader.integer("budget", 1, 65536)) << 20;
      options.triangles = static_cast<size_t>(reader.integer("triangles", 0, 4'000'000));
      options.floor = reader.flag("floor");
      return std::make_unique<RigidRepresentation>(context, options);
    },
    .floor = "every agent in its character's first stored pose, without the sort",
    .suits = {.new_clips = "no: the poses of every clip are stored",
              .close_by = "steps between stored poses are seen",
              .from_above = "yes",
              .shadows = "as the mesh"},
};

}  // namespace crowdbench::renderers
