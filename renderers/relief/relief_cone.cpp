// Based on: Policarpo and Oliveira, "Relaxed Cone Stepping for Relief Mapping" (GPU Gems 3, chapter 18): the widest
// cone at each texel such that a ray inside it meets the surface at most once. Differs from the source: texels store an
// interval, so that a ray may also pass beyond the surface that it started over (the leaving cones) and may come from
// either side; a cone is a pyramid, bounded by where rays can come out of a surface at all, which is found from each
// texel and its next one outward instead of by walking every ray; it holds from anywhere in the texel.
#include "renderers/relief/relief_cone.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/parallel.h"
#include "core/progress.h"

namespace crowdbench::renderers {
namespace {

// Least value in any run of one row (or column) of an n x n picture.
class RunMinimum {
 public:
  RunMinimum(const std::vector<uint16_t>& values, size_t n, size_t step, size_t line) : step_(step), line_(line) {
    levels_.push_back(values);
    for (size_t width = 2; width <= n; width *= 2) {
      const std::vector<uint16_t>& half = levels_.back();
      std::vector<uint16_t> level(half);
      for (size_t other = 0; other < n; ++other)
        for (size_t i = 0; i + width <= n; ++i)
          level[other * line + i * step] =
              std::min(half[other * line + i * step], half[other * line + (i + width / 2) * step]);
      levels_.push_back(std::move(level));
    }
  }
  // Over [from, to], both inside the picture.
  uint16_t of(size_t other, size_t from, size_t to) const {
    const auto level = static_cast<size_t>(std::bit_width(to - from + 1) - 1);
    const uint16_t* row = levels_[level].data() + other * line_;
    return std::min(row[from * step_], row[(to + 1 - (size_t{1} << level)) * step_]);
  }

 private:
  size_t step_, line_;
  std::vector<std::vector<uint16_t>> levels_;
};

struct Both {
  RunMinimum rows, columns;
  Both(const std::vector<uint16_t>& values, size_t n) : rows(values, n, 1, n), columns(values, n, n, 1) {}
};

constexpr double kOne = 65535.0;

uint8_t code_of(double ratio) {
  return static_cast<uint8_t>(std::floor(255.0 * std::sqrt(std::clamp(ratio, 0.0, 1.0))));
}

// The least depth at which a ray that moves toward (right, down) can come out of each texel's interval: through its
// back, or into the next texel where that holds nothing at this depth.
std::vector<uint16_t> least_exits(const std::vector<uint16_t>& front, const std::vector<uint16_t>& back, size_t n,
                                  bool right, bool down) {
  const auto covered = [&](size_t texel) { return front[texel] <= back[texel]; };
  std::vector<uint16_t> least(n * n, 65535);
  for (size_t v = 0; v < n; ++v) {
    for (size_t u = 0; u < n; ++u) {
      const size_t texel = v * n + u;
      if (!covered(texel)) continue;
      uint16_t out = back[texel];
      const auto into = [&](size_t next) {
        if (!covered(next) || front[next] > front[texel])
          out = std::min(out, front[texel]);
        else if (back[next] < back[texel])
          out = std::min(out, std::max(front[texel], back[next]));
      };
      // Beyond the map's edge the ray has left the box.
      if (right ? u + 1 < n : u > 0) into(right ? texel + 1 : texel - 1);
      if (down ? v + 1 < n : v > 0) into(down ? texel + n : texel - n);
      least[texel] = out;
    }
  }
  return least;
}

// Backs counted from the far end, so that the highest is the least; 65535 where a texel is empty.
std::vector<uint16_t> complements(const std::vector<uint16_t>& front, const std::vector<uint16_t>& back) {
  std::vector<uint16_t> out(back.size());
  for (size_t i = 0; i < out.size(); ++i)
    out[i] = front[i] <= back[i] ? static_cast<uint16_t>(65535 - back[i]) : uint16_t{65535};
  return out;
}

// What the square rings around a texel hold, clipped to the map.
class Rings {
 public:
  Rings(const std::vector<uint16_t>& front, const std::vector<uint16_t>& back, size_t n)
      : n_(n),
        exit_{Both(least_exits(front, back, n, false, false), n), Both(least_exits(front, back, n, true, false), n),
              Both(least_exits(front, back, n, false, true), n), Both(least_exits(front, back, n, true, true), n)},
        highest_(complements(front, back), n) {}
  size_t size() const { return n_; }

  // The least depth at which a ray that moves toward (u, v) comes out of anything in ring k around it.
  uint16_t least_exit(size_t u, size_t v, size_t k) const {
    const Span at = span(u, v, k);
    uint16_t least = 65535;
    if (v >= k) least = std::min({least, exit_[0].rows.of(at.top, at.left, u), exit_[1].rows.of(at.top, u, at.right)});
    if (v + k < n_)
      least = std::min({least, exit_[2].rows.of(at.bottom, at.left, u), exit_[3].rows.of(at.bottom, u, at.right)});
    if (u >= k)
      least = std::min({least, exit_[0].columns.of(at.left, at.top, v), exit_[2].columns.of(at.left, v, at.bottom)});
    if (u + k < n_)
      least = std::min({least, exit_[1].columns.of(at.right, at.top, v), exit_[3].columns.of(at.right, v, at.bottom)});
    return least;
  }
  // The least of complements() in ring k.
  uint16_t least_complement(size_t u, size_t v, size_t k) const {
    const Span at = span(u, v, k);
    uint16_t least = 65535;
    if (v >= k) least = std::min(least, highest_.rows.of(at.top, at.left, at.right));
    if (v + k < n_) least = std::min(least, highest_.rows.of(at.bottom, at.left, at.right));
    if (u >= k) least = std::min(least, highest_.columns.of(at.left, at.top, at.bottom));
    if (u + k < n_) least = std::min(least, highest_.columns.of(at.right, at.top, at.bottom));
    return least;
  }

