// Based on: Castano 2010, "Computing alpha mipmaps" (scale a level's alpha so that the fraction passing the test
// stays). Differs from the source: the target is the silhouette's own area, and alpha is mapped affinely instead of
// scaled and clamped. An affine map commutes with bilinear filtering, so the level whose contour encloses the wanted
// area is read off the filtered values themselves (a quantile) and no search is needed.
//   Two kinds of coverage have many filtered values alike, so that the quantile says little: patterns on the lattice,
// of which regular points see a few values only, are looked at again at the points of the R2 sequence (Roberts 2018,
// "The unreasonable effectiveness of quasirandom sequences"); level coverage, where no contour is, is roughened first,
// as hashed alpha testing does (Wyman and McGuire 2017, "Hashed alpha testing").
#include "renderers/impostor/tiles/alpha_map.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/random.h"

namespace crowdbench::renderers {
namespace {

struct Coverage {
  TileRect rect;
  std::span<const float> values;
  float at(int x, int y) const {
    if (x < rect.x || y < rect.y || x >= rect.x + rect.width || y >= rect.y + rect.height) return 0;
    return values[static_cast<size_t>(y - rect.y) * static_cast<size_t>(rect.width) + static_cast<size_t>(x - rect.x)];
  }
};

// The four texels around a cell between their centres.
struct Cell {
  float a, b, c, d;
  float at(float u, float v) const { return (a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v; }
};

// Every cell of which a corner is not zero.
template <typename AlphaAt, typename Visit>
void for_each_cell(const TileRect& rect, AlphaAt alpha_at, Visit visit) {
  for (int y = rect.y - 1; y < rect.y + rect.height; ++y)
    for (int x = rect.x - 1; x < rect.x + rect.width; ++x) {
      const Cell cell{alpha_at(x, y), alpha_at(x + 1, y), alpha_at(x, y + 1), alpha_at(x + 1, y + 1)};
      if (cell.a + cell.b + cell.c + cell.d != 0) visit(cell, x, y);
    }
}

enum class Points { regular, scattered };

// Alpha filtered bilinearly at evenly spread points of the plane; points where it is zero are left out.
struct Filtered {
  std::vector<float> values;
  double per_texel = 1;  // points
};
template <typename AlphaAt>
Filtered filter_alpha(const TileRect& rect, Points points, AlphaAt alpha_at) {
  // Coarse levels have few texels, so that points lie closer there.
  const size_t texels = static_cast<size_t>(rect.width) * static_cast<size_t>(rect.height);
  const int k = (texels > 1024 ? 2 : texels > 64 ? 4 : 16) * (points == Points::regular || texels <= 64 ? 1 : 2);
  Filtered out;
  out.per_texel = k * k;
  uint32_t u_bits = 0;
  uint32_t v_bits = 0;
  for_each_cell(rect, alpha_at, [&](const Cell& cell, int, int) {
    for (int j = 0; j < k; ++j)
      for (int i = 0; i < k; ++i) {
        float u = (static_cast<float>(i) + 0.5F) / static_cast<float>(k);
        float v = (static_cast<float>(j) + 0.5F) / static_cast<float>(k);
        if (points == Points::scattered) {
          // 1 / p and 1 / p^2 of 2^32, p being the plastic number: the fractions wrap by themselves.
          u = static_cast<float>(u_bits += 3242174889U) * 0x1p-32F;
          v = static_cast<float>(v_bits += 2447445414U) * 0x1p-32F;
        }
        out.values.push_back(cell.at(u, v));
      }
  });
  return out;
}

// What coverage becomes in 8 bits: 0.5 + (coverage - contour) * gain.
struct AlphaMap {
  float contour = 0.5F;
  float gain = 1;
  uint8_t operator()(float alpha) const {
    return static_cast<uint8_t>(std::clamp((0.5F + (alpha - contour) * gain) * 255 + 0.5F, 0.0F, 255.0F));
  }
};

// The contour that encloses an area, a quantile, and how many of the points beside it have its own value, as a fraction
// of the area: so much of the area is not decided by it.
struct Contour {
  float value = 0.5F;
  double undecided = 0;
};
constexpr float kAlike = 1.0F / 1024;
constexpr double kUndecided = 0.02;  // of the area: more than this, and level coverage is roughened
constexpr double kTolerated = 0.03;  // error of the area: more than this, and it is solved at scattered points

Contour contour_of(Filtered& filtered, double wanted) {
  const size_t rank = std::min(filtered.values.size() - 1, static_cast<size_t>(wanted));
  std::nth_element(filtered.values.begin(), filtered.values.begin() + static_cast<std::ptrdiff_t>(rank),
                   filtered.values.end(), std::greater<>());
  const float below = filtered.values[rank];
  const auto end = filtered.values.begin() + static_cast<std::ptrdiff_t>(rank);
  const float above = rank == 0 ? below : *std::min_element(filtered.values.begin(), end);
  const auto alike = std::ranges::count_if(
      filtered.values, [&](float v) { return std::abs(v - below) <= kAlike || std::abs(v - above) <= kAlike; });
  return {below, static_cast<double>(alike) / wanted};
}

// As steep as the alphas that occur allow, so that 8 bits place the contour well even on a hill lower than one.
AlphaMap map_of(const Coverage& coverage, float contour) {
  AlphaMap map;
  map.contour = std::clamp(contour, 1.0F / 128, 1 - 1.0F / 128);
  const float highest = std::max(*std::ranges::max_element(coverage.values), map.contour + 1e-3F);
  map.gain = std::min(0.5F / map.contour, 0.5F / (highest - map.contour));
  return map;
}

// Rounding to 8 bits moves the contour: of several gains the one that rounds best.
AlphaMap best_rounded(const Coverage& coverage, const AlphaMap& map, Points points, double wanted) {
  AlphaMap best = map;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 24; ++i) {
    const AlphaMap tried{map.contour, map.gain * (1 - 0.02F * static_cast<float>(i))};
    const Filtered coded =
        filter_alpha(coverage.rect, points, [&](int x, int y) { return static_cast<float>(tried(coverage.at(x, y))); });
    const auto passing = std::ranges::count_if(coded.values, [](float v) { return v >= 127.5F; });
    const double off = std::abs(static_cast<double>(passing) - wanted);
    if (off >= least) continue;
    least = off;
    best = tried;
    if (points == Points::scattered && off < 0.002 * wanted) break;
  }
  return best;
}

// The coverage with every partly covered texel beside a level cell at the contour moved by a hash of its place, by at
// most half of what it lacks to nothing and to all.
std::vector<float> roughened(const Coverage& coverage, float contour) {
  constexpr uint64_t kSeed = 0x7e55e11a7eULL;
  std::vector<float> out(coverage.values.begin(), coverage.values.end());
  const TileRect& rect = coverage.rect;
  const auto move = [&](int x, int y) {
    const float alpha = coverage.at(x, y);
    if (alpha <= 0 || alpha >= 1) return;
    const double at = random_unit(kSeed, static_cast<uint64_t>(static_cast<int64_t>(x)),
                                  static_cast<uint64_t>(static_cast<int64_t>(y)));
    const size_t i =
        static_cast<size_t>(y - rect.y) * static_cast<size_t>(rect.width) + static_cast<size_t>(x - rect.x);
    out[i] = alpha + std::min(alpha, 1 - alpha) * (static_cast<float>(at) - 0.5F);
  };
  for_each_cell(
      rect, [&](int x, int y) { return coverage.at(x, y); },
      [&](const Cell& cell, int x, int y) {
        const float low = std::min({cell.a, cell.b, cell.c, cell.d});
        const float high = std::max({cell.a, cell.b, cell.c, cell.d});
        constexpr float kLevel = 1.0F / 32;
        if (high - low > kLevel || contour < low - kLevel || contour > high + kLevel) return;
        for (int j = 0; j < 2; ++j)
          for (int i = 0; i < 2; ++i) move(x + i, y + j);
      });
  return out;
}

StoredAlpha stored(const Coverage& coverage, const AlphaMap& map) {
  StoredAlpha out;
  out.texels.reserve(coverage.values.size());
  out.empty = std::min<uint8_t>(map(0), 127);
  for (const float alpha : coverage.values) out.texels.push_back(alpha > 0 ? map(alpha) : out.empty);
  return out;
}

// How far the area that passes is from the wanted one, as a fraction of it, at points apart from those it was solved
// at.
double area_error(const Coverage& coverage, const AlphaMap& map, double area) {
  const Filtered coded = filter_alpha(coverage.rect, Points::scattered,
                                      [&](int x, int y) { return static_cast<float>(map(coverage.at(x, y))); });
  const auto passing = std::ranges::count_if(coded.values, [](float v) { return v >= 127.5F; });
  return std::abs(static_cast<double>(passing) / (area * coded.per_texel) - 1);
}

// Where regular points see too few values.
StoredAlpha solve_scattered(Coverage coverage, double area) {
  const auto contour = [&](double& wanted) {
    Filtered filtered = filter_alpha(coverage.rect, Points::scattered, [&](int x, int y) { return coverage.at(x, y); });
    wanted = area * filtered.per_texel;
    return contour_of(filtered, wanted);
  };
  double wanted = 0;
  Contour at = contour(wanted);
  std::vector<float> rough;
  if (at.undecided > kUndecided) {
    rough = roughened(coverage, at.value);
    coverage.values = rough;
    at = contour(wanted);
  }
  return stored(coverage, best_rounded(coverage, map_of(coverage, at.value), Points::scattered, wanted));
}

}  // namespace

StoredAlpha solve_stored_alpha(const TileRect& rect, std::span<const float> values, double area) {
  const Coverage coverage{rect, values};
  Filtered filtered = filter_alpha(rect, Points::regular, [&](int x, int y) { return coverage.at(x, y); });
  const double wanted = area * filtered.per_texel;
  if (filtered.values.empty() || wanted < 0.5) return stored(coverage, {});
  AlphaMap map = map_of(coverage, contour_of(filtered, wanted).value);
  if (values.size() <= 64) map = best_rounded(coverage, map, Points::regular, wanted);
  return area_error(coverage, map, area) <= kTolerated ? stored(coverage, map) : solve_scattered(coverage, area);
}

}  // namespace crowdbench::renderers
