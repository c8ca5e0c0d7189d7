// Silhouettes: how well two masks cover each other, how far their boundaries lie apart, and the box around them.
//
// Of ids, so that colours, background and lighting have no say, nor has a display: lengths are pixels of the picture.
// Source: intersection over union is Jaccard's coefficient (1912), the distance Hausdorff's (1914); mean and percentile
// over both directions together are this project's choice. Limits: an intersection over union of a thin figure falls at
// once where it is displaced by a pixel, and of a fat one hides a missing hand; the greatest distance is one pixel's; a
// mask that is right says nothing of which part of the body covers it.
#pragma once
#include <algorithm>
#include <optional>

#include "metrics/difference.h"

namespace crowdbench::metrics {

// 255 where the id is not 0. ids: one channel, as Capture has them.
Mask mask_of(const ImageU32& ids);
// 255 where either mask is set. Throws Error when the sizes differ.
Mask union_of(const Mask& a, const Mask& b);

// |A and B| / |A or B|: 1 = equal, 0 = disjoint. Nothing when both are empty. Throws Error when the sizes differ.
std::optional<double> silhouette_iou(const Mask& a, const Mask& b);

// The pixels that exactly one of them covers: 0 = equal. Throws Error when the sizes differ.
uint64_t symmetric_difference(const Mask& a, const Mask& b);

// A mask's boundary: its pixels of which one of the four neighbours inside the picture is outside the mask (where the
// picture's edge cuts a figure there is no boundary). From every boundary pixel of A the Euclidean distance to the
// nearest one of B is taken, and from every one of B to the nearest of A; mean, 95th percentile (type 7) and greatest
// (the Hausdorff distance of the boundaries) are over all of these together. In pixels; 0 = equal. Nothing when either
// mask has no boundary. Throws Error when sizes differ.
struct BoundaryDistance {
  double mean = 0;
  double p95 = 0;
  double greatest = 0;
};
std::optional<BoundaryDistance> boundary_distance(const Mask& a, const Mask& b);

struct Box {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};
constexpr int kCropMargin = 5;
// The bounding box of A or B, widened by `margin` pixels on every side and cut to the picture. Nothing when both masks
// are empty.
std::optional<Box> crop_box(const Mask& a, const Mask& b, int margin = kCropMargin);

// The pixels of a box. It must lie inside.
template <typename T>
Image<T> crop(const Image<T>& image, const Box& box) {
  Image<T> out(box.width, box.height, image.channels);
  const auto count = static_cast<size_t>(box.width) * static_cast<size_t>(image.channels);
  for (int y = 0; y < box.height; ++y) {
    const T* row = image.at(box.x, box.y + y);
    std::copy(row, row + count, out.at(0, y));
  }
  return out;
}

}  // namespace crowdbench::metrics
