// Based on: the separating axis theorem for rectangles (Gottschalk, Lin and Manocha, "OBBTree", 1996, in two
// dimensions).
#include "studies/stimuli/bodies.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace crowdbench::studies {
namespace {

// Lanes keep neighbours 0.7 spacings apart, Poisson disks 0.75 (scene/crowd/crowd.h).
constexpr double kLaneShare = 0.7;
constexpr double kDiskShare = 0.75;
constexpr double kLeastSpacing = 0.7;  // of the key crowd.spacing

struct Body {
  glm::dvec2 middle;               // (x, z)
  std::array<glm::dvec2, 2> axes;  // unit: to the left, ahead
  std::array<double, 2> half;      // metres along them
  double reach = 0;                // of a circle around it
  uint32_t id = 0;
};

Body body_of(const scene::FrameAgent& agent, const scene::PoseBank& bank) {
  const glm::dvec3 low = bank.bounds_min();
  const glm::dvec3 high = bank.bounds_max();
  const double sine = agent.heading.x;
  const double cosine = agent.heading.y;
  Body body;
  body.axes = {glm::dvec2(cosine, -sine), glm::dvec2(sine, cosine)};
  const double scale = agent.scale;
  body.half = {scale * (high.x - low.x) / 2, scale * (high.z - low.z) / 2};
  body.middle = glm::dvec2(agent.position.x, agent.position.z) + scale * (low.x + high.x) / 2 * body.axes[0] +
                scale * (low.z + high.z) / 2 * body.axes[1];
  body.reach = std::hypot(body.half[0], body.half[1]);
  body.id = agent.id;
  return body;
}

bool apart(const Body& a, const Body& b) {
  const glm::dvec2 between = b.middle - a.middle;
  for (const Body* const owner : {&a, &b})
    for (const glm::dvec2& axis : owner->axes) {
      double reach = 0;
      for (const Body* const body : {&a, &b})
        for (size_t i = 0; i < 2; ++i) reach += body->half[i] * std::abs(glm::dot(body->axes[i], axis));
      if (std::abs(glm::dot(between, axis)) >= reach) return true;
    }
  return false;
}

}  // namespace

double spacing_of_bodies(const scene::Scenario& scenario, const scene::Cast& cast) {
  const bool lanes = scenario.crowd.motion == scene::MotionKind::lanes;
  double need = 0;
  for (const auto& bank : cast.banks) {
    const glm::dvec3 low = bank->bounds_min();
    const glm::dvec3 high = bank->bounds_max();
    // From the pivot, twice: neighbours may face the other way, or be another character.
    const double across = 2 * std::max(std::abs(low.x), std::abs(high.x));
    const double along = 2 * std::max(std::abs(low.z), std::abs(high.z));
    need = std::max(need, lanes ? std::max(across, along) : std::hypot(across, along));
  }
  const double spacing = need * (1 + scenario.crowd.scale_variation) / (lanes ? kLaneShare : kDiskShare);
  return std::max(kLeastSpacing, std::ceil(spacing * 1000 + 1) / 1000);
}

std::optional<std::pair<uint32_t, uint32_t>> touching_bodies(const scene::Frame& frame, const scene::Cast& cast) {
  std::vector<Body> bodies;
  double reach = 0;
  for (size_t c = 0; c < frame.agents.size(); ++c)
    for (const scene::FrameAgent& agent : frame.agents[c]) {
      bodies.push_back(body_of(agent, *cast.banks[c]));
      reach = std::max(reach, bodies.back().reach);
    }
  std::sort(bodies.begin(), bodies.end(), [](const Body& a, const Body& b) { return a.middle.x < b.middle.x; });
  for (size_t i = 0; i < bodies.size(); ++i)
    for (size_t k = i + 1; k < bodies.size() && bodies[k].middle.x - bodies[i].middle.x < 2 * reach; ++k)
      if (!apart(bodies[i], bodies[k])) return std::pair(bodies[i].id, bodies[k].id);
  return std::nullopt;
}

}  // namespace crowdbench::studies
