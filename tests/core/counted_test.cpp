#include "core/counted.h"

#include <gtest/gtest.h>

namespace crowdbench {
namespace {

TEST(Counted, OneIsNotSeveralAndNoneIs) {
  EXPECT_EQ(counted(0, "point", "points"), "0 points");
  EXPECT_EQ(counted(1, "point", "points"), "1 point");
  EXPECT_EQ(counted(2, "study", "studies"), "2 studies");
}

}  // namespace
}  // namespace crowdbench
