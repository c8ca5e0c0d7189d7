// Based on: A. Aubel, R. Boulic and D. Thalmann, "Animated impostors for real-time display of numerous virtual humans"
// (1998). Differs from the source: points are means of what a joint moves, not the joints' own places, since a turn of
// the last joint of a limb moves no joint's place; which joints is reckoned from the clips.
#include "renderers/dynamic/pose_probe.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace crowdbench::renderers {
namespace {

constexpr double kHz = 60;           // of the frames that pose_staleness plays
constexpr double kSeconds = 1.5;     // of a clip, at most
constexpr size_t kMostSamples = 64;  // of the bank that points are chosen by

glm::vec3 posed_point(const scene::Mat3x4& matrix, const glm::vec3& place) {
  const glm::vec4 p(place, 1.0F);
  return {glm::dot(matrix.rows[0], p), glm::dot(matrix.rows[1], p), glm::dot(matrix.rows[2], p)};
}

}  // namespace

std::vector<JointPoint> choose_joint_points(const scene::Character& character, const scene::PoseBank& bank,
                                            size_t count) {
  const auto joints = static_cast<size_t>(bank.joints());
  std::vector<glm::dvec3> sums(joints, glm::dvec3(0.0));
  std::vector<double> weights(joints, 0.0);
  const scene::Mesh& mesh = character.mesh;
  for (size_t v = 0; v < mesh.positions.size(); ++v)
    for (int k = 0; k < scene::kInfluences; ++k) {
      const auto weight = static_cast<double>(mesh.weights[v][k]);
      sums[mesh.joints[v][k]] += glm::dvec3(mesh.positions[v]) * weight;
      weights[mesh.joints[v][k]] += weight;
    }
  std::vector<JointPoint> all;
  size_t next = 0;
  for (size_t j = 0; j < joints; ++j) {
    if (!(weights[j] > 0)) continue;
    all.push_back({static_cast<uint32_t>(j), glm::vec3(sums[j] / weights[j])});
    if (weights[j] > weights[all[next].joint]) next = all.size() - 1;
  }
  const size_t samples = bank.matrices().size() / std::max<size_t>(joints, 1);
  const size_t step = samples / kMostSamples + 1;
  const auto change = [&](const JointPoint& a, const JointPoint& b) {
    float low = std::numeric_limits<float>::infinity();
    float high = 0;
    for (size_t s = 0; s < samples; s += step) {
      const scene::Mat3x4* const palette = bank.matrices().data() + s * joints;
      const float apart = glm::distance(posed_point(palette[a.joint], a.place), posed_point(palette[b.joint], b.place));
      low = std::min(low, apart);
      high = std::max(high, apart);
    }
    return high - low;
  };
  std::vector<JointPoint> chosen;
  std::vector<float> least(all.size(), std::numeric_limits<float>::infinity());
  while (chosen.size() < std::min(count, all.size())) {
    chosen.push_back(all[next]);
    for (size_t i = 0; i < all.size(); ++i) least[i] = std::min(least[i], change(all[i], all[next]));
    next = static_cast<size_t>(std::max_element(least.begin(), least.end()) - least.begin());
    if (!(least[next] > 0)) break;
  }
  return chosen;
}

PoseProbe::PoseProbe(const scene::PoseBank& bank, const std::vector<JointPoint>& points) : points_(points.size()) {
  const auto joints = static_cast<size_t>(bank.joints());
  const size_t samples = joints == 0 ? 0 : bank.matrices().size() / joints;
  places_.reserve(samples * points_);
  for (size_t s = 0; s < samples; ++s)
    for (const JointPoint& point : points)
      places_.push_back(posed_point(bank.matrices()[s * joints + point.joint], point.place));
}

std::vector<float> PoseProbe::distances(const scene::PoseSample& pose) const {
  std::vector<float> out;
  out.reserve(points_ * (points_ - std::min<size_t>(points_, 1)) / 2);
  const auto at = [&](size_t i) {
    return glm::mix(places_[pose.a * points_ + i], places_[pose.b * points_ + i], pose.blend);
  };
  for (size_t i = 1; i < points_; ++i) {
    const glm::vec3 p = at(i);
    for (size_t j = 0; j < i; ++j) out.push_back(glm::distance(p, at(j)));
  }
  return out;
}

float largest_change(const std::vector<float>& a, const std::vector<float>& b) {
  assert(a.size() == b.size());
  float most = 0;
  for (size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

PoseStaleness pose_staleness(const scene::Character& character, const scene::PoseBank& bank, const PoseProbe& probe,
                             double threshold) {
  PoseStaleness out;
  double sum = 0;
  double count = 0;
  double played = 0;
  for (size_t k = 0; k < bank.clips().size(); ++k) {
    const double seconds = bank.clips()[k].seconds;
    if (!(seconds > 0)) continue;
    std::vector<glm::vec3> shown;
    std::vector<float> known;
    const int frames = static_cast<int>(std::min(kSeconds, std::max(seconds, 0.5)) * kHz);
    for (int f = 0; f < frames; ++f) {
      const scene::PoseSample pose = bank.sample(static_cast<int>(k), f / (kHz * seconds));
      const std::vector<float> own = probe.distances(pose);
      const std::vector<glm::vec3> points = scene::skin_points(character.mesh, bank.palette(pose));
      if (known.empty() || static_cast<double>(largest_change(own, known)) > threshold) {
        out.refreshes += known.empty() && f == 0 ? 0 : 1;
        known = own;
        shown = points;
      }
      for (size_t v = 0; v < points.size(); ++v) {
        const auto apart = static_cast<double>(glm::distance(points[v], shown[v]));
        sum += apart * apart;
        out.max = std::max(out.max, apart);
      }
      count += static_cast<double>(points.size());
    }
    played += (frames - 1) / kHz;
  }
  out.rms = count > 0 ? std::sqrt(sum / count) : 0;
  out.refreshes = played > 0 ? out.refreshes / played : 0;
  return out;
}

}  // namespace crowdbench::renderers
