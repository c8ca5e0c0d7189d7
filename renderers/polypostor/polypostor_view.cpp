#include "renderers/polypostor/polypostor_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>

#include "renderers/polypostor/polypostor_contour.h"
#include "renderers/polypostor/polypostor_key.h"
#include "renderers/polypostor/polypostor_order.h"
#include "renderers/polypostor/polypostor_torn.h"

namespace crowdbench::renderers {
namespace {

constexpr double kSeen = 1;       // texels of level 0: a part that shows less is not worth an image
constexpr double kSmooth = 0.15;  // texels: what outlines may leave of their masks' samples' steps
constexpr double kTorn = 0.5;     // square texels of one part in both poses of a step: worth a key more
constexpr int kMostCorners = 32;  // of a polygon
constexpr size_t kMostKeys = 6;   // of a part

// Poses from a stored frame to the next.
size_t pose_step(size_t poses) { return poses > 1 ? size_t{kPosesAFrame} : 1; }

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

// The tier's texels in a view's axes, from the capture centre; z towards the eye.
glm::dvec3 in_view(const PolypostorPlan& plan, const PolypostorTier& tier, const ViewBasis& basis,
                   const glm::dvec3& p) {
  const glm::dvec3 d = (p - plan.sphere.centre) / (plan.texel * tier.texel);
  return {glm::dot(d, basis.right), glm::dot(d, basis.up), glm::dot(d, basis.to_eye)};
}
// Where the plan's eye sees such a point on the plane through the centre; z stays.
glm::dvec3 from_eye(const PolypostorPlan& plan, const PolypostorTier& tier, const glm::dvec3& p) {
  const double k = plan.eye / (plan.eye - p.z * tier.texel);
  return {k * p.x, k * p.y, p.z};
}

// Where skinning takes points of the image, which is the eye's, by the nearest edge of the part's mesh at the key.
class Carrier {
 public:
  // key: a pose of the clip; seen: all vertices in it, as from_eye has them.
  Carrier(const PolypostorPlan& plan, const PolypostorTier& tier, const ViewBasis& basis, const StoredClip& clip,
          size_t part, size_t key, std::span<const glm::dvec3> seen)
      : mesh_(tier.cut.character->mesh),
        plan_(plan),
        tier_(tier),
        basis_(basis),
        corners_(tier.corners[part]),
        seen_(seen),
        first_(clip.first_frame),
        frames_(clip.frames),
        key_(clip.first_frame + key) {}

  Polyline operator()(const glm::dvec2& p) const {
    double least = INFINITY;
    std::array<uint32_t, 2> edge{};
    double along = 0;
    double height = 0;
    for (size_t i = 0; i < corners_.size(); ++i) {
      const uint32_t v = corners_[i];
      const uint32_t w = corners_[i % 3 == 2 ? i - 2 : i + 1];
      const glm::dvec3& a = seen_[v];
      const glm::dvec3& b = seen_[w];
      const glm::dvec2 ab(b - a);
      const double square = glm::dot(ab, ab);
      const double t = square > 0 ? std::clamp(glm::dot(p - glm::dvec2(a), ab) / square, 0.0, 1.0) : 0.0;
      const glm::dvec2 off = glm::dvec2(a) + ab * t - p;
      const double distance = glm::dot(off, off);
      if (distance >= least) continue;
      least = distance;
      edge = {v, w};
      along = t;
      height = a.z + (b.z - a.z) * t;
    }
    const glm::dvec2 away = p * ((plan_.eye - height * tier_.texel) / plan_.eye);  // from_eye, backwards
    const glm::dvec3 point =
        plan_.sphere.centre +
        plan_.texel * tier_.texel * (away.x * basis_.right + away.y * basis_.up + height * basis_.to_eye);
    const std::array<glm::dvec3, 2> bound = {unposed(edge[0], point), unposed(edge[1], point)};
    Polyline out;
    for (size_t f = first_; f < first_ + frames_; ++f) {
      const glm::dvec3 there = glm::mix(glm::dvec3(skin(edge[0], f) * glm::dvec4(bound[0], 1)),
                                        glm::dvec3(skin(edge[1], f) * glm::dvec4(bound[1], 1)), along);
      out.emplace_back(from_eye(plan_, tier_, in_view(plan_, tier_, basis_, there)));
    }
    return out;
  }

