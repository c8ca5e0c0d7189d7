// Based on: error diffusion, Floyd and Steinberg, "An adaptive algorithm for spatial greyscale" (1976), for which
// texels of a level are covered. Differs from the source: carried along the Z-order of blocks, so that every aligned
// square of a map keeps its area; within a block the fullest texels are taken, so that outlines stay where they are.
#include "renderers/relief/relief_atlas.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <tuple>

#include "core/colour.h"
#include "core/random.h"

namespace crowdbench::renderers {
namespace {

// One level of one box's maps.
struct Level {
  size_t n = 0;
  std::vector<uint16_t> depth;    // [axis][v][u][2]; of a cube [axis][side][v][u][2], and so `filled`
  std::vector<uint8_t> normal;    // [axis][side][v][u][4]
  std::vector<uint8_t> emission;  // the same; empty where nothing glows
  std::vector<uint32_t> filled;   // [axis][v][u]: of the texels of level 0 that lie under each, how many are covered
  size_t maps() const { return depth.size() / (2 * n * n); }  // of depths
  size_t sides() const { return 6 / maps(); }                 // faces that have one in common
};

double linear_of(uint8_t code) {
  static const std::array<double, 256> table = [] {
    std::array<double, 256> t{};
    for (size_t i = 0; i < t.size(); ++i) t[i] = srgb_to_linear(static_cast<double>(i) / 255.0);
    return t;
  }();
  return table[code];
}

// Colours (or emission) of covered texels, carried into empty ones beside them, twice.
void spread_colours(const Level& level, std::vector<uint8_t>& colours) {
  const auto n = static_cast<long>(level.n);
  for (size_t map = 0; map < level.maps(); ++map) {
    const auto at = [&](long u, long v) { return static_cast<size_t>(v * n + u); };
    std::vector<uint8_t> known(level.n * level.n);
    for (size_t i = 0; i < known.size(); ++i) {
      const uint16_t* d = level.depth.data() + (map * known.size() + i) * 2;
      known[i] = d[0] <= d[1] ? 1 : 0;
    }
    for (int round = 0; round < 2; ++round) {
      const std::vector<uint8_t> before = known;
      for (long v = 0; v < n; ++v) {
        for (long u = 0; u < n; ++u) {
          if (before[at(u, v)] != 0) continue;
          for (size_t side = 0; side < level.sides(); ++side) {
            uint8_t* face = colours.data() + (map * level.sides() + side) * known.size() * 4;
            std::array<int, 4> sum{};
            int count = 0;
            for (long y = std::max(0L, v - 1); y <= std::min(n - 1, v + 1); ++y) {
              for (long x = std::max(0L, u - 1); x <= std::min(n - 1, u + 1); ++x) {
                if (before[at(x, y)] == 0) continue;
                ++count;
                for (size_t c = 0; c < 4; ++c) sum[c] += face[at(x, y) * 4 + c];
              }
            }
            if (count == 0) continue;
            for (size_t c = 0; c < 4; ++c) face[at(u, v) * 4 + c] = static_cast<uint8_t>((sum[c] + count / 2) / count);
            known[at(u, v)] = 1;
          }
        }
      }
    }
  }
}

// One axis's bounds at the level that has texels of 2^level of the model's.
std::vector<uint8_t> bounds_of(const uint16_t* extent, size_t n, uint32_t level) {
  const long step = 1L << level;
  const size_t m = n >> (level + 1);
  const auto last = static_cast<long>(n) - 1;
  // Least and greatest over 4 * step texels a side, one axis after the other.
  std::vector<uint16_t> rows(n * m * 2);
  for (size_t v = 0; v < n; ++v) {
    for (size_t i = 0; i < m; ++i) {
      uint16_t* out = rows.data() + (v * m + i) * 2;
      out[0] = 65535;
      out[1] = 0;
      const long first = static_cast<long>(i) * 2 * step - step;
      for (long u = std::max(0L, first); u <= std::min(last, first + 4 * step - 1); ++u) {
        const uint16_t* e = extent + (v * n + static_cast<size_t>(u)) * 2;
        out[0] = std::min(out[0], e[0]);
        out[1] = std::max(out[1], e[1]);
      }
    }
  }
  std::vector<uint8_t> bounds(m * m * 2);
  for (size_t j = 0; j < m; ++j) {
    for (size_t i = 0; i < m; ++i) {
      uint16_t low = 65535;
      uint16_t high = 0;
      const long first = static_cast<long>(j) * 2 * step - step;
      for (long v = std::max(0L, first); v <= std::min(last, first + 4 * step - 1); ++v) {
        const uint16_t* e = rows.data() + (static_cast<size_t>(v) * m + i) * 2;
        low = std::min(low, e[0]);
        high = std::max(high, e[1]);
      }
      // Nothing there stays (255, 0), which no depth fits; a texel of the level more either way.
      const double slack = 1.0 * 65535.0 * static_cast<double>(step) / static_cast<double>(n);
      bounds[(j * m + i) * 2] =
          low > high ? 255 : static_cast<uint8_t>(std::max(0.0, std::floor((low - slack) / 257.0)));
      bounds[(j * m + i) * 2 + 1] =
          low > high ? 0 : static_cast<uint8_t>(std::min(255.0, std::ceil((high + slack) / 257.0)));
    }
  }
  return bounds;
}

// Neighbours whose children touched still touch: where their mean intervals do not meet, they are widened to the middle
// of the gap, as far as the children reach.
void meet_again(const std::vector<std::array<uint16_t, 2>>& reach, size_t n, uint16_t* depth) {
  const auto meet = [&](size_t a, size_t b) {
    uint16_t* at_a = depth + a * 2;
    uint16_t* at_b = depth + b * 2;
    if (at_a[0] > at_a[1] || at_b[0] > at_b[1]) return;
    const bool ordered = at_a[1] < at_b[0];
    uint16_t& top = ordered ? at_a[1] : at_b[1];
    uint16_t& bottom = ordered ? at_b[0] : at_a[0];
    const uint16_t highest = reach[ordered ? a : b][1];
    const uint16_t lowest = reach[ordered ? b : a][0];
    if (top >= bottom || lowest > highest) return;
    const auto meeting = static_cast<uint16_t>(std::clamp((int{top} + int{bottom}) / 2, int{lowest}, int{highest}));
    top = std::max(top, meeting);
    bottom = std::min(bottom, meeting);
  };
  for (size_t v = 0; v < n; ++v) {
    for (size_t u = 0; u < n; ++u) {
      if (u + 1 < n) meet(v * n + u, v * n + u + 1);
      if (v + 1 < n) meet(v * n + u, v * n + u + n);
      if (v + 1 < n && u + 1 < n) meet(v * n + u, v * n + u + n + 1);
      if (v + 1 < n && u > 0) meet(v * n + u, v * n + u + n - 1);
    }
  }
}

// Of the four texels under a coarser one those that are covered, in reading order, within their map.
struct Children {
  std::array<size_t, 4> texel{};
  int count = 0;
  uint16_t least = 65535, greatest = 0;  // depth
  std::array<int, 2> depth_sums{};       // of fronts and of backs
};
Children children_of(const Level& from, size_t map, size_t u, size_t v) {
  const size_t m = from.n;
  Children out;
  for (size_t k = 0; k < 4; ++k) {
    const size_t texel = (2 * v + k / 2) * m + 2 * u + k % 2;
    const uint16_t* d = from.depth.data() + (map * m * m + texel) * 2;
    if (d[0] > d[1]) continue;
    out.texel[static_cast<size_t>(out.count++)] = texel;
    out.least = std::min(out.least, d[0]);
    out.greatest = std::max(out.greatest, d[1]);
    out.depth_sums[0] += d[0];
    out.depth_sums[1] += d[1];
  }
  return out;
}

// Normal and what glows on one face of a texel, `at` of its face in the coarser level: means, but for what the normal's
// fourth channel holds, which is the first child's. At least one child.
void halve_face(const Level& from, const Children& children, size_t face, size_t at, Level& to) {
  const size_t first_texel = face * from.n * from.n;
  const size_t target = (face * to.n * to.n + at) * 4;
  const auto child = [&](int k) { return (first_texel + children.texel[static_cast<size_t>(k)]) * 4; };
  glm::vec3 direction(0.0F);
  for (int k = 0; k < children.count; ++k) {
    const size_t texel = child(k);
    direction += glm::vec3(from.normal[texel], from.normal[texel + 1], from.normal[texel + 2]) / 127.5F - 1.0F;
  }
  const auto mean = [&](const std::vector<uint8_t>& codes, size_t c) {
    double sum = 0;
    for (int k = 0; k < children.count; ++k) sum += linear_of(codes[child(k) + c]);
    return linear_to_srgb8(sum / children.count);
  };
  uint8_t* normal = to.normal.data() + target;
  for (size_t c = 0; c < 3 && !from.emission.empty(); ++c) to.emission[target + c] = mean(from.emission, c);
  const float length = glm::length(direction);
  direction = length > 1e-6F ? direction / length : glm::vec3(0, 1, 0);
  for (int c = 0; c < 3; ++c) normal[c] = static_cast<uint8_t>(direction[c] * 127.5F + 128.0F);
  normal[3] = from.normal[child(0) + 3];
}

// One map of a halved level, before it is known which of its texels are covered.
struct Halves {
  size_t n = 0;
  std::vector<Children> children;  // of each texel
  const uint32_t* filled = nullptr;
  uint32_t full = 1;  // what `filled` is of a texel that is wholly covered
};

// The texels of a block under which there is anything, the fullest first; equal ones in an order of no pattern.
std::vector<size_t> ranked(const Halves& map, size_t left, size_t top, size_t side) {
  std::vector<size_t> order;
  for (size_t v = top; v < top + side; ++v)
    for (size_t u = left; u < left + side; ++u)
      if (map.filled[v * map.n + u] > 0) order.push_back(v * map.n + u);
  const auto rank = [&](size_t t) {
    return std::tuple(-int64_t{map.filled[t]}, -map.children[t].count, random_bits(map.n, t, 0));
  };
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return rank(a) < rank(b); });
  return order;
}

