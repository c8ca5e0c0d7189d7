#include "renderers/posecache/cache_trade.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "renderers/posecache/pose_slots.h"

namespace crowdbench::renderers {
namespace {

constexpr uint32_t kMostPairs = 8;  // of a clip that are measured
constexpr int kPlaces = 4;          // within each
constexpr int kRate = 60;           // frames a second
constexpr int kFrames = 20;         // that are measured, after as many

}  // namespace

std::vector<KeyCircle> key_circles(const scene::PoseBank& bank, uint32_t keys) {
  std::vector<KeyCircle> circles;
  uint32_t first = 0;
  for (const scene::BankClip& clip : bank.clips()) {
    const uint32_t count = clip.samples <= 1 ? 1 : keys == 0 ? clip.samples : keys;
    circles.push_back({first, count});
    first += count;
  }
  return circles;
}

uint32_t key_count(const std::vector<KeyCircle>& circles) {
  return circles.empty() ? 0 : circles.back().first + circles.back().keys;
}

BlendError blend_error(const scene::Character& character, const scene::PoseBank& bank,
                       const std::vector<KeyCircle>& circles) {
  BlendError error;
  double sum = 0;
  double count = 0;
  for (size_t k = 0; k < circles.size(); ++k) {
    const uint32_t keys = circles[k].keys;
    const auto points = [&](double phase) {
      return scene::skin_points(character.mesh, bank.palette(bank.sample(static_cast<int>(k), phase)));
    };
    const uint32_t pairs = std::min(keys, kMostPairs);
    for (uint32_t p = 0; p < pairs && keys > 1; ++p) {
      const double from = std::floor(static_cast<double>(p) * keys / pairs);
      const std::vector<glm::vec3> a = points(from / keys);
      const std::vector<glm::vec3> b = points((from + 1) / keys);
      for (int i = 0; i < kPlaces; ++i) {
        const double blend = (i + 0.5) / kPlaces;
        const std::vector<glm::vec3> own = points((from + blend) / keys);
        for (size_t v = 0; v < own.size(); ++v) {
          const auto apart =
              static_cast<double>(glm::distance(own[v], glm::mix(a[v], b[v], static_cast<float>(blend))));
          sum += apart * apart;
          error.max = std::max(error.max, apart);
        }
        count += static_cast<double>(own.size());
      }
    }
  }
  error.rms = count > 0 ? std::sqrt(sum / count) : 0;
  return error;
}

CacheTrade cache_trade(const scene::PoseBank& bank, const std::vector<KeyCircle>& circles, uint32_t slots,
                       KeyRule choice, double keep, uint32_t agents) {
  CacheTrade out;
  const uint32_t keys = key_count(circles);
  PoseSlots cache(keys, slots);
  KeyDemand demand{circles, {}, KeySet(keys, 1), keep};  // at the beginning none costs more than another
  for (int frame = 0; frame < 2 * kFrames; ++frame) {
    demand.agents.assign(keys, 0);
    for (uint32_t i = 0; i < agents; ++i) {
      const size_t clip = i % circles.size();
      const double seconds = bank.clips()[clip].seconds;
      const double at = random_unit(1, i, 0) + (seconds > 0 ? frame / (kRate * seconds) : 0);
      ++demand.agents[key_place(circles[clip], static_cast<float>(at - std::floor(at))).key];
    }
    const KeySet set = choose_keys(demand, slots, choice);
    const size_t filled = cache.take(set).size();
    demand.cached = set;
    if (frame < kFrames) continue;
    out.hits += static_cast<double>(hits_of(demand, set)) / kFrames;
    out.skinned += static_cast<double>(filled) / kFrames;
  }
  return out;
}

}  // namespace crowdbench::renderers
