// The places of a cache of skinned key poses, and which key pose each of them holds.
#pragma once
#include <cstdint>
#include <vector>

#include "renderers/posecache/key_choice.h"

namespace crowdbench::renderers {

class PoseSlots {
 public:
  PoseSlots(uint32_t keys, uint32_t slots);
  struct Fill {
    uint32_t slot = 0;
    uint32_t key = 0;
  };
  // Gives every key pose of the set a place; at most as many as there are places. Those that had none take places never
  // used, then those whose key poses have been out of sets for longest (of equal ones the lowest), and are to be
  // skinned: by ascending place.
  std::vector<Fill> take(const KeySet& set);
  // Of a key pose of the last set.
  uint32_t slot(uint32_t key) const { return slot_of_[key]; }

 private:
  struct Slot {
    uint32_t key = 0;
    uint64_t used = 0;  // number of the last set that it was in; 0: empty
  };
  std::vector<uint32_t> slot_of_;  // by key pose; kNone
  std::vector<Slot> slots_;
  uint64_t sets_ = 0;
};

}  // namespace crowdbench::renderers