// Which texels are covered: those of which at least half is, or in each block of four by four so many more or fewer,
// the fullest first, that what is covered up to there is the area of level 0 within a texel (of the smallest maps, half
// of one).
std::vector<uint8_t> covered_texels(const Halves& map) {
  const size_t side = std::min<size_t>(map.n, 4);
  const size_t blocks = map.n / side;
  const int64_t full = map.full;
  const int64_t most = map.n > 8 ? full : full / 2;
  std::vector<uint8_t> covered(map.n * map.n);
  int64_t owed = 0;  // texels of level 0 that nothing covers yet
  for (size_t k = 0; k < blocks * blocks; ++k) {
    size_t left = 0;
    size_t top = 0;
    for (size_t bit = 0; blocks >> bit != 0; ++bit) {
      left |= (k >> (2 * bit) & 1) << bit;
      top |= (k >> (2 * bit + 1) & 1) << bit;
    }
    const std::vector<size_t> order = ranked(map, left * side, top * side, side);
    for (const size_t t : order) owed += map.filled[t];
    for (const size_t t : order) {
      if (map.children[t].count == 0) continue;  // has no depth
      const bool half = 2 * int64_t{map.filled[t]} >= full;
      if (half ? owed - full < -most : owed <= most) break;
      covered[t] = 1;
      owed -= full;
    }
  }
  return covered;
}

