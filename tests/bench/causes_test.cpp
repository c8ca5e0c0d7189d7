// Error by cause where both sides are drawn: rendered cases that have exactly one cause each.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <string>

#include "bench/experiments/cause_chain.h"
#include "bench/experiments/cause_rows.h"
#include "bench/experiments/cause_words.h"
#include "bench/experiments/quality.h"
#include "metrics/picture_causes.h"
#include "renderers/gl/context.h"
#include "scene/mannequin/mannequin.h"
#include "tests/support/sanitized.h"

namespace crowdbench::bench {
namespace {

using metrics::Cause;
using metrics::CauseErrors;
using metrics::CauseRow;

void expect_sum(const CauseErrors& errors) {
  const auto check = [](const CauseRow& row) {
    int64_t sum = row.residue;
    for (const int64_t amount : row.amounts) sum += amount;
    EXPECT_EQ(sum, row.total) << row.id;
  };
  check(errors.whole);
  for (const CauseRow& row : errors.agents) check(row);
}

double share(const CauseErrors& errors, Cause cause) {
  return static_cast<double>(errors.whole.amount(cause)) / static_cast<double>(errors.whole.total);
}

// The cause has all of the error but for `rest` of it, and so has no other.
void expect_only(const CauseErrors& errors, Cause cause, double rest = 0) {
  expect_sum(errors);
  ASSERT_GT(errors.whole.total, 0);
  for (const metrics::CauseDoc& doc : metrics::causes())
    EXPECT_NEAR(share(errors, doc.cause), doc.cause == cause ? 1.0 : 0.0, rest) << doc.name;
  EXPECT_NEAR(static_cast<double>(errors.whole.residue), 0, rest * static_cast<double>(errors.whole.total));
}

// A lens of a long focal length, so that parallel rays and the eye's own are the same to within a tenth of a pixel.
class CausesGl : public ::testing::Test {
 protected:
  void SetUp() override {
    scene::MannequinOptions small;
    small.triangles = 500;
    auto character = std::make_shared<const scene::Character>(scene::make_mannequin(small));
    cast_.characters = {character};
    cast_.banks = {
        std::make_shared<const scene::PoseBank>(*character, std::vector<int>{character->placement.default_clip})};
    cast_.shares = {1.0};
    renderer_ = std::make_unique<renderers::Renderer>(context_, cast_);
    mesh_ = make("reference");
    frame_.width = frame_.height = 160;
    frame_.camera.fov_y = 1.5 * std::numbers::pi / 180;
    frame_.outfits.resize(2);
    for (scene::Outfit& outfit : frame_.outfits)
      for (glm::vec4& colour : outfit.colours) colour = glm::vec4(1.0F);
    for (glm::vec4& colour : frame_.outfits[1].colours) colour = {0.9F, 0.5F, 0.3F, 1.0F};
    frame_.agents.resize(1);
    look(0);
  }
  std::unique_ptr<renderers::Representation> make(const std::string& spec) {
    return renderers::make_representation({.context = context_, .cast = cast_, .use_cache = false, .progress = false},
                                          renderers::parse_spec(spec));
  }
  // The middle of the figures, or another point, seen level from an azimuth, one figure 120 pixels tall.
  void look(double azimuth_deg, double height_px = 120, std::optional<glm::dvec3> centre = {}) {
    const double azimuth = azimuth_deg * std::numbers::pi / 180;
    const double distance = 1.75 * frame_.height / (height_px * 2 * std::tan(frame_.camera.fov_y / 2));
    const scene::PoseBank& bank = *cast_.banks[0];
    centre_ = centre.value_or(0.5 * (glm::dvec3(bank.bounds_min()) + glm::dvec3(bank.bounds_max())));
    frame_.camera.target = centre_;
    frame_.camera.eye = centre_ + distance * glm::dvec3(std::sin(azimuth), 0, std::cos(azimuth));
    frame_.origin = frame_.camera.eye;
  }
  // farther: by that factor, and as much larger: it covers the same pixels.
  void stand(double x, double z, double phase = 0, double farther = 1) {
    scene::FrameAgent agent;
    agent.position = glm::vec3(farther * (glm::dvec3(x, 0, z) - frame_.origin));
    agent.scale = static_cast<float>(farther);
    agent.phase = static_cast<float>(phase);
    agent.pose = cast_.banks[0]->sample(0, phase);
    agent.id = static_cast<uint32_t>(frame_.agents[0].size()) + 1;
    frame_.agents[0].push_back(agent);
  }
  CausePictures told(const scene::Frame& posed, const scene::Frame& frame, renderers::Representation& test,
                     const StoredWhat& stored = {}) {
    const renderers::Capture reference = renderer_->capture(frame_, *mesh_);
    return draw_causes({reference, posed, frame, 1.75}, {context_, cast_, *renderer_, *mesh_},
                       {context_, cast_, *renderer_, test}, stored);
  }
  CausePictures told(const std::string& spec) {
    const auto test = make(spec);
    scene::Frame posed = frame_;
    show_stored_frames(posed, cast_, *test);
    return told(posed, frame_, *test, stored_by(renderers::parse_spec(spec), cast_));
  }

