#include "metrics/agent_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <span>
#include <utility>

#include "core/statistics.h"
#include "metrics/picture_causes.h"

namespace crowdbench::metrics {
namespace {

constexpr double kOutlinePixel = 3 * 40.0 * 40.0;  // what a wrong pixel of the outline costs, squared code values
constexpr double kExplains = 0.5;                  // of the cost, what a shift by whole pixels may leave
constexpr double kImproves = 0.9;                  // the same of a motion by fractions of pixels
constexpr double kUncovered = 0.15;                // of the changed outline, what such a motion may leave unexplained
constexpr double kLeastMotion = 0.08;              // pixels, of the point that moves most
constexpr size_t kLeastOutline = 4;                // changed pixels of an outline that say where it went
constexpr double kMatched = 0.5;                   // of the agent's pixels, what a motion must bring to the agent

// The samples around a place, with their weights.
struct Cell {
  std::array<size_t, 4> at{};
  std::array<double, 4> weight{};
  size_t count = 0;
  bool inside = true;  // all of them lie in the picture
};

class Sampler {
 public:
  // Both must outlive it.
  Sampler(const AgentPictures& agent, const Motion& motion) : agent_(agent), motion_(motion) {}

  // Where the pixel comes from.
  std::pair<double, double> from(int x, int y) const {
    return {motion_.middle_x + (x - motion_.middle_x - motion_.dx) / motion_.scale,
            motion_.middle_y + (y - motion_.middle_y - motion_.dy) / motion_.scale};
  }
  Cell cell(int x, int y) const {
    const auto [qx, qy] = from(x, y);
    const double left = std::floor(qx + kOnSample);
    const double top = std::floor(qy + kOnSample);
    const double fx = qx - left > kOnSample ? qx - left : 0;
    const double fy = qy - top > kOnSample ? qy - top : 0;
    Cell out;
    for (int j = 0; j < (fy > 0 ? 2 : 1); ++j)
      for (int i = 0; i < (fx > 0 ? 2 : 1); ++i) {
        const double px = left + i;
        const double py = top + j;
        if (px < 0 || py < 0 || px >= width() || py >= height()) {
          out.inside = false;
          continue;
        }
        out.at.at(out.count) = index(static_cast<int>(px), static_cast<int>(py));
        out.weight.at(out.count++) = (i != 0 ? fx : 1 - fx) * (j != 0 ? fy : 1 - fy);
      }
    return out;
  }
  bool shows(size_t sample) const { return agent_.source.ids.data[sample] == agent_.id; }
  double cover(const Cell& cell) const {
    double sum = 0;
    for (size_t i = 0; i < cell.count; ++i) sum += shows(cell.at.at(i)) ? cell.weight.at(i) : 0;
    return sum;
  }
  bool all(const Cell& cell) const { return cover(cell) > 1 - 1e-9; }
  // The mean of a buffer over the cell's samples that show the agent; at least one.
  template <typename T>
  double mean(const Cell& cell, const Image<T>& of, int channel) const {
    double sum = 0;
    double weight = 0;
    for (size_t i = 0; i < cell.count; ++i) {
      if (!shows(cell.at.at(i))) continue;
      sum += cell.weight.at(i) * static_cast<double>(value(of, cell.at.at(i), channel));
      weight += cell.weight.at(i);
    }
    return sum / weight;
  }
  // The least and the greatest of a buffer over the agent's samples within a pixel of where (x, y) comes from.
  template <typename T>
  std::pair<double, double> near(int x, int y, const Image<T>& of, int channel) const {
    const auto [qx, qy] = from(x, y);
    double least = 1e300;
    double most = -1e300;
    for (int py = static_cast<int>(std::ceil(qy - 1)); py <= static_cast<int>(std::floor(qy + 1)); ++py)
      for (int px = static_cast<int>(std::ceil(qx - 1)); px <= static_cast<int>(std::floor(qx + 1)); ++px) {
        if (px < 0 || py < 0 || px >= width() || py >= height() || !shows(index(px, py))) continue;
        const auto v = static_cast<double>(value(of, index(px, py), channel));
        least = std::min(least, v);
        most = std::max(most, v);
      }
    return {least, most};
  }
  // Another agent stood there, behind which this one may have been.
  bool unknown(const Cell& cell) const {
    return std::any_of(cell.at.begin(), cell.at.begin() + static_cast<std::ptrdiff_t>(cell.count), [&](size_t sample) {
      const uint32_t id = agent_.source.ids.data[sample];
      return id != 0 && id != agent_.id;
    });
  }
  // Another agent stands there in the test: whether this one would be is not known.
  bool behind(size_t pixel) const {
    const uint32_t shown = agent_.test.ids.data[pixel];
    return shown != 0 && shown != agent_.id;
  }
  // Another agent was there and still is: the pixel stays.
  bool hidden(size_t pixel) const { return behind(pixel) && agent_.now.ids.data[pixel] == agent_.test.ids.data[pixel]; }
  size_t index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width()) + static_cast<size_t>(x);
  }
  int width() const { return agent_.now.ids.width; }
  int height() const { return agent_.now.ids.height; }

