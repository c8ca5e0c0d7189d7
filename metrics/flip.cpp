#include "metrics/flip.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstdint>

#include "core/colour.h"
#include "core/parallel.h"
#include "metrics/flip_rows.h"
#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

// A work item. Wide and high enough that what is computed twice at its border is little, small enough that the rows
// that are in use stay in a core's cache.
constexpr int kTileWidth = 384;
constexpr int kTileHeight = 256;

struct Filters {
  Taps achromatic, red_green;
  std::array<Taps, 2> blue_yellow;
  Taps gaussian, first, second;
  int radius = 0;  // the largest

  explicit Filters(double pixels_per_degree) {
    const ContrastFilters contrast = contrast_filters(pixels_per_degree);
    const FeatureFilters feature = feature_filters(pixels_per_degree);
    achromatic = trimmed(contrast.achromatic);
    red_green = trimmed(contrast.red_green);
    blue_yellow = {trimmed(contrast.blue_yellow[0]), trimmed(contrast.blue_yellow[1])};
    gaussian = feature.gaussian;
    first = feature.first;
    second = feature.second;
    for (const Taps* taps : {&achromatic, &red_green, &blue_yellow[0], &blue_yellow[1], &gaussian})
      radius = std::max(radius, static_cast<int>(taps->size()) - 1);
  }
};

// Filtered along x: what one row of one picture leaves for the filters along y.
enum Plane7 : uint8_t { kAchromatic, kRedGreen, kBlueYellow0, kBlueYellow1, kGaussian, kFirst, kSecond, kPlanes };

// One tile of both pictures, from top to bottom. Rows that were filtered along x are kept in a ring.
class Tile {
 public:
  Tile(const Filters& filters, int width, int height, int left, int right)
      : filters_(filters),
        width_(width),
        height_(height),
        left_(left),
        right_(right),
        count_(static_cast<size_t>(right - left)),
        stride_(in_blocks(count_)),
        window_(2 * filters.radius + 1),
        ring_(2 * size_t{kPlanes} * static_cast<size_t>(window_) * stride_),
        source_(6 * padded()),
        work_(8 * stride_),
        pointers_(static_cast<size_t>(window_)) {}

  // Filters row y of picture p (0 the reference, 1 the test) along x.
  void take(size_t p, int y, const LinearRow& linear);
  // Everything of row y whose neighbours were taken. Each has in_blocks(right - left) elements.
  void finish(int y, float* colour, float* edge, float* point, float* error);

 private:
  // Room for the tile's columns, those of the filters on both sides, and the rest of a block.
  size_t padded() const { return stride_ + 2 * static_cast<size_t>(filters_.radius) + kRowBlock; }
  float* ring_row(size_t p, size_t plane, int y) {
    return ring_.data() +
           ((p * kPlanes + plane) * static_cast<size_t>(window_) + static_cast<size_t>(y % window_)) * stride_;
  }
  float* work(size_t i) { return work_.data() + i * stride_; }
  // The pointers to a row of one picture's plane and to its neighbours; the first and the last row are repeated.
  const float* const* column(size_t p, Plane7 plane, int y) {
    for (int i = -filters_.radius; i <= filters_.radius; ++i)
      pointers_[static_cast<size_t>(i + filters_.radius)] = ring_row(p, plane, std::clamp(y + i, 0, height_ - 1));
    return pointers_.data() + filters_.radius;
  }
  // The same along a row.
  const float* const* along(const float* first) {
    for (size_t i = 0; i < pointers_.size(); ++i) pointers_[i] = first + i;
    return pointers_.data() + filters_.radius;
  }

  const Filters& filters_;
  int width_, height_, left_, right_;
  size_t count_, stride_;
  int window_;
  std::vector<float> ring_, source_, work_;
  std::vector<const float*> pointers_;
};