 private:
  glm::dmat4 skin(uint32_t vertex, size_t frame) const {
    glm::dmat4 m(0.0);
    for (int k = 0; k < scene::kInfluences; ++k) {
      const scene::Mat3x4& joint = plan_.palettes[frame][mesh_.joints[vertex][k]];
      for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
          m[column][row] +=
              static_cast<double>(mesh_.weights[vertex][k]) * static_cast<double>(joint.rows[row][column]);
    }
    m[3][3] = 1;
    return m;
  }
  glm::dvec3 unposed(uint32_t vertex, const glm::dvec3& p) const {
    const glm::dmat4 m = skin(vertex, key_);
    if (std::abs(glm::determinant(glm::dmat3(m))) < 1e-18) return glm::dvec3(mesh_.positions[vertex]);
    return glm::dvec3(glm::inverse(m) * glm::dvec4(p, 1));
  }

  const scene::Mesh& mesh_;
  const PolypostorPlan& plan_;
  const PolypostorTier& tier_;
  const ViewBasis& basis_;
  std::span<const uint32_t> corners_;
  std::span<const glm::dvec3> seen_;
  size_t first_, frames_, key_;
};

// scale: of the rectangle's texels.
TileRect rect_around(const Polyline& contour, double scale) {
  glm::dvec2 low(INFINITY);
  glm::dvec2 high(-INFINITY);
  for (const glm::dvec2& p : contour) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const glm::ivec2 first(glm::floor(scale * low));
  const glm::ivec2 last(glm::ceil(scale * high));
  return {first.x, first.y, last.x - first.x, last.y - first.y};
}

// What a view sees of one part through a clip.
struct SeenPart {
  std::vector<Polyline> contours;           // by pose
  std::vector<TileRect> rects;              // by pose: around the contour as it was traced, texels of level 0
  std::vector<double> areas;                // by pose, texels of level 0
  std::vector<std::vector<double>> errors;  // by key and pose: look_error; empty where the key does not show the part
};
struct SeenView {
  std::vector<std::vector<glm::dvec3>> positions;  // by pose and vertex: from_eye
  std::vector<SeenPart> parts;
  std::vector<PartMask> figures;  // by pose: all parts
};

// Turns triangles round that are seen from behind as well and lie that way.
void face_the_eye(const std::vector<uint8_t>& two_sided, std::vector<glm::dvec2>& corners) {
  for (size_t t = 0; t < two_sided.size(); ++t) {
    if (two_sided[t] == 0) continue;
    const glm::dvec2 a = corners[3 * t + 1] - corners[3 * t];
    const glm::dvec2 b = corners[3 * t + 2] - corners[3 * t];
    if (a.x * b.y - a.y * b.x < 0) std::swap(corners[3 * t + 1], corners[3 * t + 2]);
  }
}

// Errors of looks by key and pose: of stored frames, and between two of them their mean.
std::vector<std::vector<double>> look_errors(const PolypostorTier& tier, const std::vector<uint32_t>& corners,
                                             const SeenView& view, const SeenPart& part,
                                             const std::vector<std::vector<glm::vec3>>& normals) {
  const size_t poses = view.positions.size();
  const size_t step = pose_step(poses);
  std::vector<PartLook> images(poses);
  for (size_t f = 0; f < poses; f += step) images[f] = look_at_part(corners, view.positions[f], normals[f], tier.tones);
  std::vector<std::vector<double>> errors(poses);
  for (size_t k = 0; k < poses; k += step) {
    if (part.areas[k] < kSeen) continue;
    errors[k].resize(poses);
    for (size_t f = 0; f < poses; f += step)
      if (f != k) errors[k][f] = look_error(images[k], images[f], corners, view.positions[k], view.positions[f]);
    for (size_t f = 0; f < poses; ++f)
      if (f % step != 0) errors[k][f] = 0.5 * (errors[k][f - f % step] + errors[k][(f - f % step + step) % poses]);
  }
  return errors;
}

// looks: whether keys are to be compared.
SeenView see_parts(const PolypostorPlan& plan, const PolypostorTier& tier, const StoredClip& clip,
                   const ViewBasis& basis, bool looks) {
  SeenView out;
  std::vector<std::vector<glm::vec3>> normals;  // view axes
  const glm::mat3 to_view = glm::transpose(glm::mat3(basis.right, basis.up, basis.to_eye));
  for (uint32_t f = 0; f < clip.frames; ++f) {
    auto& points = out.positions.emplace_back();
    for (const glm::vec3& p : tier.positions[clip.first_frame + f])
      points.push_back(from_eye(plan, tier, in_view(plan, tier, basis, glm::dvec3(p))));
    auto& turned = normals.emplace_back();
    for (const glm::vec3& n : tier.normals[clip.first_frame + f]) turned.push_back(to_view * n);
  }
  out.parts.resize(tier.corners.size());
  std::vector<PartMask> masks(tier.corners.size());
  std::vector<glm::dvec2> flat;
  for (uint32_t f = 0; f < clip.frames; ++f) {
    for (size_t c = 0; c < tier.corners.size(); ++c) {
      SeenPart& part = out.parts[c];
      flat.clear();
      for (const uint32_t v : tier.corners[c]) flat.emplace_back(out.positions[f][v]);
      face_the_eye(tier.two_sided[c], flat);
      masks[c] = rasterise(flat);
      part.areas.push_back(facing_area(masks[c]) * tier.texel * tier.texel);
      const Polyline traced = part.areas.back() > 0 ? trace_contour(masks[c]) : Polyline{};
      part.contours.push_back(simplify(traced, kSmooth));
      part.rects.push_back(traced.empty() ? TileRect{} : rect_around(traced, tier.texel));
    }
    out.figures.push_back(unite(masks));
  }
  for (size_t c = 0; c < tier.corners.size(); ++c) {
    SeenPart& part = out.parts[c];
    part.errors.resize(clip.frames);
    if (looks) part.errors = look_errors(tier, tier.corners[c], out, part, normals);
  }
  return out;
}

// One key's polygon, and what it makes of every pose.
struct KeyFit {
  Fit fit;
  TileRect rect;              // of the image
  std::vector<double> costs;  // by its looks, and by the texels between its outline and the pose's own
  std::vector<double> torn;   // torn_area
};

// Which of them costs least from pose f to the next.
template <typename Costly>
size_t cheapest(const Costly& fits, size_t f, size_t poses) {
  const auto cost = [&](const auto& one) { return one.costs[f] + one.costs[(f + 1) % poses]; };
  return static_cast<size_t>(
      std::min_element(fits.begin(), fits.end(), [&](const auto& a, const auto& b) { return cost(a) < cost(b); }) -
      fits.begin());
}

class KeyFitter {
 public:
  // wanted: the part's outlines, by pose. fit(key, finely): its image and polygon, of more corners where it is to be
  // fine.
  KeyFitter(const SeenPart& part, std::span<const WantedOutline> wanted, std::function<KeyFit(size_t, bool)> fit)
      : part_(part), wanted_(wanted), fit_(std::move(fit)) {}

