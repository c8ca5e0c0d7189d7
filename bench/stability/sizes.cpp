// Pictures of one pixel and of the driver's largest side; agents of a pixel and of a tenth; none, many, and all in one
// place.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "bench/stability/surface.h"
#include "core/error.h"

namespace crowdbench::bench {
namespace {

using renderers::Capture;

scene::Frame sized_frame(Fixture& fixture, int width, int height) {
  scene::Frame frame = empty_frame({0.3, 1.2, 3}, {0, 0.9, 0}, 40, width, height);
  add_agent(frame, fixture.walker(), {0, 0, 0});
  return frame;
}

Found worse(Found a, Found b) { return b.measured > a.measured ? std::move(b) : std::move(a); }

Found small_and_odd(Fixture& fixture) {
  Found found = wrong_pixels(fixture, sized_frame(fixture, 1, 1));
  for (const auto& [width, height] : {std::pair{1, 31}, std::pair{31, 1}, std::pair{77, 53}, std::pair{333, 127}})
    found = worse(std::move(found), wrong_pixels(fixture, sized_frame(fixture, width, height)));
  return found;
}

Found the_limit(Fixture& fixture) {
  const int side = fixture.context().limits().viewport_size;
  Found found = wrong_pixels(fixture, sized_frame(fixture, side, 3));
  found = worse(std::move(found), wrong_pixels(fixture, sized_frame(fixture, 3, side)));
  bool refused = false;
  try {
    fixture.draw(sized_frame(fixture, side + 1, 3));
  } catch (const Error&) {
    refused = true;
  }
  if (!refused) {
    found.measured += 1;
    found.got = fmt::format("{} pixels were not refused", side + 1);
  }
  found.note = fmt::format("this driver's side: {}; {}", side, found.note);
  return found;
}

// Where thousand agents stand so that their pixels meet every sub-pixel place alike and no two agents meet: Roberts'
// additive recurrence of the plastic number (2018).
glm::dvec2 spread(int i) {
  const double x = 0.5 + 0.7548776662466927 * i;
  const double y = 0.5 + 0.5698402909980532 * i;
  return {x - std::floor(x), y - std::floor(y)};
}

// Square pixels that a figure of one pixel's height covers, measured where it is 400 tall.
double figure_area(Fixture& fixture) {
  scene::Frame frame = empty_frame({0, 0.875, 1000}, {0, 0.875, 0}, 0.12, 480, 480);
  add_agent(frame, fixture.walker(), {0, 0, 0});
  const double tall = 1.75 / scene::pixel_size_at(frame.camera, 1000, frame.height);
  const Capture mesh = fixture.draw_mesh(frame);
  const auto covered = std::count_if(mesh.ids.data.begin(), mesh.ids.data.end(), [](uint32_t id) { return id != 0; });
  return static_cast<double>(covered) / (tall * tall);
}

// How far the samples that thousand agents of so many pixels cover are from what their area is, as a fraction.
// samples: k x k a pixel, drawn for the picture's own size.
Found covered_in_the_mean(Fixture& fixture, double pixels, int k) {
  constexpr int kAgents = 1000;
  constexpr int kWidth = 128;
  constexpr int kHeight = 96;
  scene::Frame frame = empty_frame({0, 0, 0}, {0, 0, -1}, 1, kWidth, kHeight);
  const double distance = 1.75 / (pixels * scene::pixel_size_at(frame.camera, 1, kHeight));
  const double metres = 1.75 / pixels;  // of a pixel
  for (int i = 0; i < kAgents; ++i) {
    const glm::dvec2 at = (spread(i) - 0.5) * glm::dvec2(kWidth - 4, kHeight - 4) * metres;
    add_agent(frame, fixture.walker(), {at.x, at.y - 0.875, -distance});
  }
  renderers::Renderer renderer(fixture.context(), fixture.walker());
  const renderers::Target target(fixture.context(), kWidth * k, kHeight * k, {.ids = true});
  renderer.draw(frame, fixture.representation(), target);
  const Capture drawn = target.read();
  const auto covered = std::count_if(drawn.ids.data.begin(), drawn.ids.data.end(), [](uint32_t id) { return id != 0; });
  const double expected = kAgents * figure_area(fixture) * pixels * pixels * k * k;
  Found found;
  found.measured = std::abs(static_cast<double>(covered) / expected - 1);
  found.bound = 0.05;
  found.expected = fmt::format("{:.1f} samples", expected);
  found.got = fmt::format("{} samples", covered);
  found.place = "the whole picture";
  found.note = fmt::format("{} x {} samples a pixel", k, k);
  return found;
}

Found crowd_of(Fixture& fixture, uint32_t agents) {
  scene::Scenario scenario;
  scenario.width = 160;
  scenario.height = 120;
  scenario.crowd.agents = agents;
  const scene::Crowd crowd = scene::make_crowd(scenario, fixture.walker(), scene::stage_view(scenario));
  const scene::Frame frame = scene::make_frame(scenario, fixture.walker(), crowd, scenario.camera.at(0), 0);
  const Capture drawn = fixture.draw(frame, agents < 2);
  const Insane insane = insane_pixels(drawn, frame);
  Found found;
  found.measured = static_cast<double>(insane.pixels);
  found.got = insane.what;
  std::set<uint32_t> seen(drawn.ids.data.begin(), drawn.ids.data.end());
  seen.erase(0);
  if (seen.empty() != (agents == 0)) found.measured += 1;
  found.note = fmt::format("{} of {} agents in view, {} seen", frame.agents[0].size(), agents, seen.size());
  return found;
}

// Every pixel shows the first of 32 equal agents, and twice the same; then 32 in different poses, twice the same.
Found at_one_point(Fixture& fixture) {
  scene::Frame equal = empty_frame({0.3, 1.2, 3}, {0, 0.9, 0}, 40, fixture.side(240), fixture.side(240));
  scene::Frame posed = equal;
  for (int i = 0; i < 32; ++i) {
    add_agent(equal, fixture.walker(), {0, 0, 0});
    add_agent(posed, fixture.walker(), {0, 0, 0}, i / 32.0, i / 50.0);
  }
  const Capture first = fixture.draw(equal);
  Found found = largest_difference(first.colour, fixture.draw(equal).colour);
  const Capture a = fixture.draw(posed);
  const Capture b = fixture.draw(posed);
  found = worse(std::move(found), largest_difference(a.colour, b.colour));
  found.measured = 0;
  for (size_t i = 0; i < first.ids.data.size(); ++i) {
    const bool other = first.ids.data[i] > 1;
    const bool flickers = a.ids.data[i] != b.ids.data[i];
    if (!other && !flickers) continue;
    if (found.measured == 0) {
      const auto x = static_cast<int>(i) % first.ids.width;
      const auto y = static_cast<int>(i) / first.ids.width;
      found.place = fmt::format("pixel ({}, {})", x, y);
      found.expected = other ? "id 1" : fmt::format("id {}", a.ids.data[i]);
      found.got = fmt::format("id {}", other ? first.ids.data[i] : b.ids.data[i]);
    }
    found.measured += 1;
  }
  found.bound = 0;
  return found;
}

void add_crowds(std::vector<StabilityCase>& cases) {
  const auto add = [&](std::string_view name, std::string_view asked, bool full, bool small,
                       Found (*measure)(Fixture&)) {
    cases.push_back({.name = name,
                     .group = "sizes",
                     .asked = asked,
                     .unit = "wrong pixels",
                     .bound_from = "no pixel without a finite depth or of an agent that is not there; somebody is seen "
                                   "where somebody stands",
                     .full = full,
                     .small = small,
                     .measure = measure});
  };
  add("agents_0", "a crowd of nobody", false, true, [](Fixture& fixture) { return crowd_of(fixture, 0); });
  add("agents_1", "of one", false, true, [](Fixture& fixture) { return crowd_of(fixture, 1); });
  add("agents_65536", "of 65,536", false, false, [](Fixture& fixture) { return crowd_of(fixture, 65536); });
  add("agents_1000000", "of a million", true, false, [](Fixture& fixture) { return crowd_of(fixture, 1'000'000); });
}

}  // namespace

void add_size_cases(std::vector<StabilityCase>& cases) {
  const auto add = [&](std::string_view name, std::string_view asked, std::string_view unit, std::string_view from,
                       bool small, Found (*measure)(Fixture&)) {
    cases.push_back({.name = name,
                     .group = "sizes",
                     .asked = asked,
                     .unit = unit,
                     .bound_from = from,
                     .small = small,
                     .measure = measure});
  };
  add("size_odd", "pictures of 1x1, 1x31, 31x1, 77x53 and 333x127 pixels", "wrong pixels", kSurfaceBound, true,
      small_and_odd);
  add("size_limit", "pictures as wide, and as tall, as the driver draws; one pixel more is refused", "wrong pixels",
      kSurfaceBound, false, the_limit);
  constexpr const char* kMean = "asked for: 5 % of the area of thousand figures; their places meet sub-pixels evenly";
  add("figure_1px", "a thousand agents one pixel tall: pixels covered in the mean", "of the area", kMean, true,
      [](Fixture& fixture) { return covered_in_the_mean(fixture, 1, fixture.small() ? 3 : 5); });
  add("figure_tenth_px", "the same a tenth of a pixel tall", "of the area", kMean, false,
      [](Fixture& fixture) { return covered_in_the_mean(fixture, 0.1, 21); });
  add_crowds(cases);
  add("agents_at_one_point", "32 equal agents in one place show the first of them; 32 unequal ones twice the same",
      "pixels", "the first drawn of equal depths stays (GREATER), and lists are in the order of ids", true,
      at_one_point);
}

}  // namespace crowdbench::bench