  gl::Context context_;
  scene::Cast cast_;
  scene::Frame frame_;
  glm::dvec3 centre_{0.0};
  std::unique_ptr<renderers::Renderer> renderer_;
  std::unique_ptr<renderers::Representation> mesh_;
};

TEST_F(CausesGl, TheMeshAgainstItselfHasNone) {
  stand(0, 0);
  const CausePictures causes = told(frame_, frame_, *mesh_);
  EXPECT_EQ(causes.errors.whole.total, 0);
  for (const metrics::CauseStep& step : causes.steps) EXPECT_EQ(step.codes, causes.steps[0].codes);
}

TEST_F(CausesGl, AnAgentAStoredFrameLateIsPose) {
  stand(-0.6, 0);
  stand(0.6, 0, 0.3);
  scene::Frame late = frame_;
  late.agents[0][1].pose = cast_.banks[0]->sample(0, 0.2);
  const CausePictures causes = told(late, late, *mesh_);
  expect_only(causes.errors, Cause::pose);
  EXPECT_EQ(causes.errors.agent(1)->total, 0);
  EXPECT_EQ(causes.errors.agent(2)->total, causes.errors.whole.total);
}

// What the representation's own shown_phase says is put in: pre-posed meshes have no other error.
TEST_F(CausesGl, StoredFramesOfAMeshArePose) {
  stand(0, 0, 0.13);
  expect_only(told("rigid").errors, Cause::pose, 0.02);
}

TEST_F(CausesGl, ARecolouredAgentIsTexture) {
  stand(-0.4, 0);
  stand(0.4, 0);
  scene::Frame painted = frame_;
  painted.agents[0][0].outfit = 1;
  const CausePictures causes = told(frame_, painted, *mesh_);
  expect_only(causes.errors, Cause::texture);
  EXPECT_EQ(causes.errors.agent(1)->total, causes.errors.whole.total);
}

TEST_F(CausesGl, OtherLightOnTheSameSurfacesIsShading) {
  stand(0, 0);
  scene::Frame lit = frame_;
  lit.light.direction = {-0.8F, 0.5F, 0.3F};
  expect_only(told(frame_, lit, *mesh_).errors, Cause::shading);
}

// Two agents that cover the same pixels as before, the nearer one now behind the other.
TEST_F(CausesGl, AgentsThatChangedPlacesAreOrder) {
  stand(-0.15, 1.0);
  stand(0.15, -1.0);
  frame_.agents[0][1].outfit = 1;
  scene::Frame swapped = frame_;
  swapped.agents[0][0].position *= 1.1F;
  swapped.agents[0][0].scale *= 1.1F;
  const CausePictures causes = told(frame_, swapped, *mesh_);
  expect_only(causes.errors, Cause::order, 0.02);
  EXPECT_GT(static_cast<double>(causes.errors.agent(1)->amount(Cause::order)),
            0.98 * static_cast<double>(causes.errors.whole.total));
}

TEST_F(CausesGl, AnAgentThatMovedIsAShiftOfItsPixels) {
  stand(-0.5, 0);
  stand(0.5, 0);
  const renderers::Capture reference = renderer_->capture(frame_, *mesh_);
  scene::Frame moved = frame_;
  const double pixel = scene::pixel_size_at(frame_.camera, glm::distance(frame_.origin, centre_), frame_.height);
  moved.agents[0][0].position.x -= static_cast<float>(3 * pixel);
  moved.agents[0][0].position.y += static_cast<float>(2 * pixel);
  const renderers::Capture test = renderer_->capture(moved, *mesh_);
  const metrics::PictureCauses causes = metrics::causes_of_pictures(
      {reference.colour, test.colour, reference.ids, test.ids, &reference.depth, &test.depth});
  expect_only(causes.errors, Cause::place, 0.05);
  EXPECT_EQ(causes.changes[0].dx, -3);
  EXPECT_EQ(causes.changes[0].dy, -2);
  EXPECT_EQ(causes.changes[1].dx, 0);
}

// Sixteen views: at 0 degrees the view and the frame are stored exactly, at 11 the view is half a step away.
TEST_F(CausesGl, TheStoredViewIsACauseBesideItAlone) {
  CROWDBENCH_SKIP_SANITIZED("CausesGl.TheSizeClassIsACauseWhereACoarserLevelIsShown");
  const std::string spec = "flat:views=sphere-16x1,frames=2,texels=512";
  const glm::dvec3 centre = stored_by(renderers::parse_spec(spec), cast_).views[0].centre;
  look(0, 120, centre);
  stand(0, 0);
  const CausePictures at = told(spec);
  expect_sum(at.errors);
  EXPECT_EQ(at.errors.whole.amount(Cause::pose), 0);
  EXPECT_EQ(at.errors.whole.amount(Cause::order), 0);
  EXPECT_FALSE(at.errors.available(Cause::surface)) << "its depth is that of a plane";
  frame_.agents[0].clear();
  look(11, 120, centre);
  stand(0, 0);
  const CausePictures beside = told(spec);
  expect_sum(beside.errors);
  EXPECT_EQ(beside.errors.whole.amount(Cause::pose), 0);
  EXPECT_EQ(beside.errors.whole.largest(), Cause::view);
  EXPECT_GT(share(beside.errors, Cause::view), 0.8);
  EXPECT_LT(static_cast<double>(at.errors.whole.amount(Cause::view)),
            0.02 * static_cast<double>(beside.errors.whole.amount(Cause::view)));
  EXPECT_LT(share(at.errors, Cause::view), 0.1);
}

// Made of others: an agent's stored view is that of who draws it.
TEST_F(CausesGl, TheViewOfAHybridIsThatOfWhoDrawsTheAgent) {
  const std::string far = "flat:views=sphere-16x1,frames=2,texels=128";
  look(11, 120, stored_by(renderers::parse_spec(far), cast_).views[0].centre);
  stand(0, 0);
  const CausePictures alone = told(far);
  const CausePictures drawn_far = told("hybrid(mesh," + far + ",distance=1)");
  expect_sum(drawn_far.errors);
  EXPECT_EQ(drawn_far.errors.whole.amount(Cause::view), alone.errors.whole.amount(Cause::view));
  EXPECT_GT(share(drawn_far.errors, Cause::view), 0.5);
  EXPECT_FALSE(drawn_far.errors.available(Cause::pose));
  const CausePictures drawn_near = told("hybrid(mesh," + far + ",distance=100000)");
  expect_sum(drawn_near.errors);
  EXPECT_TRUE(drawn_near.errors.available(Cause::view));
  EXPECT_EQ(drawn_near.errors.whole.amount(Cause::view), 0);
}

TEST_F(CausesGl, TheSizeClassIsACauseWhereACoarserLevelIsShown) {
  const std::string spec = "flat:views=sphere-16x1,frames=2,texels=256";
  stand(0, 0);
  const CausePictures finest = told("flat:views=sphere-16x1,frames=2,texels=64");
  EXPECT_EQ(finest.level_samples, 1);
  EXPECT_EQ(finest.errors.whole.amount(Cause::level), 0);
  frame_.agents[0].clear();
  look(0, 40);
  stand(0, 0);
  const CausePictures coarse = told(spec);
  expect_sum(coarse.errors);
  EXPECT_GT(coarse.level_samples, 1);
  EXPECT_NE(coarse.errors.whole.amount(Cause::level), 0);
}

TEST_F(CausesGl, ACrowdsCausesAreItsAgents) {
  stand(-0.7, 0);
  stand(0.0, 0.8, 0.3);
  stand(0.15, -0.8);
  stand(0.8, 0);
  scene::Frame test = frame_;
  test.agents[0][0].outfit = 1;
  test.agents[0][1].position *= 1.1F;
  test.agents[0][1].scale *= 1.1F;
  test.agents[0][3].pose = cast_.banks[0]->sample(0, 0.2);
  scene::Frame posed = frame_;
  posed.agents[0][3].pose = test.agents[0][3].pose;
  const CausePictures causes = told(posed, test, *mesh_);
  expect_sum(causes.errors);
  EXPECT_EQ(causes.errors.agent(1)->amount(Cause::texture), causes.errors.agent(1)->total);
  EXPECT_GT(causes.errors.agent(1)->total, 0);
  EXPECT_EQ(causes.errors.agent(2)->largest(), Cause::order);
  EXPECT_EQ(causes.errors.agent(4)->amount(Cause::pose), causes.errors.agent(4)->total);
  EXPECT_GT(causes.errors.agent(4)->total, 0);
}

TEST(CauseWords, SayWhatDominatesOnlyWhereItIsClear) {
  std::vector<CauseUnit> units;
  const auto add = [&](double height, int64_t view, int64_t silhouette) {
    CauseUnit unit{height, units.size(), {}};
    unit.row.amounts[static_cast<size_t>(Cause::view)] = view;
    unit.row.amounts[static_cast<size_t>(Cause::silhouette)] = silhouette;
    unit.row.total = view + silhouette;
    units.push_back(unit);
  };
  for (int i = 0; i < 10; ++i) {
    add(20 + i, 90, 10);
    add(40 + i, 70 + i, 20);
    add(70 + i, i % 2 == 0 ? 100 : 0, i % 2 == 0 ? 0 : 99);
    add(130 + i, 5, 60);
  }
  add(300, 1, 0);
  const std::vector<CauseRange> ranges = causes_by_height(units, 1);
  ASSERT_EQ(ranges.size(), 4U) << "the first two are one";
  EXPECT_EQ(ranges[0].from, 15);
  EXPECT_EQ(ranges[0].below, 60);
  EXPECT_EQ(ranges[0].units, 20U);
  EXPECT_EQ(ranges[0].dominant, Cause::view);
  EXPECT_LE(ranges[0].share.low, ranges[0].shares[static_cast<size_t>(Cause::view)]);
  EXPECT_GE(ranges[0].share.high, ranges[0].shares[static_cast<size_t>(Cause::view)]);
  EXPECT_FALSE(ranges[1].dominant);
  EXPECT_EQ(ranges[2].dominant, Cause::silhouette);
  EXPECT_FALSE(ranges[3].dominant) << "one view says nothing about others";
  const std::string words = cause_words(ranges, "view");
  EXPECT_EQ(words.find("below 60 pixels: the stored view ("), 0U) << words;
  EXPECT_NE(words.find("60 to 120 pixels: not distinguishable (most: the stored view, then the silhouette)"),
            std::string::npos)
      << words;
  EXPECT_NE(words.find("120 to 240 pixels: the silhouette ("), std::string::npos) << words;
  EXPECT_NE(words.find("from 240 pixels on: not distinguishable with 1 view"), std::string::npos) << words;
}

TEST(CauseWords, NoErrorIsSaid) {
  const CauseUnit unit{100, 1, {}};
  EXPECT_EQ(cause_words(causes_by_height({&unit, 1}, 1), "agent"), "at 100 pixels: no error");
}

TEST(CauseRows, ARangeIsARowWithTheSharesThatItHas) {
  CauseRange low;
  low.from = 0;
  low.below = 60;
  low.units = 8;
  low.total = 1000;
  low.shares[static_cast<size_t>(Cause::pose)] = 0.75;
  low.shares[static_cast<size_t>(Cause::order)] = -0.25;
  low.residue = 0.5;
  low.first = low.dominant = Cause::pose;
  low.share = {0.6, 0.9};
  CauseRange high;
  high.from = 60;
  high.below = std::numeric_limits<double>::infinity();
  const std::vector<CauseRange> ranges = {low, high};
  const std::vector<CauseRangeRow> rows = cause_rows(7, {"flat", "mesh", "mannequin"}, ranges, "view");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].run, 7);
  EXPECT_EQ(rows[0].representation, "flat");
  EXPECT_EQ(rows[0].reference, "mesh");
  EXPECT_EQ(rows[0].character, "mannequin");
  EXPECT_EQ(rows[0].unit, "view");
  EXPECT_EQ(rows[0].below, 60);
  EXPECT_EQ(rows[0].units, 8U);
  EXPECT_EQ(rows[0].total, 1000U);
  EXPECT_EQ(rows[0].residue, 0.5);
  EXPECT_EQ(rows[0].dominant, metrics::doc_of(Cause::pose).name);
  EXPECT_EQ(rows[0].share_low, 0.6);
  EXPECT_EQ(rows[0].share_high, 0.9);
  EXPECT_EQ(rows[0].words, cause_range_words(ranges, 0, "view"));
  double shares = 0;
  for (const CauseShareRow& share : rows[0].shares) shares += share.share;
  EXPECT_EQ(rows[0].shares.size(), 2U) << "causes without a share are left out";
  EXPECT_EQ(shares + rows[0].residue, 1.0);
  EXPECT_EQ(rows[1].below, std::nullopt);
  EXPECT_EQ(rows[1].dominant, std::nullopt);
  EXPECT_TRUE(rows[1].shares.empty());
  EXPECT_TRUE(cause_rows(7, {}, {}, "view").empty());
}

