// bench_metrics: what each score of two pictures costs, in seconds of process CPU, and what all of them cost together.
//
//   bench_metrics [REFERENCE TEST]    default: a made pair of 1920 x 1080
//
// The scores take turns in one process, so that a busy machine slows all alike; a figure is the median of the rounds.
// Each score does its own work alone ("alone": luma, SSIM's map and the like included), then all scores share it
// ("together"). Float pictures are the linear light of the same pair. Where it was built with OpenCV's quality module,
// that library's SSIM takes its turns too. Decoding is not timed.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "bench/speed/cpu_time.h"
#include "core/colour.h"
#include "core/error.h"
#include "core/image_io.h"
#include "core/random.h"
#include "metrics/registry.h"
#ifdef CROWDBENCH_OPENCV_QUALITY
#include <opencv2/quality/qualityssim.hpp>

#include "metrics/mat.h"
#endif

namespace {

using namespace crowdbench;
using bench::cpu_seconds;

constexpr int kRounds = 5;

// Waves of all sizes with noise; the test is a little brighter, its noise another.
Image8 made_picture(uint64_t seed, int brighter) {
  Image8 out(1920, 1080, 3);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const double wave = std::sin(0.00002 * (c + 1) * x * y) + std::sin(0.01 * (x - c * y));
        const auto noise = static_cast<double>(
            random_below(seed, static_cast<uint64_t>(y * out.width + x), static_cast<uint64_t>(c), 16));
        out.at(x, y)[c] = static_cast<uint8_t>(std::clamp(120 + 50 * wave + noise + brighter, 0.0, 255.0));
      }
  return out;
}

ImageF linear_of(const Image8& image) {
  ImageF out(image.width, image.height, image.channels);
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = static_cast<float>(srgb_to_linear(image.data[i] / 255.0));
  return out;
}

Image8 read_picture(const char* path) {
  AnyImage image = read_image(path);
  if (auto* codes = std::get_if<Image8>(&image)) return std::move(*codes);
  throw Error(path, "is not a picture of 8 bits", "name a PNG");
}

#ifdef CROWDBENCH_OPENCV_QUALITY
Image8 green_of(const Image8& image) {
  Image8 out(image.width, image.height, 1);
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = image.data[i * static_cast<size_t>(image.channels) + 1];
  return out;
}
#endif

struct Contest {
  std::string name;
  std::function<std::string()> run;  // returns what was found
  std::string found;
  std::vector<double> seconds;
};

std::string score_once(metrics::ScoreTable table, const metrics::ScoreInput& input) {
  metrics::Shared shared;
  const auto scored = metrics::score_pictures(table, input, shared);
  return scored.size() == 1 ? metrics::value_text(*scored[0].score, scored[0].result.value)
                            : fmt::format("{} scores", scored.size());
}

void run(const Image8& reference, const Image8& test) {
  const ImageF linear_reference = linear_of(reference);
  const ImageF linear_test = linear_of(test);
  metrics::ScoreInput codes;
  codes.reference.codes = &reference;
  codes.test.codes = &test;
  codes.display = &metrics::default_display();
  codes.display_is_default = true;
  metrics::ScoreInput floats;
  floats.reference.linear = &linear_reference;
  floats.test.linear = &linear_test;
  std::vector<Contest> contests;
  const metrics::ScoreTable all = metrics::scores();
  for (size_t i = 0; i < all.size(); ++i)
    for (const metrics::ScoreInput* input : {&codes, &floats})
      if (all[i]->compute != nullptr && (all[i]->needs & ~metrics::given(*input)) == 0)
        contests.push_back(
            {std::string(all[i]->name), [&all, i, input] { return score_once(all.subspan(i, 1), *input); }, "", {}});
  contests.push_back({"all of code values, together", [&] { return score_once(all, codes); }, "", {}});
#ifdef CROWDBENCH_OPENCV_QUALITY
  // Of the three colours, as that module is used, and of one channel, as ours is of luma.
  const auto opencv_ssim = [](const Image8& a, const Image8& b) {
    const cv::Scalar s = cv::quality::QualitySSIM::compute(metrics::view(a), metrics::view(b), cv::noArray());
    double sum = 0;
    for (int c = 0; c < a.channels; ++c) sum += s[c];
    return fmt::format("{:.4f}", sum / a.channels);
  };
  const Image8 green_reference = green_of(reference);
  const Image8 green_test = green_of(test);
  contests.push_back({"OpenCV quality SSIM, R G B", [&] { return opencv_ssim(reference, test); }, "", {}});
  contests.push_back(
      {"OpenCV quality SSIM, one channel", [&] { return opencv_ssim(green_reference, green_test); }, "", {}});
#endif
  for (int round = 0; round < kRounds; ++round)
    for (Contest& contest : contests) {
      const double start = cpu_seconds();
      contest.found = contest.run();
      contest.seconds.push_back(cpu_seconds() - start);
    }
  fmt::print("{} x {} pixels, process CPU seconds, {} rounds\n{:<34} {:>8} {:>8} {:>8}  {}\n", reference.width,
             reference.height, kRounds, "", "median", "least", "most", "value");
  for (Contest& contest : contests) {
    std::sort(contest.seconds.begin(), contest.seconds.end());
    fmt::print("{:<34} {:>8.3f} {:>8.3f} {:>8.3f}  {}\n", contest.name, contest.seconds[kRounds / 2],
               contest.seconds.front(), contest.seconds.back(), contest.found);
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc == 3)
      run(read_picture(argv[1]), read_picture(argv[2]));
    else
      run(made_picture(1, 0), made_picture(2, 3));
    return 0;
  } catch (const Error& error) {
    fmt::print(stderr, "bench_metrics: {}\n", error.what());
    return 2;
  }
}
