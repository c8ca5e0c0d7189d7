#include "metrics/surface_causes.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/colour.h"
#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

// By what the pixel of the test differs from the reference's, before any colour.
enum class Kind : uint8_t { nothing, order, silhouette, surface, same };

Kind kind_of(const SurfaceSubstitution& of, size_t pixel) {
  const uint32_t a = of.reference.ids.data[pixel];
  const uint32_t b = of.test.ids.data[pixel];
  if (a == 0 && b == 0) return Kind::nothing;
  if (a != b)
    return a != 0 && b != 0 && !of.agents_in_both.empty() && of.agents_in_both.data[pixel] != 0 ? Kind::order
                                                                                                : Kind::silhouette;
  if (!of.depth_tolerance) return Kind::same;
  const double gap =
      std::abs(static_cast<double>(of.reference.depth.data[pixel]) - static_cast<double>(of.test.depth.data[pixel]));
  return gap > *of.depth_tolerance ? Kind::surface : Kind::same;
}

int code_of(const Surfaces& side, size_t pixel, int channel, double lit) {
  const size_t at = 3 * pixel + static_cast<size_t>(channel);
  return linear_to_srgb8(static_cast<double>(side.base.data[at]) * lit + static_cast<double>(side.emissive.data[at]));
}

// How much light the pixel's surface receives; that of the other side where its own cannot be seen.
double received(const SurfaceSubstitution& of, const Surfaces& side, const Surfaces& other, size_t pixel) {
  float lambert = side.lambert.data[pixel];
  if (lambert < 0) lambert = other.lambert.data[pixel];
  return of.ambient + of.diffuse * std::max(0.0, static_cast<double>(lambert));
}

uint8_t moved(uint8_t code, int by) { return static_cast<uint8_t>(std::clamp(code + by, 0, 255)); }

// Drivers encode sRGB to within this of what is encoded here.
constexpr int kRounding = 2;  // code values

// The pixel's code values after the shading and after the texture were put in. What is added are differences of
// colours that are encoded here, so that what the two sides have in common stays as it was drawn; where the test's
// picture is no farther from the end than drivers round, the end is the test's picture.
void put_in_colour(const SurfaceSubstitution& of, size_t pixel, const uint8_t* drawn, uint8_t* shaded,
                   uint8_t* textured) {
  const double own = received(of, of.reference, of.test, pixel);
  const double light = received(of, of.test, of.reference, pixel);
  for (int c = 0; c < 3; ++c) {
    const int relit = code_of(of.reference, pixel, c, light);
    const int by_shading = relit - code_of(of.reference, pixel, c, own);
    const int by_texture = code_of(of.test, pixel, c, light) - relit;
    uint8_t end = moved(shaded[c], by_shading + by_texture);
    const bool changed = own != light || by_texture != 0;
    if (changed && std::abs(int{end} - int{drawn[c]}) <= kRounding) end = drawn[c];
    shaded[c] = by_texture == 0 ? end : moved(shaded[c], by_shading);
    textured[c] = end;
  }
}

}  // namespace

std::vector<CauseStep> substitute_surfaces(const SurfaceSubstitution& of) {
  for (const Surfaces* side : {&of.reference, &of.test}) {
    require_same_size(of.reference.codes, side->codes);
    require_same_size(side->codes, side->ids);
    require_same_size(side->codes, side->base);
    require_same_size(side->codes, side->emissive);
    require_same_size(side->codes, side->lambert);
    if (of.depth_tolerance) require_same_size(side->codes, side->depth);
  }
  Image8 order = of.reference.codes;
  Image8 silhouette = order, surface = order, shading = order, texture = order;
  const auto channels = static_cast<size_t>(order.channels);
  for (size_t i = 0; i < order.pixels(); ++i) {
    const Kind kind = kind_of(of, i);
    const size_t at = i * channels;
    // A picture has what was put in from its kind's step on.
    for (const auto& [from, image] :
         {std::pair{Kind::order, &order}, std::pair{Kind::silhouette, &silhouette}, std::pair{Kind::surface, &surface},
          std::pair{Kind::same, &shading}, std::pair{Kind::same, &texture}})
      if (kind != Kind::nothing && kind != Kind::same && from >= kind)
        std::copy_n(of.test.codes.data.begin() + static_cast<std::ptrdiff_t>(at), channels,
                    image->data.begin() + static_cast<std::ptrdiff_t>(at));
    if (kind == Kind::same) put_in_colour(of, i, &of.test.codes.data[at], &shading.data[at], &texture.data[at]);
  }
  std::vector<CauseStep> steps;
  steps.push_back({Cause::order, std::move(order)});
  steps.push_back({Cause::silhouette, std::move(silhouette)});
  if (of.depth_tolerance) steps.push_back({Cause::surface, std::move(surface)});
  steps.push_back({Cause::shading, std::move(shading)});
  steps.push_back({Cause::texture, std::move(texture)});
  steps.push_back({std::nullopt, of.test.codes});
  return steps;
}

}  // namespace crowdbench::metrics
