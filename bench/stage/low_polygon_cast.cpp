#include "bench/stage/low_polygon_cast.h"

#include <algorithm>

namespace crowdbench::bench {

LowPolygonCast low_polygon_cast(const Staged& staged) {
  LowPolygonCast low{{}, staged};
  for (scene::CharacterEntry& entry : low.staged.scenario.characters)
    entry = {.source = "mannequin:triangles=500", .height = entry.height.value_or(1.75), .share = entry.share};
  low.cast = scene::load_cast(low.staged.scenario);
  scene::Crowd& crowd = low.staged.crowd;
  for (size_t i = 0; i < crowd.size(); ++i) {
    const auto& bank = *low.cast.banks[crowd.character[i]];
    crowd.bank_clip[i] = std::min<uint16_t>(crowd.bank_clip[i], static_cast<uint16_t>(bank.clips().size() - 1));
  }
  return low;
}

}  // namespace crowdbench::bench
