// The one check that every metric of two pictures begins with.
#pragma once
#include "core/error.h"
#include "core/image.h"

namespace crowdbench::metrics {

template <typename A, typename B>
void require_same_size(const Image<A>& a, const Image<B>& b) {
  if (a.width != b.width || a.height != b.height)
    throw Error({},
                fmt::format("the pictures differ in size, {} x {} and {} x {}", a.width, a.height, b.width, b.height),
                "compare pictures of one size");
}

}  // namespace crowdbench::metrics