 private:
  static constexpr double kOnSample = 1e-6;
  template <typename T>
  static T value(const Image<T>& of, size_t sample, int channel) {
    return of.data[sample * static_cast<size_t>(of.channels) + static_cast<size_t>(channel)];
  }
  const AgentPictures& agent_;
  const Motion& motion_;
};

// The squared error that the best gain, not below 0, and offset leave.
struct ColourFit {
  double n = 0, a = 0, b = 0, aa = 0, ab = 0, bb = 0;
  void add(double x, double y) {
    n += 1;
    a += x, b += y;
    aa += x * x, ab += x * y, bb += y * y;
  }
  double residual() const {
    const double own = bb - b * b / n;
    const double both = ab - a * b / n;
    const double other = aa - a * a / n;
    return std::max(0.0, both > 0 && other > 0 ? own - both * both / other : own);
  }
};

// How much farther away the agent is at the points that the motion brings together: the median.
struct DepthGap {
  double median = 0;
  double depth = 0;    // metres, its own median
  bool rigid = false;  // most of it by the same, and its relief stayed: a plane has none, whatever it shows
};

double spread_of(std::span<const double> depths) { return quantile(depths, 0.95) - quantile(depths, 0.05); }

std::optional<DepthGap> depth_gap(const AgentPictures& agent, const Motion& motion, const Range& range) {
  if (agent.source.depth.empty() || agent.test.depth.empty()) return std::nullopt;
  const Sampler sampler(agent, motion);
  std::vector<double> gaps, depths;
  for (int y = range.top; y <= range.bottom; ++y)
    for (int x = range.left; x <= range.right; ++x) {
      const size_t here = sampler.index(x, y);
      if (agent.test.ids.data[here] != agent.id) continue;
      const Cell cell = sampler.cell(x, y);
      if (!cell.inside || !sampler.all(cell)) continue;
      const double own = sampler.mean(cell, agent.source.depth, 0);
      const double gap = static_cast<double>(agent.test.depth.data[here]) - own;
      if (!std::isfinite(gap)) continue;
      gaps.push_back(gap);
      depths.push_back(own);
    }
  if (gaps.empty()) return std::nullopt;
  DepthGap out;
  constexpr double kOther = 0.5;  // of the relief, what the relief may differ by
  const bool relief_stayed = spread_of(gaps) <= std::max(kSurfaceTolerance, kOther * spread_of(depths));
  out.median = median_in_place(gaps);
  out.depth = median_in_place(depths);
  const double within = std::max(0.5 * kSurfaceTolerance, 0.1 * std::abs(out.median));
  const auto same =
      std::count_if(gaps.begin(), gaps.end(), [&](double g) { return std::abs(g - out.median) <= within; });
  constexpr double kMost = 0.7;  // slanted surfaces and what stands out from the body have other gaps
  out.rigid = relief_stayed && static_cast<double>(same) >= kMost * static_cast<double>(gaps.size());
  return out;
}

