#include "renderers/impostor/tiles/tile.h"

#include <algorithm>
#include <cmath>

#include "core/colour.h"
#include "renderers/impostor/tiles/alpha_map.h"

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

Tile encode(const Plane& plane, double area) {
  Tile tile;
  tile.rect = plane.rect;
  tile.coverage = area;
  const StoredAlpha stored = solve_stored_alpha(plane.rect, plane.alpha, area);
  tile.empty_alpha = stored.empty;
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
      tile.albedo[o + 3] = reach == 0 ? stored.texels[plane.index(x, y)] : tile.empty_alpha;
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
