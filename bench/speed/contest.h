// What the speed programs let compete: calls that take turns, timed in process CPU.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "core/image.h"

namespace crowdbench::bench {

struct Contest {
  std::string name;
  std::function<std::string()> run;  // what is timed; returns what was found
  std::string found;
  std::vector<double> seconds;  // by round
};

// One call of ours and the same one of another library: both take the same pictures and give the same map or figure.
struct Duel {
  std::string what;
  Contest ours, theirs;
  double aim = 1;  // theirs / ours that we want at least
};

// Rounds in which all of them take their turns, the order turned by one each round, after one that is not timed.
void run_rounds(std::vector<Contest*> contests, int rounds);

// ---- libraries that are measured beside ours, each where the build found it (bench/CMakeLists.txt); nothing otherwise

// OpenCV's quality module: SSIM of one channel.
void add_opencv(std::vector<Duel>& to, const Image8& reference, const Image8& test);
// NVlabs/flip's FLIP.h: the map and its mean.
void add_flip(std::vector<Duel>& to, const Image8& reference, const Image8& test);
// halidecx/fcvvdp, a C port of ColorVideoVDP: one picture, and a frame of a clip.
void add_fcvvdp(std::vector<Duel>& to, const Image8& reference, const Image8& test);

}  // namespace crowdbench::bench