// Whole pixels that bring an edge or the middle of the agent to where it is in the test, and those beside them.
std::set<std::pair<int, int>> candidates(const Extent& from, const Extent& to) {
  const int across[] = {to.left - from.left, to.right - from.right, static_cast<int>(std::lround(to.x - from.x))};
  const int down[] = {to.top - from.top, to.bottom - from.bottom, static_cast<int>(std::lround(to.y - from.y))};
  std::set<std::pair<int, int>> out;
  for (const int dx : across)
    for (const int dy : down)
      for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j) out.emplace(dx + i, dy + j);
  out.erase({0, 0});
  return out;
}

class Search {
 public:
  Search(const AgentPictures& agent, const Extent& from, const Extent& to)
      : agent_(agent),
        from_(from),
        to_(to),
        range_(around(from, to, agent.now.ids, 2)),
        half_(0.5 * std::max({1, from.right - from.left + 1, from.bottom - from.top + 1})) {
    constexpr size_t kMostPixels = 4000;
    const auto area =
        static_cast<size_t>(range_.right - range_.left + 1) * static_cast<size_t>(range_.bottom - range_.top + 1);
    stride_ = static_cast<int>(1 + area / kMostPixels);
  }

  Mismatch least() const {
    const Mismatch before = mismatch_of(agent_, at({}), range_);
    const std::optional<AgentMove> whole = best_shift(before);
    const Mismatch after = mismatch_of(agent_, best_motion(whole ? &whole->motion : nullptr), range_);
    const auto cheaper = [](const Mismatch& a, const Mismatch& b) { return b.cost < a.cost ? b : a; };
    return cheaper(whole ? cheaper(before, whole->after) : before, after);
  }

  std::optional<AgentMove> run() {
    AgentMove out;
    out.before = mismatch_of(agent_, at({}), range_);
    const std::optional<AgentMove> whole = best_shift(out.before);
    if (whole && whole->after.cost == 0) return whole;
    out.motion = best_motion(whole ? &whole->motion : nullptr);
    out.after = mismatch_of(agent_, out.motion, range_);
    out.farther = farther(out.motion);
    const bool cheaper = !whole || out.after.cost < kSimpler * whole->after.cost;
    if (cheaper && (moves_outline(out) || moves_away(out))) return out;
    if (!whole) return std::nullopt;
    AgentMove shift = *whole;
    shift.farther = farther(shift.motion);
    return shift;
  }

 private:
  static constexpr double kSimpler = 0.8;  // of two explanations the simpler, unless the other leaves so much less

  Motion at(Motion motion) const {
    motion.middle_x = from_.x;
    motion.middle_y = from_.y;
    return motion;
  }

  std::optional<AgentMove> best_shift(const Mismatch& before) const {
    if (before.outline == 0) return std::nullopt;
    Motion best = at({});
    double least = cost(best);
    for (const auto& [dx, dy] : candidates(from_, to_)) {
      const Motion motion = at({1, static_cast<double>(dx), static_cast<double>(dy)});
      const double c = cost(motion);
      if (c >= least) continue;
      least = c;
      best = motion;
    }
    const Mismatch after = mismatch_of(agent_, best, range_);
    // What another agent uncovers moves the edges of what is seen, too, but brings no outline to its place.
    if (static_cast<double>(after.outline) >= kExplains * static_cast<double>(before.outline)) return std::nullopt;
    if (after.cost >= kExplains * before.cost) return std::nullopt;
    return AgentMove{best, std::nullopt, before, after};
  }

  // Where another agent stood nothing is known and nothing costs: a motion that fetches all of the agent from behind
  // others explains everything, and is told by nothing.
  double cost(const Motion& motion) const {
    const Mismatch of = mismatch_of(agent_, motion, range_, stride_);
    const auto least = static_cast<double>(std::min(from_.pixels, to_.pixels));
    if (!motion.none() && static_cast<double>(of.matched) < kMatched * least)
      return std::numeric_limits<double>::infinity();
    return of.cost;
  }

