// Pixels of float pictures that no score can be made of.
#pragma once
#include <cstdint>
#include <string>

#include "metrics/difference.h"

namespace crowdbench::metrics {

struct NotFinite {
  uint64_t nan = 0;       // pixels with a colour channel that is not a number
  uint64_t infinite = 0;  // pixels with an infinite one and none that is not a number
  int x = -1, y = -1;     // the first of either in reading order
  uint64_t pixels() const { return nan + infinite; }
};
// Alpha is not looked at.
NotFinite not_finite(const ImageF& image);

// "the test has 3 pixels that are not a number and 1 infinite, the first at (7, 2)", of a picture that has some.
std::string not_finite_text(const NotFinite& found, const char* which);
// "the test has 3 pixels that are not a number and 1 infinite, the first at (7, 2)"; both pictures' where both have
// some; empty where neither has.
std::string not_finite_text(const NotFinite& reference, const NotFinite& test);

}  // namespace crowdbench::metrics
