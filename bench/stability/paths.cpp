// Camera paths where a picture may crack or jump: through bodies, along the faces and edges of the box around one, over
// the pole, and over every seam between stored views. A step is 1e-4 of the way.
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "bench/stability/surface.h"
#include "renderers/impostor/views/view_sampling.h"

namespace crowdbench::bench {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kStep = 1e-4;  // of the way

struct View {
  glm::dvec3 eye, target, up{0, 1, 0};
};
using Way = std::function<View(double t)>;  // t in [0, 1]

struct Path {
  Way at;
  double fov_deg = 40;
  double near = 0.1;
  double moved = 0;  // metres by which a step moves the picture's content against the eye, at most
};

scene::Frame frame_at(Fixture& fixture, const Path& path, double t) {
  const View view = path.at(t);
  scene::Frame frame = empty_frame(view.eye, view.target, path.fov_deg, fixture.side(240), fixture.side(240));
  frame.camera.up = view.up;
  frame.camera.near = path.near;
  add_agent(frame, fixture.walker(), {0, 0, 0});
  return frame;
}

// The step that comes nearest to its bound, or exceeds it most, of all that were taken.
struct Steps {
  Found found;
  double margin = std::numeric_limits<double>::infinity();
  int taken = 0;
  int left_out = 0;

  Steps() { found.measured = found.bound = 0; }

  void take(Fixture& fixture, const Path& path, double from, double to) {
    const scene::Frame before = frame_at(fixture, path, from);
    const scene::Frame after = frame_at(fixture, path, to);
    const renderers::Capture a = fixture.draw(before, true);
    const renderers::Capture b = fixture.draw(after, true);
    if (const uint64_t insane = insane_pixels(a, before).pixels + insane_pixels(b, after).pixels; insane > 0) {
      found.measured = std::numeric_limits<double>::infinity();
      found.place = fmt::format("{:.4f} of the way", from);
      found.got = insane_pixels(a, before).what + insane_pixels(b, after).what;
      margin = -found.measured;
      return;
    }
    // A plane that cuts the body cuts more of it at every step, whoever draws.
    const double nearest = std::min(nearest_depth(a), nearest_depth(b));
    if (nearest < 3 * path.near) {
      ++left_out;
      return;
    }
    ++taken;
    const StepChange change = step_change(a.colour, b.colour);
    const double pixels = std::isfinite(nearest) ? path.moved * (std::abs(to - from) / kStep) /
                                                       scene::pixel_size_at(before.camera, nearest, before.height)
                                                 : 0;
    const double bound = step_bound(change.edges, pixels);
    const double left = bound - static_cast<double>(change.changed);
    if (left >= margin) return;
    margin = left;
    found.measured = static_cast<double>(change.changed);
    found.bound = bound;
    found.place = fmt::format("{:.4f} of the way, pixel ({}, {})", from, change.x, change.y);
    found.expected = "less change";
    found.got = fmt::format("{} pixels changed", change.changed);
    found.before = enlarged(a.colour, change.x, change.y);
    found.after = enlarged(b.colour, change.x, change.y);
    found.note = fmt::format("a step moves the nearest surface by {:.2g} pixels", pixels);
  }

