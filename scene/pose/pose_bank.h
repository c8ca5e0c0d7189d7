// PoseBank: every used clip of a character sampled at a fixed rate into joint matrices; the one source of poses for
// every representation. A phase between two samples is the linear blend of their matrices, on the CPU and on the GPU
// alike.
#pragma once
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::scene {

// Three rows of four floats: the upper 3x4 of a model-space joint matrix, row-major, 48 bytes; what the GPU reads.
struct Mat3x4 {
  glm::vec4 rows[3];
};

// Vertices as a palette poses them, in its space: in floats, as the GPU reckons.
std::vector<glm::vec3> skin_points(const Mesh& mesh, std::span<const Mat3x4> palette);

struct BankClip {
  int clip = -1;                   // into Character::clips, -1: the bind pose
  uint32_t first_sample = 0;       // samples are counted over the whole bank
  uint32_t samples = 1;            // at phases 0, 1/samples, 2/samples, ...; the last blends into the first
  double seconds = 0;              // of one cycle; 0 for a still pose
  double ground_speed = 0;         // metres a second at speed 1
  glm::dvec2 direction{0.0, 1.0};  // unit, (x, z) in model space: where to
  double turns = 0;                // a second: how fast that direction and the character turn, from +Z towards +X
};

// Where a phase lies: matrices = mix(sample a, sample b, blend).
struct PoseSample {
  uint32_t a = 0;
  uint32_t b = 0;
  float blend = 0;
};

class PoseBank {
 public:
  // Samples the given clips (indices into character.clips) at `rate` Hz; the samples divide a loop exactly, at least
  // one in each clip.
  PoseBank(const Character& character, const std::vector<int>& clips, double rate = 30.0);
  // A bank with exactly one sample: a clip at one of the file's own times, in model space (or raw glTF space when
  // `raw`); clip -1: the bind pose. What commands about one agent and every bake use.
  static PoseBank exact(const Character& character, int clip, double time, bool raw = false);
  // A bank of frames[i] samples of clips[i] at phases 0, 1/frames[i], ... exactly on the curves.
  static PoseBank frames(const Character& character, const std::vector<int>& clips, const std::vector<int>& frames);

  // bank_clip: index into clips(). phase: any value, wrapped into [0, 1).
  PoseSample sample(int bank_clip, double phase) const;
  // The blended palette of one pose.
  std::vector<Mat3x4> palette(const PoseSample& sample) const;
  // Index into clips() of a character's clip; -1 when the bank does not hold it.
  int bank_clip(int character_clip) const;

  const std::vector<BankClip>& clips() const { return clips_; }
  int joints() const { return joints_; }
  // samples x joints, sample-major.
  const std::vector<Mat3x4>& matrices() const { return matrices_; }
  // Axis-aligned bounds of the posed mesh over every sample, metres, model space.
  glm::vec3 bounds_min() const { return bounds_min_; }
  glm::vec3 bounds_max() const { return bounds_max_; }

 private:
  PoseBank() = default;
  void add_sample(const Character& character, const std::vector<glm::dmat4>& palette);
  int joints_ = 0;
  std::vector<BankClip> clips_;
  std::vector<Mat3x4> matrices_;
  glm::vec3 bounds_min_{0.0F};
  glm::vec3 bounds_max_{0.0F};
};

}  // namespace crowdbench::scene
