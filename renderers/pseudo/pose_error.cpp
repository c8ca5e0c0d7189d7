#include "renderers/pseudo/pose_error.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace crowdbench::renderers {
namespace {

constexpr uint32_t kMostPoses = 8;  // of a clip that are measured
constexpr int kDistances = 4;       // on either side of each

}  // namespace

PoseError even_pose_error(const scene::Character& character, const scene::PoseBank& bank, uint32_t poses) {
  PoseError error;
  double sum = 0;
  double count = 0;
  const auto points = [&](size_t clip, double phase) {
    return scene::skin_points(character.mesh, bank.palette(bank.sample(static_cast<int>(clip), phase)));
  };
  for (size_t k = 0; k < bank.clips().size(); ++k) {
    const uint32_t measured = std::min(poses, kMostPoses);
    for (uint32_t m = 0; m < measured; ++m) {
      const double phase = std::floor(static_cast<double>(m) * poses / measured) / poses;
      const std::vector<glm::vec3> shown = points(k, phase);
      for (int d = -kDistances; d < kDistances; ++d) {
        const std::vector<glm::vec3> own = points(k, phase + (d + 0.5) / (2.0 * kDistances * poses));
        for (size_t v = 0; v < own.size(); ++v) {
          const auto apart = static_cast<double>(glm::distance(own[v], shown[v]));
          sum += apart * apart;
          error.max = std::max(error.max, apart);
        }
        count += static_cast<double>(own.size());
      }
    }
  }
  error.rms = count > 0 ? std::sqrt(sum / count) : 0;
  return error;
}

}  // namespace crowdbench::renderers
