// Characters that are valid and extreme: whoever draws them is held against the mesh.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/stability/odd_characters.h"
#include "bench/stability/surface.h"
#include "core/error.h"

namespace crowdbench::bench {
namespace {

// From one side, in one pose: what stores views needs to bake no more than that.
renderers::VisitViewSamples seen_from(const glm::dvec3& eye) {
  return [eye](size_t, const std::function<void(const renderers::ViewSample&)>& see) { see({glm::vec3(eye), 0, 0}); };
}

// What the pictures of one odd character come to: insane pixels, an error, and the area beside the mesh's.
Found draw_odd(Fixture& fixture, const OddCharacter& odd) {
  const scene::Cast cast = odd_cast(odd);
  const glm::dvec3 low(cast.banks[0]->bounds_min());
  const glm::dvec3 high(cast.banks[0]->bounds_max());
  const glm::dvec3 middle = (low + high) * 0.5;
  const double size = std::max(glm::length(high - low), 1e-6);
  const glm::dvec3 eye = middle + glm::dvec3(0, 0, 2.0 * size);
  // In the small form too: at half of it the needle is a pixel thick, and missed between pixels.
  constexpr int kSide = 160;
  scene::Frame frame = empty_frame(eye, middle, 40, kSide, kSide);
  frame.camera.near = 0.05 * size;
  add_agent(frame, cast, {0, 0, 0});
  renderers::MakeContext make{.context = fixture.context(), .cast = cast, .use_cache = false, .progress = false};
  if (renderers::honours_required_by(fixture.asked())) make.required_by = seen_from(eye);
  const auto drawn_by = renderers::make_representation(make, fixture.asked());
  const auto mesh =
      renderers::make_representation({.context = fixture.context(), .cast = cast}, renderers::reference_spec());
  renderers::Renderer renderer(fixture.context(), cast);
  const renderers::Capture drawn = renderer.capture(frame, *drawn_by, {.linear = true});
  const double texel = drawn_by->texel_metres(0) / scene::pixel_size_at(frame.camera, 2 * size, frame.height);
  Found found = wrong_beside(renderer.capture(frame, *mesh), drawn, frame, static_cast<int>(std::ceil(2 + 2 * texel)));
  if (!found.place.empty()) found.place = fmt::format("{}: {}", odd.name, found.place);
  return found;
}

Found draw_all(Fixture& fixture) {
  Found worst;
  worst.measured = 0;
  int drawn = 0;
  for (const OddCharacter& odd : odd_characters()) {
    if (fixture.small() && drawn > 4) break;
    ++drawn;
    Found found = draw_odd(fixture, odd);
    if (found.measured > worst.measured) worst = std::move(found);
  }
  worst.bound = 0;
  worst.note += fmt::format("{}{} characters", worst.note.empty() ? "" : "; ", drawn);
  return worst;
}

// One of the large ones: drawn, or refused by a budget that a user may raise.
Found draw_large(Fixture& fixture, const char* name) {
  const auto& all = large_characters();
  const auto large = std::find_if(all.begin(), all.end(), [&](const OddCharacter& odd) { return odd.name == name; });
  try {
    return draw_odd(fixture, *large);
  } catch (const Error& error) {
    const std::string line = error.what();
    if (line.find("budget") == std::string::npos) throw;
    Found found;
    found.measured = 0;
    found.note = "refused: " + line;
    return found;
  }
}

// kSurfaceBound, and what was changed after it was seen.
constexpr const char* kOddBound =
    "no pixel without a finite colour and depth; outlines to two pixels and two texels of the mesh's: the pixel that a "
    "rasteriser may round away and the texel that a map's outline ends in, on both sides. The needle was made 16 mm "
    "thick, two pixels, after one of 8 mm had been missed between pixels";

constexpr const char* kLargeBound =
    "no pixel without a finite colour and depth; outlines to two pixels and two texels of the mesh's: the pixel that a "
    "rasteriser may round away and the texel that a map's outline ends in, on both sides";

}  // namespace

void add_character_cases(std::vector<StabilityCase>& cases) {
  cases.push_back({.name = "characters_odd",
                   .group = "characters",
                   .asked = "one triangle, a joint without any, none with area, a needle, a sheet, a joint scaled to "
                            "nothing and a mirrored one, q against -q, 255 joints, 1e-3 and 1e3 m",
                   .unit = "wrong pixels",
                   .bound_from = kOddBound,
                   .bound_seen = true,
                   .measure = draw_all});
  const auto add_large = [&](std::string_view name, std::string_view asked, Found (*measure)(Fixture&)) {
    cases.push_back({.name = name,
                     .group = "characters",
                     .asked = asked,
                     .unit = "wrong pixels",
                     .bound_from = kLargeBound,
                     .full = true,
                     .small = false,
                     .measure = measure});
  };
  add_large("characters_300k", "a character of 300,312 triangles: drawn, or refused by a budget that is named",
            [](Fixture& fixture) { return draw_large(fixture, "triangles_300k"); });
  add_large("characters_5000_boxes", "a character of 5,000 boxes on as many joints: likewise",
            [](Fixture& fixture) { return draw_large(fixture, "boxes_5000"); });
}

}  // namespace crowdbench::bench
