#include "bench/stability/depth_truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "bench/stability/fixture.h"
#include "truth/judge.h"
#include "truth/posed_agent.h"
#include "truth/ray.h"
#include "truth/view.h"

namespace crowdbench::bench {
namespace {

constexpr int kPairs = 8;
constexpr double kSmooth = 3;  // metres a metre of pixel: steeper, a pixel is not inner

// 1 mm to 10 m, evenly in their logarithm over all pairs. Every other pair has the farther one first: of equal depths
// the first drawn stays.
DepthScene pairs_at(Fixture& fixture, double distance, int scene_index, int scenes) {
  const int rows = fixture.side(140);
  const double tall = 1.75 * 1.2;  // metres that the picture shows
  const double fov = 2 * std::atan(tall / 2 / distance) * 180 / std::numbers::pi;
  DepthScene out;
  out.frame = empty_frame({0, 0.9, distance}, {0, 0.9, 0}, fov, fixture.side(440), rows);
  for (int pair = 0; pair < kPairs; ++pair) {
    const double share = static_cast<double>(pair * scenes + scene_index) / (kPairs * scenes - 1);
    const double gap = std::pow(10.0, -3 + 4 * share);
    const double x = 0.8 * (pair - (kPairs - 1) / 2.0);
    const double phase = 0.11 * pair;
    // On one ray from the eye, so that the farther one is hidden and not beside.
    const double behind = x * (distance + gap) / distance;
    const bool farther_first = pair % 2 == 1;
    if (farther_first) add_agent(out.frame, fixture.walker(), {behind, 0, -gap}, phase, 0.1);
    add_agent(out.frame, fixture.walker(), {x, 0, 0}, phase, 0.1);
    if (!farther_first) add_agent(out.frame, fixture.walker(), {behind, 0, -gap}, phase, 0.1);
  }
  return out;
}

// Metres along the axis that a place beside is nearer or farther, a pixel.
double slope_of(const truth::View& view, const glm::dvec3& normal, const glm::dvec3& direction, double depth) {
  const glm::dvec2 across(glm::dot(normal, view.right()), glm::dot(normal, view.down()));
  return depth * glm::length(across) / std::abs(glm::dot(normal, direction));
}

void add_layers(DepthScene& scene, const scene::Cast& cast, const truth::View& view, size_t agent) {
  const scene::FrameAgent& one = scene.frame.agents[0][agent];
  const scene::Mesh& mesh = cast.characters[0]->mesh;
  const truth::AgentPose pose(*cast.characters[0], *cast.banks[0], one);
  const truth::OutlineBound bound = truth::outline_bound(cast, scene.frame, 0, agent);
  const std::vector<uint32_t> corners = truth::drawn_indices(mesh);
  const int width = scene.frame.width;
  for (size_t t = 0; t + 2 < corners.size(); t += 3) {
    const std::array<glm::dvec3, 3> at = {pose.position(corners[t]), pose.position(corners[t + 1]),
                                          pose.position(corners[t + 2])};
    const std::array<glm::dvec2, 3> places = {view.place(at[0]), view.place(at[1]), view.place(at[2])};
    const glm::dvec2 low = glm::min(places[0], glm::min(places[1], places[2]));
    const glm::dvec2 high = glm::max(places[0], glm::max(places[1], places[2]));
    const glm::dvec3 normal = glm::cross(at[1] - at[0], at[2] - at[0]);
    for (int y = std::max(0, static_cast<int>(low.y) - 1); y <= std::min(scene.frame.height - 1.0, high.y); ++y)
      for (int x = std::max(0, static_cast<int>(low.x) - 1); x <= std::min(width - 1.0, high.x); ++x) {
        const glm::dvec3 direction = view.direction({x + 0.5, y + 0.5});
        truth::TriangleHit hit;
        if (!truth::Ray(glm::dvec3(0.0), direction).hits(at[0], at[1], at[2], hit) || hit.back) continue;
        const double off = slope_of(view, normal, direction, hit.t) * bound.pixels() +
                           hit.t * view.pixel() * (bound.weights + bound.single);
        scene.layers[static_cast<size_t>(y * width + x)].push_back({hit.t, one.id, off});
      }
  }
}

// Whose surfaces are there, of each as many times as it has.
std::vector<uint32_t> ids_of(const std::vector<Layer>& layers) {
  std::vector<uint32_t> out;
  for (const Layer& layer : layers) out.push_back(layer.id);
  std::ranges::sort(out);
  return out;
}

void find_inner(DepthScene& scene, const truth::View& view) {
  const int width = scene.frame.width;
  const auto layers_at = [&](int x, int y) -> const std::vector<Layer>& {
    return scene.layers[static_cast<size_t>(y * width + x)];
  };
  for (int y = 1; y + 1 < scene.frame.height; ++y)
    for (int x = 1; x + 1 < width; ++x) {
      const std::vector<Layer>& here = layers_at(x, y);
      if (here.empty()) continue;
      const std::vector<uint32_t> ids = ids_of(here);
      const double first = here.front().depth;
      bool same = true;
      for (int i = 0; i < 9 && same; ++i) {
        const std::vector<Layer>& there = layers_at(x + i % 3 - 1, y + i / 3 - 1);
        same = ids_of(there) == ids && there.front().id == here.front().id &&
               std::abs(there.front().depth - first) < kSmooth * first * view.pixel();
      }
      scene.inner[static_cast<size_t>(y * width + x)] = same;
    }
}

}  // namespace

const DepthTruth& depth_truth(Fixture& fixture) {
  if (!fixture.depth_truth()) {
    auto made = std::make_shared<DepthTruth>();
    const std::vector<double> distances =
        fixture.small() ? std::vector<double>{2, 200, 1e4} : std::vector<double>{2, 20, 200, 2000, 1e4};
    for (size_t i = 0; i < distances.size(); ++i) {
      DepthScene scene = pairs_at(fixture, distances[i], static_cast<int>(i), static_cast<int>(distances.size()));
      const truth::View view(scene.frame);
      scene.layers.resize(static_cast<size_t>(scene.frame.width * scene.frame.height));
      scene.inner.resize(scene.layers.size());
      for (size_t agent = 0; agent < scene.frame.agents[0].size(); ++agent)
        add_layers(scene, fixture.walker(), view, agent);
      for (auto& layers : scene.layers)
        std::ranges::sort(layers, [](const Layer& a, const Layer& b) {
          return a.depth != b.depth ? a.depth < b.depth : a.id < b.id;
        });
      find_inner(scene, view);
      made->scenes.push_back(std::move(scene));
    }
    fixture.depth_truth() = made;
  }
  return *fixture.depth_truth();
}

}  // namespace crowdbench::bench
