// Based on: ColorVideoVDP (Mantiuk et al. 2024): its display model and the matrices of pycvvdp/display_model.py (MIT
// licence, LICENSE beside this file).
#include "metrics/cvvdp/opponent.h"

#include <algorithm>

#include "core/parallel.h"

namespace crowdbench::metrics::vdp {
namespace {

constexpr Matrix3 kXyzToLms = {{{0.187596268556126, 0.585168649077728, -0.026384263306304},
                                {-0.133397430663221, 0.405505777260049, 0.034502127690364},
                                {0.000244379021663, -0.000542995890619, 0.019406849066323}}};
constexpr Matrix3 kLmsToDkl = {{{1, 1, 0}, {1, -2.311130179947035, 0}, {-1, -1, 50.97757132871878}}};

Matrix3 product(const Matrix3& a, const Matrix3& b) {
  Matrix3 out{};
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j)
      for (size_t k = 0; k < 3; ++k) out[i][j] += a[i][k] * b[k][j];
  return out;
}

// Work on rows by several threads, a few rows an item.
template <typename Work>
void by_rows(int height, unsigned threads, const Work& work) {
  constexpr int kRows = 32;
  parallel_for(static_cast<size_t>((height + kRows - 1) / kRows), threads, [&](size_t i) {
    const int first = static_cast<int>(i) * kRows;
    for (int y = first; y < std::min(first + kRows, height); ++y) work(y);
  });
}

}  // namespace

Matrix3 opponent_matrix(const ColourSpace& space) { return product(kLmsToDkl, product(kXyzToLms, space.rgb_to_xyz)); }

OpponentColours::OpponentColours(const Display& display) : display_(display) {
  const Matrix3 m = opponent_matrix(display.colour_space);
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j) matrix_[i][j] = static_cast<float>(m[i][j]);
}

// HLG mixes the components, so that a table by component does not exist; every other display has one.
template <typename T>
void OpponentColours::by_table(const Image<T>& image, std::vector<float>& table, OpponentPlanes& out,
                               unsigned threads) const {
  constexpr size_t kCodes = size_t{1} << (8 * sizeof(T));
  const bool mixes = display_.colour_space.eotf == Eotf::hlg;
  if (table.empty() && !mixes) {
    table.resize(kCodes);
    for (size_t v = 0; v < kCodes; ++v) {
      const double value = static_cast<double>(v) / static_cast<double>(kCodes - 1);
      table[v] = static_cast<float>(light_of(display_, {value, value, value})[0]);
    }
  }
  for (FloatPlane& plane : out) plane.resize(image.width, image.height);
  const auto step = static_cast<size_t>(image.channels);
  const size_t green = step >= 3 ? 1 : 0;
  const size_t blue = step >= 3 ? 2 : 0;
  const auto& m = matrix_;
  by_rows(image.height, threads, [&](int y) {
    const T* in = image.at(0, y);
    float* a = out[0].row(y);
    float* rg = out[1].row(y);
    float* yv = out[2].row(y);
    for (int x = 0; x < image.width; ++x, in += step) {
      std::array<float, 3> light{};
      if (mixes) {
        const double scale = 1.0 / static_cast<double>(kCodes - 1);
        const auto exact = light_of(display_, {in[0] * scale, in[green] * scale, in[blue] * scale});
        light = {static_cast<float>(exact[0]), static_cast<float>(exact[1]), static_cast<float>(exact[2])};
      } else {
        light = {table[in[0]], table[in[green]], table[in[blue]]};
      }
      a[x] = m[0][0] * light[0] + m[0][1] * light[1] + m[0][2] * light[2];
      rg[x] = m[1][0] * light[0] + m[1][1] * light[1] + m[1][2] * light[2];
      yv[x] = m[2][0] * light[0] + m[2][1] * light[1] + m[2][2] * light[2];
    }
  });
}

void OpponentColours::planes(const Image8& image, OpponentPlanes& out, unsigned threads) {
  by_table(image, table8_, out, threads);
}

void OpponentColours::planes(const Image16& image, OpponentPlanes& out, unsigned threads) {
  by_table(image, table16_, out, threads);
}

void OpponentColours::planes(const ImageF& image, OpponentPlanes& out, unsigned threads) const {
  for (FloatPlane& plane : out) plane.resize(image.width, image.height);
  const auto step = static_cast<size_t>(image.channels);
  const size_t green = step >= 3 ? 1 : 0;
  const size_t blue = step >= 3 ? 2 : 0;
  by_rows(image.height, threads, [&](int y) {
    const float* in = image.at(0, y);
    for (int x = 0; x < image.width; ++x, in += step) {
      const auto light = light_of(display_, {in[0], in[green], in[blue]});
      for (size_t c = 0; c < 3; ++c)
        out[c].row(y)[x] = matrix_[c][0] * static_cast<float>(light[0]) + matrix_[c][1] * static_cast<float>(light[1]) +
                           matrix_[c][2] * static_cast<float>(light[2]);
    }
  });
}

}  // namespace crowdbench::metrics::vdp
