#include "metrics/picture_causes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "core/colour.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "metrics/agent_motion.h"
#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

Image8 rgb_of(const Image8& image) {
  Image8 out(image.width, image.height, 3);
  for (size_t i = 0; i < image.pixels(); ++i)
    for (int c = 0; c < 3; ++c)
      out.data[3 * i + static_cast<size_t>(c)] =
          image.data[i * static_cast<size_t>(image.channels) + static_cast<size_t>(std::min(c, image.channels - 1))];
  return out;
}

bool differ(const Layer& a, const Layer& b, size_t pixel) {
  return !std::equal(&a.codes.data[3 * pixel], &a.codes.data[3 * pixel] + 3, &b.codes.data[3 * pixel]);
}

void copy_pixel(const Layer& from, size_t pixel, Layer& to) {
  std::copy_n(&from.codes.data[3 * pixel], 3, &to.codes.data[3 * pixel]);
  to.ids.data[pixel] = from.ids.data[pixel];
  if (!to.depth.empty() && !from.depth.empty()) to.depth.data[pixel] = from.depth.data[pixel];
}

constexpr double kPlane = 1e-4;  // of the depth: as far as what is drawn in a plane may lie beside it
constexpr double kRelief = 0.1;  // of a body's pixels, those that lie beside any plane

// The share of the pixels that lie farther from the best plane than `tolerance` metres. In the picture the reciprocal
// of a plane's depth is a linear function of the place, whatever the lens.
double beside_plane(const ImageF& depth, const std::vector<size_t>& pixels, double tolerance) {
  const auto place = [&](size_t i) {
    const auto width = static_cast<size_t>(depth.width);
    const size_t row = i / width;
    return std::array{static_cast<double>(i % width), static_cast<double>(row)};
  };
  const auto reciprocal = [&](size_t i) { return 1 / static_cast<double>(depth.data[i]); };
  double n = 0, mx = 0, my = 0, mq = 0;
  for (const size_t i : pixels) {
    const auto [x, y] = place(i);
    n += 1, mx += x, my += y, mq += reciprocal(i);
  }
  mx /= n, my /= n, mq /= n;
  double xx = 0, xy = 0, yy = 0, xq = 0, yq = 0;
  for (const size_t i : pixels) {
    const auto [px, py] = place(i);
    const double x = px - mx, y = py - my, q = reciprocal(i) - mq;
    xx += x * x, xy += x * y, yy += y * y, xq += x * q, yq += y * q;
  }
  const double determinant = xx * yy - xy * xy;
  if (!(determinant > 1e-9 * xx * yy)) return 0;  // a line of pixels lies in a plane
  const double a = (xq * yy - yq * xy) / determinant;
  const double b = (yq * xx - xq * xy) / determinant;
  size_t beside = 0;
  for (const size_t i : pixels) {
    const auto [x, y] = place(i);
    const double plane = 1 / (mq + a * (x - mx) + b * (y - my));
    if (!(std::abs(static_cast<double>(depth.data[i]) - plane) <= tolerance)) ++beside;
  }
  return static_cast<double>(beside) / n;
}

// sRGB code values as linear light.
double linear_of(size_t code) {
  static const auto table = [] {
    std::array<double, 256> out{};
    for (size_t i = 0; i < out.size(); ++i) out.at(i) = srgb_to_linear(static_cast<double>(i) / 255);
    return out;
  }();
  return table[code];
}

// A pixel's colour, to be found again in other light.
class LightOf {
 public:
  explicit LightOf(const uint8_t* codes) {
    for (size_t c = 0; c < 3; ++c) {
      constexpr int kSlack = 6;  // code values, as a blurred texture differs from a sharp one
      sum_ += linear_of(codes[c]);
      low_.at(c) = linear_of(static_cast<size_t>(std::max(0, codes[c] - kSlack)));
      high_.at(c) = linear_of(static_cast<size_t>(std::min(255, codes[c] + kSlack)));
    }
  }
  bool is_that_of(const uint8_t* codes) const {
    const std::array<double, 3> own = {linear_of(codes[0]), linear_of(codes[1]), linear_of(codes[2])};
    const double sum = own[0] + own[1] + own[2];
    const double factor = sum > 0 ? sum_ / sum : 1;
    constexpr double kMost = 5;  // times as much light
    if (factor > kMost || factor < 1 / kMost) return false;
    for (size_t c = 0; c < 3; ++c)
      if (own.at(c) * factor < low_.at(c) || own.at(c) * factor > high_.at(c)) return false;
    return true;
  }

