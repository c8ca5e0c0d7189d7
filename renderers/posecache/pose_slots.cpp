#include "renderers/posecache/pose_slots.h"

#include <algorithm>
#include <cassert>

namespace crowdbench::renderers {
namespace {

constexpr uint32_t kNoSlot = ~0U;

}  // namespace

PoseSlots::PoseSlots(uint32_t keys, uint32_t slots) : slot_of_(keys, kNoSlot), slots_(slots) {}

std::vector<PoseSlots::Fill> PoseSlots::take(const KeySet& set) {
  ++sets_;
  std::vector<uint32_t> missing;
  for (uint32_t key = 0; key < set.size(); ++key) {
    if (!set[key]) continue;
    if (slot_of_[key] == kNoSlot)
      missing.push_back(key);
    else
      slots_[slot_of_[key]].used = sets_;
  }
  std::vector<uint32_t> free;
  for (uint32_t s = 0; s < slots_.size(); ++s)
    if (slots_[s].used != sets_) free.push_back(s);
  assert(missing.size() <= free.size());
  std::stable_sort(free.begin(), free.end(), [&](uint32_t a, uint32_t b) { return slots_[a].used < slots_[b].used; });
  free.resize(missing.size());
  std::sort(free.begin(), free.end());
  std::vector<Fill> out;
  for (size_t i = 0; i < missing.size(); ++i) {
    Slot& slot = slots_[free[i]];
    if (slot.used > 0) slot_of_[slot.key] = kNoSlot;
    slot = {missing[i], sets_};
    slot_of_[missing[i]] = free[i];
    out.push_back({free[i], missing[i]});
  }
  return out;
}

}  // namespace crowdbench::renderers