  Found end() {
    found.note += fmt::format("{}{} steps looked at", found.note.empty() ? "" : "; ", taken);
    if (left_out > 0)
      found.note += fmt::format("; {} more, where the near plane cuts the body, by their numbers alone", left_out);
    return found;
  }
};

Found along(Fixture& fixture, const Path& path, int places) {
  Steps steps;
  for (int i = 0; i < places; ++i) {
    const double t = (i + 0.5) / places;
    steps.take(fixture, path, t, t + kStep);
  }
  return steps.end();
}

Found through_a_body(Fixture& fixture) {
  const Path path{[](double t) {
                    const glm::dvec3 eye(0.02, 1.25, 1.5 - 3 * t);
                    return View{eye, eye + glm::dvec3(0, 0, -1)};
                  },
                  60, 0.005, 3 * kStep};
  return along(fixture, path, fixture.small() ? 8 : 24);
}

Found along_faces(Fixture& fixture) {
  const glm::dvec3 low(fixture.walker().banks[0]->bounds_min());
  const glm::dvec3 high(fixture.walker().banks[0]->bounds_max());
  Steps steps;
  const auto walk = [&](const glm::dvec3& from, const glm::dvec3& to) {
    const glm::dvec3 middle = 0.5 * (low + high);
    const Path path{[=](double t) {
                      return View{glm::mix(from, to, t), middle};
                    },
                    60, 0.01, 2 * glm::length(to - from) * kStep};
    const int places = fixture.small() ? 3 : 8;
    for (int i = 0; i < places; ++i) steps.take(fixture, path, (i + 0.5) / places, (i + 0.5) / places + kStep);
  };
  walk({high.x, 1.0, 2}, {high.x, 1.0, -2});        // in the plane of a side
  walk({2, high.y, 0.3}, {-2, high.y, 0.3});        // of the top
  walk({high.x, high.y, 2}, {high.x, high.y, -2});  // along an edge
  walk({low.x, -1, high.z}, {low.x, 3, high.z});
  return steps.end();
}

// A turn of the eye about the walker's middle, four metres off: what lies one metre from the axis moves by as much as
// the angle, and the eye's own turn moves everything by less.
struct Turn {
  glm::dvec3 centre{0, 0.9, 0};
  double radius = 4;
  View at(double azimuth, double elevation) const {
    const glm::dvec3 d{std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                       std::cos(azimuth) * std::cos(elevation)};
    const glm::dvec3 up{-std::sin(azimuth) * std::sin(elevation), std::cos(elevation),
                        -std::cos(azimuth) * std::sin(elevation)};
    return {centre + radius * d, centre, up};
  }
};

// Over the pole along a meridian, from 80 degrees on one side to 80 on the other.
Path over_the_pole(const glm::dvec3& centre) {
  const double span = 20 * kPi / 180;
  return {[=](double t) { return Turn{centre}.at(0.3, kPi / 2 + (t - 0.5) * span); }, 30, 0.1, span * kStep};
}
Path around(const glm::dvec3& centre) {
  return {[=](double t) { return Turn{centre}.at(2 * kPi * t, 20 * kPi / 180); }, 30, 0.1, 2 * kPi * kStep};
}
Path upwards(const glm::dvec3& centre) {
  return {[=](double t) { return Turn{centre}.at(0.7, -0.2 + 1.7 * t); }, 30, 0.1, 1.7 * kStep};
}

// The places of a path at which another stored view is picked, to a tenth of a step.
std::vector<double> seams(const Path& path, const renderers::ViewSampling& sampling) {
  const auto pick = [&](double t) { return sampling.grid.pick(path.at(t).eye - sampling.centre); };
  std::vector<double> out;
  constexpr int kPlaces = 400;
  for (int i = 0; i < kPlaces; ++i) {
    double low = static_cast<double>(i) / kPlaces;
    double high = static_cast<double>(i + 1) / kPlaces;
    const renderers::ViewPick before = pick(low);
    if (before == pick(high)) continue;
    while (high - low > kStep / 10) {
      const double middle = (low + high) / 2;
      (pick(middle) == before ? low : high) = middle;
    }
    out.push_back((low + high) / 2);
  }
  return out;
}

// Of a representation that stores views: on both sides of every seam, steps that cross none. Others: places in between.
Found over_seams(Fixture& fixture, const std::function<Path(const glm::dvec3& centre)>& made, int others) {
  if (!fixture.stores_views()) return along(fixture, made({0, 0.9, 0}), others);
  const scene::Cast& cast = fixture.walker();
  const renderers::ViewSampling sampling =
      fixture.type().view_sampling(fixture.asked(), *cast.characters[0], cast.banks[0]);
  const Path path = made(sampling.centre);
  const std::vector<double> all = seams(path, sampling);
  Steps steps;
  for (size_t i = 0; i < all.size(); i += fixture.small() ? 4 : 1) {
    if (all[i] > 2 * kStep) steps.take(fixture, path, all[i] - kStep / 2, all[i] - 1.5 * kStep);
    if (all[i] < 1 - 2 * kStep) steps.take(fixture, path, all[i] + kStep / 2, all[i] + 1.5 * kStep);
  }
  Found found = steps.end();
  found.note += fmt::format("; on both sides of {} seams of {}", all.size(), sampling.grid.text());
  return found;
}

constexpr const char* kStepBound =
    "2 x edges of the picture x the way in pixels of the nearest surface, six deviations of that count, and 3; steps "
    "that another stored view is picked in are not counted, those half a step beside are";

}  // namespace

void add_path_cases(std::vector<StabilityCase>& cases) {
  const auto add = [&](std::string_view name, std::string_view asked, Found (*measure)(Fixture&)) {
    cases.push_back({.name = name,
                     .group = "paths",
                     .asked = asked,
                     .unit = "pixels changed",
                     .bound_from = kStepBound,
                     .measure = measure});
  };
  add("path_through_body", "steps of 1e-4 of the way through the chest, from 1.5 m before it to behind",
      through_a_body);
  add("path_faces", "steps in the planes of the box around the body, and along two of its edges", along_faces);
  add("path_pole", "steps over the pole, along a meridian",
      [](Fixture& fixture) { return over_seams(fixture, over_the_pole, fixture.small() ? 5 : 11); });
  add("path_azimuth_seams", "steps around the body at 20 degrees of elevation",
      [](Fixture& fixture) { return over_seams(fixture, around, fixture.small() ? 4 : 16); });
  add("path_elevation_seams", "steps from below the ground to the pole",
      [](Fixture& fixture) { return over_seams(fixture, upwards, fixture.small() ? 4 : 16); });
}

}  // namespace crowdbench::bench
