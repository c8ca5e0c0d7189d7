// Based on: Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli, "Image quality assessment: from error visibility to
// structural similarity", IEEE TIP 13(4), 2004; Z. Wang, E. P. Simoncelli, A. C. Bovik, "Multi-scale structural
// similarity for image quality assessment", Asilomar 2003.
// Differs from the source: no automatic downsampling before SSIM. A negative mean contrast, which has no real power,
// counts as 0 in MS-SSIM.
#include "metrics/ssim.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "metrics/intermediates.h"
#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

constexpr double kC1 = (0.01 * 255) * (0.01 * 255);
constexpr double kC2 = (0.03 * 255) * (0.03 * 255);
constexpr double kSigma = 1.5;
constexpr std::array<double, 5> kScaleWeights = {0.0448, 0.2856, 0.3001, 0.2363, 0.1333};

// The window's half: weight at distance 0..5, the eleven adding up to 1.
using Kernel = std::array<double, kSsimRadius + 1>;

Kernel gaussian() {
  Kernel kernel{};
  double sum = 0;
  for (int i = 0; i <= kSsimRadius; ++i) {
    kernel[static_cast<size_t>(i)] = std::exp(-i * i / (2 * kSigma * kSigma));
    sum += (i == 0 ? 1 : 2) * kernel[static_cast<size_t>(i)];
  }
  for (double& k : kernel) k /= sum;
  return kernel;
}

// out[x] = the window's sum over in[x .. x + 10].
void filter_row(const Kernel& k, const double* __restrict in, double* __restrict out, size_t count) {
  for (size_t x = 0; x < count; ++x) {
    const double* c = in + x + kSsimRadius;
    out[x] = k[0] * c[0] + k[1] * (c[-1] + c[1]) + k[2] * (c[-2] + c[2]) + k[3] * (c[-3] + c[3]) +
             k[4] * (c[-4] + c[4]) + k[5] * (c[-5] + c[5]);
  }
}

using Rows = std::array<const double*, kSsimWindow>;

void filter_column(const Kernel& k, const Rows& r, double* __restrict out, size_t count) {
  for (size_t x = 0; x < count; ++x)
    out[x] = k[0] * r[5][x] + k[1] * (r[4][x] + r[6][x]) + k[2] * (r[3][x] + r[7][x]) + k[3] * (r[2][x] + r[8][x]) +
             k[4] * (r[1][x] + r[9][x]) + k[5] * (r[0][x] + r[10][x]);
}

// SSIM and its contrast term of one row of windows, from the filtered a, b, a^2 + b^2 and a b. Only the sum of the two
// variances is in the formula, so that four filtered planes suffice.
void combine_row(const double* __restrict mean_a, const double* __restrict mean_b, const double* __restrict squares,
                 const double* __restrict product, double* __restrict similarity, double* __restrict contrast,
                 size_t count) {
  for (size_t x = 0; x < count; ++x) {
    const double ab = mean_a[x] * mean_b[x];
    const double aa_bb = mean_a[x] * mean_a[x] + mean_b[x] * mean_b[x];
    const double c = (2 * (product[x] - ab) + kC2) / (squares[x] - aa_bb + kC2);
    contrast[x] = c;
    similarity[x] = (2 * ab + kC1) / (aa_bb + kC1) * c;
  }
}

// Mean of 2 x 2 pixels; a missing row or column is the last one again.
Plane halved(const Plane& in) {
  Plane out((in.width + 1) / 2, (in.height + 1) / 2, 1);
  for (int y = 0; y < out.height; ++y) {
    const double* upper = in.at(0, 2 * y);
    const double* lower = in.at(0, std::min(2 * y + 1, in.height - 1));
    double* o = out.at(0, y);
    for (size_t x = 0; x < static_cast<size_t>(in.width / 2); ++x)
      o[x] = 0.25 * (upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1]);
    if (in.width % 2 == 1) o[out.width - 1] = 0.5 * (upper[in.width - 1] + lower[in.width - 1]);
  }
  return out;
}

}  // namespace

