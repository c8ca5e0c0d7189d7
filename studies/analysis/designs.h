// Orders in which things are shown, so that what comes first, or after what, is the same for all of them over
// participants.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

namespace crowdbench::studies {

// A Williams design of n >= 1 conditions (Williams 1949): every condition once a row and, within each n rows, once at
// every place; every condition directly after every other equally often. n rows for even n, 2 n for odd n (there is no
// smaller one for 3 and 5).
std::vector<std::vector<uint32_t>> williams_design(uint32_t n);

// Who meets whom: all pairs of n >= 2 items once, in rounds in which nobody is twice (n - 1 rounds for even n, n for
// odd). The first of a pair is shown first (above, or left): every item so as often as second for odd n, once more or
// less for even n.
using Pairs = std::vector<std::pair<uint32_t, uint32_t>>;
std::vector<Pairs> round_robin(uint32_t n);

}  // namespace crowdbench::studies
