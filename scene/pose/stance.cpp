#include "scene/pose/stance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace crowdbench::scene {
namespace {

constexpr double kStraight = 0.087;    // sine of 5 degrees: a stance foot's direction this near to an axis is along it
constexpr double kStanceAgrees = 0.6;  // of a clip's intervals: that many of them go where their median goes
constexpr double kContact = 0.04;      // of the height above the clip's lowest sole point: in contact
// In walks and runs of ten characters no point that is in contact all along moves by less than 0.4 of the height, and
// half of the points at least (the rest are toes, which hardly rise) come forward 0.04 of it higher than they go back,
// and as far, but for a tenth where a last pose is missing. In blows, falls and getting up at most 0.37 of them do, in
// a throw that steps into it 0.47.
constexpr double kStanding = 0.05;  // of the height: a point in contact all along that moves by less carries all along
constexpr double kLift = 0.01;      // of the height: so much higher than it goes back a point comes forward that steps
constexpr double kSteps = 0.4;      // of the points of all soles: a foot may be dragged along
constexpr double kSameWay = 1.5;    // the longer of its ways back and forward over the shorter, at most

double lowest_of(const SoleTracks& tracks) {
  double lowest = std::numeric_limits<double>::max();
  for (const auto& points : tracks.poses)
    for (const glm::dvec3& p : points) lowest = std::min(lowest, p.y);
  return lowest;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Along an axis where it nearly is.
glm::dvec2 straightened(glm::dvec2 v) {
  const double length = glm::length(v);
  for (int axis = 0; axis < 2; ++axis)
    if (std::abs(v[axis]) < kStraight * length) return axis == 0 ? glm::dvec2(0.0, v.y) : glm::dvec2(v.x, 0.0);
  return v;
}

// How far the point that stays lowest over an interval between two poses, and in contact, goes backwards in it.
std::vector<glm::dvec2> bearing_moves(const SoleTracks& tracks, double lowest) {
  std::vector<glm::dvec2> out;
  for (size_t i = 0; i + 1 < tracks.poses.size(); ++i) {
    double best = lowest + kContact * tracks.height;
    std::optional<glm::dvec2> moved;
    for (size_t v = 0; v < tracks.poses[i].size(); ++v) {
      const glm::dvec3& a = tracks.poses[i][v];
      const glm::dvec3& b = tracks.poses[i + 1][v];
      if (std::max(a.y, b.y) > best) continue;
      best = std::max(a.y, b.y);
      moved = glm::dvec2(a.x - b.x, a.z - b.z);
    }
    if (moved) out.push_back(*moved);
  }
  return out;
}

// Does the point keep its place on the ground all along?
bool stands(const SoleTracks& tracks, size_t v, double lowest) {
  glm::dvec3 least = tracks.poses[0][v];
  glm::dvec3 most = least;
  for (const auto& points : tracks.poses) {
    least = glm::min(least, points[v]);
    most = glm::max(most, points[v]);
  }
  return most.y <= lowest + kContact * tracks.height &&
         std::hypot(most.x - least.x, most.z - least.z) <= kStanding * tracks.height;
}

// Does the point go back low and come forward higher? direction: unit, where forward is.
bool steps(const SoleTracks& tracks, size_t v, const glm::dvec2& direction) {
  struct Way {
    double length = 0, heights = 0;
    void add(double moved, double y) {
      length += moved;
      heights += moved * y;
    }
  } back, forward;
  for (size_t i = 0; i + 1 < tracks.poses.size(); ++i) {
    const glm::dvec3& a = tracks.poses[i][v];
    const glm::dvec3& b = tracks.poses[i + 1][v];
    const double moved = glm::dot(glm::dvec2(b.x - a.x, b.z - a.z), direction);
    (moved > 0 ? forward : back).add(std::abs(moved), 0.5 * (a.y + b.y));
  }
  const auto [shorter, longer] = std::minmax(back.length, forward.length);
  if (shorter <= 0 || longer > kSameWay * shorter) return false;
  return forward.heights / forward.length - back.heights / back.length >= kLift * tracks.height;
}

bool figure_steps(const SoleTracks& tracks, double lowest, const glm::dvec2& direction) {
  const size_t points = tracks.poses[0].size();
  size_t stepping = 0;
  for (size_t v = 0; v < points; ++v) {
    if (stands(tracks, v, lowest)) return false;
    stepping += steps(tracks, v, direction) ? 1 : 0;
  }
  return static_cast<double>(stepping) >= kSteps * static_cast<double>(points);
}

}  // namespace

std::optional<glm::dvec2> stance_velocity(const SoleTracks& tracks) {
  const double lowest = lowest_of(tracks);
  const std::vector<glm::dvec2> moves = bearing_moves(tracks, lowest);
  if (moves.empty()) return std::nullopt;
  const auto intervals = static_cast<double>(tracks.poses.size() - 1);
  std::vector<double> x;
  std::vector<double> z;
  for (const glm::dvec2& moved : moves) {
    x.push_back(moved.x * intervals / tracks.duration);
    z.push_back(moved.y * intervals / tracks.duration);
  }
  const glm::dvec2 velocity = straightened({median(x), median(z)});
  const double speed = glm::length(velocity);
  if (speed <= kStillFoot * tracks.height) return glm::dvec2(0.0);
  size_t agree = 0;
  for (size_t i = 0; i < x.size(); ++i)
    if (glm::dot(glm::dvec2(x[i], z[i]), velocity) > 0.5 * speed * speed) ++agree;
  // Feet shift and turn in clips that go nowhere; forwards, where people walk, the median is trusted.
  const bool forwards = velocity.x == 0 && velocity.y > 0;
  if (!forwards && static_cast<double>(agree) < kStanceAgrees * static_cast<double>(x.size())) return glm::dvec2(0.0);
  return figure_steps(tracks, lowest, velocity / speed) ? velocity : glm::dvec2(0.0);
}

}  // namespace crowdbench::scene
