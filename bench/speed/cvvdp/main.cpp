// bench_cvvdp: what ColorVideoVDP costs, in seconds of process CPU, and how much memory a clip takes.
//
//   bench_cvvdp [THREADS [FRAMES]]    default: 1 thread, a clip of 40 frames
//
// Pictures are made, not decoded. A figure is the median of the rounds; a clip's, of its frames after the filter's
// length. Peak memory is the process's, of all that ran so far.
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "bench/speed/cpu_time.h"
#include "core/error.h"
#include "core/random.h"
#include "metrics/cvvdp/cvvdp.h"

namespace {

using namespace crowdbench;
using bench::cpu_seconds;
using bench::median;

constexpr double kFps = 30;

double peak_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

// Waves with noise.
Image8 made_picture(int width, int height, uint64_t seed) {
  Image8 out(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) {
        const double wave = std::sin(0.00002 * (c + 1) * x * y) + std::sin(0.01 * (x - c * y));
        const auto noise =
            static_cast<double>(random_below(seed, static_cast<uint64_t>(y * width + x), static_cast<uint64_t>(c), 16));
        out.at(x, y)[c] = static_cast<uint8_t>(std::clamp(120 + 50 * wave + noise, 0.0, 255.0));
      }
  return out;
}

void print_row(const std::string& what, const std::vector<double>& seconds, double jod) {
  fmt::print("{:<44} {:>8.3f} {:>8.3f} {:>8.3f} {:>9.0f} {:>8.3f}\n", what, median(seconds),
             *std::min_element(seconds.begin(), seconds.end()), *std::max_element(seconds.begin(), seconds.end()),
             peak_mib(), jod);
}

void time_pictures(int width, int height, unsigned threads, bool maps) {
  const Image8 reference = made_picture(width, height, 1);
  const Image8 test = made_picture(width, height, 2);
  metrics::CvvdpOptions options;
  options.threads = threads;
  if (maps) options.map = [](size_t, metrics::CvvdpMap&&) {};
  std::vector<double> seconds;
  double jod = 0;
  for (int round = 0; round < 7; ++round) {
    const double start = cpu_seconds();
    jod = metrics::cvvdp(reference, test, metrics::default_display(), options).jod;
    seconds.push_back(cpu_seconds() - start);
  }
  print_row(fmt::format("picture pair {} x {}{}", width, height, maps ? ", with its map" : ""), seconds, jod);
}

void time_clip(int width, int height, unsigned threads, int frames) {
  std::vector<Image8> pictures;
  for (uint64_t i = 0; i < 3; ++i) pictures.push_back(made_picture(width, height, i));
  metrics::CvvdpOptions options;
  options.threads = threads;
  options.fps = kFps;
  metrics::Cvvdp clip(metrics::default_display(), options);
  std::vector<double> seconds;
  for (int f = 0; f < frames; ++f) {
    const double start = cpu_seconds();
    clip.take(pictures[0], pictures[f % 8 == 3 ? 1 : 2]);
    if (f >= 10 || f + 1 == frames) seconds.push_back(cpu_seconds() - start);
  }
  print_row(fmt::format("frame pair {} x {}, clip of {} at {:g}/s", width, height, frames, kFps), seconds,
            clip.finish().jod);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const auto threads = static_cast<unsigned>(argc > 1 ? std::max(std::atoi(argv[1]), 0) : 1);
    const int frames = argc > 2 ? std::max(std::atoi(argv[2]), 1) : 40;
    fmt::print("{:<44} {:>8} {:>8} {:>8} {:>9} {:>8}\n", "process CPU seconds", "median", "least", "most", "peak MiB",
               "JOD");
    time_pictures(1920, 1080, threads, false);
    time_pictures(1920, 1080, threads, true);
    time_clip(1280, 720, threads, frames);
    time_clip(1280, 1024, threads, frames);
    time_clip(1920, 1080, threads, frames);
    return 0;
  } catch (const Error& error) {
    fmt::print(stderr, "bench_cvvdp: {}\n", error.what());
    return 2;
  }
}