  Motion best_motion(const Motion* whole) const {
    Motion best = at({});
    double least = cost(best);
    const auto offer = [&](const Motion& motion) {
      const double c = cost(motion);
      if (c >= least) return false;
      least = c;
      best = motion;
      return true;
    };
    if (whole) offer(*whole);
    const double size = std::sqrt(to_.spread / static_cast<double>(to_.pixels) /
                                  std::max(1e-9, from_.spread / static_cast<double>(from_.pixels)));
    offer(at({1, to_.x - from_.x, to_.y - from_.y}));
    offer(at({std::clamp(size, 0.5, 2.0), to_.x - from_.x, to_.y - from_.y}));
    for (double step = 0.4; step >= 0.025; step /= 2) {
      constexpr int kMostMoves = 6;
      for (int i = 0; i < kMostMoves; ++i) {
        const Motion centre = best;
        bool moved = false;
        for (const double by : {step, -step}) {
          for (double Motion::*axis : {&Motion::dx, &Motion::dy, &Motion::scale}) {
            Motion motion = centre;
            motion.*axis += axis == &Motion::scale ? by / half_ : by;
            moved = offer(motion) || moved;
          }
        }
        if (!moved) break;
      }
    }
    return best;
  }

  // The change of depth that goes with the change of size.
  std::optional<double> farther(const Motion& motion) const {
    const std::optional<DepthGap> gap = depth_gap(agent_, motion, range_);
    if (!gap || !gap->rigid || !(gap->depth + gap->median > 0)) return std::nullopt;
    const double expected = gap->depth / (gap->depth + gap->median);
    constexpr double kEdge = 0.5;  // pixels
    if (std::abs(motion.scale - expected) * half_ > kEdge) return std::nullopt;
    return gap->median;
  }

  double farthest(const Motion& motion) const {
    return std::hypot(motion.dx, motion.dy) + std::abs(motion.scale - 1) * half_;
  }
  bool explained(const AgentMove& move) const {
    return static_cast<double>(move.after.uncovered) <= kUncovered * static_cast<double>(move.before.outline);
  }
  bool moves_outline(const AgentMove& move) const {
    return farthest(move.motion) >= kLeastMotion && move.before.outline >= kLeastOutline && explained(move) &&
           move.after.cost < kImproves * move.before.cost;
  }
  bool moves_away(const AgentMove& move) const {
    return move.farther && std::abs(*move.farther) > kSurfaceTolerance && explained(move);
  }

  const AgentPictures& agent_;
  const Extent& from_;
  const Extent& to_;
  Range range_;
  double half_;
  int stride_ = 1;
};

bool equal_in(const AgentPictures& agent, const Range& range) {
  for (int y = range.top; y <= range.bottom; ++y)
    for (int x = range.left; x <= range.right; ++x) {
      const auto i = static_cast<size_t>(y) * static_cast<size_t>(agent.now.ids.width) + static_cast<size_t>(x);
      const bool in_source = agent.source.ids.data[i] == agent.id;
      if (in_source != (agent.test.ids.data[i] == agent.id)) return false;
      if (!in_source) continue;
      if (!std::equal(&agent.source.codes.data[3 * i], &agent.source.codes.data[3 * i] + 3,
                      &agent.test.codes.data[3 * i]))
        return false;
      if (!agent.source.depth.empty() && agent.source.depth.data[i] != agent.test.depth.data[i]) return false;
    }
  return true;
}

// Whether a value lies among those around, which are not all that a resampling may give.
bool among(double value, const std::pair<double, double>& near, double slack) {
  const double more = slack + 0.25 * (near.second - near.first);
  return value >= near.first - more && value <= near.second + more;
}

struct Pixel {
  size_t place = 0;
  std::array<uint8_t, 3> codes{};
  uint32_t id = 0;
  float depth = 0;
};

