#include "metrics/silhouette.h"

#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/statistics.h"
#include "metrics/intermediates.h"
#include "metrics/mat.h"
#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

// 0 on the boundary and 255 elsewhere, as the distance transform wants it; `count` becomes the boundary's pixels.
Image8 boundary_of(const Mask& mask, size_t& count) {
  Image8 out(mask.width, mask.height, 1);
  count = 0;
  const auto outside = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < mask.width && y < mask.height && *mask.at(x, y) == 0;
  };
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      const bool boundary =
          *mask.at(x, y) != 0 && (outside(x - 1, y) || outside(x + 1, y) || outside(x, y - 1) || outside(x, y + 1));
      *out.at(x, y) = boundary ? 0 : 255;
      count += boundary ? 1 : 0;
    }
  }
  return out;
}

// Appends the distance to the nearest boundary pixel of `to`, for every boundary pixel of `from`.
void append_distances(const Image8& from, const Image8& to, std::vector<double>& distances) {
  Image<float> distance(to.width, to.height, 1);
  cv::Mat out = view(distance);
  cv::distanceTransform(view(to), out, cv::DIST_L2, cv::DIST_MASK_PRECISE, CV_32F);
  for (size_t i = 0; i < from.data.size(); ++i)
    if (from.data[i] == 0)
      distances.push_back(out.at<float>(static_cast<int>(i / static_cast<size_t>(from.width)),
                                        static_cast<int>(i % static_cast<size_t>(from.width))));
}

}  // namespace

Mask mask_of(const ImageU32& ids) {
  Mask mask(ids.width, ids.height, 1);
  for (size_t i = 0; i < mask.data.size(); ++i)
    mask.data[i] = ids.data[i * static_cast<size_t>(ids.channels)] ? 255 : 0;
  return mask;
}

Mask union_of(const Mask& a, const Mask& b) {
  require_same_size(a, b);
  Mask out(a.width, a.height, 1);
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = (a.data[i] | b.data[i]) != 0 ? 255 : 0;
  return out;
}

std::optional<double> silhouette_iou(const Mask& a, const Mask& b) {
  require_same_size(a, b);
  size_t both = 0;
  size_t either = 0;
  for (size_t i = 0; i < a.data.size(); ++i) {
    both += a.data[i] != 0 && b.data[i] != 0 ? 1 : 0;
    either += a.data[i] != 0 || b.data[i] != 0 ? 1 : 0;
  }
  if (either == 0) return std::nullopt;
  return static_cast<double>(both) / static_cast<double>(either);
}

uint64_t symmetric_difference(const Mask& a, const Mask& b) {
  require_same_size(a, b);
  uint64_t count = 0;
  for (size_t i = 0; i < a.data.size(); ++i) count += (a.data[i] != 0) != (b.data[i] != 0) ? 1 : 0;
  return count;
}

std::optional<BoundaryDistance> boundary_distance(const Mask& a, const Mask& b) {
  require_same_size(a, b);
  size_t count_a = 0;
  size_t count_b = 0;
  const Image8 boundary_a = boundary_of(a, count_a);
  const Image8 boundary_b = boundary_of(b, count_b);
  if (count_a == 0 || count_b == 0) return std::nullopt;
  std::vector<double> distances;
  distances.reserve(count_a + count_b);
  append_distances(boundary_a, boundary_b, distances);
  append_distances(boundary_b, boundary_a, distances);
  double sum = 0;
  for (const double d : distances) sum += d;
  return BoundaryDistance{sum / static_cast<double>(distances.size()), quantile(distances, 0.95),
                          *std::max_element(distances.begin(), distances.end())};
}

std::optional<Box> crop_box(const Mask& a, const Mask& b, int margin) {
  require_same_size(a, b);
  int left = a.width;
  int right = -1;
  int top = a.height;
  int bottom = -1;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      if (*a.at(x, y) == 0 && *b.at(x, y) == 0) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = y;
    }
  }
  if (right < 0) return std::nullopt;
  left = std::max(left - margin, 0);
  top = std::max(top - margin, 0);
  right = std::min(right + margin, a.width - 1);
  bottom = std::min(bottom + margin, a.height - 1);
  return Box{left, top, right - left + 1, bottom - top + 1};
}

namespace {

struct Boundary {
  std::optional<BoundaryDistance> of;
};

constexpr std::string_view kNothingDrawn = "nothing is drawn in either picture";
constexpr std::string_view kNoBoundary = "a silhouette has no boundary";

ScoreResult overlap(const ScoreInput& input, Shared& shared) {
  const SilhouettePair& pair = silhouettes(input, shared);
  ScoreResult result;
  result.value = silhouette_iou(pair.reference, pair.test);
  if (!result.value) result.reason = kNothingDrawn;
  return result;
}

// An agent covers a pixel in both when both carry its id.
std::optional<double> overlap_of_agent(const ScoreInput& input, Shared&, const AgentPixels& agent) {
  size_t both = 0;
  for (const auto& [x, y] : agent.pixels) both += *input.reference.ids->at(x, y) == *input.test.ids->at(x, y) ? 1 : 0;
  return static_cast<double>(both) / static_cast<double>(agent.pixels.size());
}

double difference_of_agent(const ScoreInput& input, const AgentPixels& agent) {
  uint64_t count = 0;
  for (const auto& [x, y] : agent.pixels) count += *input.reference.ids->at(x, y) != *input.test.ids->at(x, y) ? 1 : 0;
  return static_cast<double>(count);
}

std::optional<double> hausdorff_of_agent(const ScoreInput& input, Shared&, const AgentPixels& agent) {
  const SilhouettePair pair = masks_of_agent(input, agent);
  const auto distance = boundary_distance(pair.reference, pair.test);
  return distance ? std::optional(distance->greatest) : std::nullopt;
}

ScoreResult boundary(const ScoreInput& input, Shared& shared, double BoundaryDistance::*member) {
  const std::optional<BoundaryDistance>& distance = silhouette_boundary(input, shared);
  if (!distance) return absent(std::string(kNoBoundary));
  ScoreResult result;
  result.value = (*distance).*member;
  return result;
}

}  // namespace

