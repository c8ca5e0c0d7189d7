// bench_metrics: what each score of two pictures costs, in seconds of process CPU, what all of them cost together, and
// how that compares with other libraries on the same machine.
//
//   bench_metrics [REFERENCE TEST] [--rounds N] [--markdown FILE] [--tiny]    default: a made pair of 1920 x 1080, 5
//   rounds
//
// The scores take turns in one process, so that a busy machine slows all alike; a figure is the median of the rounds.
// Each score does its own work alone ("alone": luma, SSIM's map and the like included), then all scores share it
// ("together"). Float pictures are the linear light of the same pair. Decoding is not timed.
//
// Other libraries take their turns too, each beside the same work of ours, where the build was told of them
// (bench/CMakeLists.txt): OpenCV's quality module, NVlabs/flip (-DCROWDBENCH_BESIDE_FLIP=its src/cpp) and
// halidecx/fcvvdp (-DCROWDBENCH_BESIDE_FCVVDP=its src). The ratio is theirs over ours, paired by round, with a 95 %
// bootstrap interval. --markdown writes that table as a page (docs/metrics_speed.md). --tiny: small pictures.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "bench/speed/contest.h"
#include "core/colour.h"
#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "core/machine.h"
#include "core/random.h"
#include "core/statistics.h"
#include "metrics/registry.h"