 private:
  struct Span {
    size_t left, right, top, bottom;
  };
  Span span(size_t u, size_t v, size_t k) const {
    return {u >= k ? u - k : 0, std::min(u + k, n_ - 1), v >= k ? v - k : 0, std::min(v + k, n_ - 1)};
  }

  size_t n_;
  std::array<Both, 4> exit_;  // left and up, right and up, left and down, right and down
  Both highest_;
};

struct ConeRatios {
  double approach = 1, leave = 1;
};
// Of the texel (u, v), which is filled from `before` to `behind`, in [0, 1].
ConeRatios widest_cones(const Rings& rings, size_t u, size_t v, double before, double behind) {
  ConeRatios widest;
  const double texel = 1.0 / static_cast<double>(rings.size());
  for (size_t k = 1; k < rings.size(); ++k) {
    const double across = static_cast<double>(k) * texel;
    // No ray from this column gets to ring k below this depth.
    const double floor = across - texel;
    const bool seek_approach = floor < before && across < widest.approach * (before - floor);
    const bool seek_leave = across < widest.leave * (1.0 - behind);
    if (!seek_approach && !seek_leave) break;
    if (seek_approach) {
      const double depth = std::max(rings.least_exit(u, v, k) / kOne, floor);
      if (depth < before) widest.approach = std::min(widest.approach, across / (before - depth));
    }
    if (seek_leave) {
      const uint16_t least = rings.least_complement(u, v, k);
      const double depth = 1.0 - least / kOne;
      if (least < 65535 && depth > behind) widest.leave = std::min(widest.leave, across / (depth - behind));
    }
  }
  return widest;
}

// Cones of rays that go up over [front, back].
struct Upward {
  std::vector<uint8_t> approach, leave;
};
Upward upward(const std::vector<uint16_t>& front, const std::vector<uint16_t>& back, size_t n) {
  const Rings rings(front, back, n);
  Upward cones{std::vector<uint8_t>(n * n), std::vector<uint8_t>(n * n)};
  for (size_t v = 0; v < n; ++v) {
    for (size_t u = 0; u < n; ++u) {
      const size_t here = v * n + u;
      const bool covered = front[here] <= back[here];
      const ConeRatios widest =
          widest_cones(rings, u, v, covered ? front[here] / kOne : 1.0, covered ? back[here] / kOne : 0.0);
      cones.approach[here] = code_of(widest.approach);
      cones.leave[here] = code_of(widest.leave);
    }
  }
  return cones;
}

}  // namespace

double cone_ratio(uint8_t code) { return code / 255.0 * (code / 255.0); }

std::vector<TexelCones> derive_cones(const uint16_t* depth, size_t n) {
  std::vector<uint16_t> front(n * n);
  std::vector<uint16_t> back(n * n);
  for (size_t i = 0; i < n * n; ++i) {
    front[i] = depth[2 * i];
    back[i] = depth[2 * i + 1];
  }
  const Upward up = upward(front, back, n);
  for (size_t i = 0; i < n * n; ++i) {
    front[i] = static_cast<uint16_t>(65535 - depth[2 * i + 1]);
    back[i] = static_cast<uint16_t>(65535 - depth[2 * i]);
  }
  const Upward down = upward(front, back, n);
  std::vector<TexelCones> cones(n * n);
  for (size_t i = 0; i < n * n; ++i) cones[i] = {up.approach[i], up.leave[i], down.approach[i], down.leave[i]};
  return cones;
}

std::vector<uint8_t> derive_cones(const ReliefModel& model, const AtlasPlan& plan, const Atlas& atlas,
                                  const BakeProgress& progress) {
  const auto width = static_cast<size_t>(plan.width);
  std::vector<uint8_t> cones(atlas.depth.size() * 2);
  parallel_for(
      model.boxes.size() * 3, 0,
      [&](size_t job) {
        const size_t box = job / 3;
        const auto texels = static_cast<size_t>(model.boxes[box].texels);
        for (uint32_t level = 0; level < atlas_levels(model.boxes[box].texels); ++level) {
          const size_t n = texels >> level;
          const AtlasPlace place = atlas_place(plan, box, texels, level);
          const size_t first = place.top * width + place.left + job % 3 * texels;
          std::vector<uint16_t> depth(n * n * 2);
          for (size_t v = 0; v < n; ++v)
            std::copy_n(atlas.depth.begin() + static_cast<std::ptrdiff_t>((first + v * width) * 2), n * 2,
                        depth.begin() + static_cast<std::ptrdiff_t>(v * n * 2));
          const std::vector<TexelCones> of = derive_cones(depth.data(), n);
          for (size_t v = 0; v < n; ++v) {
            for (size_t u = 0; u < n; ++u) {
              const TexelCones& c = of[v * n + u];
              uint8_t* to = cones.data() + (first + v * width + u) * 4;
              to[0] = c.approach_up;
              to[1] = c.leave_up;
              to[2] = c.approach_down;
              to[3] = c.leave_down;
            }
          }
        }
      },
      [&](size_t done) {
        throw_if_interrupted();
        if (progress) progress(done, model.boxes.size() * 3);
      });
  return cones;
}

}  // namespace crowdbench::renderers
