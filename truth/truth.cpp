#include "truth/truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/colour.h"
#include "core/error.h"
#include "core/progress.h"
#include "truth/caster.h"

namespace crowdbench::truth {
namespace {

constexpr size_t kRaysAtOnce = size_t{1} << 18U;
constexpr int kMostSide = 63;

int side_of(const scene::Frame& frame, const TruthOptions& options) {
  const int side = options.side > 0 ? options.side : frame.antialiasing.supersample;
  if (side < 1 || side > kMostSide || side % 2 == 0)
    throw Error("truth", fmt::format("{} is not an odd number of rays a side of a pixel", side),
                fmt::format("use 1, 3, 5, ... {}", kMostSide));
  return side;
}

Places places_of_rows(const scene::Frame& frame, int top, int rows, int side) {
  Places out;
  out.top = top;
  out.width = frame.width;
  out.height = rows;
  for (int y = top; y < top + rows; ++y)
    for (int x = 0; x < frame.width; ++x) {
      out.first.push_back(static_cast<uint32_t>(out.at.size()));
      for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) out.at.emplace_back(x + (i + 0.5) / side, y + (j + 0.5) / side);
    }
  out.first.push_back(static_cast<uint32_t>(out.at.size()));
  return out;
}

TruthPicture empty_picture(const scene::Frame& frame, bool shade) {
  TruthPicture out;
  const int w = frame.width;
  const int h = frame.height;
  if (shade) {
    out.colour = Image8(w, h, 4);
    out.linear = ImageF(w, h, 4);
  }
  out.depth = Image<double>(w, h, 1);
  out.normal = Image<double>(w, h, 3);
  out.ids = ImageU32(w, h, 1);
  out.materials = ImageU32(w, h, 1);
  out.coverage = Image<double>(w, h, 1);
  return out;
}

// points: the pixel's.
void put_pixel(TruthPicture& out, int x, int y, std::span<const TruthPoint> points, bool shade) {
  const TruthPoint& centre = points[points.size() / 2];
  *out.depth.at(x, y) = centre.depth;
  for (int c = 0; c < 3; ++c) out.normal.at(x, y)[c] = centre.normal[c];
  *out.ids.at(x, y) = centre.id;
  *out.materials.at(x, y) = centre.id != 0 ? centre.material + 1 : 0;
  glm::dvec3 sum(0.0);
  size_t covered = 0;
  for (const TruthPoint& point : points) {
    sum += point.linear;
    covered += point.id != 0 ? 1U : 0U;
  }
  const auto count = static_cast<double>(points.size());
  *out.coverage.at(x, y) = static_cast<double>(covered) / count;
  if (!shade) return;
  for (int c = 0; c < 3; ++c) {
    out.linear.at(x, y)[c] = static_cast<float>(sum[c] / count);
    out.colour.at(x, y)[c] = linear_to_srgb8(sum[c] / count);
  }
  out.linear.at(x, y)[3] = 1.0F;
  out.colour.at(x, y)[3] = 255;
}

// Buckets of the places that lie in the picture; order: by bucketed place, the one that was given.
Places bucketed(const scene::Frame& frame, std::span<const glm::dvec2> places, std::vector<size_t>& order) {
  std::vector<std::pair<size_t, size_t>> pixels;  // pixel, place
  int left = frame.width;
  int top = frame.height;
  int right = -1;
  int bottom = -1;
  const auto pixel_of = [](double at, int size) { return std::min(static_cast<int>(at), size - 1); };
  for (size_t i = 0; i < places.size(); ++i) {
    const glm::dvec2& p = places[i];
    if (!(p.x >= 0 && p.y >= 0 && p.x <= frame.width && p.y <= frame.height)) continue;
    const int x = pixel_of(p.x, frame.width);
    const int y = pixel_of(p.y, frame.height);
    left = std::min(left, x);
    right = std::max(right, x);
    top = std::min(top, y);
    bottom = std::max(bottom, y);
    pixels.emplace_back(static_cast<size_t>(y) * static_cast<size_t>(frame.width) + static_cast<size_t>(x), i);
  }
  Places out;
  if (pixels.empty()) return out;
  std::ranges::sort(pixels);
  out.left = left;
  out.top = top;
  out.width = right - left + 1;
  out.height = bottom - top + 1;
  size_t next = 0;
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x) {
      const size_t pixel = static_cast<size_t>(y) * static_cast<size_t>(frame.width) + static_cast<size_t>(x);
      out.first.push_back(static_cast<uint32_t>(next));
      for (; next < pixels.size() && pixels[next].first == pixel; ++next) {
        out.at.push_back(places[pixels[next].second]);
        order.push_back(pixels[next].second);
      }
    }
  out.first.push_back(static_cast<uint32_t>(next));
  return out;
}

std::vector<TruthPoint> cast_chosen(const scene::Cast& cast, const scene::Frame& frame, uint32_t only,
                                    std::span<const glm::dvec2> places, const TruthOptions& options) {
  std::vector<TruthPoint> out(places.size());
  const int side = side_of(frame, options);
  std::vector<size_t> order;
  const Places inside = bucketed(frame, places, order);
  if (order.empty()) return out;
  const Caster caster(cast, frame, 1.0 / side, options.threads, only);
  if (only != 0 && caster.agents() == 0) return out;
  const auto hits = caster.cast(inside, [](double) { throw_if_interrupted(); });
  const std::vector<TruthPoint> points = caster.describe(inside, hits, options.shade, [](size_t) { return true; });
  for (size_t i = 0; i < order.size(); ++i) out[order[i]] = points[i];
  return out;
}

}  // namespace

TruthPicture cast_truth(const scene::Cast& cast, const scene::Frame& frame, const TruthOptions& options) {
  const int side = side_of(frame, options);
  const auto rays = static_cast<size_t>(side * side);
  TruthPicture out = empty_picture(frame, options.shade);
  constexpr size_t kSteps = 1000;
  Progress progress("truth", kSteps);
  const Caster caster(cast, frame, 1.0 / side, options.threads);
  const auto rows_at_once = static_cast<int>(std::clamp<size_t>(kRaysAtOnce / (rays * static_cast<size_t>(frame.width)),
                                                                1, static_cast<size_t>(frame.height)));
  for (int top = 0; top < frame.height; top += rows_at_once) {
    const int rows = std::min(rows_at_once, frame.height - top);
    const Places places = places_of_rows(frame, top, rows, side);
    const auto hits = caster.cast(places, [&](double share) {
      progress.set_done(static_cast<size_t>((top + share * rows) / frame.height * kSteps));
    });
    const std::vector<TruthPoint> points =
        caster.describe(places, hits, options.shade, [&](size_t i) { return options.shade || i % rays == rays / 2; });
    for (size_t pixel = 0; pixel < places.first.size() - 1; ++pixel)
      put_pixel(out, static_cast<int>(pixel) % frame.width, top + static_cast<int>(pixel) / frame.width,
                std::span(points).subspan(pixel * rays, rays), options.shade);
  }
  return out;
}

std::vector<TruthPoint> cast_points(const scene::Cast& cast, const scene::Frame& frame,
                                    std::span<const glm::dvec2> places, const TruthOptions& options) {
  return cast_chosen(cast, frame, 0, places, options);
}

std::vector<TruthPoint> cast_points_at(const scene::Cast& cast, const scene::Frame& frame, uint32_t id,
                                       std::span<const glm::dvec2> places, const TruthOptions& options) {
  return cast_chosen(cast, frame, id, places, options);
}

}  // namespace crowdbench::truth
