// Depth buffers of other formats and directions: who stands in the wrong order, beside what their steps predict.
//
// Walkers in pairs, one exactly behind the other in the same pose, 1 mm to 10 m apart, 2 m to 10 km away; the truth is
// every front-facing surface at a pixel's centre, in double. A depth d is stored as z = offset + slope / d
// (renderers::StoredDepth). Two surfaces may be drawn in either order where their z are no farther apart than
//   a step of the format at the nearer of them to 1, for values round to the nearest one: reversed, |slope| is about
//   near, so that d^2 / (near 2^bits) metres are a step of fixed point; of floats reversed it is 2^-23 to 2^-24 of d
//   and, beside it, for each of the two
//   12 roundings of a float at |offset| + |slope| / d: 7 of the product with the projection, 1 of the division, 2 of
//   the viewport and 2 of the interpolation (a float rounds by 2^-24 of itself; IEEE 754)
//   the metres by which truth::OutlineBound lets a vertex be off, in depth, and across the picture times the slope of
//   the surface.
// What is farther than far is the cleared buffer: a surface that is a step or less before it may be lost. Pixels
// whose eight neighbours have the same surfaces, in front a smooth one, are counted alone: elsewhere a rasteriser may
// show what is beside. Which agent is drawn says its id; which of its surfaces, the stored depth: the one nearest to
// it, the first where the stored depth is infinite. A row also fails where a single pixel is wrong that may not be.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/stability/fixture.h"
#include "truth/judge.h"
#include "truth/posed_agent.h"
#include "truth/ray.h"
#include "truth/view.h"