void Tile::take(size_t p, int y, const LinearRow& linear) {
  const int radius = filters_.radius;
  const int from = std::max(0, left_ - radius);
  const int to = std::min(width_, right_ + radius);
  const auto missing_left = static_cast<size_t>(from - (left_ - radius));
  const auto inside = static_cast<size_t>(to - from);
  const size_t whole = count_ + 2 * static_cast<size_t>(radius);
  const std::array<float*, 3> rgb = {&source_[0], &source_[padded()], &source_[2 * padded()]};
  const std::array<float*, 3> colour = {&source_[3 * padded()], &source_[4 * padded()], &source_[5 * padded()]};
  linear(y, from, to, rgb[0] + missing_left, rgb[1] + missing_left, rgb[2] + missing_left);
  for (float* row : rgb) {
    std::fill(row, row + missing_left, row[missing_left]);
    std::fill(row + missing_left + inside, row + whole, row[missing_left + inside - 1]);
  }
  opponents_of(rgb[0], rgb[1], rgb[2], colour, whole);
  filter_even(filters_.achromatic, along(colour[0]), ring_row(p, kAchromatic, y), count_);
  filter_even(filters_.gaussian, pointers_.data() + radius, ring_row(p, kGaussian, y), count_);
  filter_odd(filters_.first, pointers_.data() + radius, ring_row(p, kFirst, y), count_);
  filter_even(filters_.second, pointers_.data() + radius, ring_row(p, kSecond, y), count_);
  filter_even(filters_.red_green, along(colour[1]), ring_row(p, kRedGreen, y), count_);
  filter_even(filters_.blue_yellow[0], along(colour[2]), ring_row(p, kBlueYellow0, y), count_);
  filter_even(filters_.blue_yellow[1], pointers_.data() + radius, ring_row(p, kBlueYellow1, y), count_);
}

void Tile::finish(int y, float* colour, float* edge, float* point, float* error) {
  std::array<OpponentRow, 2> seen{};
  for (size_t p = 0; p < 2; ++p) {
    float* const out[3] = {work(3 * p), work(3 * p + 1), work(3 * p + 2)};
    filter_even(filters_.achromatic, column(p, kAchromatic, y), out[0], count_);
    filter_even(filters_.red_green, column(p, kRedGreen, y), out[1], count_);
    filter_even(filters_.blue_yellow[0], column(p, kBlueYellow0, y), out[2], count_);
    filter_even(filters_.blue_yellow[1], column(p, kBlueYellow1, y), work(6), count_);
    add_row(work(6), out[2], count_);
    seen[p] = {out[0], out[1], out[2]};
  }
  colour_difference(seen[0], seen[1], colour, count_);
  for (size_t p = 0; p < 2; ++p) {
    filter_even(filters_.gaussian, column(p, kFirst, y), work(4 * p), count_);
    filter_even(filters_.gaussian, column(p, kSecond, y), work(4 * p + 2), count_);
    filter_odd(filters_.first, column(p, kGaussian, y), work(4 * p + 1), count_);
    filter_even(filters_.second, pointers_.data() + filters_.radius, work(4 * p + 3), count_);
  }
  length_difference({work(0), work(1)}, {work(4), work(5)}, edge, count_);
  length_difference({work(2), work(3)}, {work(6), work(7)}, point, count_);
  combine_errors(colour, edge, point, error, count_);
}

// Every code value's linear light.
template <typename T>
const std::vector<float>& linear_values() {
  static const std::vector<float> values = [] {
    constexpr size_t kMost = std::numeric_limits<T>::max();
    std::vector<float> out(kMost + 1);
    for (size_t i = 0; i <= kMost; ++i)
      out[i] = static_cast<float>(srgb_to_linear(static_cast<double>(i) / static_cast<double>(kMost)));
    return out;
  }();
  return values;
}

template <typename T>
LinearRow rows_of(const Image<T>& image) {
  const float* linear = linear_values<T>().data();
  return [&image, linear](int y, int first, int last, float* red, float* green, float* blue) {
    const T* p = image.at(first, y);
    const int g = image.channels >= 3 ? 1 : 0;
    for (int x = first; x < last; ++x, p += image.channels) {
      *red++ = linear[p[0]];
      *green++ = linear[p[g]];
      *blue++ = linear[p[2 * g]];
    }
  };
}