 private:
  double sum_ = 0;
  std::array<double, 3> low_{}, high_{};
};

class Telling {
 public:
  explicit Telling(const PicturesWithIds& pictures)
      : pictures_(pictures),
        now_{rgb_of(pictures.reference), pictures.reference_ids, {}},
        test_{rgb_of(pictures.test), pictures.test_ids, {}} {
    require_same_size(pictures.reference, pictures.test);
    require_same_size(pictures.reference, pictures.reference_ids);
    require_same_size(pictures.reference, pictures.test_ids);
    for (const ImageF* depth : {pictures.reference_depth, pictures.test_depth})
      if (depth) require_same_size(pictures.reference, *depth);
    if (pictures.reference_depth) now_.depth = *pictures.reference_depth;
    if (pictures.test_depth) test_.depth = *pictures.test_depth;
    for (const ImageU32* ids : {&pictures.reference_ids, &pictures.test_ids})
      for (const uint32_t id : ids->data)
        if (id != 0) changes_[id].id = id;
  }

  PictureCauses run() {
    std::array<std::string, kCauses> reasons = {};
    const auto reason = [&](Cause cause) -> std::string& { return reasons[static_cast<size_t>(cause)]; };
    reason(Cause::view) = "two pictures do not say what was stored; `quality` draws it";
    reason(Cause::level) = "two pictures do not say what was chosen; `quality` draws it";
    if (pictures_.posed)
      put_in_poses();
    else
      reason(Cause::pose) = "no picture of the reference in other poses was given (--pose-ref)";
    put_in_places();
    own_ = now_;
    find_recoloured();
    if (!now_.depth.empty()) {
      measure_gaps();
      find_cards();
    }
    put_in_order();
    put_in_silhouettes();
    if (now_.depth.empty())
      reason(Cause::surface) = "no depths were given (--depth-ref, --depth-test)";
    else
      put_in_surfaces();
    put_in_colours();
    steps_.push_back({std::nullopt, pictures_.test});
    PictureCauses out;
    std::vector<const ImageU32*> ids = {&pictures_.reference_ids, &pictures_.test_ids};
    if (pictures_.posed_ids) ids.push_back(pictures_.posed_ids);
    out.errors = error_by_cause(pictures_.reference, steps_, owners_of(ids));
    out.errors.reasons = std::move(reasons);
    for (auto& [id, change] : changes_) out.changes.push_back(std::move(change));
    return out;
  }

 private:
  size_t pixels() const { return now_.ids.pixels(); }

  // Whether an agent shows the other pose rather than its own, each moved as fits it best.
  bool is_late(uint32_t id, const Layer& posed, const Extent& was, const Extent& other, const Extent& shown) const {
    const Mismatch own = least_mismatch({now_, now_, test_, id}, was, shown);
    if (own.cost == 0) return false;
    const Mismatch late = least_mismatch({now_, posed, test_, id}, other, shown);
    constexpr double kExplains = 0.5;     // of the cost, or of the outline, what may be left
    constexpr double kSameColours = 1.1;  // what a pose alone explains of a repainted agent is its outline
    constexpr size_t kLeastOutline = 6;
    const bool cheaper = late.cost < kExplains * own.cost && late.outline <= own.outline;
    const bool fits = own.outline >= kLeastOutline && late.residual <= kSameColours * own.residual &&
                      static_cast<double>(late.outline) < kExplains * static_cast<double>(own.outline);
    return cheaper || fits;
  }

  void put_in_poses() {
    const Layer posed{rgb_of(*pictures_.posed), *pictures_.posed_ids, {}};
    require_same_size(now_.ids, posed.ids);
    require_same_size(now_.ids, posed.codes);
    const Extents own = extents_of(now_.ids);
    const Extents other = extents_of(posed.ids);
    const Extents shown = extents_of(test_.ids);
    std::vector<uint32_t> ids;
    for (const auto& [id, extent] : own)
      if (other.contains(id) && shown.contains(id)) ids.push_back(id);
    std::vector<uint8_t> late(ids.size());
    parallel_for(ids.size(), 0, [&](size_t i) {
      late[i] = is_late(ids[i], posed, own.at(ids[i]), other.at(ids[i]), shown.at(ids[i])) ? 1 : 0;
    });
    for (size_t i = 0; i < ids.size(); ++i) {
      if (late[i] == 0) continue;
      changes_[ids[i]].posed = true;
      put_in({now_, posed, test_, ids[i]}, {}, 0, around(own.at(ids[i]), other.at(ids[i]), now_.ids, 0), now_);
    }
    steps_.push_back({Cause::pose, now_.codes});
  }

