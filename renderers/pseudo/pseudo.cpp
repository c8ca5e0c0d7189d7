// Based on: E. Millan and I. Rudomin, "Impostors and pseudo-instancing for GPU crowd rendering" (2006).
// Differs from the source: README.md.
#include "renderers/pseudo/pseudo.h"

#include <epoxy/gl.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "renderers/bake/bake_loader.h"
#include "renderers/frame/frame_resources.h"
#include "renderers/impostor/tiles/stored_frames.h"
#include "renderers/mesh/mesh_draw.h"
#include "renderers/mesh/skinned_buffer.h"
#include "renderers/pseudo/pose_choice.h"
#include "renderers/pseudo/pose_error.h"
#include "renderers/shaders/bindings.shared.h"
#include "scene/cast/cast.h"

namespace crowdbench::renderers {
namespace {

enum class Choice : uint8_t { even, clustered };

struct PseudoOptions {
  uint32_t poses = 1;  // a clip
  Choice choice = Choice::even;
  bool floor = false;
};

// What one character's agents show in a frame.
struct Shown {
  struct Pose {
    int clip = 0;
    double phase = 0;
  };
  std::vector<Pose> poses;
  std::vector<uint32_t> first;   // by pose: into `sorted`; and the end
  std::vector<uint32_t> sorted;  // agents by pose, those of one pose in the order of the list
};

// What there is to do about a clip of which few poses are shown.
std::string more_poses_text(const scene::BankClip& clip) {
  constexpr int kMost = 256;
  const int enough = FrameCount{1, kFewFramesASecond}.of(clip.seconds);
  return enough <= kMost ? fmt::format("poses={} shows {:g}", enough, kFewFramesASecond) : "shorten the clip";
}

class PseudoRepresentation : public Representation {
 public:
  PseudoRepresentation(const MakeContext& make, const PseudoOptions& options)
      : options_(options), draw_(make.context, MeshUse::shared_pose), skinned_(make.context) {
    const auto start = std::chrono::steady_clock::now();
    size_t palette_bytes = 0;
    for (size_t c = 0; c < make.cast.characters.size(); ++c) {
      banks_.push_back(make.cast.banks[c]);
      const scene::PoseBank& bank = *banks_[c];
      meshes_.push_back(upload_mesh(make.context, *make.cast.characters[c], bank.joints(), MeshUse::shared_pose, {}));
      warn_of_bake("pseudo-instances",
                   coarse_clip_text(
                       *make.cast.characters[c], bank,
                       [&](const scene::BankClip&) { return static_cast<int>(options.poses); }, more_poses_text));
      const PoseError one = even_pose_error(*make.cast.characters[c], bank, options.poses);
      error_ = {std::max(error_.rms, one.rms), std::max(error_.max, one.max)};
      palette_bytes = std::max(palette_bytes, options.poses * bank.clips().size() * static_cast<size_t>(bank.joints()) *
                                                  sizeof(scene::Mat3x4));
    }
    palettes_ = gl::Buffer(make.context, palette_bytes);
    palette_texels_ = gl::Texture::make_buffer(make.context, GL_RGBA32F, palettes_);
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  void draw(const scene::Frame& frame, const FrameResources& resources, const AgentLists& agents,
            const Pass& pass) override {
    for (size_t c = 0; c < meshes_.size(); ++c) {
      if (agents[c].empty() || meshes_[c].groups.empty()) continue;
      choose(frame.agents[c], agents[c], banks_[c]->clips());
      resources.draw_listed(c, shown_.sorted, [&](uint32_t) { draw_character(c, resources.list(), pass); });
    }
    MeshDraw::done();
  }

  Footprint footprint() const override {
    Footprint out;
    out.buffer_bytes = skinned_.bytes() + palettes_.size();
    for (const CharacterMesh& m : meshes_) {
      out.texture_bytes += m.texture_bytes();
      out.buffer_bytes += m.buffer_bytes();
    }
    return out;
  }

  BakeInfo bake_info() const override {
    constexpr double kMillimetres = 1000;
    BakeInfo info;
    info.seconds = seconds_;
    info.facts = {{"poses_a_clip", options_.poses},
                  {"pose_error_rms_mm", error_.rms * kMillimetres},
                  {"pose_error_max_mm", error_.max * kMillimetres}};
    return info;
  }

  uint64_t triangles(size_t character) const override { return meshes_[character].triangles; }

  // Clustered poses are where the frame's agents are.
  double shown_phase(size_t character, int bank_clip, double phase) const override {
    const bool still = banks_[character]->clips()[static_cast<size_t>(bank_clip)].samples <= 1;
    if (still) return 0;
    return options_.choice == Choice::even ? nearest_even_phase(phase, options_.poses) : phase;
  }

 private:
  // Fills shown_.
  void choose(const std::vector<scene::FrameAgent>& all, const std::vector<uint32_t>& listed,
              const std::vector<scene::BankClip>& clips) {
    shown_.poses.clear();
    if (options_.floor) {
      shown_.poses.push_back({});
      shown_.first = {0, static_cast<uint32_t>(listed.size())};
      shown_.sorted = listed;
      return;
    }
    shown_.first.assign(1, 0);
    shown_.sorted.clear();
    for (size_t k = 0; k < clips.size(); ++k) {
      members_.clear();
      phases_.clear();
      for (const uint32_t i : listed)
        if (all[i].bank_clip == static_cast<int>(k)) {
          members_.push_back(i);
          phases_.push_back(all[i].phase);
        }
      const uint32_t poses = clips[k].samples <= 1 ? 1 : options_.poses;
      const bool even = options_.choice == Choice::even;
      const PoseChoice choice = even ? even_poses(phases_, poses) : clustered_poses(phases_, poses);
      append(static_cast<int>(k), choice);
    }
  }

  // A counting sort of the clip's agents by pose.
  void append(int clip, const PoseChoice& choice) {
    std::vector<uint32_t> next(choice.phases.size() + 1, 0);
    for (const uint32_t pose : choice.of) ++next[pose + 1];
    const auto begin = static_cast<uint32_t>(shown_.sorted.size());
    for (size_t p = 0; p < choice.phases.size(); ++p) {
      shown_.poses.push_back({clip, choice.phases[p]});
      next[p + 1] += next[p];
      shown_.first.push_back(begin + next[p + 1]);
    }
    shown_.sorted.resize(begin + choice.of.size());
    for (size_t i = 0; i < choice.of.size(); ++i) shown_.sorted[begin + next[choice.of[i]]++] = members_[i];
  }

  void draw_character(size_t c, const gl::Buffer& list, const Pass& pass) {
    const CharacterMesh& mesh = meshes_[c];
    rows_.clear();
    for (const Shown::Pose& pose : shown_.poses) {
      const std::vector<scene::Mat3x4> palette = banks_[c]->palette(banks_[c]->sample(pose.clip, pose.phase));
      rows_.insert(rows_.end(), palette.begin(), palette.end());
    }
    palettes_.write(rows_);
    palette_texels_.bind(CB_TEXTURE_PALETTE);
    const auto poses = static_cast<uint32_t>(shown_.poses.size());
    const uint32_t most = skinned_.capacity(mesh);
    for (uint32_t from = 0; from < poses; from += most) {
      const uint32_t some = std::min(most, poses - from);
      skinned_.skin(mesh, from, some);
      for (uint32_t p = from; p < from + some; ++p)
        draw_.draw(mesh, pass, list, shown_.first[p], shown_.first[p + 1] - shown_.first[p], p - from);
    }
  }

  PseudoOptions options_;
  MeshDraw draw_;
  SkinnedBuffer skinned_;
  std::vector<std::shared_ptr<const scene::PoseBank>> banks_;
  std::vector<CharacterMesh> meshes_;
  gl::Buffer palettes_;  // of the poses of the character being drawn
  gl::Texture palette_texels_;
  PoseError error_;  // the largest of all characters
  double seconds_ = 0;
  // Of the character being drawn.
  Shown shown_;
  std::vector<uint32_t> members_;
  std::vector<float> phases_;
  std::vector<scene::Mat3x4> rows_;
};

}  // namespace

const RepresentationType pseudo_type = {
    .name = "pseudo",
    .summary = "pseudo-instancing: a few poses of each clip, skinned once a frame and shared by all agents",
    .options = {{"poses", "1..256", "8", "of a clip that a frame skins, at most"},
                {"choice", "even|clustered", "even",
                 "which poses: evenly over the clip's phases, or the means of clusters of the frame's agents"}},
    .make = [](const MakeContext& context, const Spec& spec) -> std::unique_ptr<Representation> {
      const OptionReader reader(pseudo_type, spec);
      PseudoOptions options;
      options.poses = static_cast<uint32_t>(reader.integer("poses", 1, 256));
      options.choice = reader.choice("choice", {"even", "clustered"}) == 0 ? Choice::even : Choice::clustered;
      options.floor = reader.flag("floor");
      return std::make_unique<PseudoRepresentation>(context, options);
    },
    .floor = "every agent in its character's first pose, skinned once, without choosing",
    .suits = {.new_clips = "yes: its poses are skinned once a frame",
              .close_by = "neighbours share a pose and are out of step by up to half of one",
              .from_above = "yes",
              .shadows = "as the mesh"},
};

}  // namespace crowdbench::renderers