// Of each of the texels of halved maps, how much lies under it.
std::vector<uint32_t> filled_of(const Level& from) {
  const size_t n = from.n / 2;
  std::vector<uint32_t> filled(from.maps() * n * n);
  for (size_t i = 0; i < from.filled.size(); ++i) {
    const size_t row = i / from.n;  // of all maps
    filled[row / 2 * n + i % from.n / 2] += from.filled[i];
  }
  return filled;
}

// full: texels of level 0 under one of the halved level.
Level halved(const Level& from, uint32_t full) {
  Level to;
  const size_t n = to.n = from.n / 2;
  to.filled = filled_of(from);
  to.depth.resize(from.maps() * n * n * 2);
  to.normal.resize(6 * n * n * 4);
  if (!from.emission.empty()) to.emission.resize(to.normal.size());
  std::vector<std::array<uint16_t, 2>> reach(n * n);  // least and greatest of each texel's children
  for (size_t map = 0; map < from.maps(); ++map) {
    Halves halves{n, {}, to.filled.data() + map * n * n, full};
    for (size_t at = 0; at < n * n; ++at) halves.children.push_back(children_of(from, map, at % n, at / n));
    const std::vector<uint8_t> covered = covered_texels(halves);
    for (size_t at = 0; at < n * n; ++at) {
      const Children& children = halves.children[at];
      const int count = children.count;
      reach[at] = {children.least, children.greatest};
      const auto mean = [&](int sum) { return static_cast<uint16_t>((sum + count / 2) / count); };
      uint16_t* d = to.depth.data() + (map * n * n + at) * 2;
      d[0] = covered[at] != 0 ? mean(children.depth_sums[0]) : 65535;
      d[1] = covered[at] != 0 ? mean(children.depth_sums[1]) : 0;
      for (size_t side = 0; side < from.sides() && covered[at] != 0; ++side)
        halve_face(from, children, map * from.sides() + side, at, to);
    }
    meet_again(reach, n, to.depth.data() + map * n * n * 2);
  }
  return to;
}

}  // namespace

