#include "metrics/not_finite.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "metrics/intermediates.h"

namespace crowdbench::metrics {
namespace {

struct Reason {
  std::string text;
};

}  // namespace

NotFinite not_finite(const ImageF& image) {
  NotFinite out;
  const int colours = image.channels >= 3 ? 3 : 1;
  for (int y = 0; y < image.height; ++y) {
    const float* p = image.at(0, y);
    for (int x = 0; x < image.width; ++x, p += image.channels) {
      if (std::all_of(p, p + colours, [](float v) { return std::isfinite(v); })) continue;
      if (out.pixels() == 0) {
        out.x = x;
        out.y = y;
      }
      ++(std::any_of(p, p + colours, [](float v) { return std::isnan(v); }) ? out.nan : out.infinite);
    }
  }
  return out;
}

std::string not_finite_text(const NotFinite& found, const char* which) {
  const auto pixels = [](uint64_t count) { return fmt::format("{} pixel{}", count, count == 1 ? "" : "s"); };
  std::string text = fmt::format("the {} has ", which);
  if (found.nan > 0) text += fmt::format("{} that {} not a number", pixels(found.nan), found.nan == 1 ? "is" : "are");
  if (found.nan > 0 && found.infinite > 0) text += fmt::format(" and {} infinite", found.infinite);
  if (found.nan == 0)
    text += fmt::format("{} that {} infinite", pixels(found.infinite), found.infinite == 1 ? "is" : "are");
  return text + fmt::format(", the first at ({}, {})", found.x, found.y);
}

std::string not_finite_text(const NotFinite& reference, const NotFinite& test) {
  std::string text;
  if (reference.pixels() > 0) text = not_finite_text(reference, "reference");
  if (test.pixels() > 0) text += (text.empty() ? "" : "; ") + not_finite_text(test, "test");
  return text;
}

const std::string& not_finite_reason(const ScoreInput& input, Shared& shared) {
  return shared
      .get<Reason>(
          [&] { return Reason{not_finite_text(not_finite(*input.reference.linear), not_finite(*input.test.linear))}; })
      .text;
}

}  // namespace crowdbench::metrics