namespace crowdbench::bench {

// One surface at the centre of a pixel.
struct Layer {
  double depth = 0;  // metres along the view axis
  uint32_t id = 0;   // FrameAgent::id
  double along = 0;  // metres by which it may be off along the axis in single precision
};

struct DepthScene {
  scene::Frame frame;
  std::vector<std::vector<Layer>> layers;  // by pixel, nearest first
  std::vector<bool> inner;                 // by pixel
};

struct DepthTruth {
  std::vector<DepthScene> scenes;
};

namespace {

using renderers::DepthFormat;
using renderers::DepthStorage;

constexpr double kDepthRoundings = 12;
constexpr int kPairs = 8;
constexpr double kSmooth = 3;  // metres a metre of pixel: steeper, a pixel is not inner

// ---- the truth

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

const DepthTruth& truth_of(Fixture& fixture) {
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

// ---- what a buffer makes of it

struct Planes {
  double near, far;  // metres; far 0: none
  const char* name;
};
constexpr Planes kPlanes[] = {
    {0.1, 0, "100mm_inf"}, {0.1, 1e6, "100mm_1e6"}, {1e-3, 0, "1mm_inf"}, {1e-3, 1e6, "1mm_1e6"}};
struct Format {
  DepthFormat format;
  const char* name;
};
constexpr Format kFormats[] = {
    {DepthFormat::float32, "32f"}, {DepthFormat::fixed24, "24"}, {DepthFormat::fixed16, "16"}};

// Pixels.
struct Orders {
  uint64_t looked_at = 0;
  uint64_t between = 0, inside = 0;                      // wrong: another agent or nobody; another surface of the agent
  uint64_t predicted_between = 0, predicted_inside = 0;  // that may be wrong
  uint64_t by_steps = 0;             // of those of both kinds: that the steps alone allow to be wrong
  uint64_t beyond = 0;               // wrong where they may not be
  std::string place, expected, got;  // of the first of those, else of the first wrong one
  uint64_t wrong() const { return between + inside; }
};

class Buffer {
 public:
  Buffer(const scene::Camera& camera, const DepthStorage& storage)
      : storage_(storage), stored_(renderers::stored_depth(camera, storage)) {}
  bool may_swap(const Layer& near, const Layer& far) const {
    return apart(near.depth, far.depth) <= step(near.depth, far.depth) + error(near) + error(far);
  }
  bool one_step(const Layer& near, const Layer& far) const {
    return apart(near.depth, far.depth) <= step(near.depth, far.depth);
  }
  bool may_vanish(const Layer& one) const {
    const double cleared = storage_.reversed ? 0.0 : 1.0;
    const double z = stored_.at(one.depth);
    return std::abs(z - cleared) <= renderers::stored_step(storage_, std::max(z, cleared)) + error(one);
  }

 private:
  double apart(double a, double b) const { return std::abs(stored_.slope * (b - a) / a / b); }
  double step(double a, double b) const {
    return renderers::stored_step(storage_, std::max(stored_.at(a), stored_.at(b)));
  }
  double error(const Layer& one) const {
    const double slope = std::abs(stored_.slope) / one.depth;
    return kDepthRoundings * 0x1p-24 * (std::abs(stored_.offset) + slope) + slope * one.along / one.depth;
  }
  DepthStorage storage_;
  renderers::StoredDepth stored_;
};

// Which of the layers is drawn, none where nobody is; of the picture's agent the one that its depth is nearest to.
std::optional<size_t> layer_drawn(const std::vector<Layer>& layers, uint32_t id, double depth) {
  std::optional<size_t> best;
  for (size_t i = 0; i < layers.size(); ++i)
    if (layers[i].id == id && (!best || std::abs(layers[i].depth - depth) < std::abs(layers[*best].depth - depth)))
      best = i;
  return best;
}

void compare_pixel(const std::vector<Layer>& layers, const Buffer& buffer, uint32_t id, double depth, Orders& out,
                   const std::string& place) {
  const Layer& first = layers.front();
  ++out.looked_at;
  bool other = buffer.may_vanish(first);
  bool own = false;
  bool step = false;
  for (size_t i = 1; i < layers.size(); ++i) {
    (layers[i].id == first.id ? own : other) |= buffer.may_swap(first, layers[i]);
    step = step || buffer.one_step(first, layers[i]);
  }
  out.by_steps += step ? 1U : 0U;
  out.predicted_between += other ? 1U : 0U;
  out.predicted_inside += own ? 1U : 0U;
  const std::optional<size_t> drawn = layer_drawn(layers, id, depth);
  if (drawn && *drawn == 0) return;
  (id == first.id ? out.inside : out.between) += 1U;
  const bool allowed = drawn ? buffer.may_swap(first, layers[*drawn]) : id == 0 && buffer.may_vanish(first);
  if (allowed ? out.wrong() > 1 : out.beyond++ > 0) return;
  out.place = place;
  out.expected = fmt::format("id {} at {:.7g} m", first.id, first.depth);
  out.got = fmt::format("id {} at {:.7g} m", id, drawn ? layers[*drawn].depth : depth);
}

Orders orders_of(Fixture& fixture, const DepthStorage& storage, const Planes& planes) {
  Orders out;
  for (const DepthScene& scene : truth_of(fixture).scenes) {
    scene::Frame frame = scene.frame;
    frame.camera.near = planes.near;
    frame.camera.far = planes.far;
    const renderers::Capture picture = fixture.draw_stored(frame, storage);
    const Buffer buffer(frame.camera, storage);
    for (size_t i = 0; i < scene.layers.size(); ++i) {
      if (!scene.inner[i]) continue;
      const auto width = static_cast<size_t>(frame.width);
      compare_pixel(scene.layers[i], buffer, picture.ids.data[i], static_cast<double>(picture.depth.data[i]), out,
                    fmt::format("{:g} m, pixel ({}, {})", scene.frame.camera.eye.z, i % width, i / width));
    }
  }
  return out;
}

// ---- the rows

constexpr size_t kRows = std::size(kPlanes) * 2 * std::size(kFormats);

struct Row {
  Planes planes;
  DepthStorage storage;
  std::string name, asked;
};

// The default first.
std::vector<Row> make_rows() {
  std::vector<Row> out;
  for (const Planes& planes : kPlanes)
    for (const Format& format : kFormats)
      for (const bool reversed : {true, false}) {
        const char* direction = reversed ? "reversed" : "straight";
        out.push_back({planes,
                       {format.format, reversed},
                       fmt::format("{}_{}_{}", format.name, direction, planes.name),
                       fmt::format("depths of {} bits, {}, planes at {:g} m and {}", format.name,
                                   reversed ? "near 1 to far 0" : "near 0 to far 1", planes.near,
                                   planes.far > 0 ? fmt::format("{:g} m", planes.far) : "infinity")});
      }
  return out;
}

const Row& row_at(size_t i) {
  static const std::vector<Row> rows = make_rows();
  return rows[i];
}

Found found_of(const Orders& orders, bool between) {
  Found found;
  const uint64_t wrong = between ? orders.between : orders.inside;
  found.bound = static_cast<double>(between ? orders.predicted_between : orders.predicted_inside);
  found.measured = orders.beyond > 0 ? INFINITY : static_cast<double>(wrong);
  found.place = orders.place;
  found.expected = orders.expected;
  found.got = orders.got;
  found.note =
      fmt::format("{} wrong of {} pixels; of both kinds {} where a step alone allows it, and {} where nothing does",
                  wrong, orders.looked_at, orders.by_steps, orders.beyond);
  return found;
}

template <size_t I, bool Between>
Found measure_depth_row(Fixture& fixture) {
  return found_of(orders_of(fixture, row_at(I).storage, row_at(I).planes), Between);
}

// With the same planes: what is chosen is the format and the direction.
Found least_is_the_default(Fixture& fixture) {
  Found found;
  found.bound = INFINITY;
  for (size_t i = 0; i < 2 * std::size(kFormats); ++i) {
    const auto wrong = static_cast<double>(orders_of(fixture, row_at(i).storage, row_at(i).planes).wrong());
    if (i == 0) {
      found.measured = wrong;
    } else if (wrong < found.bound) {
      found.bound = wrong;
      found.note = fmt::format("the next is {}", row_at(i).name);
    }
  }
  return found;
}

template <size_t... I>
void add_rows(std::vector<StabilityCase>& cases, std::index_sequence<I...>) {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (size_t i = 0; i < kRows; ++i)
      for (const char* kind : {"depth_", "depth_in_"}) out.push_back(kind + row_at(i).name);
    return out;
  }();
  const auto add = [&](size_t i, bool between, Found (*measure)(Fixture&)) {
    cases.push_back({.name = names[2 * i + (between ? 0 : 1)],
                     .group = "depth",
                     .asked = row_at(i).asked,
                     .unit = between ? "pixels, other agent" : "pixels, same agent",
                     .bound_from =
                         "predicted: the pixels with two surfaces, or one and the far plane, within a step of "
                         "the format and the roundings on the way there (bench/stability/depth.cpp). That pixels are "
                         "looked at only where their neighbours have the same surfaces was decided after two "
                         "at hidden outlines had differed",
                     .bound_seen = true,
                     .once = true,
                     .small = i < 2 * std::size(kFormats),
                     .measure = measure});
  };
  (..., (add(I, true, measure_depth_row<I, true>), add(I, false, measure_depth_row<I, false>)));
}

}  // namespace

void add_depth_cases(std::vector<StabilityCase>& cases) {
  add_rows(cases, std::make_index_sequence<kRows>());
  cases.push_back({.name = "depth_default",
                   .group = "depth",
                   .asked = "32 bits of float, reversed, beside the other formats and directions with the same planes",
                   .unit = "pixels",
                   .bound_from = "the least of the others: what every picture is drawn with is to be the best of them",
                   .once = true,
                   .measure = least_is_the_default});
}

}  // namespace crowdbench::bench
