#include "metrics/picture_causes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "core/colour.h"
#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

// Of the squared error, what may be left after a pose or a shift for it to count as the explanation.
constexpr double kExplains = 0.5;

struct Extent {
  int left = 0, top = 0, right = -1, bottom = -1;  // inclusive
  double x = 0, y = 0;                             // the mean
  size_t pixels = 0;
  void add(int px, int py) {
    if (pixels == 0) *this = {px, py, px, py, 0, 0, 0};
    left = std::min(left, px), right = std::max(right, px);
    top = std::min(top, py), bottom = std::max(bottom, py);
    x += (px - x) / static_cast<double>(++pixels);
    y += (py - y) / static_cast<double>(pixels);
  }
};
using Extents = std::map<uint32_t, Extent>;

Extents extents_of(const ImageU32& ids) {
  Extents out;
  for (int y = 0; y < ids.height; ++y)
    for (int x = 0; x < ids.width; ++x)
      if (const uint32_t id = *ids.at(x, y); id != 0) out[id].add(x, y);
  return out;
}

// A picture with who is where, while causes are put in.
struct Layer {
  Image8 codes;  // RGB
  ImageU32 ids;
  ImageF depth;  // metres; empty: not known
};

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

void copy_pixel(const Layer& from, size_t source, Layer& to, size_t place) {
  std::copy_n(&from.codes.data[3 * source], 3, &to.codes.data[3 * place]);
  to.ids.data[place] = from.ids.data[source];
  if (!to.depth.empty() && !from.depth.empty()) to.depth.data[place] = from.depth.data[source];
}

// One agent of `now` replaced by what `source` shows of it, moved by (dx, dy). What it leaves is as the test has it,
// and so is what stands before it at its new place: an agent that was there and still is.
class Replacement {
 public:
  Replacement(const Layer& now, const Layer& source, const Layer& test, uint32_t id, int dx, int dy)
      : now_(now), source_(source), test_(test), id_(id), dx_(dx), dy_(dy) {}

  struct Origin {
    const Layer* layer;
    size_t pixel;
    bool shows;  // the agent
  };
  // From which layer, and from which of its pixels, this pixel comes. Where the agent left a pixel and the test has it
  // there all the same, nobody knows what it uncovered: the pixel stays as it was.
  Origin origin(int x, int y) const {
    const size_t here = index(x, y);
    const int sx = x - dx_;
    const int sy = y - dy_;
    const uint32_t shown = test_.ids.data[here];
    const uint32_t was = now_.ids.data[here];
    if (sx >= 0 && sy >= 0 && sx < now_.ids.width && sy < now_.ids.height && source_.ids.data[index(sx, sy)] == id_) {
      const bool hidden = shown != 0 && shown != id_ && was == shown;
      return hidden ? Origin{&now_, here, false} : Origin{&source_, index(sx, sy), true};
    }
    return {was == id_ && shown != id_ ? &test_ : &now_, here, false};
  }
  size_t index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(now_.ids.width) + static_cast<size_t>(x);
  }

 private:
  const Layer& now_;
  const Layer& source_;
  const Layer& test_;
  uint32_t id_;
  int dx_, dy_;
};

// What is left of the error against the test in the box, and how many pixels differ in whether they show the agent.
struct Left {
  int64_t error = 0;
  size_t outline = 0;
};

struct Range {
  int left, top, right, bottom;  // inclusive
};

Left left_after(const Replacement& replacement, const Layer& test, uint32_t id, const Range& range) {
  Left out;
  for (int y = range.top; y <= range.bottom; ++y)
    for (int x = range.left; x <= range.right; ++x) {
      const size_t here = replacement.index(x, y);
      const auto [layer, from, shows] = replacement.origin(x, y);
      const bool should = test.ids.data[here] == id;
      if (!shows && !should) continue;
      out.outline += shows != should ? 1 : 0;
      for (size_t c = 0; c < 3; ++c) {
        const int d = int{layer->codes.data[3 * from + c]} - int{test.codes.data[3 * here + c]};
        out.error += d * d;
      }
    }
  return out;
}

Range around(const Extent& a, const Extent& b, const ImageU32& ids, int margin) {
  return {std::max(0, std::min(a.left, b.left) - margin), std::max(0, std::min(a.top, b.top) - margin),
          std::min(ids.width - 1, std::max(a.right, b.right) + margin),
          std::min(ids.height - 1, std::max(a.bottom, b.bottom) + margin)};
}

bool explains(const Left& before, const Left& after) {
  return static_cast<double>(after.error) < kExplains * static_cast<double>(before.error) &&
         after.outline <= before.outline;
}

