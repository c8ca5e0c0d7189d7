// Malformed and hostile FBX and COLLADA files: each is answered by a sound character or by one line.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "assimp_walker.h"
#include "core/random.h"
#include "tests/support/driver.h"
#include "tests/support/sanitized.h"
#include "tests/support/scratch_folder.h"

namespace crowdbench::scene {
namespace {

namespace fs = std::filesystem;
using support::ScratchFolder;
using namespace test;

class AssimpHostile : public testing::TestWithParam<AssimpFormat> {};
INSTANTIATE_TEST_SUITE_P(Both, AssimpHostile, testing::Values(AssimpFormat::fbx, AssimpFormat::collada),
                         [](const auto& test) { return test.param == AssimpFormat::fbx ? "Fbx" : "Collada"; });

TEST(AssimpFaults, FaultsAreNamedAsTheFileNamesThem) {
  const std::string far = changed(text_of(AssimpFormat::fbx), "20,0,180", "20,0,1e22");
  const std::string error = error_of([&] { load_text(far, AssimpFormat::fbx); });
  EXPECT_NE(error.find("walker.fbx: positions of mesh body: element"), std::string::npos) << error;
  EXPECT_EQ(error.find("glTF validator"), std::string::npos) << error;
  LoadOptions options = as_is();
  options.hide = {"cape"};
  EXPECT_NE(
      error_of([&] { load_text(text_of(AssimpFormat::fbx), AssimpFormat::fbx, options); }).find("no node named cape"),
      std::string::npos);
}

TEST_P(AssimpHostile, LimitsHold) {
  const std::string text = text_of(GetParam());
  const auto refused = [&](const std::string& fragment, const auto& set) {
    LoadOptions options = as_is();
    set(options.limits);
    const std::string error = error_of([&] { load_text(text, GetParam(), options); });
    EXPECT_NE(error.find(fragment), std::string::npos) << error;
  };
  refused("nodes, more than the limit of 3", [](GltfLimits& l) { l.nodes = 3; });
  refused("triangles, more than the limit of 4", [](GltfLimits& l) { l.triangles = 4; });
  refused("animation numbers, more than the limit of 20", [](GltfLimits& l) { l.keys = 20; });
  refused("clips, more than the limit of 0", [](GltfLimits& l) { l.clips = 0; });
  refused("clips times nodes, more than the limit of 4", [](GltfLimits& l) { l.clip_nodes = 4; });
  refused("bytes, more than the limit of 100", [](GltfLimits& l) { l.file_bytes = 100; });
  refused("the limit is 4", [](GltfLimits& l) { l.vertices = 4; });
  refused("2 joints and rigid meshes, the limit is 1", [](GltfLimits& l) { l.joints = 1; });
  refused("the limit is 1 a side", [](GltfLimits& l) { l.image_side = 1; });
}

// A sound character or one line.
void expect_answer(const std::string& text, AssimpFormat format) {
  try {
    const Character c = load_text(text, format);
    for (const glm::dvec3& p : posed(c, c.placement.default_clip, 0.3)) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    EXPECT_EQ(error.where.rfind("walker.", 0), 0U) << error.what();
    EXPECT_FALSE(error.wrong.empty());
  }
}

// Eight of its bits are others.
std::string damaged(std::string text, uint32_t which) {
  for (uint32_t k = 0; k < 8; ++k) {
    const uint64_t r = random_bits(7, which, k);
    text[r % text.size()] ^= static_cast<char>(1U << (r >> 60 & 7));
  }
  return text;
}

TEST_P(AssimpHostile, CutShortAnywhereItIsAnswered) {
  const std::string text = text_of(GetParam());
  for (size_t part = 0; part < 16; ++part) expect_answer(text.substr(0, text.size() * part / 16), GetParam());
  EXPECT_NE(error_of([&] { load_text("", GetParam()); }), "no error");
}

TEST_P(AssimpHostile, DamagedAnywhereItIsAnswered) {
  const std::string text = text_of(GetParam());
  const uint32_t tries = support::kSanitized ? 10 : 60;
  for (uint32_t i = 0; i < tries; ++i) expect_answer(damaged(text, i), GetParam());
}

TEST(AssimpFaults, ABinaryFileThatIsCutOrDamagedIsAnswered) {
  const std::vector<uint8_t> bytes = read_file(kData / "walker_binary.fbx");
  const std::string text(bytes.begin(), bytes.end());
  for (size_t part = 0; part < 16; ++part) expect_answer(text.substr(0, text.size() * part / 16), AssimpFormat::fbx);
  const uint32_t tries = support::kSanitized ? 10 : 60;
  for (uint32_t i = 0; i < tries; ++i) expect_answer(damaged(text, i), AssimpFormat::fbx);
}

TEST(AssimpFaults, AFileThatGoesRoundInCirclesIsRefused) {
  // A node that is its own child, which Assimp follows until its stack ends.
  const std::string circle = changed(text_of(AssimpFormat::collada), "<scale>-1 1 1</scale>",
                                     "<scale>-1 1 1</scale><instance_node url=\"#hips\"/>");
  const std::string error = error_of([&] { load_text(circle, AssimpFormat::collada); });
  EXPECT_NE(error.find("walker.dae: "), std::string::npos) << error;
  EXPECT_EQ(error.find('\n'), std::string::npos);
}

// --- lists that disagree ---

struct Broken {
  AssimpFormat format;
  const char* from;
  const char* to;
  const char* said;  // after the file's name
};

constexpr const char* kPolylist = "5 0 5 4 0 4</p>";

// What Assimp would leave out in silence, take modulo something, or crash on.
const std::vector<Broken>& broken() {
  constexpr AssimpFormat fbx = AssimpFormat::fbx;
  constexpr AssimpFormat dae = AssimpFormat::collada;
  static const std::vector<Broken> all = {
      {fbx, "2,3,5,-5", "2,3,77,-5", "mesh body: index 6 of PolygonVertexIndex names vertex 77 of 6"},
      {fbx, "2,3,5,-5", "2,3,5,-78", "mesh body: index 7 of PolygonVertexIndex names vertex 77 of 6"},
      {fbx, "2,3,5,-5", "2,3,5,4", "mesh body: PolygonVertexIndex ends within a polygon"},
      {fbx, "Vertices: *18", "Vertices: *4294967295", "mesh body: Vertices says 4294967295 numbers and holds 18"},
      {fbx, "*9 {\n a: 0,0,0,", "*8 {\n a: 0,0,", "mesh hat: Vertices holds 8 numbers, which is not three a vertex"},
      {fbx, "*16 {\n a: 0,0,1,0,", "*14 {\n a: 1,0,", "mesh body: UV has 7 elements for 8 corners"},
      {fbx, "a: 2,3,4,5", "a: 2,3,4,555", "mesh body: bone chest: index 3 of Indexes names vertex 555 of 6"},
      {fbx, "*4 {\n a: 0.5,0.5,1,1", "*3 {\n a: 0.5,0.5,1", "mesh body: bone chest has 4 indices and 3 weights"},
      {fbx, "*5 {\n a: 0,-20,", "*4 {\n a: -20,", "a curve of node hips has 5 key times and 4 values"},
      {fbx, "0,11546539500,", "0,23093079001,", "a curve of node hips: key 2 of KeyTime lies before the one in front"},
      {fbx, "C: \"OO\",11,0\n", "C: \"OO\",11,12\n", "node hips is its own ancestor"},
      {dae, kPolylist, "77 0 5 4 0 4</p>", "mesh body: index 18 of <p> of polylist names VERTEX 77 of the 6 in body-p"},
      {dae, kPolylist, "-3 0 5 4 0 4</p>", "mesh body: index 18 of <p> of polylist names VERTEX -3 of the 6 in body-p"},
      {dae, kPolylist, "4294967296 0 5 4 0 4</p>", "mesh body: index 18 of <p> of polylist names VERTEX 4294967296"},
      {dae, kPolylist, "5 9 5 4 0 4</p>", "mesh body: index 19 of <p> of polylist names NORMAL 9 of the 1 in body-n"},
      {dae, kPolylist, "5 0 5</p>", "mesh body: <p> of polylist holds 21 indices, and 8 corners take 24"},
      {dae, "<vcount>4 4<", "<vcount>4<", "mesh body: <vcount> has 1 numbers for the 2 of polylist"},
      {dae, "array\" count=\"18\"", "array\" count=\"4294967295\"",
       "mesh body: float_array body-p-array says 4294967295 values and holds 18"},
      {dae, "body-p-array\" count=\"6\"", "body-p-array\" count=\"60\"",
       "mesh body: the accessor of body-p takes 60 elements of 3 from 18 values"},
      {dae, "count=\"6\" stride=\"3\"", "count=\"6\" stride=\"0\"", "mesh body: the accessor of body-p has stride 0"},
      {dae, "<v>0 0", "<v>99 0", "skin body-skin: index 0 of <v> of vertex_weights names JOINT 99 of the 2 in skin-j"},
      {dae, "<v>0 0", "<v>0 99", "skin body-skin: index 1 of <v> of vertex_weights names WEIGHT 99 of the 2 in skin-w"},
      {dae, "0 0.25 0.5", "0 1e300 0.5", "animation walk-hips: key time 1 of walk-hips-i is 1e300"},
      {dae, "0 0.25 0.5", "0 0.6 0.5", "animation walk-hips: key time 2 of walk-hips-i lies before the one in front"},
  };
  return all;
}

TEST(AssimpFaults, ListsThatDisagreeAreRefusedByMeshListAndPlace) {
  for (const Broken& one : broken()) {
    const std::string name = one.format == AssimpFormat::fbx ? "walker.fbx: " : "walker.dae: ";
    const std::string error = error_of([&] { load_text(changed(text_of(one.format), one.from, one.to), one.format); });
    EXPECT_EQ(error.rfind(name + one.said, 0), 0U) << one.to << ": " << error;
    EXPECT_NE(error.find("; export the character again"), std::string::npos) << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
}

TEST(AssimpFaults, BinaryListsThatDisagreeAreRefusedAlike) {
  std::vector<uint8_t> bytes = read_file(kData / "walker_binary.fbx");
  const std::string key = "PolygonVertexIndex";
  const auto at = std::search(bytes.begin(), bytes.end(), key.begin(), key.end());
  ASSERT_NE(at, bytes.end());
  const auto list = at - bytes.begin() + static_cast<std::ptrdiff_t>(key.size());
  ASSERT_EQ(bytes[static_cast<size_t>(list)], 'i');
  ASSERT_EQ(bytes[static_cast<size_t>(list) + 5], 0) << "packed";
  bytes[static_cast<size_t>(list) + 13 + 1] = 3;  // the second byte of the first index
  const std::string error = error_of([&] { load_text(std::string(bytes.begin(), bytes.end()), AssimpFormat::fbx); });
  EXPECT_NE(error.find("index 0 of PolygonVertexIndex names vertex 76"), std::string::npos) << error;
}

TEST(AssimpFaults, WhatAssimpComplainsOfIsAWarning) {
  const std::string text = changed(text_of(AssimpFormat::fbx), "Materials: *1 {\n a: 0", "Materials: *1 {\n a: 7");
  EXPECT_TRUE(has_warning(load_text(text, AssimpFormat::fbx), "FBX: material index out of bounds"));
}

// --- without the module or its library ---

TEST(AssimpFaults, WithoutItsLibraryOneLineNamesThePackage) {
  CROWDBENCH_SKIP_SANITIZED("nothing else, but it starts a driver of its own");
  if (!support::driver_is_built()) GTEST_SKIP() << "needs the driver";
  ScratchFolder folder;
  fs::copy_file(program_directory() / "crowdbench", folder / "crowdbench");
  const std::string command =
      fmt::format("'{}' inspect '{}' 2>&1", (folder / "crowdbench").string(), (kData / "walker.fbx").string());
  support::Outcome out = support::run_shell(command);
  EXPECT_EQ(out.status, 2);
  EXPECT_NE(out.text.find("crowdbench_assimp.so: reading FBX and COLLADA needs this module"), std::string::npos)
      << out.text;
  std::vector<uint8_t> module = read_file(program_directory() / "crowdbench_assimp.so");
  const std::string name = "libassimp.so.";
  const auto at = std::search(module.begin(), module.end(), name.begin(), name.end());
  ASSERT_NE(at, module.end());
  at[static_cast<std::ptrdiff_t>(name.size())] = 'x';  // a library that no machine has
  write_file(folder / "crowdbench_assimp.so", module.data(), module.size());
  out = support::run_shell(command);
  EXPECT_EQ(out.status, 2);
  EXPECT_NE(out.text.find("install Debian's package libassimp5"), std::string::npos) << out.text;
  EXPECT_EQ(std::count(out.text.begin(), out.text.end(), '\n'), 1) << out.text;
}

}  // namespace
}  // namespace crowdbench::scene