  // The fits whose images of the part are kept: none, one, or several.
  std::vector<KeyFit> run(KeyChoice choice) {
    refines_ = choice == KeyChoice::enough;
    std::vector<size_t> keys;
    for (size_t k = 0; k < part_.areas.size(); k += pose_step(part_.areas.size()))
      if (part_.areas[k] >= kSeen) keys.push_back(k);
    if (keys.empty()) return {};
    if (choice == KeyChoice::first) return fitted({keys[0]});
    if (choice == KeyChoice::two_keys && keys.size() > 1) return fitted(best_pair(keys));
    // By their looks first; of the best of those, by what their polygons make of them.
    std::stable_sort(keys.begin(), keys.end(),
                     [&](size_t a, size_t b) { return sum(part_.errors[a]) < sum(part_.errors[b]); });
    std::vector<KeyFit> out = best_of(keys, choice == KeyChoice::enough ? 1 : 6);
    if (choice == KeyChoice::enough && !out.empty()) mend(keys, out);
    return out;
  }

 private:
  std::vector<KeyFit> fitted(std::span<const size_t> keys) const {
    std::vector<KeyFit> out;
    for (const size_t k : keys) {
      KeyFit one = judged(k, false);
      if (one.fit.polygon.empty()) continue;
      if (refines_ && torn_around(one, k) > kTorn) {
        KeyFit fine = judged(k, true);
        if (!fine.fit.polygon.empty() && torn_around(fine, k) < torn_around(one, k)) one = std::move(fine);
      }
      out.push_back(std::move(one));
    }
    return out;
  }

