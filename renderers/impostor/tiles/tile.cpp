// Based on: Castano 2010, "Computing alpha mipmaps" (scale a level's alpha so that the fraction passing the test
// stays). Differs from the source: the target is the silhouette's own area, and alpha is mapped affinely instead of
// scaled and clamped. An affine map commutes with bilinear filtering, so the level whose contour encloses the wanted
// area is read off the filtered values themselves (a quantile) and no search is needed.
#include "renderers/impostor/tiles/tile.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/colour.h"

namespace crowdbench::renderers {
namespace {

// One level before encoding: what is averaged.
struct Plane {
  TileRect rect;
  std::vector<float> alpha;                  // true coverage
  std::vector<std::array<float, 3>> colour;  // linear
  std::vector<std::array<float, 3>> normal;  // unit
  std::vector<float> depth;                  // of the range, [-1, 1]
  std::vector<uint8_t> slot;
  std::vector<std::array<float, 3>> emission;  // linear, of the peak; empty: nothing glows

  explicit Plane(const TileRect& r) : rect(r) {
    const size_t n = static_cast<size_t>(r.width) * static_cast<size_t>(r.height);
    alpha.resize(n);
    colour.resize(n);
    normal.resize(n);
    depth.resize(n);
    slot.resize(n);
  }
  size_t index(int x, int y) const {
    return static_cast<size_t>(y - rect.y) * static_cast<size_t>(rect.width) + static_cast<size_t>(x - rect.x);
  }
  bool inside(int x, int y) const {
    return x >= rect.x && y >= rect.y && x < rect.x + rect.width && y < rect.y + rect.height;
  }
  float alpha_at(int x, int y) const { return inside(x, y) ? alpha[index(x, y)] : 0.0F; }
};

std::array<float, 3> decode_normal(uint8_t x, uint8_t y) {
  const auto nx = static_cast<float>(decode_signed(x));
  const auto ny = static_cast<float>(decode_signed(y));
  return {nx, ny, std::sqrt(std::max(0.0F, 1 - nx * nx - ny * ny))};
}

int floor_half(int v) { return v >= 0 ? v / 2 : -((1 - v) / 2); }

TileRect half(const TileRect& r) {
  const int x = floor_half(r.x);
  const int y = floor_half(r.y);
  return {x, y, floor_half(r.x + r.width - 1) + 1 - x, floor_half(r.y + r.height - 1) + 1 - y};
}

// Of the four fine texels under a coarse one those that are covered at all.
struct Sources {
  std::array<size_t, 4> texel{};
  size_t count = 0;
};
Sources sources_of(const Plane& fine, int x, int y) {
  Sources out;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      if (!fine.inside(2 * x + i, 2 * y + j)) continue;
      const size_t s = fine.index(2 * x + i, 2 * y + j);
      if (fine.alpha[s] > 0) out.texel[out.count++] = s;
    }
  return out;
}

std::array<float, 3> weighted_sum(const Plane& fine, const Sources& from,
                                  const std::vector<std::array<float, 3>>& values) {
  std::array<float, 3> sum{};
  for (size_t i = 0; i < from.count; ++i)
    for (size_t c = 0; c < 3; ++c) sum[c] += fine.alpha[from.texel[i]] * values[from.texel[i]][c];
  return sum;
}

// The slot that most of the area has, and how much that is. Depths of other slots are not averaged with it.
struct MainSlot {
  uint8_t slot = 0;
  float area = -1;
};
MainSlot main_slot(const Plane& fine, const Sources& from) {
  MainSlot out;
  for (size_t i = 0; i < from.count; ++i) {
    const uint8_t slot = fine.slot[from.texel[i]];
    float same = 0;
    for (size_t k = 0; k < from.count; ++k)
      if (fine.slot[from.texel[k]] == slot) same += fine.alpha[from.texel[k]];
    if (same > out.area) out = {slot, same};
  }
  return out;
}

// The mean of at least one source, as texel `d`.
void average(const Plane& fine, const Sources& from, Plane& coarse, size_t d) {
  const MainSlot most = main_slot(fine, from);
  float total = 0;
  float depth = 0;
  for (size_t i = 0; i < from.count; ++i) {
    const size_t s = from.texel[i];
    total += fine.alpha[s];
    if (fine.slot[s] == most.slot) depth += fine.alpha[s] * fine.depth[s];
  }
  const std::array<float, 3> colour = weighted_sum(fine, from, fine.colour);
  const std::array<float, 3> normal = weighted_sum(fine, from, fine.normal);
  const float length = std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
  coarse.slot[d] = most.slot;
  coarse.alpha[d] = total / 4;
  coarse.depth[d] = depth / most.area;
  for (size_t c = 0; c < 3; ++c) {
    coarse.colour[d][c] = colour[c] / total;
    coarse.normal[d][c] = length > 0 ? normal[c] / length : (c == 2 ? 1.0F : 0.0F);
  }
  if (fine.emission.empty()) return;
  const std::array<float, 3> emission = weighted_sum(fine, from, fine.emission);
  for (size_t c = 0; c < 3; ++c) coarse.emission[d][c] = emission[c] / total;
}

Plane half(const Plane& fine) {
  Plane coarse(half(fine.rect));
  if (!fine.emission.empty()) coarse.emission.resize(coarse.alpha.size());
  const TileRect& rect = coarse.rect;
  for (int y = rect.y; y < rect.y + rect.height; ++y)
    for (int x = rect.x; x < rect.x + rect.width; ++x) {
      const Sources from = sources_of(fine, x, y);
      if (from.count > 0) average(fine, from, coarse, coarse.index(x, y));
    }
  return coarse;
}

// Alpha filtered bilinearly at evenly spread points of the plane; points where it is zero are left out.
struct Filtered {
  std::vector<float> values;
  double per_texel = 1;  // points
};
template <typename AlphaAt>
Filtered filter_alpha(const Plane& plane, AlphaAt alpha_at) {
  // Coarse levels have few texels, so that points lie closer there.
  const size_t texels = plane.alpha.size();
  const int k = texels > 1024 ? 2 : texels > 64 ? 4 : 16;
  Filtered out;
  out.per_texel = k * k;
  for (int y = plane.rect.y - 1; y < plane.rect.y + plane.rect.height; ++y)
    for (int x = plane.rect.x - 1; x < plane.rect.x + plane.rect.width; ++x) {
      // The cell between four texel centres.
      const float a = alpha_at(x, y);
      const float b = alpha_at(x + 1, y);
      const float c = alpha_at(x, y + 1);
      const float d = alpha_at(x + 1, y + 1);
      if (a + b + c + d == 0) continue;
      for (int j = 0; j < k; ++j)
        for (int i = 0; i < k; ++i) {
          const float u = (static_cast<float>(i) + 0.5F) / static_cast<float>(k);
          const float v = (static_cast<float>(j) + 0.5F) / static_cast<float>(k);
          out.values.push_back((a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v);
        }
    }
  return out;
}

// What a plane's alpha becomes in 8 bits: 0.5 + (alpha - contour) * gain.
struct AlphaMap {
  float contour = 0.5F;
  float gain = 1;
  uint8_t operator()(float alpha) const {
    return static_cast<uint8_t>(std::clamp((0.5F + (alpha - contour) * gain) * 255 + 0.5F, 0.0F, 255.0F));
  }
};

// The map for which the filtered alpha is at least one half over `area` texels.
AlphaMap solve_alpha_map(const Plane& plane, double area) {
  const auto alpha_at = [&](int x, int y) { return plane.alpha_at(x, y); };
  Filtered filtered = filter_alpha(plane, alpha_at);
  AlphaMap map;
  const double wanted = area * filtered.per_texel;
  if (filtered.values.empty() || wanted < 0.5) return map;
  // The contour that encloses the area is a quantile.
  const size_t rank = std::min(filtered.values.size() - 1, static_cast<size_t>(wanted));
  std::nth_element(filtered.values.begin(), filtered.values.begin() + static_cast<std::ptrdiff_t>(rank),
                   filtered.values.end(), std::greater<>());
  map.contour = std::clamp(filtered.values[rank], 1.0F / 128, 1 - 1.0F / 128);
  // As steep as the alphas that occur allow, so that 8 bits place the contour well even on a hill lower than one.
  const float highest = std::max(*std::max_element(plane.alpha.begin(), plane.alpha.end()), map.contour + 1e-3F);
  map.gain = std::min(0.5F / map.contour, 0.5F / (highest - map.contour));
  if (plane.alpha.size() > 64) return map;
  // A handful of texels: rounding to 8 bits moves the contour, so the gain that rounds best is taken.
  AlphaMap best = map;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 24; ++i) {
    const AlphaMap tried{map.contour, map.gain * (1 - 0.02F * static_cast<float>(i))};
    const Filtered coded =
        filter_alpha(plane, [&](int x, int y) { return static_cast<float>(tried(plane.alpha_at(x, y))); });
    const auto passing = std::count_if(coded.values.begin(), coded.values.end(), [](float v) { return v >= 127.5F; });
    const double off = std::abs(static_cast<double>(passing) - wanted);
    if (off >= least) continue;
    least = off;
    best = tried;
  }
  return best;
}

Tile encode(const Plane& plane, double area) {
  Tile tile;
  tile.rect = plane.rect;
  tile.coverage = area;
  const AlphaMap stored = solve_alpha_map(plane, area);
  tile.empty_alpha = std::min<uint8_t>(stored(0), 127);
  const size_t n = static_cast<size_t>(tile.stride()) * static_cast<size_t>(tile.rows()) * 4;
  tile.albedo.assign(n, 0);
  tile.surface.assign(n, 0);
  if (!plane.emission.empty()) tile.emission.assign(n, 0);
  for (int row = 0; row < tile.rows(); ++row)
    for (int column = 0; column < tile.stride(); ++column) {
      const int x = plane.rect.x + column - kTileGutter;
      const int y = plane.rect.y + row - kTileGutter;
      const size_t o =
          4 * (static_cast<size_t>(row) * static_cast<size_t>(tile.stride()) + static_cast<size_t>(column));
      // Covered texels speak for themselves; the others take the mean of the covered ones around them.
      float weight = 0;
      std::array<float, 3> colour{};
      std::array<float, 3> normal{};
      std::array<float, 3> emission{};
      float depth = 0;
      float heaviest = 0;
      uint8_t slot = 0;
      const int reach = plane.alpha_at(x, y) > 0 ? 0 : 1;
      for (int j = -reach; j <= reach; ++j)
        for (int i = -reach; i <= reach; ++i) {
          const float w = plane.alpha_at(x + i, y + j);
          if (w <= 0) continue;
          const size_t s = plane.index(x + i, y + j);
          weight += w;
          depth += w * plane.depth[s];
          for (size_t c = 0; c < 3; ++c) {
            colour[c] += w * plane.colour[s][c];
            normal[c] += w * plane.normal[s][c];
            if (!plane.emission.empty()) emission[c] += w * plane.emission[s][c];
          }
          if (w > heaviest) {
            heaviest = w;
            slot = plane.slot[s];
          }
        }
      tile.albedo[o + 3] = reach == 0 ? stored(plane.alpha_at(x, y)) : tile.empty_alpha;
      tile.surface[o + 0] = tile.surface[o + 1] = tile.surface[o + 3] = 128;
      if (weight <= 0) continue;
      const float length = std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]) + 1e-20F;
      for (size_t c = 0; c < 3; ++c)
        tile.albedo[o + c] = static_cast<uint8_t>(std::clamp(std::sqrt(colour[c] / weight) * 255 + 0.5F, 0.0F, 255.0F));
      tile.surface[o + 0] = encode_signed(normal[0] / length);
      tile.surface[o + 1] = encode_signed(normal[1] / length);
      tile.surface[o + 2] = slot;
      tile.surface[o + 3] = encode_signed(depth / weight);
      if (plane.emission.empty()) continue;
      for (size_t c = 0; c < 3; ++c) tile.emission[o + c] = linear_to_srgb8(static_cast<double>(emission[c] / weight));
      tile.emission[o + 3] = 255;
    }
  return tile;
}

}  // namespace

