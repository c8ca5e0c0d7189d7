// Whatever the number of threads, a score of two pictures has the same bits. Most scores work on one thread; those that
// share their work out are run on one, two and four.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "core/random.h"
#include "metrics/cvvdp/cvvdp.h"
#include "metrics/flip.h"
#include "metrics/hdr_flip.h"
#include "metrics/silhouette.h"
#include "test_paths.h"

namespace crowdbench::metrics {
namespace {

// More than one of FLIP's tiles in both directions, and more pixels than ColorVideoVDP gives to one thread.
constexpr int kWidth = 801;
constexpr int kHeight = 530;

uint64_t any_below(uint64_t seed, size_t i, uint64_t end) { return random_below(seed, i, 1, end); }

Image8 codes(uint64_t seed) {
  Image8 out(kWidth, kHeight, 3);
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = static_cast<uint8_t>(any_below(seed, i, 256));
  return out;
}

ImageF light(uint64_t seed) {
  ImageF out(kWidth, kHeight, 3);
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = static_cast<float>(any_below(seed, i, 4000)) / 500;
  return out;
}

// Blots: what a silhouette's boundary is measured on.
Mask blots(uint64_t seed) {
  Mask out(kWidth, kHeight, 1);
  for (size_t k = 0; k < 40; ++k) {
    const auto left = static_cast<int>(any_below(seed, 2 * k, kWidth - 40));
    const auto top = static_cast<int>(any_below(seed, 2 * k + 1, kHeight - 40));
    for (int y = top; y < top + 40; ++y)
      for (int x = left; x < left + 30; ++x) *out.at(x, y) = 255;
  }
  return out;
}

// Of one run: every number that comes out.
struct Bits {
  ImageF flip, hdr_flip, exposure, jod;
  CvvdpResult cvvdp;
  std::optional<BoundaryDistance> boundary;
};

Bits with_threads(unsigned threads) {
  Bits out;
  const Image8 a = codes(1);
  const Image8 b = codes(2);
  out.flip = flip_map(a, b, {kFlipPixelsPerDegree, threads});
  HdrFlipSettings settings;
  settings.flip.threads = threads;
  settings.exposures = 2;
  HdrFlip hdr = hdr_flip(light(3), light(4), settings);
  out.hdr_flip = std::move(hdr.map);
  out.exposure = std::move(hdr.exposure);
  CvvdpOptions options;
  options.threads = threads;
  options.map = [&](size_t, CvvdpMap&& map) { out.jod = std::move(map.jod); };
  out.cvvdp = cvvdp(a, b, default_display(), options);
  // OpenCV's workers are as many as the machine has cores.
  const int before = cv::getNumThreads();
  cv::setNumThreads(threads == 1 ? 1 : -1);
  out.boundary = boundary_distance(blots(5), blots(6));
  cv::setNumThreads(before);
  return out;
}

TEST(Threads, OneTwoAndFourGiveTheSameBits) {
  const Bits one = with_threads(1);
  EXPECT_LT(one.cvvdp.jod, 10);
  for (const unsigned threads : {2U, 4U}) {
    SCOPED_TRACE(threads);
    const Bits other = with_threads(threads);
    EXPECT_EQ(other.flip, one.flip);
    EXPECT_EQ(other.hdr_flip, one.hdr_flip);
    EXPECT_EQ(other.exposure, one.exposure);
    EXPECT_EQ(other.jod, one.jod);
    EXPECT_EQ(other.cvvdp.jod, one.cvvdp.jod);
    EXPECT_EQ(other.cvvdp.by_frame, one.cvvdp.by_frame);
    ASSERT_TRUE(other.boundary);
    EXPECT_EQ(other.boundary->mean, one.boundary->mean);
    EXPECT_EQ(other.boundary->p95, one.boundary->p95);
    EXPECT_EQ(other.boundary->greatest, one.boundary->greatest);
  }
}

// What shares its work out is known, so that nothing new does without a comparison: above, and in popping_test.cpp
// (discontinuity.cpp). popping.cpp hands a number on; picture_causes.cpp writes one element an agent.
TEST(Threads, NothingElseOfThisFolderUsesThem) {
  namespace fs = std::filesystem;
  const std::set<std::string> known = {"flip.cpp",        "discontinuity.cpp",  "picture_causes.cpp", "cvvdp/cvvdp.cpp",
                                       "cvvdp/frame.cpp", "cvvdp/opponent.cpp", "cvvdp/window.cpp"};
  const fs::path folder = fs::path(CROWDBENCH_SOURCE_DIR) / "metrics";
  std::set<std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string ending = entry.path().extension().string();
    if (ending != ".cpp" && ending != ".h") continue;
    std::ifstream file(entry.path());
    std::string text;
    for (std::string line; std::getline(file, line);) text += line.substr(0, line.find("//")) + '\n';
    for (const char* word : {"parallel_for(", "std::thread", "std::async", "omp parallel"})
      if (text.find(word) != std::string::npos) found.insert(entry.path().lexically_relative(folder).string());
  }
  EXPECT_EQ(found, known);
}

}  // namespace
}  // namespace crowdbench::metrics
