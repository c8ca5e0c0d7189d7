// Which pixels of two pictures `compare` counts: --ignore x,y,w,h and --mask FILE.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/image_io.h"
#include "core/json.h"
#include "metrics/difference.h"

namespace crowdbench::bench {

struct RegionOptions {
  std::vector<std::string> ignore;  // rectangles
  std::string mask;                 // a picture: black does not count, whatever its alpha
  bool given() const { return !ignore.empty() || !mask.empty(); }
};

struct CompareRegion {
  metrics::Mask counted;           // 1 channel, 0 = left out
  uint64_t pixels = 0;             // that count, at least one
  std::vector<std::string> notes;  // lines
};

// Nothing where no region is asked for. Throws Error: a rectangle that is none or lies outside the picture, a mask of
// another size, nothing left to count.
// A mask's colours decide: a pixel counts where any of them is above 0. Alpha has no say, and a note tells where it
// would decide otherwise (0 where a colour is above 0, or above 0 where none is); full alpha everywhere says nothing.
std::optional<CompareRegion> compare_region(const RegionOptions& options, int width, int height);
// "region": {"pixels", "ignore", "mask"}
Json region_json(const RegionOptions& options, const CompareRegion& region);

// Gives the test's pixels that do not count the reference's values, so that scores of the whole picture, and windows
// that reach over the region's edge, see no difference there; of floats, what is not finite there becomes 0 in both.
// Pictures of one kind and size; where the number of channels differs, grey is repeated.
void equal_outside(const CompareRegion& region, AnyImage& reference, AnyImage& test);

}  // namespace crowdbench::bench