// An agent laid into a picture, pixel by pixel.
class Laying {
 public:
  Laying(const AgentPictures& agent, const Motion& motion, double farther)
      : agent_(agent), sampler_(agent, motion), exact_(motion.whole()), farther_(farther) {}

  // Nothing where the pixel stays.
  std::optional<Pixel> at(int x, int y) const {
    const size_t here = sampler_.index(x, y);
    const bool in_test = agent_.test.ids.data[here] == agent_.id;
    if (!in_test && sampler_.hidden(here)) return std::nullopt;
    const Cell cell = sampler_.cell(x, y);
    const double cover = sampler_.cover(cell);
    const bool edge = cover < 1 - 1e-9;
    // It left the pixel, or comes out from behind another: what there is only the test knows. Where that other one is
    // now, it did not come out from behind it but before it, which is no matter of place.
    if (in_test && cover == 0) return known(sampler_.unknown(cell) && !shows_other(here), here);
    if (!in_test && edge) return known(agent_.now.ids.data[here] == agent_.id, here);
    return moved(x, y, cell, in_test);
  }

 private:
  std::optional<Pixel> known(bool by_test, size_t here) const {
    return by_test ? std::optional(pixel_of(agent_.test, here)) : std::nullopt;
  }
  bool shows_other(size_t here) const {
    const uint32_t shown = agent_.now.ids.data[here];
    return shown != 0 && shown != agent_.id;
  }
  static Pixel pixel_of(const Layer& layer, size_t place) {
    Pixel out{place, {}, layer.ids.data[place], layer.depth.empty() ? 0 : layer.depth.data[place]};
    std::copy_n(&layer.codes.data[3 * place], 3, out.codes.begin());
    return out;
  }
  Pixel moved(int x, int y, const Cell& cell, bool in_test) const {
    const size_t here = sampler_.index(x, y);
    const Pixel test = pixel_of(agent_.test, here);
    constexpr double kCodes = 3;
    Pixel out{here, {}, agent_.id, std::numeric_limits<float>::quiet_NaN()};
    bool known = !exact_ && in_test;
    for (size_t c = 0; c < 3; ++c) {
      const int channel = static_cast<int>(c);
      out.codes.at(c) = static_cast<uint8_t>(std::lround(sampler_.mean(cell, agent_.source.codes, channel)));
      known = known && among(test.codes.at(c), sampler_.near(x, y, agent_.source.codes, channel), kCodes);
    }
    if (known) out.codes = test.codes;
    if (agent_.source.depth.empty() || agent_.test.depth.empty()) return out;
    out.depth = static_cast<float>(sampler_.mean(cell, agent_.source.depth, 0) + farther_);
    const double depth = static_cast<double>(test.depth) - farther_;
    if (!exact_ && in_test && among(depth, sampler_.near(x, y, agent_.source.depth, 0), kSurfaceTolerance))
      out.depth = test.depth;
    return out;
  }

  const AgentPictures& agent_;
  Sampler sampler_;
  bool exact_;
  double farther_;
};

}  // namespace

void Extent::add(int px, int py) {
  if (pixels == 0) *this = {px, py, px, py, 0, 0, 0, 0};
  left = std::min(left, px), right = std::max(right, px);
  top = std::min(top, py), bottom = std::max(bottom, py);
  const double from_x = px - x;
  const double from_y = py - y;
  x += from_x / static_cast<double>(++pixels);
  y += from_y / static_cast<double>(pixels);
  spread += from_x * (px - x) + from_y * (py - y);
}

Extents extents_of(const ImageU32& ids) {
  Extents out;
  for (int y = 0; y < ids.height; ++y)
    for (int x = 0; x < ids.width; ++x)
      if (const uint32_t id = *ids.at(x, y); id != 0) out[id].add(x, y);
  return out;
}

Range around(const Extent& a, const Extent& b, const ImageU32& ids, int margin) {
  return {std::max(0, std::min(a.left, b.left) - margin), std::max(0, std::min(a.top, b.top) - margin),
          std::min(ids.width - 1, std::max(a.right, b.right) + margin),
          std::min(ids.height - 1, std::max(a.bottom, b.bottom) + margin)};
}

