#include "renderers/impostor/tiles/stored_frames.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/hash.h"

namespace crowdbench::renderers {

std::vector<scene::Mat3x4> StoredFrames::palette(size_t frame) const {
  return bank(poses[frame].moves)->palette(poses[frame].sample);
}

std::vector<std::vector<glm::vec3>> StoredFrames::positions(const scene::Mesh& mesh) const {
  std::vector<std::vector<glm::vec3>> out;
  for (size_t f = 0; f < size(); ++f) out.push_back(posed_positions(mesh, palette(f)));
  return out;
}

StoredFrames stored_frames(const scene::Character& character, const std::shared_ptr<const scene::PoseBank>& bank,
                           int frames) {
  StoredFrames out;
  out.still = bank;
  std::vector<int> moving;
  for (const scene::BankClip& c : bank->clips())
    if (c.samples > 1) moving.push_back(c.clip);
  if (!moving.empty())
    out.moving = std::make_shared<const scene::PoseBank>(scene::PoseBank::frames(character, moving, frames));
  int next_moving = 0;
  for (size_t c = 0; c < bank->clips().size(); ++c) {
    const bool moves = bank->clips()[c].samples > 1;
    const int clip = moves ? next_moving++ : static_cast<int>(c);
    const int count = moves ? frames : 1;
    out.clips.push_back({static_cast<uint32_t>(out.size()), static_cast<uint32_t>(count)});
    for (int f = 0; f < count; ++f)
      out.poses.push_back({moves, out.bank(moves)->sample(clip, static_cast<double>(f) / count)});
  }
  return out;
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

void hash_poses(Sha256& hash, const scene::PoseBank& bank) {
  for (const scene::BankClip& c : bank.clips()) {
    hash.value(c.clip).value(c.samples > 1);
    if (c.samples > 1) continue;
    // A still pose may be any moment of the clip; it is told apart by its matrices.
    for (const scene::Mat3x4& m : bank.palette(bank.sample(static_cast<int>(&c - bank.clips().data()), 0)))
      hash.bytes(&m, sizeof m);
  }
}

}  // namespace crowdbench::renderers
