// How outlines that are shown are judged by those that are wanted.
#include "renderers/polypostor/polypostor_torn.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"

namespace crowdbench::renderers {
namespace {

TEST(PolypostorTorn, IsWhatIsSeenToStandOutOrLack) {
  const auto box = [](double right) { return Polyline{{0, 0}, {right, 0}, {right, 10}, {0, 10}}; };
  const auto mask = [](double right) {
    return rasterise(std::vector<glm::dvec2>{{0, 0}, {right, 0}, {right, 10}, {0, 0}, {right, 10}, {0, 10}});
  };
  const auto torn = [&](const Polyline& shown, const PartMask& figure) {
    const Polyline wanted = box(10);
    return WantedOutline(wanted, figure, 0.5).torn(shown);
  };
  EXPECT_EQ(torn(box(10), mask(10)), 0);
  EXPECT_EQ(torn(box(10.4), mask(10)), 0) << "within the slack";
  // Three texels too wide, or too narrow: 2.5 beyond the slack along an edge of ten, and what of the edges beside it.
  const double wide = torn(box(13), mask(10));
  EXPECT_NEAR(wide, 25 + 2 * 0.5 * 2.5 * 2.5, 5);
  EXPECT_NEAR(torn(box(7), mask(10)), wide, 5);
  // Neither is seen where the rest of the figure lies there.
  EXPECT_EQ(torn(box(13), mask(20)), 0);
  EXPECT_LT(torn(box(7), mask(20)), wide / 2);
}

// A star of many edges, some of no length, asked from everywhere, and on itself, with every kind of hint.
TEST(PolypostorTorn, AnIndexedLineAnswersAsTheWholeLineDoes) {
  Polyline star;
  for (uint64_t i = 0; i < 61; ++i) {
    const double angle = 0.103 * static_cast<double>(i);
    star.push_back((5 + 4 * random_unit(1, i, 0)) * glm::dvec2(std::cos(angle), std::sin(angle)));
    if (i % 9 == 0) star.push_back(star.back());
  }
  const IndexedLine indexed(star);
  EXPECT_EQ(indexed.perimeter(), perimeter(star));
  for (uint64_t k = 0; k < 500; ++k) {
    glm::dvec2 p(24 * random_unit(2, k, 0) - 12, 24 * random_unit(2, k, 1) - 12);
    const glm::dvec2& corner = star[k % star.size()];
    if (k % 5 == 0) p = corner;
    if (k % 5 == 1) p = corner + 0.37 * (star[(k + 1) % star.size()] - corner);  // on an edge, but for rounding
    const NearestPoint whole = nearest_point(star, p);
    for (const size_t hint : {size_t{0}, size_t{40}, k, whole.edge, size_t{100000}}) {
      const NearestPoint quick = indexed.nearest(p, hint);
      EXPECT_EQ(quick.edge, whole.edge) << k << " " << hint;
      EXPECT_EQ(quick.point, whole.point);
      EXPECT_EQ(quick.distance, whole.distance);
    }
  }
  const Polyline nothing;
  EXPECT_TRUE(std::isinf(IndexedLine(nothing).nearest({0, 0}, 3).distance));
}

}  // namespace
}  // namespace crowdbench::renderers
