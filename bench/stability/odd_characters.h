// Characters that are valid and extreme, made in code.
#pragma once
#include <string_view>
#include <vector>

#include "scene/cast/cast.h"

namespace crowdbench::bench {

struct OddCharacter {
  std::string_view name;
  std::string_view about;
  scene::Character (*make)() = nullptr;
};
// One triangle, a joint without triangles, triangles without area, a needle, a sheet, a joint scaled to nothing, a
// mirrored one, 255 joints, and scales of 1e-3 and 1e3. About one unit large, about the origin; one clip or none.
const std::vector<OddCharacter>& odd_characters();
// Likewise, and large: some take seconds to bake.
const std::vector<OddCharacter>& large_characters();

// A cast of it alone, with the bank of its first clip or of its bind pose.
scene::Cast odd_cast(const OddCharacter& odd);

}  // namespace crowdbench::bench
