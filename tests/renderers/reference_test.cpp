// Outside oracle: pictures of posed characters by another engine (three.js). Absent from a clone: the test says so.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/files.h"
#include "core/image_io.h"
#include "gl_test_support.h"
#include "scene/cast/cast.h"
#include "scene/gltf/gltf.h"
#include "test_paths.h"
#include "tests/support/sanitized.h"

namespace crowdbench::renderers {
namespace {

using Json = nlohmann::json;
using testing::context;

const std::filesystem::path kReference = std::filesystem::path(CROWDBENCH_SHARED_DIR) / "reference";
const std::filesystem::path kCharacters = std::filesystem::path(CROWDBENCH_SHARED_DIR) / "characters";

glm::dvec3 point(const Json& j) { return {j[0].get<double>(), j[1].get<double>(), j[2].get<double>()}; }

// Whether all pixels within 2 of (x, y) are set in both: the common mask, eroded.
bool deep_inside(const ImageU32& ids, const Image8& mask, int x, int y) {
  if (x < 2 || y < 2 || x + 2 >= ids.width || y + 2 >= ids.height) return false;
  for (int j = -2; j <= 2; ++j)
    for (int i = -2; i <= 2; ++i)
      if (ids.at(x + i, y + j)[0] == 0 || mask.at(x + i, y + j)[0] < 128) return false;
  return true;
}

class ReferenceGl : public testing::GlTest {};

TEST_F(ReferenceGl, MasksAndColoursAgreeWithAnotherEngine) {
  CROWDBENCH_SKIP_SANITIZED("the contract and GltfSharedPoses");
  if (!std::filesystem::exists(kReference / "cases.json")) GTEST_SKIP() << "no shared/reference beside this clone";
  const Json cases = Json::parse(read_text(kReference / "cases.json"))["cases"];
  ASSERT_GE(cases.size(), 18U);
  double iou_sum = 0;
  for (const Json& c : cases) {
    const std::string id = c["id"];
    SCOPED_TRACE(id);
    scene::LoadOptions load;
    load.normalise.height.reset();
    auto character = std::make_shared<const scene::Character>(
        scene::load_character(kCharacters / c["file"].get<std::string>(), load));
    const int clip = c["clip_index"].is_null() ? -1 : c["clip_index"].get<int>();
    scene::Cast cast;
    cast.banks.push_back(std::make_shared<const scene::PoseBank>(
        scene::PoseBank::exact(*character, clip, c["time"].get<double>(), /*raw=*/true)));
    cast.characters.push_back(character);
    cast.shares.push_back(1.0);
    scene::Frame frame = testing::frame_of_one(1, 0, c["size"][0], c["size"][1], c["fov"]);
    frame.camera.eye = point(c["eye"]);
    frame.camera.target = point(c["target"]);
    frame.camera.up = point(c["up"]);
    frame.camera.near = c["near"];
    frame.origin = frame.camera.eye;
    testing::add_agent(frame, cast, {0, 0, 0}, 1);
    Renderer renderer(context(), cast);
    const auto mesh = make_representation({.context = context(), .cast = cast}, parse_spec("mesh"));
    const Capture capture = renderer.capture(frame, *mesh);
    if (const char* folder = std::getenv("CROWDBENCH_TEST_OUT"))
      write_png(std::filesystem::path(folder) / (id + ".png"), capture.colour);

    const auto mask = std::get<Image8>(read_image(kReference / "masks" / (id + ".png")));
    const auto colour = std::get<Image8>(read_image(kReference / "colour" / (id + ".png")));
    ASSERT_EQ(mask.width, capture.ids.width);
    ASSERT_EQ(mask.height, capture.ids.height);
    uint64_t both = 0;
    uint64_t either = 0;
    uint64_t samples = 0;
    double difference = 0;
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x) {
        const bool ours = capture.ids.at(x, y)[0] != 0;
        const bool theirs = mask.at(x, y)[0] >= 128;
        both += ours && theirs ? 1U : 0U;
        either += ours || theirs ? 1U : 0U;
        if (!deep_inside(capture.ids, mask, x, y)) continue;
        for (int k = 0; k < 3; ++k)
          difference += std::abs(static_cast<int>(capture.colour.at(x, y)[k]) - static_cast<int>(colour.at(x, y)[k]));
        samples += 3;
      }
    const double iou = static_cast<double>(both) / static_cast<double>(either);
    const double mean_difference = difference / static_cast<double>(samples);
    iou_sum += iou;
    const bool small = id.find("small") != std::string::npos;
    EXPECT_GE(iou, small ? 0.99 : 0.995);
    EXPECT_LE(mean_difference, 3.0);
    std::printf("%-48s IoU %.5f  colour %.3f\n", id.c_str(), iou, mean_difference);
  }
  EXPECT_GE(iou_sum / static_cast<double>(cases.size()), 0.998);
  std::printf("mean IoU %.5f\n", iou_sum / static_cast<double>(cases.size()));
}

}  // namespace
}  // namespace crowdbench::renderers
