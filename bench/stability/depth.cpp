// Depth buffers of other formats and directions: who stands in the wrong order, beside what their steps predict.
//
// Walkers in pairs, one exactly behind the other in the same pose, 1 mm to 10 m apart, 2 m to 10 km away; the truth is
// every front-facing surface at a pixel's centre, in double. A depth d is stored as z = offset + slope / d
// (renderers::StoredDepth). Two surfaces may be drawn in either order where their z are no farther apart than
//   a step of the format at the larger of the two, for values round to the nearest one: reversed, |slope| is about
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
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/stability/depth_truth.h"
#include "bench/stability/fixture.h"

namespace crowdbench::bench {
namespace {

using renderers::DepthFormat;
using renderers::DepthStorage;

constexpr double kDepthRoundings = 12;

struct DepthPlanes {
  double near, far;  // metres; far 0: none
  const char* name;
};
constexpr DepthPlanes kPlanes[] = {
    {0.1, 0, "100mm_inf"}, {0.1, 1e6, "100mm_1e6"}, {1e-3, 0, "1mm_inf"}, {1e-3, 1e6, "1mm_1e6"}};
struct DepthKind {
  DepthFormat format;
  const char* name;
  const char* about;
};
constexpr DepthKind kFormats[] = {{DepthFormat::float32, "32f", "32 bits of float"},
                                  {DepthFormat::fixed24, "24", "24 bits"},
                                  {DepthFormat::fixed16, "16", "16 bits"}};

// Pixels.
struct DepthOrders {
  uint64_t looked_at = 0;
  uint64_t between = 0, inside = 0;                      // wrong: another agent or nobody; another surface of the agent
  uint64_t predicted_between = 0, predicted_inside = 0;  // that may be wrong
  uint64_t by_steps = 0;             // of those of both kinds: that the steps alone allow to be wrong
  uint64_t beyond = 0;               // wrong where they may not be
  std::string place, expected, got;  // of the first of those, else of the first wrong one
  uint64_t wrong() const { return between + inside; }
  double share(uint64_t pixels) const { return static_cast<double>(pixels) / static_cast<double>(looked_at); }
};

class DepthBuffer {
 public:
  DepthBuffer(const scene::Camera& camera, const DepthStorage& storage)
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

// place: makes its text.
template <typename Place>
void compare_pixel(const std::vector<Layer>& layers, const DepthBuffer& buffer, uint32_t id, double depth,
                   DepthOrders& out, const Place& place) {
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
  out.place = place();
  out.expected = fmt::format("id {} at {:.7g} m", first.id, first.depth);
  out.got = fmt::format("id {} at {:.7g} m", id, drawn ? layers[*drawn].depth : depth);
}

DepthOrders orders_of(Fixture& fixture, const DepthStorage& storage, const DepthPlanes& planes) {
  DepthOrders out;
  for (const DepthScene& scene : depth_truth(fixture).scenes) {
    scene::Frame frame = scene.frame;
    frame.camera.near = planes.near;
    frame.camera.far = planes.far;
    const renderers::Capture picture = fixture.draw_stored(frame, storage);
    const DepthBuffer buffer(frame.camera, storage);
    for (size_t i = 0; i < scene.layers.size(); ++i) {
      if (!scene.inner[i]) continue;
      const auto width = static_cast<size_t>(frame.width);
      compare_pixel(scene.layers[i], buffer, picture.ids.data[i], static_cast<double>(picture.depth.data[i]), out, [&] {
        return fmt::format("{:g} m, pixel ({}, {})", scene.frame.camera.eye.z, i % width, i / width);
      });
    }
  }
  return out;
}

// ---- the rows

constexpr size_t kRows = std::size(kPlanes) * 2 * std::size(kFormats);

struct DepthRow {
  DepthPlanes planes;
  DepthStorage storage;
  std::string name, asked;
};

// The default first.
std::vector<DepthRow> make_rows() {
  std::vector<DepthRow> out;
  for (const DepthPlanes& planes : kPlanes)
    for (const DepthKind& format : kFormats)
      for (const bool reversed : {true, false}) {
        const char* direction = reversed ? "reversed" : "straight";
        out.push_back({planes,
                       {format.format, reversed},
                       fmt::format("{}_{}_{}", format.name, direction, planes.name),
                       fmt::format("depths of {}, {}, planes at {:g} m and {}", format.about,
                                   reversed ? "near 1 to far 0" : "near 0 to far 1", planes.near,
                                   planes.far > 0 ? fmt::format("{:g} m", planes.far) : "infinity")});
      }
  return out;
}

const DepthRow& row_at(size_t i) {
  static const std::vector<DepthRow> rows = make_rows();
  return rows[i];
}

Found found_of(const DepthOrders& orders, bool between) {
  Found found;
  const uint64_t wrong = between ? orders.between : orders.inside;
  found.bound = orders.share(between ? orders.predicted_between : orders.predicted_inside);
  found.measured = orders.beyond > 0 ? INFINITY : orders.share(wrong);
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
    const DepthOrders orders = orders_of(fixture, row_at(i).storage, row_at(i).planes);
    const double wrong = orders.share(orders.wrong());
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
                     .unit = between ? "of pixels, wrong agent" : "of pixels, wrong surface",
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
                   .unit = "of pixels",
                   .bound_from = "the least of the others: what every picture is drawn with is to be the best of them",
                   .once = true,
                   .measure = least_is_the_default});
}

}  // namespace crowdbench::bench