uint32_t atlas_levels(int texels) {
  return static_cast<uint32_t>(std::bit_width(static_cast<unsigned>(std::max(texels / 4, 1))));
}

AtlasPlan plan_atlas(const ReliefModel& model) {
  std::vector<size_t> order(model.boxes.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return model.boxes[a].texels > model.boxes[b].texels; });
  double area = 0;
  for (const ReliefBox& box : model.boxes) area += 4.5 * box.texels * box.texels;
  const int widest = 3 * model.boxes[order[0]].texels;
  // Shelves, largest first: widths are multiples of the smaller ones, so that little is lost.
  AtlasPlan plan;
  plan.width = widest * std::max(1, static_cast<int>(std::ceil(std::sqrt(area) / widest)));
  plan.left.resize(order.size());
  plan.top.resize(order.size());
  int x = 0;
  int y = 0;
  int shelf = 0;
  for (const size_t i : order) {
    const int n = model.boxes[i].texels;
    if (x + 3 * n > plan.width) {
      x = 0;
      y += shelf;
      shelf = 0;
    }
    shelf = std::max(shelf, n * 3 / 2);
    plan.left[i] = static_cast<uint32_t>(x);
    plan.top[i] = static_cast<uint32_t>(y);
    x += 3 * n;
  }
  plan.height = y + shelf;
  return plan;
}

AtlasPlace atlas_place(const AtlasPlan& plan, size_t box, size_t texels, uint32_t level) {
  return {plan.left[box] + (level == 0 ? 0 : texels - (texels >> (level - 1))),
          plan.top[box] + (level == 0 ? 0 : texels)};
}