bool Motion::whole() const { return scale == 1 && dx == std::round(dx) && dy == std::round(dy); }

Mismatch mismatch_of(const AgentPictures& agent, const Motion& motion, const Range& range, int stride) {
  const Sampler sampler(agent, motion);
  std::array<ColourFit, 3> fits;
  double wrong = 0;
  size_t shown = 0;
  Mismatch out;
  for (int y = range.top; y <= range.bottom; ++y)
    for (int x = range.left + (y * 7) % stride; x <= range.right; x += stride) {
      const size_t here = sampler.index(x, y);
      const bool in_test = agent.test.ids.data[here] == agent.id;
      shown += in_test ? 1 : 0;
      const Cell cell = sampler.cell(x, y);
      if (!cell.inside || (!in_test && sampler.behind(here))) continue;
      const double cover = sampler.cover(cell);
      out.matched += in_test && cover > 0 ? 1 : 0;
      if (in_test && cover < 1 - 1e-9 && sampler.unknown(cell)) continue;
      const double gap = cover - (in_test ? 1 : 0);
      wrong += gap * gap;
      out.outline += std::abs(gap) > 0.5 ? 1 : 0;
      out.uncovered += std::abs(gap) > 1 - 1e-9 ? 1 : 0;
      if (in_test && cover > 1 - 1e-9)
        for (int c = 0; c < 3; ++c)
          fits.at(static_cast<size_t>(c))
              .add(sampler.mean(cell, agent.source.codes, c), agent.test.codes.data[3 * here + static_cast<size_t>(c)]);
    }
  const auto pixels = static_cast<double>(shown);
  if (fits[0].n > 0)
    for (const ColourFit& fit : fits) out.residual += fit.residual() / fit.n;
  else
    out.residual = kOutlinePixel;
  out.cost = stride * (out.residual * pixels + kOutlinePixel * wrong);
  out.outline *= static_cast<size_t>(stride);
  out.uncovered *= static_cast<size_t>(stride);
  out.matched *= static_cast<size_t>(stride);
  return out;
}

Mismatch least_mismatch(const AgentPictures& agent, const Extent& from, const Extent& to) {
  if (equal_in(agent, around(from, to, agent.now.ids, 0))) return {};
  return Search(agent, from, to).least();
}

double outline_length(const ImageU32& ids, uint32_t id, const Extent& extent) {
  const auto shows = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < ids.width && y < ids.height && *ids.at(x, y) == id;
  };
  size_t ends = 0;
  for (int y = extent.top; y <= extent.bottom + 1; ++y)
    for (int x = extent.left; x <= extent.right + 1; ++x) {
      ends += shows(x, y) != shows(x - 1, y) ? 1 : 0;
      ends += shows(x, y) != shows(x, y - 1) ? 1 : 0;
    }
  return 0.5 * static_cast<double>(ends);
}

std::optional<AgentMove> find_move(const AgentPictures& agent, const Extent& from, const Extent& to) {
  if (equal_in(agent, around(from, to, agent.now.ids, 0))) return std::nullopt;
  return Search(agent, from, to).run();
}

void put_in(const AgentPictures& agent, const Motion& motion, double farther, const Range& range, Layer& now) {
  std::vector<Pixel> pixels;
  const Laying laying(agent, motion, farther);
  for (int y = range.top; y <= range.bottom; ++y)
    for (int x = range.left; x <= range.right; ++x)
      if (const std::optional<Pixel> pixel = laying.at(x, y)) pixels.push_back(*pixel);
  for (const Pixel& pixel : pixels) {
    std::copy(pixel.codes.begin(), pixel.codes.end(), &now.codes.data[3 * pixel.place]);
    now.ids.data[pixel.place] = pixel.id;
    if (!now.depth.empty()) now.depth.data[pixel.place] = pixel.depth;
  }
}

}  // namespace crowdbench::metrics
