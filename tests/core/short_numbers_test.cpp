#include "core/short_numbers.h"

#include <gtest/gtest.h>

namespace crowdbench {
namespace {

using Texts = std::map<std::string, std::string>;

TEST(ShortNumbers, KeepAsManyDigitsAsTellThemApart) {
  EXPECT_EQ(short_numbers({"43.217391304347828", "43.26", "71.5"}),
            (Texts{{"43.217391304347828", "43.2"}, {"43.26", "43.26"}, {"71.5", "71.5"}}));
  EXPECT_EQ(short_numbers({"43.217391304347828", "43.219391304347828"}),
            (Texts{{"43.217391304347828", "43.217"}, {"43.219391304347828", "43.219"}}));
  EXPECT_EQ(short_numbers({"0.00012345678", "1234567.25"}),
            (Texts{{"0.00012345678", "0.000123"}, {"1234567.25", "1.23e+06"}}));
  EXPECT_EQ(short_numbers({"-0.1111111111", "0.1111111111"}),
            (Texts{{"-0.1111111111", "-0.111"}, {"0.1111111111", "0.111"}}));
}

TEST(ShortNumbers, LeaveShortNumbersAndWordsAsTheyAre) {
  EXPECT_EQ(short_numbers({"1", "10.25", "100000"}), (Texts{{"1", "1"}, {"10.25", "10.25"}, {"100000", "100000"}}));
  EXPECT_EQ(short_numbers({"mesh:triangles=300", "nan", "1.5 m", ""}),
            (Texts{{"mesh:triangles=300", "mesh:triangles=300"}, {"nan", "nan"}, {"1.5 m", "1.5 m"}, {"", ""}}));
  EXPECT_EQ(short_numbers({"0.50000000", "0.5000000"}),
            (Texts{{"0.50000000", "0.50000000"}, {"0.5000000", "0.5000000"}}))
      << "one number in two ways: nothing shorter tells them apart";
  EXPECT_TRUE(short_numbers({}).empty());
}

}  // namespace
}  // namespace crowdbench