// now: not a layer that the replacement reads.
void replace(Layer& now, const Replacement& replacement, const Range& range) {
  for (int y = range.top; y <= range.bottom; ++y)
    for (int x = range.left; x <= range.right; ++x) {
      const auto [layer, from, shows] = replacement.origin(x, y);
      copy_pixel(*layer, from, now, replacement.index(x, y));
    }
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
    if (!now_.depth.empty()) measure_gaps();
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

  void put_in_poses() {
    const Layer posed{rgb_of(*pictures_.posed), *pictures_.posed_ids, {}};
    require_same_size(now_.ids, posed.ids);
    require_same_size(now_.ids, posed.codes);
    const Extents own = extents_of(now_.ids);
    const Extents other = extents_of(posed.ids);
    const Extents shown = extents_of(test_.ids);
    for (const auto& [id, extent] : own) {
      const auto there = other.find(id);
      const auto then = shown.find(id);
      if (there == other.end() || then == shown.end()) continue;
      Range range = around(extent, there->second, now_.ids, 0);
      const Range with_test = around(there->second, then->second, now_.ids, 0);
      range = {std::min(range.left, with_test.left), std::min(range.top, with_test.top),
               std::max(range.right, with_test.right), std::max(range.bottom, with_test.bottom)};
      const Left before = left_after({now_, now_, test_, id, 0, 0}, test_, id, range);
      if (!explains(before, left_after({now_, posed, test_, id, 0, 0}, test_, id, range))) continue;
      changes_[id].posed = true;
      const Layer was = now_;
      replace(now_, {was, posed, test_, id, 0, 0}, range);
    }
    steps_.push_back({Cause::pose, now_.codes});
  }

  void put_in_places() {
    const Extents own = extents_of(now_.ids);
    const Extents shown = extents_of(test_.ids);
    for (const auto& [id, extent] : own) {
      const auto then = shown.find(id);
      if (then == shown.end()) continue;
      const Range range = around(extent, then->second, now_.ids, 2);
      const Left before = left_after({now_, now_, test_, id, 0, 0}, test_, id, range);
      if (before.outline == 0) continue;  // it is where it was
      Left best = before;
      for (const auto& [dx, dy] : candidates(extent, then->second)) {
        const Left left = left_after({now_, now_, test_, id, dx, dy}, test_, id, range);
        // What another agent uncovers moves the edges of what is seen, too, but brings no outline to its place.
        const bool fits = static_cast<double>(left.outline) < kExplains * static_cast<double>(before.outline);
        if (!fits || !explains(before, left) || left.error >= best.error) continue;
        best = left;
        changes_[id].dx = dx;
        changes_[id].dy = dy;
      }
      if (best.error == before.error) continue;
      const Layer was = now_;
      replace(now_, {was, was, test_, id, changes_[id].dx, changes_[id].dy}, range);
    }
    steps_.push_back({Cause::place, now_.codes});
  }

  // Agents have changed places where one shows what the other showed over 3 x 3 pixels at least, and where that is more
  // than all else that changed of its outline: a limb that moved uncovers others, too.
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
    std::map<uint32_t, size_t> exchanged;
    for (const Pair& pair : thick) exchanged[pair.first] += pixels_of[pair];
    std::erase_if(thick, [&](const Pair& pair) { return 2 * exchanged[pair.first] <= changed[pair.first]; });
    put_in_where(Cause::order, [&](size_t i) { return thick.contains({now_.ids.data[i], test_.ids.data[i]}); });
    for (const auto& [behind, before] : thick) changes_[behind].changed_places_with.push_back(before);
  }

  void put_in_silhouettes() {
    put_in_where(Cause::silhouette, [&](size_t i) { return now_.ids.data[i] != test_.ids.data[i]; });
  }

  // How much farther away an agent is than where it was found to have moved to in the picture: the same points of its
  // body are compared.
  void measure_gaps() {
    std::map<uint32_t, std::vector<double>> farther;
    for (size_t i = 0; i < pixels(); ++i)
      if (const uint32_t id = now_.ids.data[i]; id != 0 && id == test_.ids.data[i])
        farther[id].push_back(static_cast<double>(test_.depth.data[i]) - static_cast<double>(now_.depth.data[i]));
    for (auto& [id, gaps] : farther) {
      std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2), gaps.end());
      changes_[id].farther = gaps[gaps.size() / 2];
    }
  }

  void put_in_surfaces() {
    put_in_where(Cause::surface, [&](size_t i) {
      if (test_.ids.data[i] == 0) return false;
      return std::abs(static_cast<double>(now_.depth.data[i]) - static_cast<double>(test_.depth.data[i])) >
             kSurfaceTolerance;
    });
  }

  void put_in_colours() {
    put_in_where(Cause::shading,
                 [&](size_t i) { return test_.ids.data[i] != 0 && differ(now_, test_, i) && one_factor(i); });
    put_in_where(Cause::texture, [&](size_t i) { return test_.ids.data[i] != 0 && differ(now_, test_, i); });
  }

  // Whether the pixel's channels differ by one factor in linear light, to within what code values round.
  bool one_factor(size_t i) const {
    const uint8_t* a = &now_.codes.data[3 * i];
    const uint8_t* b = &test_.codes.data[3 * i];
    double from = 0;
    double to = 0;
    for (size_t c = 0; c < 3; ++c) {
      from += srgb_to_linear(a[c] / 255.0);
      to += srgb_to_linear(b[c] / 255.0);
    }
    if (from == 0) return false;
    constexpr double kRounding = 1.5;  // code values
    for (size_t c = 0; c < 3; ++c)
      if (std::abs(255 * linear_to_srgb(srgb_to_linear(a[c] / 255.0) * to / from) - b[c]) > kRounding) return false;
    return true;
  }

  template <typename Where>
  void put_in_where(Cause cause, const Where& where) {
    std::vector<size_t> places;
    for (size_t i = 0; i < pixels(); ++i)
      if (where(i)) places.push_back(i);
    for (const size_t i : places) copy_pixel(test_, i, now_, i);
    steps_.push_back({cause, now_.codes});
  }

  const PicturesWithIds& pictures_;
  Layer now_;
  Layer test_;
  std::map<uint32_t, AgentChange> changes_;
  std::vector<CauseStep> steps_;
};

}  // namespace

PictureCauses causes_of_pictures(const PicturesWithIds& pictures) { return Telling(pictures).run(); }

}  // namespace crowdbench::metrics
