// The truth of scenes whose answer can be worked out by hand, and that no thread has a say in it.
#include "truth/truth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "core/error.h"
#include "scene/mannequin/mannequin.h"
#include "tests/scene/tiny_character.h"
#include "truth/judge.h"
#include "truth/surface.h"
#include "truth/texture.h"
#include "truth/view.h"

namespace crowdbench::truth {
namespace {

// The tiny character is the triangle (0, 0, 0), (0, 2, 0), (0, 2, 0.5), whose front looks along +X.
scene::Cast cast_of(scene::Character character, const std::vector<int>& clips) {
  scene::Cast cast;
  auto shared = std::make_shared<const scene::Character>(std::move(character));
  cast.banks.push_back(std::make_shared<const scene::PoseBank>(*shared, clips));
  cast.characters.push_back(std::move(shared));
  cast.shares = {1.0};
  return cast;
}

// From +X at the triangle: the picture's right is -Z, one metre is 10 pixels at its depth of 5.
scene::Frame side_view() {
  scene::Frame frame;
  frame.camera.eye = {5, 1, 0};
  frame.camera.target = {0, 1, 0};
  frame.camera.fov_y = 2 * std::atan(0.4);  // 4 m at 5 m
  frame.origin = frame.camera.eye;
  frame.width = 60;
  frame.height = 40;
  frame.outfits.resize(1);
  for (glm::vec4& colour : frame.outfits[0].colours) colour = glm::vec4(1.0F);
  scene::FrameAgent agent;
  agent.position = glm::vec3(-frame.origin);
  agent.id = 5;
  frame.agents = {{agent}};
  return frame;
}

TEST(Truth, ATriangleIsWhereItIsByHand) {
  scene::Character character = scene::tiny_character();
  character.materials[0].base_colour = {0.5F, 0.25F, 0.125F, 1};
  const scene::Cast cast = cast_of(character, {-1});
  const scene::Frame frame = side_view();
  // Its upper edge is at row 10 and its foot at row 30, in the middle; at the top it reaches 5 pixels to the left.
  const std::vector<glm::dvec2> places = {{29, 10.5}, {29, 9.5}, {31, 12}, {29.9, 28}, {29, 28}, {27.4, 15}, {-3, 2}};
  const std::vector<TruthPoint> points = cast_points(cast, frame, places);
  const std::vector<uint32_t> ids = {5, 0, 0, 5, 0, 5, 0};
  for (size_t i = 0; i < ids.size(); ++i) EXPECT_EQ(points[i].id, ids[i]) << i;
  EXPECT_NEAR(points[0].depth, 5.0, 1e-12);
  EXPECT_EQ(points[1].depth, std::numeric_limits<double>::infinity());
  // Height 1.95, 0.1 along Z: of the corner (0, 2, 0.5) 0.2, of (0, 2, 0) what is left of 1.95 / 2.
  EXPECT_NEAR(points[0].weights.z, 0.2, 1e-12);
  EXPECT_NEAR(points[0].weights.y, 0.775, 1e-12);
  EXPECT_NEAR(points[0].normal.x, 1.0, 1e-12);
  const glm::dvec3 towards = glm::normalize(glm::dvec3(frame.light.direction));
  EXPECT_NEAR(points[0].linear.x, 0.5 * (0.25 + 0.75 * towards.x), 1e-7);
  EXPECT_NEAR(points[1].linear.x, static_cast<double>(frame.background.x), 1e-7);
  // From behind it is not there, unless its material has two sides.
  scene::Frame behind = frame;
  behind.camera.eye.x = -5;
  behind.origin = behind.camera.eye;
  behind.agents[0][0].position = glm::vec3(-behind.origin);
  const std::vector<glm::dvec2> mirrored = {{31, 10.5}};
  EXPECT_EQ(cast_points(cast, behind, mirrored)[0].id, 0U);
  character.materials[0].double_sided = true;
  const TruthPoint back = cast_points(cast_of(character, {-1}), behind, mirrored)[0];
  EXPECT_EQ(back.id, 5U);
  EXPECT_TRUE(back.back);
  EXPECT_NEAR(back.normal.x, -1.0, 1e-12) << "towards the eye";
}

TEST(Truth, CoverageIsAShareOfRaysAndNearAndFarCut) {
  const scene::Cast cast = cast_of(scene::tiny_character(), {-1});
  scene::Frame frame = side_view();
  const TruthPicture picture = cast_truth(cast, frame, {.side = 15});
  double pixels = 0;
  for (const double share : picture.coverage.data) pixels += share;
  EXPECT_NEAR(pixels, 50.0, 0.5) << "half of 20 x 5 pixels";
  EXPECT_EQ(*picture.ids.at(28, 12), 5U);
  EXPECT_EQ(*picture.materials.at(28, 12), 1U);
  EXPECT_EQ(*picture.materials.at(40, 12), 0U);
  frame.camera.near = 5.001;
  EXPECT_EQ(*cast_truth(cast, frame).ids.at(28, 12), 0U);
  frame.camera.near = 0.1;
  frame.camera.far = 4.999;
  EXPECT_EQ(*cast_truth(cast, frame).ids.at(28, 12), 0U);
  frame.camera.far = 5.001;
  EXPECT_EQ(*cast_truth(cast, frame).ids.at(28, 12), 5U);
  EXPECT_THROW(cast_truth(cast, frame, {.side = 2}), Error);
}

TEST(Truth, TheFirstOfTwoAtOnePlaceIsSeenAndTheGroundHidesWhatIsBelow) {
  const scene::Cast cast = cast_of(scene::tiny_character(), {-1});
  scene::Frame frame = side_view();
  frame.agents[0].push_back(frame.agents[0][0]);
  frame.agents[0][1].id = 2;
  EXPECT_EQ(*cast_truth(cast, frame).ids.at(28, 12), 5U);
  EXPECT_EQ(cast_points_at(cast, frame, 2, std::vector<glm::dvec2>{{28.5, 12.5}})[0].id, 2U);
  EXPECT_EQ(cast_points_at(cast, frame, 99, std::vector<glm::dvec2>{{28.5, 12.5}})[0].id, 0U);
  frame.ground = true;
  frame.ground_height = 0.8;
  const TruthPicture picture = cast_truth(cast, frame);
  EXPECT_EQ(*picture.ids.at(28, 12), 5U);
  EXPECT_EQ(*picture.ids.at(29, 25), 0U) << "0.45 m high";
  // The eye is 0.2 m above: a ray that falls by 0.04 + 0.05 a metre meets the ground in front of the triangle.
  EXPECT_NEAR(*picture.depth.at(29, 25), 0.2 / (5.5 * 0.02), 1e-9);
}

TEST(Truth, NoBitDependsOnThreads) {
  scene::Character character = scene::make_mannequin({.triangles = 500, .joints = 20, .normalise = {}});
  const scene::Cast cast = cast_of(std::move(character), {0});
  scene::Frame frame = side_view();
  frame.ground = true;
  frame.agents[0].clear();
  for (uint32_t i = 0; i < 30; ++i) {
    scene::FrameAgent agent;
    agent.position = glm::vec3(glm::dvec3(0.3 * (i % 5), 0, 0.4 * (i % 6) - 1.2) - frame.origin);
    agent.pose = cast.banks[0]->sample(0, 0.03 * i);
    agent.id = i + 1;
    frame.agents[0].push_back(agent);
  }
  const TruthPicture one = cast_truth(cast, frame, {.side = 3, .threads = 1});
  for (const unsigned threads : {2U, 5U}) {
    const TruthPicture several = cast_truth(cast, frame, {.side = 3, .threads = threads});
    EXPECT_EQ(several.ids, one.ids);
    EXPECT_EQ(several.depth, one.depth);
    EXPECT_EQ(several.normal, one.normal);
    EXPECT_EQ(several.linear, one.linear);
    EXPECT_EQ(several.coverage, one.coverage);
  }
  // Judged by itself nothing is wrong.
  ImageF depth(frame.width, frame.height, 1);
  for (size_t i = 0; i < depth.data.size(); ++i) depth.data[i] = static_cast<float>(one.depth.data[i]);
  const Judgement judgement = judge(cast, frame, one, {one.ids, depth, one.colour});
  EXPECT_EQ(judgement.wrong, 0U);
  EXPECT_GT(judgement.covered, 100U);
  EXPECT_EQ(judgement.worst_colour, 0);
  // A bound has all its terms, and grows with the resolution but for the grid's.
  const OutlineBound bound = outline_bound(cast, frame, 0, 0);
  EXPECT_DOUBLE_EQ(bound.snap, std::sqrt(2.0) / 256);
  scene::Frame large = frame;
  large.width *= 2;
  large.height *= 2;
  const OutlineBound twice = outline_bound(cast, large, 0, 0);
  EXPECT_DOUBLE_EQ(twice.snap, bound.snap);
  EXPECT_NEAR(twice.weights, 2 * bound.weights, 1e-12);
  EXPECT_NEAR(twice.single, 2 * bound.single, 1e-12);
}

TEST(TruthTexture, LevelsAndFiltersByHand) {
  scene::Texture texture;
  texture.image = Image8(4, 2, 4);
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 2; ++y) {
      std::fill_n(texture.image.at(x, y), 3, static_cast<uint8_t>(x % 2 == 0 ? 0 : 255));
      texture.image.at(x, y)[3] = static_cast<uint8_t>(y == 0 ? 0 : 200);
    }
  const TruthTexture truth(texture);
  ASSERT_EQ(truth.levels().size(), 3U);
  // Black and white halve in linear light: 0.5 is 188 in sRGB; alpha is linear as it is.
  EXPECT_EQ(truth.levels()[1].width, 2);
  EXPECT_EQ(truth.levels()[1].at(0, 0)[0], 188);
  EXPECT_EQ(truth.levels()[1].at(0, 0)[3], 100);
  // Magnified: a quarter of the way from the first texel's middle to the second's.
  const TextureFootprint near{{0.01, 0}, {0, 0.01}};
  EXPECT_NEAR(truth.sample({0.75 / 4, 0.25}, near).x, 0.25, 1e-12);
  // It repeats: half way over the edge lie the last and the first.
  EXPECT_NEAR(truth.sample({0, 0.25}, near).x, 0.5, 1e-12);
  // Two texels a sample are one level on; between levels the mean by the logarithm.
  EXPECT_DOUBLE_EQ(level_of({{0.5, 0}, {0, 0.1}}, 4, 2), 1.0);
  const double middle = truth.sample({0.25, 0.5}, {{0.5, 0}, {0, 0}}).x;
  EXPECT_NEAR(middle, 0.5, 0.005);
  EXPECT_NEAR(truth.sample({1.5 / 4, 0.25}, {{std::sqrt(2.0) / 4, 0}, {0, 0}}).x, 0.5 * (1.0 + middle), 1e-9);
}

TEST(TruthView, PlacesAndRaysAreInverse) {
  const scene::Frame frame = side_view();
  const View view(frame);
  const glm::dvec2 place(12.25, 33.5);
  const glm::dvec3 point = 7.5 * view.direction(place);
  EXPECT_NEAR(view.depth(point), 7.5, 1e-12);
  EXPECT_NEAR(view.place(point).x, place.x, 1e-10);
  EXPECT_NEAR(view.place(point).y, place.y, 1e-10);
  EXPECT_NEAR(view.pixel(), 0.02, 1e-12);
}

TEST(TruthSurface, LinesOfTheGroundByHand) {
  EXPECT_DOUBLE_EQ(line_coverage(0.0, 0.01, 0.015), 1.0);
  EXPECT_DOUBLE_EQ(line_coverage(0.5, 0.01, 0.015), 0.0);
  EXPECT_NEAR(line_coverage(0.015, 0.01, 0.015), 0.5, 1e-12);
  EXPECT_NEAR(line_coverage(0.3, 10.0, 0.015), 0.03, 1e-12);
}

}  // namespace
}  // namespace crowdbench::truth
