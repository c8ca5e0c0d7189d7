// Based on: ColorVideoVDP (Mantiuk et al. 2024). A row of a band needs 13 rows of the masker's blur, so that a strip is
// worked through from top to bottom with the last rows kept: everything between the pyramid and the sums stays in the
// processor's cache.
#include "metrics/cvvdp/band.h"

#include <algorithm>
#include <cmath>

#include "metrics/cvvdp/fast_math.h"
#include "metrics/cvvdp/pooling.h"

namespace crowdbench::metrics::vdp {
namespace {

constexpr float kLeastBackground = 0.01F;  // cd/m2
constexpr float kMostContrast = 1000;
constexpr int kRadius = 6;
constexpr int kWindow = 2 * kRadius + 1;
constexpr float kEpsilon = static_cast<float>(kEps);
constexpr size_t kLanes = 8;

struct Constants {
  std::array<float, kRadius + 1> blur{};  // weight at distance 0..6
  float mask_gain = 0, most = 0;
  float eps_p = 0;
  PerChannel<float> q{}, eps_q{};
  std::array<PerChannel<float>, kChannels> cross{};
};

const Constants& constants() {
  static const Constants all = [] {
    Constants k;
    constexpr double kSigma = 3;
    double sum = 0;
    for (int i = 0; i <= kRadius; ++i) sum += (i == 0 ? 1 : 2) * std::exp(-i * i / (2 * kSigma * kSigma));
    for (int i = 0; i <= kRadius; ++i)
      k.blur[static_cast<size_t>(i)] = static_cast<float>(std::exp(-i * i / (2 * kSigma * kSigma)) / sum);
    k.mask_gain = static_cast<float>(std::pow(10, kMaskC));
    k.most = static_cast<float>(std::pow(10, kMaxDifference));
    // By the function that the rows use, so that no difference gives exactly 0.
    k.eps_p = fast_pow(kEpsilon, static_cast<float>(kMaskP));
    for (size_t c = 0; c < kChannels; ++c) {
      k.q[c] = static_cast<float>(kMaskQ[c]);
      k.eps_q[c] = fast_pow(kEpsilon, k.q[c]);
      for (size_t from = 0; from < kChannels; ++from)
        k.cross[from][c] = static_cast<float>(std::exp2(kCrossMasking[from][c]));
    }
    return k;
  }();
  return all;
}

// inverse = gain / background of one picture.
CROWDBENCH_VECTORISED
void invert_background(const float* __restrict around, float gain, float* __restrict inverse, size_t count) {
  for (size_t x = 0; x < count; ++x) {
    const float b = around[x] > kLeastBackground ? around[x] : kLeastBackground;
    inverse[x] = gain / b;
  }
}

// log2 of the reference's background, and its segment of the sensitivities.
CROWDBENCH_VECTORISED
void find_segments(const float* __restrict around, float* __restrict log2_l, int32_t* __restrict segment,
                   size_t count) {
  for (size_t x = 0; x < count; ++x) {
    const float b = around[x] > kLeastBackground ? around[x] : kLeastBackground;
    const float l = fast_log2(b);
    const float held = l < Segments::kHigh ? l : Segments::kHigh;
    log2_l[x] = held;
    const auto i = static_cast<int32_t>((held - Segments::kLow) * Segments::kPerUnit);
    constexpr auto kLast = static_cast<int32_t>(kTableSize - 2);
    segment[x] = i < kLast ? i : kLast;
  }
}

CROWDBENCH_VECTORISED
void interpolate(const float* __restrict at, const float* __restrict slope, const float* __restrict log2_l,
                 const int32_t* __restrict segment, float* __restrict log2_s, size_t count) {
  for (size_t x = 0; x < count; ++x) log2_s[x] = at[segment[x]] + slope[segment[x]] * log2_l[x];
}

struct ChannelRow {
  const float *fine, *around, *inverse;  // of one picture
};

// |t - r| and min(|t|, |r|) of one channel, t and r being contrasts in units of their threshold.
CROWDBENCH_VECTORISED
void compare_contrasts(const ChannelRow& test, const ChannelRow& ref, const float* __restrict log2_s, float most,
                       float* __restrict difference, float* __restrict masker, size_t count) {
  const float* __restrict tf = test.fine;
  const float* __restrict ta = test.around;
  const float* __restrict ti = test.inverse;
  const float* __restrict rf = ref.fine;
  const float* __restrict ra = ref.around;
  const float* __restrict ri = ref.inverse;
  for (size_t x = 0; x < count; ++x) {
    const float s = fast_exp2(log2_s[x]);
    float t = (tf[x] - ta[x]) * ti[x];
    float r = (rf[x] - ra[x]) * ri[x];
    t = (t < most ? t : most) * s;
    r = (r < most ? r : most) * s;
    difference[x] = std::fabs(t - r);
    const float at = std::fabs(t);
    const float ar = std::fabs(r);
    masker[x] = at < ar ? at : ar;
  }
}

// out[x] around in[x], which has six elements before and behind.
CROWDBENCH_VECTORISED
void blur_row(const float* __restrict k, const float* __restrict in, float* __restrict out, size_t count) {
  for (size_t x = 0; x < count; ++x) {
    const float* c = in + x;
    out[x] = k[0] * c[0] + k[1] * (c[-1] + c[1]) + k[2] * (c[-2] + c[2]) + k[3] * (c[-3] + c[3]) +
             k[4] * (c[-4] + c[4]) + k[5] * (c[-5] + c[5]) + k[6] * (c[-6] + c[6]);
  }
}

using WindowRows = std::array<const float*, kWindow>;

CROWDBENCH_VECTORISED
void blur_column(const float* __restrict k, const WindowRows& r, float* __restrict out, size_t count) {
  const float *r0 = r[0], *r1 = r[1], *r2 = r[2], *r3 = r[3], *r4 = r[4], *r5 = r[5], *r6 = r[6], *r7 = r[7],
              *r8 = r[8], *r9 = r[9], *r10 = r[10], *r11 = r[11], *r12 = r[12];
  for (size_t x = 0; x < count; ++x)
    out[x] = k[0] * r6[x] + k[1] * (r5[x] + r7[x]) + k[2] * (r4[x] + r8[x]) + k[3] * (r3[x] + r9[x]) +
             k[4] * (r2[x] + r10[x]) + k[5] * (r1[x] + r11[x]) + k[6] * (r0[x] + r12[x]);
}

CROWDBENCH_VECTORISED
void mask_power(float* __restrict v, float gain, float q, float eps_q, size_t count) {
  for (size_t x = 0; x < count; ++x) v[x] = fast_pow(gain * v[x] + kEpsilon, q) - eps_q;
}

// weight[k]: of channel k on the one that is masked.
CROWDBENCH_VECTORISED
void add_masking(const float* __restrict v, float weight, float* __restrict pooled, size_t count) {
  for (size_t x = 0; x < count; ++x) pooled[x] += weight * v[x];
}

CROWDBENCH_VECTORISED
void mask_difference(const float* __restrict difference, const float* __restrict pooled, float most, float p,
                     float eps_p, float* __restrict d, size_t count) {
  for (size_t x = 0; x < count; ++x) {
    const float raw = (fast_pow(difference[x] + kEpsilon, p) - eps_p) / (1 + pooled[x]);
    d[x] = most * raw / (most + raw);
  }
}

// The sum of P(d, 2), in eight sums side by side whose order no compiler may change.
CROWDBENCH_VECTORISED
void add_squares(const float* __restrict d, double* __restrict lanes, size_t count) {
  const size_t whole = count / kLanes * kLanes;
  for (size_t x = 0; x < whole; x += kLanes)
    for (size_t i = 0; i < kLanes; ++i) {
      const auto v = static_cast<double>(d[x + i]);
      lanes[i] += v * (v + 2 * kEps);
    }
  for (size_t x = whole; x < count; ++x) {
    const auto v = static_cast<double>(d[x]);
    lanes[x - whole] += v * (v + 2 * kEps);
  }
}

double sum_of_squares(const float* d, size_t count) {
  std::array<double, kLanes> lanes{};
  add_squares(d, lanes.data(), count);
  return ((lanes[0] + lanes[4]) + (lanes[1] + lanes[5])) + ((lanes[2] + lanes[6]) + (lanes[3] + lanes[7]));
}

constexpr float kEps4 = kEpsilon * kEpsilon * (kEpsilon * kEpsilon);

CROWDBENCH_VECTORISED
void add_fourth_power(const float* __restrict d, float weight, float* __restrict sum, size_t count) {
  for (size_t x = 0; x < count; ++x) {
    const float v = weight * d[x] + kEpsilon;
    sum[x] += v * v * (v * v) - kEps4;
  }
}

CROWDBENCH_VECTORISED
void fourth_root(float* __restrict v, float eps_root, size_t count) {
  for (size_t x = 0; x < count; ++x) v[x] = fast_pow(v[x] + kEpsilon, 0.25F) - eps_root;
}

int reflected_row(int y, int height) {
  if (y < 0) return -y;
  return y < height ? y : 2 * (height - 1) - y;
}

// The rows of one strip.
class Strip {
 public:
  Strip(const BandInput& in, BandOutput& out);
  void run(int first_row, int last_row);