  // In the key's own pose and those beside it: its own step and the one before.
  static double torn_around(const KeyFit& fit, size_t key) {
    const size_t poses = fit.torn.size();
    return fit.torn[(key + poses - 1) % poses] + fit.torn[key] + fit.torn[(key + 1) % poses];
  }

  KeyFit judged(size_t key, bool finely) const {
    constexpr double kOutline = 3;  // of looks, a square texel between the outlines
    constexpr double kTear = 12;    // one that is torn
    KeyFit one = fit_(key, finely);
    if (one.fit.polygon.empty()) return one;
    one.costs = part_.errors[key];
    one.costs.resize(part_.areas.size());
    for (size_t f = 0; f < part_.areas.size(); ++f) {
      one.torn.push_back(wanted_[f].torn(one.fit.outlines[f]));
      one.costs[f] += kOutline * one.fit.errors[f] * wanted_[f].perimeter() + kTear * one.torn[f];
    }
    one.fit.outlines.clear();
    return one;
  }
  std::vector<KeyFit> fitted(std::initializer_list<size_t> keys) const {
    return fitted(std::span<const size_t>(keys.begin(), keys.size()));
  }

  // The pair that looks best, each step between poses shown by the better one.
  std::array<size_t, 2> best_pair(std::span<const size_t> keys) const {
    const size_t poses = part_.areas.size();
    std::array<size_t, 2> best{};
    double least = INFINITY;
    for (size_t i = 0; i < keys.size(); ++i)
      for (size_t j = 0; j < i; ++j) {
        const std::vector<double>& a = part_.errors[keys[i]];
        const std::vector<double>& b = part_.errors[keys[j]];
        double cost = 0;
        for (size_t f = 0; f < poses; ++f) cost += std::min(a[f] + a[(f + 1) % poses], b[f] + b[(f + 1) % poses]);
        if (cost >= least) continue;
        least = cost;
        best = {keys[j], keys[i]};
      }
    return best;
  }

  // Of the first so many keys the one of least cost.
  std::vector<KeyFit> best_of(std::span<const size_t> keys, size_t tried) const {
    std::vector<KeyFit> out;
    for (const size_t k : keys.first(std::min(keys.size(), tried))) {
      std::vector<KeyFit> one = fitted({k});
      if (!one.empty() && (out.empty() || sum(one[0].costs) < sum(out[0].costs))) out = std::move(one);
    }
    return out;
  }

  // Adds keys while a step is torn, each the frame nearest to the step that is torn most; those that no step shows go.
  void mend(std::span<const size_t> keys, std::vector<KeyFit>& fits) const {
    const size_t poses = part_.areas.size();
    std::vector<uint8_t> tried(poses, 0);
    std::vector<uint8_t> given_up(poses, 0);
    for (const KeyFit& f : fits) tried[f.fit.key] = 1;
    while (fits.size() < kMostKeys) {
      size_t worst = poses;
      double most = kTorn;
      for (size_t s = 0; s < poses; ++s) {
        double least = INFINITY;
        for (const KeyFit& f : fits) least = std::min(least, f.torn[s] + f.torn[(s + 1) % poses]);
        if (given_up[s] != 0 || least <= most) continue;
        most = least;
        worst = s;
      }
      if (worst == poses) break;
      const auto key = std::find_if(keys.begin(), keys.end(), [&](size_t k) {
        const size_t after = (k + poses - worst) % poses;  // from the step's first pose
        return tried[k] == 0 && (after <= pose_step(poses) || after >= poses - 1);
      });
      if (key == keys.end()) {
        given_up[worst] = 1;
        continue;
      }
      tried[*key] = 1;
      for (KeyFit& more : fitted({*key})) fits.push_back(std::move(more));
    }
    std::vector<uint8_t> shown(fits.size(), 0);
    for (size_t s = 0; s < poses; ++s) shown[cheapest(fits, s, poses)] = 1;
    for (size_t i = fits.size(); i-- > 0;)
      if (shown[i] == 0) fits.erase(fits.begin() + static_cast<std::ptrdiff_t>(i));
  }