TEST(PopRows, ASwitchNobodySeesHasNoValues) {
  PoppingResult result;
  result.components = {"mesh", "flat"};
  Switch seen;
  seen.id = 4;
  seen.tick = 20;
  seen.steps = 3;
  seen.complete = false;
  seen.from = 1;
  seen.distance = 12.5;
  seen.pixels = 40;
  seen.worst_tick = 21;
  seen.values.assign(metrics::pop_scores().size(), 0.25);
  Switch unseen = seen;
  unseen.pixels = 0;
  result.switches = {seen, unseen};
  const std::vector<PopRow> rows = pop_rows(7, "hybrid", "mannequin", "a display", result);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].from, "flat");
  EXPECT_EQ(rows[0].to, "mesh");
  EXPECT_EQ(rows[0].agent, 3U) << "an id is the agent's index + 1";
  EXPECT_EQ(rows[0].frames, 3U);
  EXPECT_FALSE(rows[0].complete);
  EXPECT_EQ(rows[0].worst_tick, 21U);
  EXPECT_EQ(rows[0].display, "a display");
  ASSERT_EQ(rows[0].scores.size(), metrics::pop_scores().size());
  EXPECT_EQ(rows[0].scores[0].name, metrics::pop_scores()[0].name);
  EXPECT_EQ(rows[0].scores[0].value, 0.25);
  for (const PopScoreRow& score : rows[1].scores) EXPECT_EQ(score.value, std::nullopt) << score.name;
}

}  // namespace
}  // namespace crowdbench::bench
