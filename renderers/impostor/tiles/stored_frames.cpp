#include "renderers/impostor/tiles/stored_frames.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/hash.h"
#include "scene/pose/hidden.h"

namespace crowdbench::renderers {

namespace {

constexpr const char* kFrames = "frames";
constexpr const char* kFps = "fps";

}  // namespace

int FrameCount::of(double cycle_seconds) const {
  if (!(frames_a_second > 0)) return frames * poses;
  return std::max(1, static_cast<int>(std::min(std::ceil(cycle_seconds * frames_a_second - 1e-9), 1e6))) * poses;
}

OptionDoc frames_option(const std::string& meaning) { return {kFrames, "1..256", "10", meaning}; }

OptionDoc fps_option() {
  return {kFps, "0..120", "0", "stored frames a second, in place of `frames`, for long clips; 0: `frames` a clip"};
}

FrameCount read_frame_count(const OptionReader& reader) {
  return {static_cast<int>(reader.integer(kFrames, 1, 256)), reader.number(kFps, 0, 120)};
}

std::vector<scene::Mat3x4> StoredFrames::palette(size_t frame) const {
  return bank(poses[frame].moves)->palette(poses[frame].sample);
}

std::vector<std::vector<glm::vec3>> StoredFrames::positions(const scene::Mesh& mesh) const {
  std::vector<std::vector<glm::vec3>> out;
  for (size_t f = 0; f < size(); ++f) out.push_back(scene::shown_positions(mesh, palette(f)));
  return out;
}

StoredFrames stored_frames(const scene::Character& character, const std::shared_ptr<const scene::PoseBank>& bank,
                           const FrameCount& count) {
  StoredFrames out;
  out.still = bank;
  std::vector<int> moving;
  std::vector<int> frames;
  for (const scene::BankClip& c : bank->clips()) {
    if (c.samples <= 1) continue;
    moving.push_back(c.clip);
    frames.push_back(count.of(c.seconds));
    if (frames.back() > kMostStoredFrames)
      throw Error(character.name,
                  fmt::format("{} stored frames of a clip of {:.4g} s, the limit is {}", frames.back(), c.seconds,
                              kMostStoredFrames),
                  fmt::format("give fps = {:.3g} or less", kMostStoredFrames / c.seconds));
  }
  if (!moving.empty())
    out.moving = std::make_shared<const scene::PoseBank>(scene::PoseBank::frames(character, moving, frames));
  int next_moving = 0;
  for (size_t c = 0; c < bank->clips().size(); ++c) {
    const bool moves = bank->clips()[c].samples > 1;
    const int stored = moves ? frames[static_cast<size_t>(next_moving)] : 1;
    const int clip = moves ? next_moving++ : static_cast<int>(c);
    out.clips.push_back({static_cast<uint32_t>(out.size()), static_cast<uint32_t>(stored)});
    for (int f = 0; f < stored; ++f)
      out.poses.push_back({moves, out.bank(moves)->sample(clip, static_cast<double>(f) / stored)});
  }
  return out;
}

int most_frames(const StoredFrames& frames) {
  uint32_t most = 1;
  for (const StoredClip& clip : frames.clips) most = std::max(most, clip.frames);
  return static_cast<int>(most);
}

std::string coarse_clip_text(const scene::Character& character, const scene::PoseBank& bank,
                             const std::function<int(const scene::BankClip&)>& stored,
                             const std::function<std::string(const scene::BankClip&)>& helps) {
  const scene::BankClip* coarsest = nullptr;
  double fewest = kFewFramesASecond;
  for (const scene::BankClip& c : bank.clips()) {
    if (c.samples <= 1) continue;
    const double a_second = stored(c) / c.seconds;
    if (a_second >= fewest * (1 - 1e-9)) continue;
    fewest = a_second;
    coarsest = &c;
  }
  if (coarsest == nullptr) return {};
  const std::string& name = character.clips[static_cast<size_t>(coarsest->clip)].name;
  return fmt::format("{}: {} stored frames of clip '{}' ({:.3g} s) are {:.2g} a second of motion; {}", character.name,
                     stored(*coarsest), printable(name, 60), coarsest->seconds, fewest, helps(*coarsest));
}

std::string coarse_frames_text(const scene::Character& character, const scene::PoseBank& bank,
                               const FrameCount& count) {
  return coarse_clip_text(
      character, bank, [&](const scene::BankClip& c) { return count.of(c.seconds); },
      [&](const scene::BankClip& c) {
        return fmt::format("fps={:g} stores {}", kFewFramesASecond,
                           FrameCount{count.frames, kFewFramesASecond}.of(c.seconds));
      });
}

std::vector<double> pose_steps(const StoredFrames& frames, const std::vector<std::vector<glm::vec3>>& positions) {
  std::vector<double> steps;
  for (const StoredClip& clip : frames.clips)
    for (uint32_t f = 0; f < clip.frames && clip.frames > 1; ++f) {
      const auto& here = positions[clip.first_frame + f];
      const auto& next = positions[clip.first_frame + (f + 1) % clip.frames];
      float most = 0;
      for (size_t v = 0; v < here.size(); ++v) {
        const glm::vec3 d = next[v] - here[v];
        most = std::max(most, glm::dot(d, d));
      }
      steps.push_back(std::sqrt(static_cast<double>(most)));
    }
  return steps;
}

CaptureSphere capture_sphere(const scene::Character& character, const std::vector<std::vector<glm::vec3>>& positions) {
  const CaptureSphere sphere = enclosing_sphere(positions);
  if (!(sphere.radius > 0)) throw Error(character.name, "has no extent to take pictures of", "check the file");
  return sphere;
}

int tile_levels(int texels) {
  int levels = 1;
  while ((texels >> levels) >= 16) ++levels;
  return levels;
}

void hash_poses(Sha256& hash, const scene::PoseBank& bank, const FrameCount& count) {
  hash.value(count.frames);
  // Only where it is given, so that most bakes stay those of earlier versions.
  if (count.frames_a_second > 0) hash.value(count.frames_a_second);
  for (const scene::BankClip& c : bank.clips()) {
    hash.value(c.clip).value(c.samples > 1);
    if (c.samples > 1) continue;
    // A still pose may be any moment of the clip; it is told apart by its matrices.
    for (const scene::Mat3x4& m : bank.palette(bank.sample(static_cast<int>(&c - bank.clips().data()), 0)))
      hash.bytes(&m, sizeof m);
  }
}

}  // namespace crowdbench::renderers