SilhouettePair masks_of_agent(const ScoreInput& input, const AgentPixels& agent) {
  int left = input.reference.ids->width;
  int top = input.reference.ids->height;
  int right = 0;
  int bottom = 0;
  for (const auto& [x, y] : agent.pixels) {
    left = std::min(left, x);
    right = std::max(right, x);
    top = std::min(top, y);
    bottom = std::max(bottom, y);
  }
  left = std::max(left - 1, 0);
  top = std::max(top - 1, 0);
  right = std::min(right + 1, input.reference.ids->width - 1);
  bottom = std::min(bottom + 1, input.reference.ids->height - 1);
  const Mask empty(right - left + 1, bottom - top + 1, 1);
  SilhouettePair pair{empty, empty};
  for (const auto& [x, y] : agent.pixels) {
    *pair.reference.at(x - left, y - top) = *input.reference.ids->at(x, y) == agent.id ? 255 : 0;
    *pair.test.at(x - left, y - top) = *input.test.ids->at(x, y) == agent.id ? 255 : 0;
  }
  return pair;
}

const SilhouettePair& silhouettes(const ScoreInput& input, Shared& shared) {
  return shared.get<SilhouettePair>([&] {
    return SilhouettePair{mask_of(*input.reference.ids), mask_of(*input.test.ids)};
  });
}

const std::optional<BoundaryDistance>& silhouette_boundary(const ScoreInput& input, Shared& shared) {
  return shared
      .get<Boundary>([&] {
        const SilhouettePair& pair = silhouettes(input, shared);
        return Boundary{boundary_distance(pair.reference, pair.test)};
      })
      .of;
}

extern const Score score_silhouette_iou = {
    .name = "silhouette_iou",
    .title = "silhouette IoU",
    .column = "IoU",
    .unit = "",
    .direction = Direction::higher_is_better,
    .digits = 4,
    .least = 0,
    .greatest = 1,
    .needs = kNeedsIds,
    .uses = kInTables | kHeadline | kCharted,
    .computes = "pixels that both cover over pixels that either covers",
    .source = "",
    .absence = kNothingDrawn,
    .compute = overlap,
    .by_agent = overlap_of_agent,
};

extern const Score score_boundary_px_mean = {
    .name = "boundary_px_mean",
    .title = "boundary distance",
    .column = "bound",
    .unit = "px",
    .direction = Direction::lower_is_better,
    .digits = 3,
    .least = 0,
    .greatest = std::numeric_limits<double>::infinity(),
    .needs = kNeedsIds,
    .uses = kInTables,
    .computes = "mean distance from each boundary pixel of one silhouette to the nearest of the other, from both sides",
    .source = "",
    .absence = kNoBoundary,
    .compute = [](const ScoreInput& input, Shared& shared) { return boundary(input, shared, &BoundaryDistance::mean); },
};

extern const Score score_boundary_px_p95 = {
    .name = "boundary_px_p95",
    .title = "95th percentile of the boundary distance",
    .column = "b p95",
    .unit = "px",
    .direction = Direction::lower_is_better,
    .digits = 2,
    .least = 0,
    .greatest = std::numeric_limits<double>::infinity(),
    .needs = kNeedsIds,
    .uses = kInTables,
    .computes = "95th percentile of the same distances",
    .source = "",
    .absence = kNoBoundary,
    .compute = [](const ScoreInput& input, Shared& shared) { return boundary(input, shared, &BoundaryDistance::p95); },
};

extern const Score score_silhouette_hausdorff_px = {
    .name = "silhouette_hausdorff_px",
    .title = "Hausdorff distance of the silhouettes",
    .column = "Hausdorff",
    .unit = "px",
    .direction = Direction::lower_is_better,
    .digits = 2,
    .least = 0,
    .greatest = std::numeric_limits<double>::infinity(),
    .needs = kNeedsIds,
    .computes = "greatest of the same distances",
    .source = "",
    .absence = kNoBoundary,
    .compute = [](const ScoreInput& input,
                  Shared& shared) { return boundary(input, shared, &BoundaryDistance::greatest); },
    .by_agent = hausdorff_of_agent,
};

extern const Score score_silhouette_difference_px = {
    .name = "silhouette_difference_px",
    .title = "symmetric difference of the silhouettes",
    .column = "sym diff",
    .unit = "px",
    .direction = Direction::lower_is_better,
    .digits = 0,
    .least = 0,
    .greatest = std::numeric_limits<double>::infinity(),
    .needs = kNeedsIds,
    .computes = "count of the pixels that exactly one covers",
    .source = "",
    .compute =
        [](const ScoreInput& input, Shared& shared) {
          const SilhouettePair& pair = silhouettes(input, shared);
          ScoreResult result;
          result.value = static_cast<double>(symmetric_difference(pair.reference, pair.test));
          return result;
        },
    .by_agent = [](const ScoreInput& input, Shared&, const AgentPixels& agent) -> std::optional<double> {
      return difference_of_agent(input, agent);
    },
};

}  // namespace crowdbench::metrics
