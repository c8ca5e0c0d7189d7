#include "bench/stage/coverage.h"

#include <gtest/gtest.h>

namespace crowdbench::bench {
namespace {

TEST(Coverage, CountsPixelsAndAgentsByHand) {
  ImageU32 ids(4, 2, 1);
  ids.data = {0, 7, 7, 0, 1, 0, 7, 0};
  const scene::Coverage coverage = coverage_of(ids);
  EXPECT_EQ(coverage.covered_px, 4U);
  EXPECT_EQ(coverage.occupancy, 0.5);
  EXPECT_EQ(coverage.agents_visible, 2U);
  EXPECT_EQ(coverage_of(ImageU32{}).occupancy, 0.0);
}

}  // namespace
}  // namespace crowdbench::bench