  void put_in_places() {
    const Extents own = extents_of(now_.ids);
    const Extents shown = extents_of(test_.ids);
    std::vector<uint32_t> ids;
    for (const auto& [id, extent] : own)
      if (shown.contains(id)) ids.push_back(id);
    std::vector<std::optional<AgentMove>> moves(ids.size());
    std::vector<double> told(ids.size());
    parallel_for(ids.size(), 0, [&](size_t i) {
      const AgentPictures agent{now_, now_, test_, ids[i]};
      const Extent& from = own.at(ids[i]);
      const Extent& to = shown.at(ids[i]);
      moves[i] = find_move(agent, from, to);
      const Mismatch left = moves[i] ? moves[i]->after : mismatch_of(agent, {}, around(from, to, now_.ids, 2));
      told[i] = static_cast<double>(left.outline) / outline_length(now_.ids, ids[i], from);
    });
    for (size_t i = 0; i < ids.size(); ++i) {
      AgentChange& change = changes_[ids[i]];
      change.told_px = told[i];
      if (!moves[i]) continue;
      change.dx = moves[i]->motion.dx;
      change.dy = moves[i]->motion.dy;
      change.farther = moves[i]->farther;
      put_in({now_, now_, test_, ids[i]}, moves[i]->motion, moves[i]->farther.value_or(0),
             around(own.at(ids[i]), shown.at(ids[i]), now_.ids, 2), now_);
    }
    steps_.push_back({Cause::place, now_.codes});
  }

  // Agents have changed places where one is shown where the other was over 3 x 3 pixels at least, and where that is, of
  // both, more than all else that changed of their outlines: a limb that moved covers others, too, and uncovers them.
  void put_in_order() {
    using Pair = std::pair<uint32_t, uint32_t>;
    std::map<Pair, size_t> pixels_of;  // that showed the first, and show the second
    std::map<uint32_t, size_t> changed;
    std::set<Pair> thick;
    const auto pair_at = [&](int x, int y) { return Pair(*now_.ids.at(x, y), *test_.ids.at(x, y)); };
    for (int y = 0; y < now_.ids.height; ++y)
      for (int x = 0; x < now_.ids.width; ++x) {
        const Pair pair = pair_at(x, y);
        if (pair.first == pair.second) continue;
        ++changed[pair.first];
        ++changed[pair.second];
        if (pair.first == 0 || pair.second == 0) continue;
        ++pixels_of[pair];
        if (x == 0 || y == 0 || x + 1 == now_.ids.width || y + 1 == now_.ids.height || thick.contains(pair)) continue;
        bool filled = true;
        for (int j = -1; j <= 1 && filled; ++j)
          for (int i = -1; i <= 1 && filled; ++i) filled = pair_at(x + i, y + j) == pair;
        if (filled) thick.insert(pair);
      }
    const auto net = [&](const Pair& pair) {
      const size_t there = pixels_of[pair];
      const size_t back = pixels_of[{pair.second, pair.first}];
      return there - std::min(there, back);
    };
    std::map<uint32_t, size_t> exchanged;
    for (const Pair& pair : thick)
      for (const uint32_t id : {pair.first, pair.second}) exchanged[id] += net(pair);
    const auto moved = [&](uint32_t id) { return 2 * exchanged[id] <= changed[id]; };
    std::erase_if(thick, [&](const Pair& pair) { return net(pair) == 0 || moved(pair.first) || moved(pair.second); });
    put_in_where(Cause::order, [&](size_t i) { return thick.contains({now_.ids.data[i], test_.ids.data[i]}); });
    for (const auto& [behind, before] : thick) changes_[behind].changed_places_with.push_back(before);
  }

  void put_in_silhouettes() {
    put_in_where(Cause::silhouette, [&](size_t i) { return now_.ids.data[i] != test_.ids.data[i]; });
  }