Atlas fill_atlas(const ReliefModel& model, const AtlasPlan& plan) {
  const auto width = static_cast<size_t>(plan.width);
  const auto height = static_cast<size_t>(plan.height);
  Atlas atlas;
  const size_t maps = model.depth_maps();
  const size_t depth_width = width * maps / 3;
  atlas.depth.assign(depth_width * height * 2, 0);
  for (size_t i = 0; i < atlas.depth.size(); i += 2) atlas.depth[i] = 65535;
  atlas.colour.assign(2 * width * height * 4, 0);
  atlas.normal.assign(2 * width * height * 4, 0);
  if (!model.emission.empty()) atlas.emission.assign(2 * width * height * 4, 0);
  if (!model.cube) atlas.bounds.assign(width / 2 * (height / 2) * 2, 0);
  for (size_t i = 0; i < atlas.bounds.size(); i += 2) atlas.bounds[i] = 255;
  for (size_t i = 0; i < model.boxes.size(); ++i) {
    const ReliefBox& box = model.boxes[i];
    const auto n = static_cast<size_t>(box.texels);
    const auto slice = [&](const auto& all, size_t per_texel) {
      const auto begin = all.begin() + static_cast<std::ptrdiff_t>(box.first * per_texel);
      return std::vector(begin, begin + static_cast<std::ptrdiff_t>(n * n * per_texel));
    };
    Level level{n, slice(model.depth, 2 * maps), slice(model.normal, 24), {}, std::vector<uint32_t>(maps * n * n)};
    for (size_t t = 0; t < level.filled.size(); ++t)
      level.filled[t] = level.depth[2 * t] <= level.depth[2 * t + 1] ? 1 : 0;
    if (!model.emission.empty()) level.emission = slice(model.emission, 24);
    for (uint32_t l = 0; l < atlas_levels(box.texels); ++l) {
      if (l > 0) level = halved(level, 1U << (2 * l));
      const auto first =
          model.colour.begin() + static_cast<std::ptrdiff_t>(4 * (l == 0 ? 6 * box.first : model.colour_texel(i, l)));
      std::vector<uint8_t> colour(first, first + static_cast<std::ptrdiff_t>(24 * level.n * level.n));
      spread_colours(level, colour);
      std::vector<uint8_t> emission = level.emission;
      if (!emission.empty()) spread_colours(level, emission);
      const size_t aside = l == 0 ? 0 : n - (n >> (l - 1));
      const size_t top = plan.top[i] + (l == 0 ? 0 : n);
      for (size_t v = 0; v < level.n; ++v) {
        for (size_t map = 0; map < maps; ++map)
          std::copy_n(
              level.depth.begin() + static_cast<std::ptrdiff_t>((map * level.n + v) * level.n * 2), level.n * 2,
              atlas.depth.begin() + static_cast<std::ptrdiff_t>(
                                        ((top + v) * depth_width + plan.left[i] * maps / 3 + map * n + aside) * 2));
        for (size_t face = 0; face < 6; ++face) {
          const auto from = static_cast<std::ptrdiff_t>((face * level.n + v) * level.n * 4);
          const auto to =
              static_cast<std::ptrdiff_t>(((top + v) * 2 * width + 2 * plan.left[i] + face * n + aside) * 4);
          std::copy_n(colour.begin() + from, level.n * 4, atlas.colour.begin() + to);
          if (!emission.empty()) std::copy_n(emission.begin() + from, level.n * 4, atlas.emission.begin() + to);
          std::copy_n(level.normal.begin() + from, level.n * 4, atlas.normal.begin() + to);
        }
      }
      for (size_t map = 0; map < 3 && !model.cube; ++map) {
        const std::vector<uint8_t> bounds = bounds_of(model.extent.data() + (box.first * 3 + map * n * n) * 2, n, l);
        const size_t m = n >> (l + 1);
        for (size_t v = 0; v < m; ++v)
          std::copy_n(
              bounds.begin() + static_cast<std::ptrdiff_t>(v * m * 2), m * 2,
              atlas.bounds.begin() + static_cast<std::ptrdiff_t>(
                                         ((top / 2 + v) * (width / 2) + (plan.left[i] + map * n + aside) / 2) * 2));
      }
    }
  }
  return atlas;
}

}  // namespace crowdbench::renderers