std::optional<Ssim> ssim(const Plane& a, const Plane& b) {
  require_same_size(a, b);
  if (a.width < kSsimWindow || a.height < kSsimWindow) return std::nullopt;
  static const Kernel kernel = gaussian();
  const auto width = static_cast<size_t>(a.width);
  const size_t count = width - (kSsimWindow - 1);
  // Eleven horizontally filtered rows of each of the four planes, reused in turn.
  constexpr size_t kPlanes = 4;
  std::vector<double> ring(kPlanes * kSsimWindow * count);
  const auto ring_row = [&](size_t plane, size_t row) {
    return ring.data() + (plane * kSsimWindow + row % kSsimWindow) * count;
  };
  std::vector<double> squares(width);
  std::vector<double> product(width);
  std::vector<double> filtered(kPlanes * count);
  std::vector<double> contrast(count);

  Ssim out;
  out.map = Plane(a.width - 2 * kSsimRadius, a.height - 2 * kSsimRadius, 1);
  double similarity_sum = 0;
  double contrast_sum = 0;
  for (int y = 0; y < a.height; ++y) {
    const double* pa = a.at(0, y);
    const double* pb = b.at(0, y);
    for (size_t x = 0; x < width; ++x) {
      squares[x] = pa[x] * pa[x] + pb[x] * pb[x];
      product[x] = pa[x] * pb[x];
    }
    const auto row = static_cast<size_t>(y);
    const std::array<const double*, kPlanes> sources = {pa, pb, squares.data(), product.data()};
    for (size_t p = 0; p < kPlanes; ++p) filter_row(kernel, sources[p], ring_row(p, row), count);
    if (y < kSsimWindow - 1) continue;
    const size_t top = row - (kSsimWindow - 1);
    for (size_t p = 0; p < kPlanes; ++p) {
      Rows rows{};
      for (size_t i = 0; i < rows.size(); ++i) rows[i] = ring_row(p, top + i);
      filter_column(kernel, rows, filtered.data() + p * count, count);
    }
    double* similarity = out.map.at(0, static_cast<int>(top));
    combine_row(filtered.data(), filtered.data() + count, filtered.data() + 2 * count, filtered.data() + 3 * count,
                similarity, contrast.data(), count);
    for (size_t x = 0; x < count; ++x) {
      similarity_sum += similarity[x];
      contrast_sum += contrast[x];
    }
  }
  out.mean = similarity_sum / static_cast<double>(out.map.pixels());
  out.contrast = contrast_sum / static_cast<double>(out.map.pixels());
  return out;
}

std::optional<double> ms_ssim(const Plane& a, const Plane& b, const Ssim* first) {
  require_same_size(a, b);
  if (a.width < kMsSsimSmallest || a.height < kMsSsimSmallest) return std::nullopt;
  double product = 1;
  Plane small_a;
  Plane small_b;
  for (size_t scale = 0; scale < kScaleWeights.size(); ++scale) {
    if (scale > 0) {
      small_a = halved(scale == 1 ? a : small_a);
      small_b = halved(scale == 1 ? b : small_b);
    }
    const bool last = scale + 1 == kScaleWeights.size();
    double term = 0;
    if (scale == 0 && first) {
      term = first->contrast;
    } else {
      // 176 halved four times is 11: every scale has a window.
      const auto here = scale == 0 ? ssim(a, b) : ssim(small_a, small_b);
      term = last ? here->mean : here->contrast;
    }
    product *= std::pow(std::max(term, 0.0), kScaleWeights[scale]);
  }
  return product;
}

