#include "bench/experiments/quality.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bench/experiments/quality_rows.h"
#include "core/error.h"
#include "renderers/gl/context.h"
#include "scene/mannequin/mannequin.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::bench {
namespace {

TEST(QualityNumbers, ListsAndRanges) {
  const auto numbers = [](const std::string& text) { return parse_numbers(text, "--x", -1000, 1000); };
  EXPECT_EQ(numbers("30"), (std::vector<double>{30}));
  EXPECT_EQ(numbers("30,60,120"), (std::vector<double>{30, 60, 120}));
  EXPECT_EQ(numbers("0:90:30"), (std::vector<double>{0, 30, 60, 90})) << "the last is included";
  EXPECT_EQ(numbers("0:100:30"), (std::vector<double>{0, 30, 60, 90}));
  EXPECT_EQ(numbers("3:1:-1,7.5"), (std::vector<double>{3, 2, 1, 7.5}));
  EXPECT_EQ(numbers("0:0.3:0.1").size(), 4U) << "rounding does not lose the last";
  for (const char* text : {"", "a", "1,", "1:2", "1:2:0", "1:2:-1", "1e9", "nan", "inf", "0:1:1e-9", "1;2"})
    EXPECT_THROW(numbers(text), Error) << text;
}

TEST(QualityCamera, HeightInPixelsAtTheCentresDepth) {
  const double height = 1.75;
  const glm::dvec3 centre{0.1, 0.9, -0.2};
  for (const double pixels : {30.0, 120.0, 240.0}) {
    QualityView view;
    view.height_px = pixels;
    view.azimuth_deg = 33;
    view.elevation_deg = 20;
    const scene::Camera camera = quality_camera(view, centre, distance_of_height(view, height, 480));
    EXPECT_NEAR(camera.fov_y, std::numbers::pi / 6, 1e-12);
    const double depth = glm::distance(camera.eye, centre);
    EXPECT_NEAR(height / scene::pixel_size_at(camera, depth, 480), pixels, 1e-9);
  }
}

TEST(QualityCamera, AFigureCoversTheRowsAskedForWhateverStandsOut) {
  // A post of two metres with a head half a metre before it, and feet half a metre behind.
  const glm::dvec3 centre{0, 1, 0};
  const std::vector<glm::dvec3> figure = {{0, 0, -0.5}, {0, 2, 0.5}, {0, 1, 0}};
  for (const double azimuth : {0.0, 90.0, 180.0}) {
    QualityView view;
    view.height_px = 200;
    view.azimuth_deg = azimuth;
    const double distance = distance_of_figure(view, centre, figure, 480);
    const scene::Camera camera = quality_camera(view, centre, distance);
    const auto row = [&](const glm::dvec3& p) {
      const glm::dvec3 forward = glm::normalize(centre - camera.eye);
      return (p.y - 1) / glm::dot(p - camera.eye, forward) / std::tan(camera.fov_y / 2) * 240;
    };
    EXPECT_NEAR(row(figure[1]) - row(figure[0]), 200, 1e-6) << azimuth;
  }
  QualityView front;
  front.height_px = 200;
  QualityView back = front;
  back.azimuth_deg = 180;
  const std::vector<glm::dvec3> stands_out = {{0, 0, 0.5}, {0, 2, 0.5}};
  EXPECT_NEAR(distance_of_figure(front, centre, stands_out, 480), distance_of_figure(back, centre, stands_out, 480) + 1,
              1e-6);
  front.height_px = 4000;
  EXPECT_GT(distance_of_figure(front, centre, figure, 480), 0.5) << "never inside of the figure";
}

TEST(QualityCamera, AzimuthTurnsTowardsTheLeftAndElevationIsAbove) {
  const auto direction = [](double azimuth, double elevation) {
    QualityView view;
    view.azimuth_deg = azimuth;
    view.elevation_deg = elevation;
    const scene::Camera camera = quality_camera(view, {0, 1, 0}, distance_of_height(view, 2, 480));
    return glm::normalize(camera.eye - glm::dvec3(0, 1, 0));
  };
  EXPECT_NEAR(glm::distance(direction(0, 0), glm::dvec3(0, 0, 1)), 0, 1e-12);
  EXPECT_NEAR(glm::distance(direction(90, 0), glm::dvec3(1, 0, 0)), 0, 1e-12);
  EXPECT_NEAR(glm::distance(direction(0, 90), glm::dvec3(0, 1, 0)), 0, 1e-12);
  EXPECT_NEAR(glm::distance(direction(0, 30), glm::dvec3(0, 0.5, std::sqrt(0.75))), 0, 1e-12);
}

TEST(QualitySizes, TallFiguresGetALargerPicture) {
  QualitySetup setup;
  EXPECT_EQ(quality_size(setup, 120).height, 480);
  EXPECT_EQ(quality_size(setup, 120).width, 640);
  EXPECT_GE(quality_size(setup, 480).height, 720);
}

class QualityGl : public ::testing::Test {
 protected:
  QualitySetup setup() {
    scene::MannequinOptions small;
    small.triangles = 500;
    QualitySetup out;
    out.character = std::make_shared<const scene::Character>(scene::make_mannequin(small));
    out.use_cache = false;
    QualityView view;
    view.clip = out.character->placement.default_clip;
    view.height_px = 60;
    out.views = {view};
    return out;
  }
  gl::Context context_;
};

// Each cause mended leaves the score between what it was and 1, and one of them must matter.
TEST_F(QualityGl, CausesExplainTheScore) {
  QualitySetup asked = setup();
  asked.representations = {"mesh", "relief:map=32,capture=bind,merge=0"};
  asked.exact_pose = true;
  asked.causes = true;
  const auto rows = compute_quality(context_, asked);
  ASSERT_EQ(rows.size(), 2U);
  for (const auto& value : {rows[0].causes.silhouette, rows[0].causes.surface, rows[0].causes.shading})
    EXPECT_DOUBLE_EQ(value.value(), 1.0);
  const double score = rows[1].scores.value("ssim").value();
  EXPECT_LT(score, 0.999);
  double best = 0;
  for (const auto& value : {rows[1].causes.silhouette, rows[1].causes.surface, rows[1].causes.shading}) {
    EXPECT_GE(value.value(), score - 0.01) << "windows shared by two kinds may lose a little";
    EXPECT_LT(value.value(), 1.0);
    best = std::max(best, *value);
  }
  EXPECT_GT(best, score + 0.001);
}

TEST_F(QualityGl, TheMeshAgainstItselfIsPerfect) {
  QualitySetup s = setup();
  s.representations = {"mesh"};
  s.views[0].azimuth_deg = 40;
  int seen = 0;
  const auto rows = compute_quality(context_, s, [&](const QualityRow&, const QualityPictures& pictures) {
    ++seen;
    EXPECT_EQ(pictures.reference.colour, pictures.test.colour);
  });
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(seen, 1);
  EXPECT_EQ(rows[0].scores.value("silhouette_iou"), 1.0);
  EXPECT_EQ(rows[0].scores.value("boundary_px_mean"), 0.0);
  EXPECT_EQ(rows[0].scores.value("ssim"), 1.0);
  EXPECT_TRUE(std::isinf(rows[0].scores.value("psnr").value()));
}

TEST_F(QualityGl, AnImpostorIsGoodAtItsStoredViewAndWorseBesideIt) {
  QualitySetup s = setup();
  s.representations = {"flat:views=sphere-6x2,frames=2,texels=128"};
  QualityView view = s.views[0];
  view.height_px = 120;
  s.views = {view, view};
  s.views[1].azimuth_deg = 30;
  const auto rows = compute_quality(context_, s);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_GT(rows[0].scores.value("silhouette_iou").value(), 0.93);
  EXPECT_LT(rows[1].scores.value("silhouette_iou").value(), rows[0].scores.value("silhouette_iou").value() - 0.03);
  EXPECT_LT(rows[1].scores.value("ssim").value(), rows[0].scores.value("ssim").value());
}

TEST_F(QualityGl, CompressedTilesCostLittle) {
  QualitySetup s = setup();
  s.representations = {"flat:views=sphere-6x2,frames=2,texels=128",
                       "flat:views=sphere-6x2,frames=2,texels=128,compress=bc"};
  QualityView view = s.views[0];
  view.height_px = 120;
  s.views = {view, view};
  s.views[1].azimuth_deg = 60;
  const auto rows = compute_quality(context_, s);
  ASSERT_EQ(rows.size(), 4U);
  for (const QualityRow& row : rows) EXPECT_GT(row.scores.value("silhouette_iou").value(), 0.93) << row.representation;
  for (size_t v = 0; v < 2; ++v) {
    const metrics::FigureScores& plain = rows[v].scores;
    const metrics::FigureScores& blocks = rows[v + 2].scores;
    EXPECT_GT(blocks.value("silhouette_iou").value(), plain.value("silhouette_iou").value() - 0.005);
    EXPECT_GT(blocks.value("ssim").value(), plain.value("ssim").value() - 0.02);
    EXPECT_GT(blocks.value("psnr").value(), plain.value("psnr").value() - 1);
    EXPECT_NE(blocks.value("psnr").value(), plain.value("psnr").value()) << "both drawn the same way";
  }
}

// The representation's own frame is a quarter of a cycle off; given the exact time, only its drawing is judged.
TEST_F(QualityGl, ExactPoseTakesTheStoredFramesErrorAway) {
  QualitySetup s = setup();
  s.representations = {"flat:views=sphere-4x1,frames=1,texels=128"};
  const scene::Clip& clip = s.character->clips[static_cast<size_t>(s.views[0].clip)];
  s.views[0].azimuth_deg = 90;
  s.views[0].time = clip.start + clip.duration() / 4;
  const double stored = compute_quality(context_, s)[0].scores.value("silhouette_iou").value();
  s.exact_pose = true;
  const double exact = compute_quality(context_, s)[0].scores.value("silhouette_iou").value();
  EXPECT_GT(exact, 0.9);
  EXPECT_LT(stored, 0.8);
}

// A bake that its budget refuses has rows that say why; the others stand.
TEST_F(QualityGl, ARefusedRepresentationDoesNotLoseTheOthers) {
  QualitySetup s = setup();
  s.representations = {"flat:views=sphere-6x2,frames=2,texels=128", "mesh"};
  s.bake_budget = uint64_t{1} << 16;
  const auto rows = compute_quality(context_, s);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_NE(rows[0].refused.find("budget"), std::string::npos) << rows[0].refused;
  ASSERT_EQ(rows[0].scores.scores.size(), rows[1].scores.scores.size());
  for (const metrics::Scored& one : rows[0].scores.scores) {
    EXPECT_FALSE(one.result.value) << one.score->name;
    EXPECT_EQ(one.result.reason, rows[0].refused);
  }
  EXPECT_EQ(rows[1].refused, "");
  EXPECT_EQ(rows[1].index, 1U);
  EXPECT_EQ(rows[1].scores.value("silhouette_iou"), 1.0);
  s.representations = {"flat:views=sphere-6x2,frames=2,texels=128"};
  EXPECT_THROW(compute_quality(context_, s), Error) << "nothing is left";
}

// ---- rows

QualityRow made_up_row() {
  QualityRow row;
  row.representation = "flat";
  row.view.height_px = 64;
  row.view.azimuth_deg = 37;
  row.view.elevation_deg = 15;
  row.view.time = 0.25;
  row.scores.scores = {{metrics::scores()[0], {.value = 0.5}}, {metrics::scores()[1], metrics::absent("no pixels")}};
  return row;
}

TEST(QualityRows, AViewIsAComparison) {
  const ComparisonRow row = quality_row(3, {"mannequin", "walk"}, made_up_row(), {});
  EXPECT_EQ(row.run, 3);
  EXPECT_EQ(row.kind, "agent");
  EXPECT_EQ(row.representation, "flat");
  EXPECT_EQ(row.reference, renderers::reference_spec().text());
  EXPECT_EQ(row.character, "mannequin");
  EXPECT_EQ(row.clip, "walk");
  EXPECT_EQ(row.height_px, 64);
  EXPECT_EQ(row.azimuth_deg, 37);
  EXPECT_EQ(row.elevation_deg, 15);
  EXPECT_EQ(row.time, 0.25);
  EXPECT_EQ(row.display_given, false);
  ASSERT_EQ(row.scores.size(), 2U);
  EXPECT_EQ(row.scores[0].name, metrics::scores()[0]->name);
  EXPECT_EQ(row.scores[0].value, 0.5);
  EXPECT_EQ(row.scores[1].value, std::nullopt);
  EXPECT_EQ(row.scores[1].reason, "no pixels");
}

TEST(QualityRows, PicturesAreCutToBothFiguresAndLeftOutWhereThereAreNone) {
  const support::ScratchFolder folder;
  QualityPictures pictures;
  for (renderers::Capture* side : {&pictures.reference, &pictures.test}) {
    side->colour = Image8(100, 80, 4);
    side->ids = ImageU32(100, 80, 1);
  }
  {
    StoreWriter store(folder / "r.sqlite");
    RunRow of;
    of.headline = "cpu";
    const int64_t run = store.write(of);
    const int64_t comparison = store.write(quality_row(run, {}, made_up_row(), {}));
    write_quality_pictures(store, run, comparison, made_up_row(), pictures);
    // The reference's figure from 30 to 39, the test's from 45 to 49: 20 columns, and 8 more on each side.
    for (int x = 30; x < 40; ++x) *pictures.reference.ids.at(x, 40) = 1;
    for (int x = 45; x < 50; ++x) *pictures.test.ids.at(x, 40) = 1;
    write_quality_pictures(store, run, comparison, made_up_row(), pictures);
  }
  const StoreContents kept = read_store(folder / "r.sqlite", true);
  ASSERT_EQ(kept.pictures.size(), 3U) << "reference, test and difference of the second";
  for (const PictureRow& picture : kept.pictures) {
    EXPECT_EQ(picture.width, 36) << picture.role;
    EXPECT_EQ(picture.height, 17) << picture.role;
  }
}

}  // namespace
}  // namespace crowdbench::bench
