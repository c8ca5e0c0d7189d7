#include <cmath>
#include <vector>

#include "metrics/intermediates.h"
#include "metrics/sizes.h"
#include "metrics/ssim.h"

namespace crowdbench::metrics {
namespace {

constexpr double kStability = 170;

// Mean of 2 x 2 pixels; a missing row or column is 0, as in the authors' definition.
Plane halved_with_zeros(const Plane& in) {
  Plane out((in.width + 1) / 2, (in.height + 1) / 2, 1);
  const std::vector<double> zeros(static_cast<size_t>(in.width), 0.0);
  for (int y = 0; y < out.height; ++y) {
    const double* upper = in.at(0, 2 * y);
    const double* lower = 2 * y + 1 < in.height ? in.at(0, 2 * y + 1) : zeros.data();
    double* o = out.at(0, y);
    for (size_t x = 0; x < static_cast<size_t>(in.width / 2); ++x)
      o[x] = 0.25 * (upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1]);
    if (in.width % 2 == 1) o[out.width - 1] = 0.25 * (upper[in.width - 1] + lower[in.width - 1]);
  }
  return out;
}

// Prewitt's operator over 3, zeros beyond the border.
Plane gradient_magnitude(const Plane& in) {
  Plane out(in.width, in.height, 1);
  const auto width = static_cast<size_t>(in.width);
  const std::vector<double> zeros(width + 2, 0.0);
  // Both with a zero at each end.
  std::vector<double> sums(width + 2, 0.0);         // of three rows
  std::vector<double> differences(width + 2, 0.0);  // upper row less lower row
  for (int y = 0; y < in.height; ++y) {
    const double* upper = y > 0 ? in.at(0, y - 1) : zeros.data();
    const double* middle = in.at(0, y);
    const double* lower = y + 1 < in.height ? in.at(0, y + 1) : zeros.data();
    for (size_t x = 0; x < width; ++x) {
      sums[x + 1] = upper[x] + middle[x] + lower[x];
      differences[x + 1] = upper[x] - lower[x];
    }
    double* o = out.at(0, y);
    for (size_t x = 0; x < width; ++x) {
      const double horizontal = (sums[x + 2] - sums[x]) / 3;
      const double vertical = (differences[x] + differences[x + 1] + differences[x + 2]) / 3;
      o[x] = std::sqrt(horizontal * horizontal + vertical * vertical);
    }
  }
  return out;
}

}  // namespace

double gmsd(const Plane& a, const Plane& b) {
  require_same_size(a, b);
  const Plane ga = gradient_magnitude(halved_with_zeros(a));
  const Plane gb = gradient_magnitude(halved_with_zeros(b));
  const size_t count = ga.data.size();
  if (count < 2) return 0;
  std::vector<double> similarity(count);
  double sum = 0;
  for (size_t i = 0; i < count; ++i) {
    const double u = ga.data[i];
    const double v = gb.data[i];
    similarity[i] = (2 * u * v + kStability) / (u * u + v * v + kStability);
    sum += similarity[i];
  }
  const double mean = sum / static_cast<double>(count);
  double squares = 0;
  for (const double s : similarity) squares += (s - mean) * (s - mean);
  return std::sqrt(squares / static_cast<double>(count - 1));
}

extern const Score score_gmsd = {
    .name = "gmsd",
    .title = "GMSD",
    .column = "GMSD",
    .unit = "",
    .direction = Direction::lower_is_better,
    .digits = 4,
    .least = 0,
    .greatest = 1,
    .needs = kNeedsCodes,
    .computes = "standard deviation of the similarity of gradient magnitudes, on luma halved",
    .source = "Xue et al. 2014",
    .compute =
        [](const ScoreInput& input, Shared& shared) {
          const LumaPair& luma = luma_pair(input, shared);
          ScoreResult result;
          result.value = gmsd(luma.reference, luma.test);
          return result;
        },
};

}  // namespace crowdbench::metrics
