#include "scene/pose/pose_bank.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "scene/character/cut_out.h"
#include "scene/pose/hidden.h"
#include "scene/pose/pose.h"

namespace crowdbench::scene {
namespace {

Mat3x4 to_rows(const glm::dmat4& m) {
  Mat3x4 out;
  for (int row = 0; row < 3; ++row) out.rows[row] = glm::vec4(m[0][row], m[1][row], m[2][row], m[3][row]);
  return out;
}

double wrapped(double phase) {
  const double whole = phase - std::floor(phase);
  return whole < 1.0 ? whole : 0.0;  // a phase just below zero rounds up to one
}

BankClip describe(const Character& character, int clip) {
  BankClip out;
  out.clip = clip;
  if (clip < 0) return out;
  out.seconds = cycle_seconds(character, clip);
  const ClipMotion& motion = character.motion[static_cast<size_t>(clip)];
  out.ground_speed = motion.ground_speed;
  out.direction = motion.direction;
  out.turns = motion.yaw_rate / 6.283185307179586;
  return out;
}

// Bounds of what masks leave, where there are any; `matrices` of `joints` a sample.
void leave_out_what_masks_cut(const Character& character, const std::vector<Mat3x4>& matrices, size_t joints,
                              glm::vec3& low, glm::vec3& high) {
  DrawnExtent extent(character);
  if (!extent.cuts() || matrices.empty()) return;
  low = glm::vec3(std::numeric_limits<float>::max());
  high = glm::vec3(std::numeric_limits<float>::lowest());
  std::vector<double> along(character.mesh.positions.size());
  for (size_t first = 0; first < matrices.size(); first += joints) {
    const std::vector<glm::vec3> points =
        shown_positions(character.mesh, std::span<const Mat3x4>{matrices.data() + first, joints});
    for (int axis = 0; axis < 3; ++axis)
      for (const float sign : {-1.0F, 1.0F}) {
        for (size_t v = 0; v < along.size(); ++v) along[v] = sign * points[v][axis];
        const float most = sign * static_cast<float>(extent.most(along));
        (sign < 0 ? low : high)[axis] = sign < 0 ? std::min(low[axis], most) : std::max(high[axis], most);
      }
  }
}

}  // namespace

std::vector<glm::vec3> skin_points(const Mesh& mesh, std::span<const Mat3x4> palette) {
  std::vector<glm::vec3> points(mesh.positions.size(), glm::vec3(0.0F));
  for (size_t v = 0; v < points.size(); ++v) {
    const glm::vec4 position(mesh.positions[v], 1.0F);
    for (int i = 0; i < kInfluences; ++i) {
      const float weight = mesh.weights[v][i];
      if (weight == 0.0F) continue;
      const Mat3x4& m = palette[mesh.joints[v][i]];
      points[v] += weight * glm::vec3(glm::dot(m.rows[0], position), glm::dot(m.rows[1], position),
                                      glm::dot(m.rows[2], position));
    }
  }
  return points;
}

PoseBank::PoseBank(const Character& character, const std::vector<int>& clips, double rate) {
  assert(rate > 0.0);
  for (const int clip : clips) {
    BankClip entry = describe(character, clip);
    entry.samples = static_cast<uint32_t>(std::max(1.0, std::round(entry.seconds * rate)));
    entry.first_sample = clips_.empty() ? 0 : clips_.back().first_sample + clips_.back().samples;
    for (uint32_t i = 0; i < entry.samples; ++i) {
      add_sample(character, model_matrices(character, clip, static_cast<double>(i) / entry.samples));
    }
    clips_.push_back(entry);
  }
  leave_out_what_masks_cut(character, matrices_, static_cast<size_t>(joints_), bounds_min_, bounds_max_);
}

PoseBank PoseBank::exact(const Character& character, int clip, double time, bool raw) {
  PoseBank bank;
  BankClip entry;
  entry.clip = clip;
  if (raw) {
    bank.add_sample(character, joint_matrices(character, clip, time));
  } else {
    bank.add_sample(character, model_matrices(character, clip, clip < 0 ? 0.0 : phase_of_time(character, clip, time)));
  }
  bank.clips_.push_back(entry);
  leave_out_what_masks_cut(character, bank.matrices_, static_cast<size_t>(bank.joints_), bank.bounds_min_,
                           bank.bounds_max_);
  return bank;
}

PoseBank PoseBank::frames(const Character& character, const std::vector<int>& clips, const std::vector<int>& frames) {
  assert(frames.size() == clips.size());
  PoseBank bank;
  for (size_t c = 0; c < clips.size(); ++c) {
    const int clip = clips[c];
    assert(frames[c] > 0);
    BankClip entry = describe(character, clip);
    entry.samples = entry.seconds > 0.0 ? static_cast<uint32_t>(frames[c]) : 1;
    entry.first_sample = bank.clips_.empty() ? 0 : bank.clips_.back().first_sample + bank.clips_.back().samples;
    for (uint32_t i = 0; i < entry.samples; ++i) {
      bank.add_sample(character, model_matrices(character, clip, static_cast<double>(i) / entry.samples));
    }
    bank.clips_.push_back(entry);
  }
  leave_out_what_masks_cut(character, bank.matrices_, static_cast<size_t>(bank.joints_), bank.bounds_min_,
                           bank.bounds_max_);
  return bank;
}

PoseSample PoseBank::sample(int bank_clip, double phase) const {
  assert(bank_clip >= 0 && static_cast<size_t>(bank_clip) < clips_.size());
  const BankClip& entry = clips_[static_cast<size_t>(bank_clip)];
  const double position = wrapped(phase) * entry.samples;
  const auto a = std::min(static_cast<uint32_t>(position), entry.samples - 1);
  const uint32_t b = a + 1 == entry.samples ? 0 : a + 1;
  PoseSample out{entry.first_sample + a, entry.first_sample + b, static_cast<float>(position - a)};
  if (entry.samples == 1) out.blend = 0.0F;
  return out;
}

std::vector<Mat3x4> PoseBank::palette(const PoseSample& sample) const {
  const auto count = static_cast<size_t>(joints_);
  const Mat3x4* a = matrices_.data() + sample.a * count;
  const Mat3x4* b = matrices_.data() + sample.b * count;
  std::vector<Mat3x4> out(count);
  for (size_t j = 0; j < count; ++j) {
    for (int row = 0; row < 3; ++row) out[j].rows[row] = glm::mix(a[j].rows[row], b[j].rows[row], sample.blend);
  }
  return out;
}

int PoseBank::bank_clip(int character_clip) const {
  for (size_t i = 0; i < clips_.size(); ++i) {
    if (clips_[i].clip == character_clip) return static_cast<int>(i);
  }
  return -1;
}

void PoseBank::add_sample(const Character& character, const std::vector<glm::dmat4>& palette) {
  if (matrices_.empty()) {
    joints_ = static_cast<int>(palette.size());
    bounds_min_ = glm::vec3(std::numeric_limits<float>::max());
    bounds_max_ = glm::vec3(std::numeric_limits<float>::lowest());
  }
  const size_t first = matrices_.size();
  for (const glm::dmat4& matrix : palette) matrices_.push_back(to_rows(matrix));
  for (const glm::vec3& posed :
       shown_positions(character.mesh, std::span<const Mat3x4>{matrices_.data() + first, palette.size()})) {
    bounds_min_ = glm::min(bounds_min_, posed);
    bounds_max_ = glm::max(bounds_max_, posed);
  }
}

}  // namespace crowdbench::scene
