#include "reports/page/stability_page.h"

#include <gtest/gtest.h>

#include "core/image_io.h"
#include "reports/page/libraries.h"

namespace crowdbench::reports {
namespace {

TEST(StabilityPage, ShowsWhatFailsWithItsPicturesAndEveryRow) {
  StabilityPageRow good;
  good.name = "world_1e3";
  good.representation = "mesh";
  good.measured = "0";
  good.bound = "0.5";
  good.unit = "code values";
  good.pass = true;
  StabilityPageRow bad = good;
  bad.name = "eye_<1cm>";
  bad.pass = false;
  bad.bound_seen = true;
  bad.place = "pixel (3, 4)";
  bad.width = bad.height = 8;
  bad.before = bad.after = encode_png(Image8(8, 8, 3));
  std::string page;
  try {
    page = stability_page({good, bad}, "a renderer", "a program");
  } catch (const std::exception& error) {
    GTEST_SKIP() << error.what();
  }
  EXPECT_NE(page.find("1 of 2 rows do not hold"), std::string::npos);
  EXPECT_NE(page.find("eye_&lt;1cm&gt;"), std::string::npos);
  EXPECT_EQ(page.find("eye_<1cm>"), std::string::npos) << "escaped";
  EXPECT_NE(page.find("set after seeing"), std::string::npos);
  EXPECT_NE(page.find("data:image/png"), std::string::npos);
  EXPECT_NE(page.find("pixel (3, 4)"), std::string::npos);
  EXPECT_NE(page.find(">world_1e3<"), std::string::npos);
}

}  // namespace
}  // namespace crowdbench::reports