namespace {

struct Similarity {
  std::optional<Ssim> of;
};

constexpr std::string_view kTooSmall = "a side is below the window's 11 pixels";
static_assert(kSsimWindow == 11);
constexpr std::string_view kTooSmallForScales = "a side is below 176 pixels, the least for five scales";
static_assert(kMsSsimSmallest == 176);
constexpr std::string_view kNoWindow = "no window lies in the region";

ScoreMap map_of(const Ssim& ssim) { return {ssim.map, kSsimRadius, kSsimRadius, 1, 0, "", true}; }

ScoreResult mean_ssim(const ScoreInput& input, Shared& shared) {
  const std::optional<Ssim>& s = similarity(input, shared);
  if (!s) return absent(std::string(kTooSmall));
  ScoreResult result;
  result.value = s->mean;
  if (input.maps) result.map = map_of(*s);
  return result;
}

ScoreResult region_ssim(const ScoreInput& input, Shared& shared) {
  const std::optional<Ssim>& s = similarity(input, shared);
  if (!s) return absent(std::string(kTooSmall));
  require_same_size(luma_pair(input, shared).reference, *input.region);
  double sum = 0;
  size_t count = 0;
  for (int y = 0; y < s->map.height; ++y)
    for (int x = 0; x < s->map.width; ++x)
      if (*input.region->at(x + kSsimRadius, y + kSsimRadius) != 0) {
        sum += *s->map.at(x, y);
        ++count;
      }
  if (count == 0) return absent(std::string(kNoWindow));
  ScoreResult result;
  result.value = sum / static_cast<double>(count);
  return result;
}

std::optional<double> ssim_of_agent(const ScoreInput& input, Shared& shared, const AgentPixels& agent) {
  const std::optional<Ssim>& s = similarity(input, shared);
  return s ? mean_over(s->map, kSsimRadius, kSsimRadius, agent) : std::nullopt;
}

ScoreResult five_scales(const ScoreInput& input, Shared& shared) {
  const LumaPair& luma = luma_pair(input, shared);
  const std::optional<Ssim>& s = similarity(input, shared);
  const std::optional<double> value = ms_ssim(luma.reference, luma.test, s ? &*s : nullptr);
  if (!value) return absent(std::string(kTooSmallForScales));
  ScoreResult result;
  result.value = value;
  return result;
}

}  // namespace

const std::optional<Ssim>& similarity(const ScoreInput& input, Shared& shared) {
  return shared
      .get<Similarity>([&] {
        const LumaPair& luma = luma_pair(input, shared);
        return Similarity{ssim(luma.reference, luma.test)};
      })
      .of;
}

extern const Score score_ssim = {
    .name = "ssim",
    .title = "SSIM",
    .column = "SSIM",
    .unit = "",
    .direction = Direction::higher_is_better,
    .digits = 4,
    .least = -1,
    .greatest = 1,
    .needs = kNeedsCodes,
    .uses = kInTables | kHeadline | kByCause,
    .computes = "structural similarity of luma, 11 x 11 Gaussian window, mean over the windows inside",
    .source = "Wang et al. 2004",
    .absence = kTooSmall,
    .map_file = "ssim_map",
    .compute = mean_ssim,
    .colours = grey_colours,
};

extern const Score score_ssim_union = {
    .name = "ssim_union",
    .title = "SSIM in the figure",
    .column = "SSIM fig.",
    .unit = "",
    .direction = Direction::higher_is_better,
    .digits = 4,
    .least = -1,
    .greatest = 1,
    .needs = kNeedsCodes | kNeedsRegion,
    .scope = Scope::region,
    .uses = kInTables | kCharted,
    .computes = "ssim, mean over the windows whose centre is in the region",
    .source = "Wang et al. 2004",
    .absence = kTooSmall,
    .compute = region_ssim,
    .by_agent = ssim_of_agent,
};

extern const Score score_ms_ssim = {
    .name = "ms_ssim",
    .title = "MS-SSIM",
    .column = "MS-SSIM",
    .unit = "",
    .direction = Direction::higher_is_better,
    .digits = 4,
    .least = 0,
    .greatest = 1,
    .needs = kNeedsCodes,
    .computes = "product of contrast over five scales and of the last scale's ssim, each to its power",
    .source = "Wang, Simoncelli and Bovik 2003",
    .absence = kTooSmallForScales,
    .compute = five_scales,
};

}  // namespace crowdbench::metrics
