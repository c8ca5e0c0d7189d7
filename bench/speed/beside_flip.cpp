#include "bench/speed/contest.h"

#ifdef CROWDBENCH_BESIDE_FLIP
#include <FLIP.h>
#include <fmt/format.h>

#include <cstdlib>
#include <memory>

#include "core/colour.h"
#include "metrics/flip.h"

namespace crowdbench::bench {
namespace {

// That function's input is linear light in floats; ours is code values, and their decoding is in our time.
ImageF linear_of(const Image8& image) {
  ImageF out(image.width, image.height, 3);
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = static_cast<float>(srgb_to_linear(image.data[i] / 255.0));
  return out;
}

std::string evaluate(const ImageF& reference, const ImageF& test) {
  FLIP::Parameters parameters;
  float mean = 0;
  float* map = nullptr;
  FLIP::evaluate(reference.data.data(), test.data.data(), reference.width, reference.height, false, parameters, false,
                 true, mean, &map);
  delete[] map;
  return fmt::format("{:.4f}", mean);
}

}  // namespace

void add_flip(std::vector<Duel>& to, const Image8& reference, const Image8& test) {
  const auto linear = std::make_shared<std::pair<ImageF, ImageF>>(linear_of(reference), linear_of(test));
  to.push_back({"FLIP: its map and mean",
                {"ours",
                 [&] { return fmt::format("{:.4f}", metrics::flip_pooled(metrics::flip_map(reference, test)).mean); },
                 "",
                 {}},
                {"NVlabs/flip " CROWDBENCH_BESIDE_FLIP ", C++",
                 [linear] { return evaluate(linear->first, linear->second); },
                 "",
                 {}},
                2});
}

}  // namespace crowdbench::bench
#else
namespace crowdbench::bench {
void add_flip(std::vector<Duel>&, const Image8&, const Image8&) {}
}  // namespace crowdbench::bench
#endif