  const SeenPart& part_;
  std::span<const WantedOutline> wanted_;
  bool refines_ = false;  // polygons, where they need more corners
  std::function<KeyFit(size_t, bool)> fit_;
};

// It refers to them.
Onlooker onlooker_of(std::span<const WantedOutline> wanted) {
  return {[wanted](size_t f, const Polyline& moved) {
            return wanted[f].torn(moved) + kHidden * wanted[f].area_between(moved);
          },
          [wanted](size_t f, const glm::dvec2& p) { return wanted[f].shows(p); }};
}

// To texels of level 0.
void enlarge(Fit& fit, double texel) {
  for (glm::dvec2& p : fit.polygon) p *= texel;
  for (Polyline& pose : fit.poses)
    for (glm::dvec2& p : pose) p *= texel;
  for (double& error : fit.errors) error *= texel;
}

}  // namespace

void fit_view(const PolypostorPlan& plan, const ViewBasis& basis, KeyChoice choice, ViewParts& view) {
  const PolypostorTier& tier = plan.tiers[view.tier];
  const StoredClip& clip = plan.frames.clips[view.clip];
  const SeenView seen = see_parts(plan, tier, clip, basis, choice != KeyChoice::first);
  for (const PartMask& figure : seen.figures) view.areas.push_back(covered_area(figure));
  std::vector<std::vector<TilePlane>> planes(clip.frames);  // by pose and part
  for (uint32_t f = 0; f < clip.frames; ++f) {
    for (const auto& moments : tier.moments)
      planes[f].push_back(fit_plane(moments[clip.first_frame + f], plan.sphere.centre, basis));
    order_planes(plan, tier, seen.positions[f], planes[f]);
  }
  view.sheets.resize(seen.parts.size());
  for (size_t part = 0; part < seen.parts.size(); ++part) {
    const SeenPart& of = seen.parts[part];
    const double slack = tier.texel > 1 ? 0.5 : plan.slack;
    std::vector<WantedOutline> wanted;
    for (size_t f = 0; f < of.contours.size(); ++f) wanted.emplace_back(of.contours[f], seen.figures[f], slack);
    const Onlooker onlooker = onlooker_of(wanted);
    KeyFitter fitter(of, wanted, [&](size_t key, bool finely) {
      const Carrier carrier(plan, tier, basis, clip, part, key, seen.positions[key]);
      FitOptions options = tier.fit;
      if (finely) options.corners = std::min(2 * options.corners, kMostCorners);
      return KeyFit{fit_part(of.contours[key], of.contours, key, carrier, options, onlooker), of.rects[key], {}, {}};
    });
    std::vector<KeyFit> fits = fitter.run(choice);
    for (KeyFit& one : fits) {
      Sheet sheet;
      sheet.rect = one.rect;
      if (fits.size() > 1) sheet.costs = std::move(one.costs);
      sheet.torn = std::move(one.torn);
      sheet.fit = std::move(one.fit);
      enlarge(sheet.fit, tier.texel);
      for (const auto& of_pose : planes) sheet.planes.push_back(of_pose[part]);
      view.sheets[part].push_back(std::move(sheet));
    }
  }
}

size_t sheet_for(std::span<const Sheet> sheets, size_t f, size_t frames) {
  return sheets.size() < 2 ? 0 : cheapest(sheets, f, frames);
}

}  // namespace crowdbench::renderers