TileRect level_rect(const TileRect& rect, int level) {
  TileRect out = rect;
  for (int i = 0; i < level && out.width > 0 && out.height > 0; ++i) out = half(out);
  return out;
}

uint8_t encode_signed(double v) { return static_cast<uint8_t>(std::clamp(std::floor(v * 127 + 128.5), 1.0, 255.0)); }
double decode_signed(uint8_t code) { return (static_cast<double>(code) - 128) / 127; }

std::vector<Tile> build_tile_levels(const TileRect& rect, const std::vector<CapturedTexel>& texels, int levels,
                                    bool crop) {
  // Crop to what is covered: the caller's rectangle is a bound.
  int x0 = rect.width;
  int x1 = -1;
  int y0 = rect.height;
  int y1 = -1;
  for (int y = 0; y < rect.height; ++y)
    for (int x = 0; x < rect.width; ++x) {
      if (texels[static_cast<size_t>(y) * static_cast<size_t>(rect.width) + static_cast<size_t>(x)].albedo[3] == 0)
        continue;
      x0 = std::min(x0, x);
      x1 = std::max(x1, x);
      y0 = std::min(y0, y);
      y1 = std::max(y1, y);
    }
  std::vector<Tile> tiles(static_cast<size_t>(levels));
  if (x1 < 0) return tiles;
  if (!crop) {
    x0 = y0 = 0;
    x1 = rect.width - 1;
    y1 = rect.height - 1;
  }
  Plane plane({rect.x + x0, rect.y + y0, x1 - x0 + 1, y1 - y0 + 1});
  double area = 0;
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const CapturedTexel& t =
          texels[static_cast<size_t>(y) * static_cast<size_t>(rect.width) + static_cast<size_t>(x)];
      const size_t d = plane.index(rect.x + x, rect.y + y);
      plane.alpha[d] = static_cast<float>(t.albedo[3]) / 255;
      area += plane.alpha[d];
      for (size_t c = 0; c < 3; ++c) {
        const float v = static_cast<float>(t.albedo[c]) / 255;
        plane.colour[d][c] = v * v;
      }
      plane.normal[d] = decode_normal(t.surface[0], t.surface[1]);
      plane.slot[d] = t.surface[2];
      plane.depth[d] = static_cast<float>(decode_signed(t.surface[3]));
      if (t.emission == std::array<uint8_t, 3>{}) continue;
      if (plane.emission.empty()) plane.emission.resize(plane.alpha.size());
      for (size_t c = 0; c < 3; ++c) {
        const float v = static_cast<float>(t.emission[c]) / 255;
        plane.emission[d][c] = v * v;
      }
    }
  for (int level = 0; level < levels; ++level) {
    if (level > 0) {
      plane = half(plane);
      area /= 4;
    }
    tiles[static_cast<size_t>(level)] = encode(plane, area);
  }
  return tiles;
}

double filtered_alpha(const Tile& tile, double x, double y) {
  const auto stored = [&](int column, int row) {
    column = std::clamp(column, 0, tile.stride() - 1);
    row = std::clamp(row, 0, tile.rows() - 1);
    return tile.albedo[4 * (static_cast<size_t>(row) * static_cast<size_t>(tile.stride()) +
                            static_cast<size_t>(column)) +
                       3] /
           255.0;
  };
  // In texels of the stored image, texel centres at integers.
  const double u = x - tile.rect.x + kTileGutter - 0.5;
  const double v = y - tile.rect.y + kTileGutter - 0.5;
  const int i = static_cast<int>(std::floor(u));
  const int j = static_cast<int>(std::floor(v));
  const double fu = u - i;
  const double fv = v - j;
  return (stored(i, j) * (1 - fu) + stored(i + 1, j) * fu) * (1 - fv) +
         (stored(i, j + 1) * (1 - fu) + stored(i + 1, j + 1) * fu) * fv;
}

}  // namespace crowdbench::renderers
