#include "metrics/agents.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <unordered_map>

#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

struct Sums {
  AgentScore score;
  uint64_t pixels = 0;
  uint64_t absolute = 0;
  uint64_t squares = 0;
  double similarity = 0;
  uint64_t windows = 0;
  double depth = 0;
};

AgentScore finished(const Sums& sums, bool with_depth) {
  AgentScore out = sums.score;
  const double samples = 3.0 * static_cast<double>(sums.pixels);
  out.iou = static_cast<double>(out.pixels_both) / static_cast<double>(sums.pixels);
  out.mae = static_cast<double>(sums.absolute) / samples;
  out.mse = static_cast<double>(sums.squares) / samples;
  out.psnr = sums.squares == 0 ? std::numeric_limits<double>::infinity() : 10 * std::log10(255.0 * 255.0 / out.mse);
  if (sums.windows > 0) out.ssim_union = sums.similarity / static_cast<double>(sums.windows);
  if (with_depth && out.pixels_both > 0) out.depth_mae = sums.depth / static_cast<double>(out.pixels_both);
  return out;
}

}  // namespace

std::vector<AgentScore> score_agents(const Image8& reference, const Image8& test, const ImageU32& reference_ids,
                                     const ImageU32& test_ids, const Depths& depths, const Ssim* similarity) {
  require_same_size(reference, test);
  require_same_size(reference, reference_ids);
  require_same_size(reference, test_ids);
  const bool with_depth = depths.reference && depths.test;
  if (with_depth) {
    require_same_size(reference, *depths.reference);
    require_same_size(reference, *depths.test);
  }
  std::optional<Ssim> own;
  if (!similarity) {
    own = ssim(luma601(reference), luma601(test));
    if (own) similarity = &*own;
  }

  std::vector<Sums> all;
  std::unordered_map<uint32_t, size_t> index;
  const auto sums_of = [&](uint32_t id) -> Sums& {
    const auto [found, added] = index.try_emplace(id, all.size());
    if (added) {
      all.emplace_back();
      all.back().score.id = id;
    }
    return all[found->second];
  };
  const size_t r1 = reference.channels >= 3 ? 1 : 0;
  const size_t t1 = test.channels >= 3 ? 1 : 0;
  for (int y = 0; y < reference.height; ++y) {
    for (int x = 0; x < reference.width; ++x) {
      const uint32_t in_reference = *reference_ids.at(x, y);
      const uint32_t in_test = *test_ids.at(x, y);
      if (in_reference == 0 && in_test == 0) continue;
      const uint8_t* r = reference.at(x, y);
      const uint8_t* t = test.at(x, y);
      uint64_t absolute = 0;
      uint64_t squares = 0;
      for (size_t c = 0; c < 3; ++c) {
        const auto d = static_cast<uint64_t>(std::abs(int{r[c * r1]} - int{t[c * t1]}));
        absolute += d;
        squares += d * d;
      }
      const int map_x = x - kSsimRadius;
      const int map_y = y - kSsimRadius;
      const bool has_window =
          similarity && map_x >= 0 && map_y >= 0 && map_x < similarity->map.width && map_y < similarity->map.height;
      const auto add = [&](uint32_t id) {
        Sums& sums = sums_of(id);
        ++sums.pixels;
        sums.absolute += absolute;
        sums.squares += squares;
        if (has_window) {
          sums.similarity += *similarity->map.at(map_x, map_y);
          ++sums.windows;
        }
        sums.score.pixels_ref += id == in_reference ? 1 : 0;
        sums.score.pixels_test += id == in_test ? 1 : 0;
        if (in_reference != in_test) return;
        ++sums.score.pixels_both;
        if (with_depth) {
          const double u = *depths.reference->at(x, y);
          const double v = *depths.test->at(x, y);
          sums.depth += u == v ? 0 : std::abs(u - v);
        }
      };
      if (in_reference != 0) add(in_reference);
      if (in_test != 0 && in_test != in_reference) add(in_test);
    }
  }
  std::vector<AgentScore> out;
  out.reserve(all.size());
  for (const Sums& sums : all) out.push_back(finished(sums, with_depth));
  std::sort(out.begin(), out.end(), [](const AgentScore& a, const AgentScore& b) { return a.id < b.id; });
  return out;
}

}  // namespace crowdbench::metrics
