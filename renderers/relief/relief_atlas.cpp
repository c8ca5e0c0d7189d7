#include "renderers/relief/relief_atlas.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>

namespace crowdbench::renderers {
namespace {

// One level of one box's maps.
struct Level {
  size_t n = 0;
  std::vector<uint16_t> depth;  // [axis][v][u][2]
  std::vector<uint8_t> colour;  // [axis][side][v][u][4]
  std::vector<uint8_t> normal;
};

Level halved(const Level& from) {
  Level to;
  const size_t n = to.n = from.n / 2;
  const size_t m = from.n;
  to.depth.resize(3 * n * n * 2);
  to.colour.resize(6 * n * n * 4);
  to.normal.resize(to.colour.size());
  for (size_t map = 0; map < 3; ++map) {
    for (size_t v = 0; v < n; ++v) {
      for (size_t u = 0; u < n; ++u) {
        std::array<size_t, 4> child{};
        int covered = 0;
        uint16_t least = 65535;
        uint16_t greatest = 0;
        for (size_t k = 0; k < 4; ++k) {
          const size_t texel = (2 * v + k / 2) * m + 2 * u + k % 2;
          const uint16_t* d = from.depth.data() + (map * m * m + texel) * 2;
          if (d[0] > d[1]) continue;
          child[static_cast<size_t>(covered++)] = texel;
          least = std::min(least, d[0]);
          greatest = std::max(greatest, d[1]);
        }
        uint16_t* d = to.depth.data() + (map * n * n + v * n + u) * 2;
        d[0] = covered >= 2 ? least : 65535;
        d[1] = covered >= 2 ? greatest : 0;
        if (covered < 2) continue;
        for (size_t side = 0; side < 2; ++side) {
          const size_t face = map * 2 + side;
          uint8_t* colour = to.colour.data() + (face * n * n + v * n + u) * 4;
          uint8_t* normal = to.normal.data() + (face * n * n + v * n + u) * 4;
          std::array<int, 3> sum{};
          glm::vec3 direction(0.0F);
          for (int k = 0; k < covered; ++k) {
            const size_t texel = (face * m * m + child[static_cast<size_t>(k)]) * 4;
            for (size_t c = 0; c < 3; ++c) sum[c] += from.colour[texel + c];
            direction += glm::vec3(from.normal[texel], from.normal[texel + 1], from.normal[texel + 2]) / 127.5F - 1.0F;
          }
          for (size_t c = 0; c < 3; ++c) colour[c] = static_cast<uint8_t>((sum[c] + covered / 2) / covered);
          const float length = glm::length(direction);
          direction = length > 1e-6F ? direction / length : glm::vec3(0, 1, 0);
          for (int c = 0; c < 3; ++c) normal[c] = static_cast<uint8_t>(direction[c] * 127.5F + 128.0F);
          // The first covered child's.
          const size_t first = (face * m * m + child[0]) * 4;
          colour[3] = from.colour[first + 3];
          normal[3] = from.normal[first + 3];
        }
      }
    }
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

Atlas fill_atlas(const ReliefModel& model, const AtlasPlan& plan) {
  const auto width = static_cast<size_t>(plan.width);
  const auto height = static_cast<size_t>(plan.height);
  Atlas atlas;
  atlas.depth.assign(width * height * 2, 0);
  for (size_t i = 0; i < atlas.depth.size(); i += 2) atlas.depth[i] = 65535;
  atlas.colour.assign(2 * width * height * 4, 0);
  atlas.normal.assign(2 * width * height * 4, 0);
  for (size_t i = 0; i < model.boxes.size(); ++i) {
    const ReliefBox& box = model.boxes[i];
    const auto n = static_cast<size_t>(box.texels);
    const auto slice = [&](const auto& all, size_t per_texel) {
      const auto begin = all.begin() + static_cast<std::ptrdiff_t>(box.first * per_texel);
      return std::vector(begin, begin + static_cast<std::ptrdiff_t>(n * n * per_texel));
    };
    Level level{n, slice(model.depth, 6), slice(model.colour, 24), slice(model.normal, 24)};
    for (uint32_t l = 0; l < atlas_levels(box.texels); ++l) {
      if (l > 0) level = halved(level);
      const size_t aside = l == 0 ? 0 : n - (n >> (l - 1));
      const size_t top = plan.top[i] + (l == 0 ? 0 : n);
      for (size_t v = 0; v < level.n; ++v) {
        for (size_t map = 0; map < 3; ++map)
          std::copy_n(level.depth.begin() + static_cast<std::ptrdiff_t>((map * level.n + v) * level.n * 2), level.n * 2,
                      atlas.depth.begin() +
                          static_cast<std::ptrdiff_t>(((top + v) * width + plan.left[i] + map * n + aside) * 2));
        for (size_t face = 0; face < 6; ++face) {
          const auto from = static_cast<std::ptrdiff_t>((face * level.n + v) * level.n * 4);
          const auto to =
              static_cast<std::ptrdiff_t>(((top + v) * 2 * width + 2 * plan.left[i] + face * n + aside) * 4);
          std::copy_n(level.colour.begin() + from, level.n * 4, atlas.colour.begin() + to);
          std::copy_n(level.normal.begin() + from, level.n * 4, atlas.normal.begin() + to);
        }
      }
    }
  }
  return atlas;
}

}  // namespace crowdbench::renderers