// Error bits order values of 0 or above as the values do: the upper half of them names one of 65536 drawers.
constexpr size_t kDrawers = size_t{1} << 16U;
size_t drawer_of(float value) { return std::bit_cast<uint32_t>(value) >> 16U; }

// The value at which the running sum of the ascending errors exceeds `goal`. sums: of each drawer.
double weighted_quantile(const ImageF& map, const std::vector<double>& sums, double goal) {
  double sum = 0;
  size_t drawer = 0;
  while (drawer + 1 < kDrawers && sum + sums[drawer] <= goal) sum += sums[drawer++];
  std::vector<float> within;
  for (const float value : map.data)
    if (drawer_of(value) == drawer) within.push_back(value);
  std::sort(within.begin(), within.end());
  for (const float value : within) {
    sum += value;
    if (sum > goal) return value;
  }
  return within.empty() ? 0 : within.back();
}

}  // namespace

ImageF flip_map(int width, int height, const LinearRow& reference, const LinearRow& test, const FlipSettings& settings,
                FlipStages* stages) {
  assert(settings.pixels_per_degree >= 1);
  const Filters filters(settings.pixels_per_degree);
  ImageF map(width, height, 1);
  if (stages) stages->colour = stages->edge = stages->point = map;
  const int columns = (width + kTileWidth - 1) / kTileWidth;
  const int rows = (height + kTileHeight - 1) / kTileHeight;
  const auto one_tile = [&](size_t i) {
    const int left = static_cast<int>(i) % columns * kTileWidth;
    const int top = static_cast<int>(i) / columns * kTileHeight;
    const int right = std::min(width, left + kTileWidth);
    const int bottom = std::min(height, top + kTileHeight);
    Tile tile(filters, width, height, left, right);
    const size_t stride = in_blocks(static_cast<size_t>(right - left));
    std::vector<float> out(4 * stride);
    const std::array<float*, 4> parts = {&out[0], &out[stride], &out[2 * stride], &out[3 * stride]};
    int next = std::max(0, top - filters.radius);
    for (int y = top; y < bottom; ++y) {
      for (; next <= std::min(height - 1, y + filters.radius); ++next) {
        tile.take(0, next, reference);
        tile.take(1, next, test);
      }
      tile.finish(y, parts[0], parts[1], parts[2], parts[3]);
      std::copy_n(parts[3], right - left, map.at(left, y));
      if (!stages) continue;
      std::copy_n(parts[0], right - left, stages->colour.at(left, y));
      std::copy_n(parts[1], right - left, stages->edge.at(left, y));
      std::copy_n(parts[2], right - left, stages->point.at(left, y));
    }
  };
  const auto tiles = static_cast<size_t>(columns) * static_cast<size_t>(rows);
  parallel_for(tiles, tiles == 1 ? 1 : settings.threads, one_tile);
  return map;
}

ImageF flip_map(const Image8& reference, const Image8& test, const FlipSettings& settings, FlipStages* stages) {
  require_same_size(reference, test);
  return flip_map(reference.width, reference.height, rows_of(reference), rows_of(test), settings, stages);
}

ImageF flip_map(const Image16& reference, const Image16& test, const FlipSettings& settings, FlipStages* stages) {
  require_same_size(reference, test);
  return flip_map(reference.width, reference.height, rows_of(reference), rows_of(test), settings, stages);
}

FlipPooled flip_pooled(const ImageF& map) {
  assert(!map.empty());
  FlipPooled out;
  std::vector<double> sums(kDrawers);
  float least = map.data[0];
  float most = map.data[0];
  double sum = 0;
  for (const float value : map.data) {
    sums[drawer_of(value)] += value;
    sum += value;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  out.mean = sum / static_cast<double>(map.data.size());
  out.min = least;
  out.max = most;
  // The drawers' own total: a sum in another order may differ in its last bits.
  double total = 0;
  for (const double one : sums) total += one;
  if (total == 0) return out;
  out.q1 = weighted_quantile(map, sums, 0.25 * total);
  out.weighted_median = weighted_quantile(map, sums, 0.5 * total);
  out.q3 = weighted_quantile(map, sums, 0.75 * total);
  return out;
}

}  // namespace crowdbench::metrics