namespace {

using namespace crowdbench;
using bench::Contest;
using bench::Duel;

constexpr uint64_t kSeed = 1;  // of the intervals

struct Arguments {
  std::vector<std::string> pictures;
  int rounds = 5;
  std::string markdown;
  bool tiny = false;
};

// Waves of all sizes with noise; the test is a little brighter, its noise another.
Image8 made_picture(uint64_t seed, int brighter, bool tiny) {
  Image8 out(tiny ? 240 : 1920, tiny ? 135 : 1080, 3);
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

Image8 read_picture(const std::string& path) {
  AnyImage image = read_image(path);
  if (auto* codes = std::get_if<Image8>(&image)) return std::move(*codes);
  throw Error(path, "is not a picture of 8 bits", "name a PNG");
}

std::string score_once(metrics::ScoreTable table, const metrics::ScoreInput& input) {
  metrics::Shared shared;
  const auto scored = metrics::score_pictures(table, input, shared);
  return scored.size() == 1 ? metrics::value_text(*scored[0].score, scored[0].result.value)
                            : fmt::format("{} scores", scored.size());
}

std::vector<Contest> score_contests(const metrics::ScoreInput& codes, const metrics::ScoreInput& floats) {
  std::vector<Contest> out;
  const metrics::ScoreTable all = metrics::scores();
  for (size_t i = 0; i < all.size(); ++i)
    for (const metrics::ScoreInput* input : {&codes, &floats})
      if (all[i]->compute != nullptr && (all[i]->needs & ~metrics::given(*input)) == 0)
        out.push_back(
            {std::string(all[i]->name), [all, i, input] { return score_once(all.subspan(i, 1), *input); }, "", {}});
  out.push_back({"all of code values, together", [all, &codes] { return score_once(all, codes); }, "", {}});
  return out;
}

void print_scores(const std::vector<Contest>& contests) {
  fmt::print("{:<34} {:>8} {:>8} {:>8}  {}\n", "", "median", "least", "most", "value");
  for (const Contest& contest : contests) {
    const auto [least, most] = std::ranges::minmax(contest.seconds);
    fmt::print("{:<34} {:>8.3f} {:>8.3f} {:>8.3f}  {}\n", contest.name, median(contest.seconds), least, most,
               contest.found);
  }
}

std::string duel_table(const std::vector<Duel>& duels) {
  std::string out =
      "| work | beside | ours, s | theirs, s | theirs / ours (95 %) | aim | ours finds | theirs finds "
      "|\n|---|---|--:|--:|--:|--:|--:|--:|\n";
  for (const Duel& duel : duels) {
    const MedianRatio ratio = median_of_ratios(duel.theirs.seconds, duel.ours.seconds, kSeed);
    out += fmt::format("| {} | {} | {:.3f} | {:.3f} | {:.2f} ({:.2f} to {:.2f}) | {:g} | {} | {} |\n", duel.what,
                       duel.theirs.name, median(duel.ours.seconds), median(duel.theirs.seconds), ratio.median,
                       ratio.interval.low, ratio.interval.high, duel.aim, duel.ours.found, duel.theirs.found);
  }
  return out;
}

std::string page(const std::string& head, const std::vector<Duel>& duels, const Contest& together) {
  return fmt::format(
      "# What scores cost beside other libraries\n\n"
      "Made by `bench_metrics --markdown`: {}; process CPU seconds, medians. Both sides take turns in one process, on "
      "the "
      "same pictures in memory; decoding of files is not timed. A ratio is paired by round: above 1 ours is the "
      "faster. "
      "FLIP here takes code values and decodes them within its time, NVlabs' takes linear light. ColorVideoVDP: "
      "display "
      "standard_4k on both sides; the two find different JODs of the same pictures, and why was not looked into (ours "
      "is "
      "held to the reference's own figures, tests/metrics). The row of a clip is a speed alone: nothing checks what "
      "either "
      "side finds there (-).\n\n{}\n"
      "All picture scores of one pair together, shared work done once: {:.3f} s (aim: under 2).\n\n"
      "How it was built: `cmake -DCROWDBENCH_BESIDE_FLIP=flip/src/cpp -DCROWDBENCH_BESIDE_FCVVDP=fcvvdp/src "
      "build/release`, Debian's libopencv-contrib-dev, `ninja -C build/release bench_metrics`. The sources of flip and "
      "fcvvdp are compiled by this build's compiler with flags of this build, not by their own build files: flip with "
      "-O3 "
      "and without OpenMP, fcvvdp (whose own build is Zig's) with -O3 -ffast-math -march=native and its AVX2 code. One "
      "thread each; their own builds may be faster or slower.\n",
      head, duel_table(duels), median(together.seconds));
}

void run(const Image8& reference, const Image8& test, const Arguments& arguments) {
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
  std::vector<Contest> contests = score_contests(codes, floats);
  std::vector<Duel> duels;
  bench::add_opencv(duels, reference, test);
  bench::add_flip(duels, reference, test);
  bench::add_fcvvdp(duels, reference, test);
  std::vector<Contest*> turns;
  for (Contest& contest : contests) turns.push_back(&contest);
  for (Duel& duel : duels) turns.insert(turns.end(), {&duel.ours, &duel.theirs});
  bench::run_rounds(turns, arguments.rounds);
  const std::string head =
      fmt::format("{} x {} pixels, {} rounds, {}, compiled by {}", reference.width, reference.height, arguments.rounds,
                  read_machine().cpu_model.value_or("a processor without a name"), __VERSION__);
  fmt::print("{}; process CPU seconds\n", head);
  print_scores(contests);
  if (!duels.empty()) fmt::print("\n{}", duel_table(duels));
  if (!arguments.markdown.empty()) write_file(arguments.markdown, page(head, duels, contests.back()));
}

Arguments parse(int argc, char** argv) {
  Arguments out;
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (word == "--tiny") {
      out.tiny = true;
    } else if (word == "--rounds" && i + 1 < argc) {
      out.rounds = std::atoi(argv[++i]);
    } else if (word == "--markdown" && i + 1 < argc) {
      out.markdown = argv[++i];
    } else if (!word.starts_with("--")) {
      out.pictures.emplace_back(word);
    } else {
      throw Error(std::string(word), "is not an option, or lacks its value", "see the top of bench/speed/main.cpp");
    }
  }
  if (out.pictures.size() != 2 && !out.pictures.empty()) throw Error("pictures", "are not two", "name both or none");
  if (out.rounds < 1 || out.rounds > 1000) throw Error("--rounds", "is not a number of 1 to 1000", "try 5");
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Arguments arguments = parse(argc, argv);
    if (arguments.pictures.empty())
      run(made_picture(1, 0, arguments.tiny), made_picture(2, 3, arguments.tiny), arguments);
    else
      run(read_picture(arguments.pictures[0]), read_picture(arguments.pictures[1]), arguments);
    return 0;
  } catch (const Error& error) {
    fmt::print(stderr, "bench_metrics: {}\n", error.what());
    return 2;
  }
}