  // How much farther away the surface that is drawn for an agent is than it would be where the agent was found to have
  // moved to: the same points of its body are compared.
  void measure_gaps() {
    struct Depths {
      std::vector<double> gaps, own;
    };
    std::map<uint32_t, Depths> depths;
    for (size_t i = 0; i < pixels(); ++i)
      if (const uint32_t id = now_.ids.data[i]; id != 0 && id == test_.ids.data[i]) {
        const auto own = static_cast<double>(now_.depth.data[i]);
        const double gap = static_cast<double>(test_.depth.data[i]) - own;
        if (!std::isfinite(gap)) continue;
        depths[id].gaps.push_back(gap);
        depths[id].own.push_back(own);
      }
    for (auto& [id, of] : depths) {
      AgentChange& change = changes_[id];
      const double gap = median_in_place(of.gaps);
      change.thickness = quantile(of.own, 0.95) - quantile(of.own, 0.05);
      change.surface_farther = change.farther.value_or(0) + gap;
      if (!change.farther && std::abs(gap) <= kSurfaceTolerance) change.farther = gap;
    }
  }

  void find_cards() {
    std::map<uint32_t, std::vector<size_t>> own, shown;
    for (size_t i = 0; i < pixels(); ++i) {
      if (const uint32_t id = pictures_.reference_ids.data[i]; id != 0) own[id].push_back(i);
      if (const uint32_t id = test_.ids.data[i]; id != 0) shown[id].push_back(i);
    }
    for (auto& [id, change] : changes_) {
      if (!own.contains(id) || !shown.contains(id)) continue;
      const std::vector<size_t>& drawn = shown.at(id);
      const double plane = kPlane * static_cast<double>(test_.depth.data[drawn[0]]);
      change.card = beside_plane(test_.depth, drawn, plane) == 0 &&
                    beside_plane(*pictures_.reference_depth, own.at(id), kSurfaceTolerance) > kRelief;
    }
  }

  void put_in_surfaces() {
    constexpr double kWhole = 2;  // of what is seen of a body's thickness: its back is about as far behind its middle
    const Extents extents = extents_of(own_.ids);
    put_in_where(Cause::surface, [&](size_t i) {
      const uint32_t id = test_.ids.data[i];
      if (id == 0 || changes_.at(id).card) return false;
      const double gap = std::abs(static_cast<double>(now_.depth.data[i]) - static_cast<double>(test_.depth.data[i]));
      if (!(gap > kSurfaceTolerance)) return false;
      if (!(gap <= kWhole * changes_.at(id).thickness) || !extents.contains(id) || !differ(now_, test_, i)) return true;
      return has_colour_near(i, extents.at(id));
    });
  }

  // Whether the reference shows the agent in the test pixel's colour, in some light, within a twelfth of its height.
  bool has_colour_near(size_t i, const Extent& extent) const {
    const auto width = static_cast<size_t>(own_.ids.width);
    const auto x = static_cast<int>(i % width);
    const auto y = static_cast<int>(i / width);
    const int reach = std::clamp((extent.bottom - extent.top + 1) / 12, 2, 16);
    const LightOf shown(&test_.codes.data[3 * i]);
    for (int v = std::max(extent.top, y - reach); v <= std::min(extent.bottom, y + reach); ++v)
      for (int u = std::max(extent.left, x - reach); u <= std::min(extent.right, x + reach); ++u)
        if (*own_.ids.at(u, v) == test_.ids.data[i] && shown.is_that_of(own_.codes.at(u, v))) return true;
    return false;
  }

  void find_recoloured() {
    struct Sums {
      std::array<double, 3> own{}, shown{};  // linear
      size_t pixels = 0;
    };
    std::map<uint32_t, Sums> sums;
    for (size_t i = 0; i < pixels(); ++i) {
      const uint32_t id = own_.ids.data[i];
      if (id == 0 || id != test_.ids.data[i]) continue;
      Sums& of = sums[id];
      ++of.pixels;
      for (size_t c = 0; c < 3; ++c) {
        of.own.at(c) += linear_of(own_.codes.data[3 * i + c]);
        of.shown.at(c) += linear_of(test_.codes.data[3 * i + c]);
      }
    }
    for (const auto& [id, of] : sums)
      changes_[id].recoloured = of.pixels >= kLeastSeen && is_other_colour(of.own, of.shown);
  }

  // Of two sums of linear light: whether their colours, brought to one lightness, are farther apart than a blur, a
  // wrong outline or another view make the mean of an agent.
  static bool is_other_colour(const std::array<double, 3>& a, const std::array<double, 3>& b) {
    constexpr double kOther = 0.04;  // of the sum of the three shares, 1
    const double of_a = a[0] + a[1] + a[2];
    const double of_b = b[0] + b[1] + b[2];
    if (of_a == 0 || of_b == 0) return false;
    double most = 0;
    for (size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(a.at(c) / of_a - b.at(c) / of_b));
    return most > kOther;
  }