 private:
  float* ring(std::vector<float>& of, int rows, size_t channel, int y) const {
    return of.data() + (channel * static_cast<size_t>(rows) + static_cast<size_t>(y % rows)) * count_;
  }
  float* line(std::vector<float>& of, size_t index) const { return of.data() + index * count_; }
  void produce(int y);
  void expand(int y);
  void keep_masker(size_t channel, int y);
  void consume(int y);
  void probe(std::string_view stage, size_t channel, int y, const float* row) const;
  void probe_contrasts(size_t channel, int y) const;

  const BandInput& in_;
  BandOutput& out_;
  size_t count_;
  int height_;
  bool blurs_;
  float gain_;
  std::vector<float> around_;   // [picture][channel]: the next level, expanded
  std::vector<float> inverse_;  // [picture]
  std::vector<float> log2_l_, log2_s_, padded_, expanded_;
  std::vector<int32_t> segment_;
  std::vector<float> maskers_;      // the last 13 rows by channel, blurred along the row
  std::vector<float> differences_;  // the last 7 rows by channel
  std::vector<float> masks_, pooled_, d_;
};

Strip::Strip(const BandInput& in, BandOutput& out)
    : in_(in),
      out_(out),
      count_(static_cast<size_t>(in.fine[0][0]->width)),
      height_(in.fine[0][0]->height),
      blurs_(std::min(in.fine[0][0]->width, height_) > kRadius),
      gain_(in.finest ? 1.0F : 2.0F),
      around_(2 * in.channels * count_),
      inverse_(2 * count_),
      log2_l_(count_),
      log2_s_(count_),
      padded_(count_ + 2 * kRadius),
      segment_(count_),
      maskers_(in.channels * kWindow * count_),
      differences_(in.channels * (kRadius + 1) * count_),
      masks_(in.channels * count_),
      pooled_(count_),
      d_(count_) {}

void Strip::probe(std::string_view stage, size_t channel, int y, const float* row) const {
  if (in_.probe) (*in_.probe)(stage, channel, y, {row, count_});
}

void Strip::expand(int y) {
  for (size_t p = 0; p < 2; ++p) {
    for (size_t c = 0; c < in_.channels; ++c)
      expand_row(*in_.coarse[p][c], y, static_cast<int>(count_), expanded_, line(around_, p * in_.channels + c));
    invert_background(line(around_, p * in_.channels), gain_, line(inverse_, p), count_);
  }
  find_segments(line(around_, in_.channels), log2_l_.data(), segment_.data(), count_);
}

// The contrasts of row y: their difference, and their masker blurred along the row.
void Strip::produce(int y) {
  expand(y);
  for (size_t c = 0; c < in_.channels; ++c) {
    const SensitivityLines& lines = in_.lines[c];
    interpolate(lines.at.data(), lines.slope.data(), log2_l_.data(), segment_.data(), log2_s_.data(), count_);
    const ChannelRow test = {in_.fine[0][c]->row(y), line(around_, c), line(inverse_, 0)};
    const ChannelRow ref = {in_.fine[1][c]->row(y), line(around_, in_.channels + c), line(inverse_, 1)};
    compare_contrasts(test, ref, log2_s_.data(), kMostContrast * gain_, ring(differences_, kRadius + 1, c, y),
                      padded_.data() + kRadius, count_);
    if (in_.probe) probe_contrasts(c, y);
    keep_masker(c, y);
  }
}

void Strip::keep_masker(size_t channel, int y) {
  float* u = padded_.data() + kRadius;
  float* kept = ring(maskers_, kWindow, channel, y);
  if (!blurs_) {
    std::copy(u, u + count_, kept);
    return;
  }
  for (size_t i = 1; i <= kRadius; ++i) {
    *(u - i) = u[i];
    u[count_ - 1 + i] = u[count_ - 1 - i];
  }
  blur_row(constants().blur.data(), u, kept, count_);
}

// Row y of D, from the rows around it that are kept.
void Strip::consume(int y) {
  const Constants& k = constants();
  for (size_t c = 0; c < in_.channels; ++c) {
    float* v = line(masks_, c);
    if (blurs_) {
      WindowRows rows{};
      for (int i = 0; i < kWindow; ++i)
        rows[static_cast<size_t>(i)] = ring(maskers_, kWindow, c, reflected_row(y + i - kRadius, height_));
      blur_column(k.blur.data(), rows, v, count_);
    } else {
      const float* kept = ring(maskers_, kWindow, c, y);
      std::copy(kept, kept + count_, v);
    }
    if (in_.probe) {
      std::transform(v, v + count_, d_.begin(), [&](float u) { return k.mask_gain * u; });
      probe("min_masker_blurred", c, y, d_.data());
    }
    mask_power(v, k.mask_gain, k.q[c], k.eps_q[c], count_);
  }
  float* map = out_.map ? out_.map->row(y) : nullptr;
  if (map) std::fill(map, map + count_, 0.0F);
  for (size_t c = 0; c < in_.channels; ++c) {
    std::fill(pooled_.begin(), pooled_.end(), 0.0F);
    for (size_t from = 0; from < in_.channels; ++from)
      add_masking(line(masks_, from), k.cross[from][c], pooled_.data(), count_);
    mask_difference(ring(differences_, kRadius + 1, c, y), pooled_.data(), k.most, static_cast<float>(kMaskP), k.eps_p,
                    d_.data(), count_);
    probe("mask_pooled", c, y, pooled_.data());
    probe("D", c, y, d_.data());
    out_.row_sums[c][static_cast<size_t>(y)] = sum_of_squares(d_.data(), count_);
    if (map) add_fourth_power(d_.data(), out_.map_weight[c], map, count_);
  }
  if (map) fourth_root(map, fast_pow(kEpsilon, 0.25F), count_);
}

void Strip::run(int first_row, int last_row) {
  const int reach = blurs_ ? kRadius : 0;
  const int last_needed = std::min(last_row - 1 + reach, height_ - 1);
  int next = first_row;
  for (int y = std::max(first_row - reach, 0); y <= last_needed; ++y) {
    produce(y);
    while (next < last_row && (y >= next + reach || y == height_ - 1)) consume(next++);
  }
}

void Strip::probe_contrasts(size_t channel, int y) const {
  std::vector<float> row(count_);
  constexpr std::array<std::string_view, 2> kBackgrounds = {"log10_Lbkg_test", "log10_Lbkg_ref"};
  constexpr std::array<std::string_view, 2> kContrasts = {"contrast_test", "contrast_ref"};
  for (size_t p = 0; p < 2; ++p) {
    const float* inverse = inverse_.data() + p * count_;
    const float* around = around_.data() + (p * in_.channels + channel) * count_;
    const float* fine = in_.fine[p][channel]->row(y);
    for (size_t x = 0; x < count_; ++x) row[x] = std::log10(gain_ / inverse[x]);
    if (channel == 0) probe(kBackgrounds[p], 0, y, row.data());
    for (size_t x = 0; x < count_; ++x) row[x] = std::min((fine[x] - around[x]) * inverse[x], kMostContrast * gain_);
    probe(kContrasts[p], channel, y, row.data());
  }
  const auto gain = static_cast<float>(kChannelGain[channel]);
  for (size_t x = 0; x < count_; ++x) row[x] = fast_exp2(log2_s_[x]) / gain;
  probe("S_corrected", channel, y, row.data());
}

}  // namespace

void band_rows(const BandInput& in, int first_row, int last_row, BandOutput& out) {
  Strip(in, out).run(first_row, last_row);
}

PerChannel<double> base_band(const BandInput& in, BandOutput& out) {
  std::array<double, 2> background{};
  const FloatPlane& size = *in.fine[0][0];
  const auto count = static_cast<double>(size.data.size());
  for (size_t p = 0; p < 2; ++p) {
    for (const float a : in.fine[p][0]->data) background[p] += std::max(a, kLeastBackground);
    background[p] /= count;
  }
  PerChannel<double> q{};
  std::vector<float> d(size.data.size());
  if (out.map) std::fill(out.map->data.begin(), out.map->data.end(), 0.0F);
  for (size_t c = 0; c < in.channels; ++c) {
    const double s = sensitivity(in.lines[c], background[1]);
    const auto contrast = [&](size_t p, size_t i) {
      return std::min(static_cast<double>(in.fine[p][c]->data[i]) / background[p], double{kMostContrast});
    };
    for (size_t i = 0; i < d.size(); ++i) d[i] = static_cast<float>(std::fabs(contrast(0, i) - contrast(1, i)) * s);
    q[c] = power(sum_of_squares(d.data(), d.size()) / count, 0.5);
    if (out.map) add_fourth_power(d.data(), out.map_weight[c], out.map->data.data(), d.size());
    if (in.probe) (*in.probe)("D", c, 0, d);
  }
  if (out.map) fourth_root(out.map->data.data(), fast_pow(kEpsilon, 0.25F), d.size());
  return q;
}

}  // namespace crowdbench::metrics::vdp
