#include "metrics/temporal.h"

#include <cassert>
#include <cmath>
#include <vector>

#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

// Luma of the test less luma of the reference. Differences over time of T - R are those of T less those of R.
std::vector<Plane> error_planes(std::span<const Image8> reference, std::span<const Image8> test) {
  assert(reference.size() == test.size());
  std::vector<Plane> planes;
  for (size_t t = 0; t < reference.size(); ++t) {
    require_same_size(reference[t], test[t]);
    require_same_size(reference[t], reference[0]);
    const Plane r = luma601(reference[t]);
    planes.push_back(luma601(test[t]));
    for (size_t i = 0; i < r.data.size(); ++i) planes.back().data[i] -= r.data[i];
  }
  return planes;
}

}  // namespace

std::optional<double> flicker(std::span<const Image8> reference, std::span<const Image8> test,
                              std::span<const Mask> silhouettes) {
  assert(silhouettes.empty() || silhouettes.size() == reference.size());
  const std::vector<Plane> error = error_planes(reference, test);
  for (const Mask& mask : silhouettes) require_same_size(mask, error[0]);
  double sum = 0;
  uint64_t count = 0;
  for (size_t t = 2; t < error.size(); ++t) {
    for (size_t i = 0; i < error[t].data.size(); ++i) {
      if (!silhouettes.empty() &&
          (silhouettes[t].data[i] | silhouettes[t - 1].data[i] | silhouettes[t - 2].data[i]) == 0)
        continue;
      sum += std::abs(error[t].data[i] - 2 * error[t - 1].data[i] + error[t - 2].data[i]);
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return sum / static_cast<double>(count);
}

std::vector<double> step_difference(std::span<const Image8> reference, std::span<const Image8> test) {
  const std::vector<Plane> error = error_planes(reference, test);
  std::vector<double> steps;
  for (size_t t = 1; t < error.size(); ++t) {
    double sum = 0;
    for (size_t i = 0; i < error[t].data.size(); ++i) sum += std::abs(error[t].data[i] - error[t - 1].data[i]);
    steps.push_back(sum / static_cast<double>(error[t].data.size()));
  }
  return steps;
}

}  // namespace crowdbench::metrics