  void put_in_colours() {
    const std::set<uint32_t> relit = relit_agents();
    put_in_where(Cause::shading, [&](size_t i) {
      const uint32_t id = test_.ids.data[i];
      if (id == 0 || !differ(now_, test_, i)) return false;
      return unclear(i) ? relit.contains(id) : lightness_alone(i);
    });
    put_in_where(Cause::texture, [&](size_t i) { return test_.ids.data[i] != 0 && differ(now_, test_, i); });
  }

  // So small a difference that rounding makes it look like either.
  bool unclear(size_t i) const {
    constexpr int kSmall = 3;  // code values
    for (size_t c = 3 * i; c < 3 * i + 3; ++c)
      if (std::abs(int{now_.codes.data[c]} - int{test_.codes.data[c]}) > kSmall) return false;
    return true;
  }

  // Agents most of whose clear differences are of lightness alone; of all, where none is clear.
  std::set<uint32_t> relit_agents() const {
    struct Votes {
      size_t clear = 0, clear_relit = 0, all = 0, all_relit = 0;
    };
    std::map<uint32_t, Votes> votes;
    for (size_t i = 0; i < pixels(); ++i) {
      const uint32_t id = test_.ids.data[i];
      if (id == 0 || !differ(now_, test_, i)) continue;
      Votes& of = votes[id];
      const size_t relit = lightness_alone(i) ? 1 : 0;
      of.all += 1;
      of.all_relit += relit;
      if (unclear(i)) continue;
      of.clear += 1;
      of.clear_relit += relit;
    }
    std::set<uint32_t> out;
    for (const auto& [id, of] : votes)
      if (of.clear > 0 ? 2 * of.clear_relit > of.clear : 2 * of.all_relit > of.all) out.insert(id);
    return out;
  }

  // Whether the pixel's channels all changed by one factor in linear light, by one factor in code values or by one
  // amount in code values, to within what code values round; a channel at an end of the range may have met it.
  bool lightness_alone(size_t i) const {
    const uint8_t* a = &now_.codes.data[3 * i];
    const uint8_t* b = &test_.codes.data[3 * i];
    std::array<double, 3> linear{};
    double from_linear = 0, to_linear = 0, from = 0, to = 0, amount = 0;
    int within = 0;  // channels that met no end
    for (size_t c = 0; c < 3; ++c) {
      linear.at(c) = srgb_to_linear(a[c] / 255.0);
      if (b[c] == 0 || b[c] == 255) continue;
      from_linear += linear.at(c);
      to_linear += srgb_to_linear(b[c] / 255.0);
      from += a[c];
      to += b[c];
      amount += int{b[c]} - int{a[c]};
      ++within;
    }
    // What became black or white shows nothing else.
    if (within == 0) return b[0] == b[1] && b[1] == b[2];
    const auto fits = [&](const auto& predicted) {
      constexpr double kRounding = 1.5;  // code values
      for (size_t c = 0; c < 3; ++c)
        if (std::abs(std::clamp(predicted(c), 0.0, 255.0) - b[c]) > kRounding) return false;
      return true;
    };
    if (fits([&](size_t c) { return a[c] + amount / within; })) return true;
    if (from == 0) return false;
    return fits([&](size_t c) { return a[c] * to / from; }) ||
           fits([&](size_t c) { return 255 * linear_to_srgb(std::min(1.0, linear.at(c) * to_linear / from_linear)); });
  }

  template <typename Where>
  void put_in_where(Cause cause, const Where& where) {
    std::vector<size_t> places;
    for (size_t i = 0; i < pixels(); ++i)
      if (where(i)) places.push_back(i);
    for (const size_t i : places) copy_pixel(test_, i, now_);
    steps_.push_back({cause, now_.codes});
  }

  const PicturesWithIds& pictures_;
  static constexpr size_t kLeastSeen = 16;  // pixels that say which colour an agent has
  Layer now_;
  Layer test_;
  Layer own_;  // the reference, its agents in their poses and at their places in the test
  std::map<uint32_t, AgentChange> changes_;
  std::vector<CauseStep> steps_;
};

}  // namespace

PictureCauses causes_of_pictures(const PicturesWithIds& pictures) { return Telling(pictures).run(); }

}  // namespace crowdbench::metrics
