#include "bench/timing/image_check.h"

#include <gtest/gtest.h>

namespace crowdbench::bench {
namespace {

// 10 x 10 pixels, the first `covered` with id 1, their red at `shade`.
renderers::Capture picture(size_t covered, uint8_t shade) {
  renderers::Capture capture;
  capture.colour = Image8(10, 10, 4);
  capture.ids = ImageU32(10, 10, 1);
  for (size_t i = 0; i < covered; ++i) {
    capture.ids.data[i] = 1;
    capture.colour.data[4 * i] = shade;
  }
  return capture;
}

TEST(ImageCheck, CountsCoveredAndMovedPixels) {
  const ImageCheck check = check_pictures(picture(40, 200), picture(30, 200), false, std::nullopt);
  EXPECT_EQ(check.covered_px, 40U);
  EXPECT_EQ(check.moved_px, 10U);
  EXPECT_EQ(check.fault, "");
}

TEST(ImageCheck, NothingDrawnIsAFault) {
  EXPECT_NE(check_pictures(picture(0, 0), picture(0, 0), false, std::nullopt).fault, "");
  EXPECT_NE(check_pictures(picture(0, 0), picture(0, 0), true, std::nullopt).fault, "");
}

TEST(ImageCheck, ACrowdThatStandsStillIsAFault) {
  EXPECT_NE(check_pictures(picture(40, 200), picture(40, 200), false, std::nullopt).fault.find("does not move"),
            std::string::npos);
  // A floor has a static pose: standing still is what it is for.
  EXPECT_EQ(check_pictures(picture(40, 200), picture(40, 200), true, std::nullopt).fault, "");
}

TEST(ImageCheck, CoverageMustAgreeWithTheReference) {
  const ImageCheck reference{.covered_px = 40, .moved_px = 5, .fault = ""};
  EXPECT_EQ(check_pictures(picture(46, 200), picture(20, 200), false, reference).fault, "");  // +15 %
  EXPECT_EQ(check_pictures(picture(34, 200), picture(20, 200), false, reference).fault, "");  // -15 %
  EXPECT_NE(check_pictures(picture(47, 200), picture(20, 200), false, reference).fault.find("+17.5 %"),
            std::string::npos);
  EXPECT_NE(check_pictures(picture(33, 200), picture(20, 200), false, reference).fault.find("-17.5 %"),
            std::string::npos);
  EXPECT_EQ(check_pictures(picture(80, 200), picture(20, 200), true, reference).fault, "");
}

}  // namespace
}  // namespace crowdbench::bench
