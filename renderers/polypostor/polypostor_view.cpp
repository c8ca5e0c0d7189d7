#include "renderers/polypostor/polypostor_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>

#include "renderers/polypostor/polypostor_contour.h"
#include "renderers/polypostor/polypostor_key.h"

namespace crowdbench::renderers {
namespace {

constexpr double kSeen = 1;  // texels: a part that shows less is not worth an image

// Where skinning takes points of a view's plane, by the nearest edge of the part's mesh at the key.
class Carrier {
 public:
  // key: a frame of the clip.
  Carrier(const PolypostorPlan& plan, const PolypostorTier& tier, const ViewBasis& basis, const StoredClip& clip,
          size_t part, size_t key)
      : mesh_(tier.cut.character->mesh),
        plan_(plan),
        tier_(tier),
        basis_(basis),
        corners_(tier.corners[part]),
        first_(clip.first_frame),
        frames_(clip.frames),
        key_(clip.first_frame + key) {}

  Polyline operator()(const glm::dvec2& p) const {
    const auto& positions = tier_.positions[key_];
    double least = INFINITY;
    std::array<uint32_t, 2> edge{};
    double along = 0;
    double height = 0;
    for (size_t i = 0; i < corners_.size(); ++i) {
      const uint32_t v = corners_[i];
      const uint32_t w = corners_[i % 3 == 2 ? i - 2 : i + 1];
      const glm::dvec3 a = seen(positions[v]);
      const glm::dvec3 b = seen(positions[w]);
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
    const glm::dvec3 point =
        plan_.sphere.centre + plan_.texel * (p.x * basis_.right + p.y * basis_.up + height * basis_.to_eye);
    const std::array<glm::dvec3, 2> bound = {unposed(edge[0], point), unposed(edge[1], point)};
    Polyline out;
    for (size_t f = first_; f < first_ + frames_; ++f) {
      const glm::dvec3 there = glm::mix(glm::dvec3(skin(edge[0], f) * glm::dvec4(bound[0], 1)),
                                        glm::dvec3(skin(edge[1], f) * glm::dvec4(bound[1], 1)), along);
      out.emplace_back(seen(glm::vec3(there)));
    }
    return out;
  }

 private:
  glm::dvec3 seen(const glm::vec3& p) const {  // texels
    const glm::dvec3 d = (glm::dvec3(p) - plan_.sphere.centre) / plan_.texel;
    return {glm::dot(d, basis_.right), glm::dot(d, basis_.up), glm::dot(d, basis_.to_eye)};
  }
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
  size_t first_, frames_, key_;
};

TileRect rect_around(const Polyline& contour) {
  glm::dvec2 low(INFINITY);
  glm::dvec2 high(-INFINITY);
  for (const glm::dvec2& p : contour) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const glm::ivec2 first(glm::floor(low));
  const glm::ivec2 last(glm::ceil(high));
  return {first.x, first.y, last.x - first.x, last.y - first.y};
}

// What a view sees of one part through a clip.
struct SeenPart {
  std::vector<Polyline> contours;           // by frame
  std::vector<double> areas;                // by frame, texels
  std::vector<std::vector<double>> errors;  // by key and frame: look_error; empty where the key does not show the part
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

// looks: whether keys are to be compared.
std::vector<SeenPart> see_parts(const PolypostorPlan& plan, const PolypostorTier& tier, const StoredClip& clip,
                                const ViewBasis& basis, bool looks) {
  std::vector<std::vector<glm::dvec3>> positions;  // by frame and vertex: view axes, texels
  std::vector<std::vector<glm::vec3>> normals;     // view axes
  const glm::mat3 to_view = glm::transpose(glm::mat3(basis.right, basis.up, basis.to_eye));
  for (uint32_t f = 0; f < clip.frames; ++f) {
    auto& points = positions.emplace_back();
    for (const glm::vec3& p : tier.positions[clip.first_frame + f]) {
      const glm::dvec3 d = (glm::dvec3(p) - plan.sphere.centre) / plan.texel;
      points.emplace_back(glm::dot(d, basis.right), glm::dot(d, basis.up), glm::dot(d, basis.to_eye));
    }
    auto& turned = normals.emplace_back();
    for (const glm::vec3& n : tier.normals[clip.first_frame + f]) turned.push_back(to_view * n);
  }
  std::vector<SeenPart> out;
  for (size_t c = 0; c < tier.corners.size(); ++c) {
    const std::vector<uint32_t>& corners = tier.corners[c];
    SeenPart& part = out.emplace_back();
    std::vector<PartLook> images;
    std::vector<glm::dvec2> flat;
    for (uint32_t f = 0; f < clip.frames; ++f) {
      flat.clear();
      for (const uint32_t v : corners) flat.emplace_back(positions[f][v]);
      face_the_eye(tier.two_sided[c], flat);
      const PartMask mask = rasterise(flat);
      part.areas.push_back(facing_area(mask));
      part.contours.push_back(part.areas.back() > 0 ? trace_contour(mask) : Polyline{});
      if (looks) images.push_back(look_at_part(corners, positions[f], normals[f], tier.tones));
    }
    part.errors.resize(clip.frames);
    if (!looks) continue;
    for (uint32_t k = 0; k < clip.frames; ++k)
      for (uint32_t f = 0; f < clip.frames && part.areas[k] >= kSeen; ++f)
        part.errors[k].push_back(f == k ? 0.0 : look_error(images[k], images[f], corners, positions[k], positions[f]));
  }
  return out;
}

// What a frame costs that a fit shows: by its looks, and by the texels between its outline and the frame's own.
std::vector<double> fit_costs(const SeenPart& part, const Fit& fit) {
  constexpr double kOutline = 3;  // square texel between the outlines
  std::vector<double> costs = part.errors[fit.key];
  for (size_t f = 0; f < costs.size(); ++f) costs[f] += kOutline * fit.errors[f] * perimeter(part.contours[f]);
  return costs;
}

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

// The fits whose images of a part are kept: none, one, or two.
std::vector<Fit> fit_keys(const SeenPart& part, KeyChoice choice, const std::function<Fit(size_t)>& fit) {
  constexpr size_t kTried = 6;
  const size_t frames = part.areas.size();
  std::vector<size_t> keys;
  for (size_t k = 0; k < frames; ++k)
    if (part.areas[k] >= kSeen) keys.push_back(k);
  std::vector<Fit> out;
  const auto keep = [&](Fit one) {
    if (!one.polygon.empty()) out.push_back(std::move(one));
  };
  if (keys.empty()) return out;
  if (choice == KeyChoice::first) {
    keep(fit(keys[0]));
    return out;
  }
  if (choice == KeyChoice::two_keys && keys.size() > 1) {
    // The pair that looks best, each step between stored frames shown by the better one.
    std::array<size_t, 2> best{};
    double least = INFINITY;
    for (size_t i = 0; i < keys.size(); ++i)
      for (size_t j = 0; j < i; ++j) {
        double cost = 0;
        for (size_t f = 0; f < frames; ++f) {
          const size_t next = (f + 1) % frames;
          cost += std::min(part.errors[keys[i]][f] + part.errors[keys[i]][next],
                           part.errors[keys[j]][f] + part.errors[keys[j]][next]);
        }
        if (cost >= least) continue;
        least = cost;
        best = {keys[j], keys[i]};
      }
    for (const size_t k : best) keep(fit(k));
    return out;
  }
  // By their looks first; of the best of those, by what their polygons make of them.
  std::stable_sort(keys.begin(), keys.end(),
                   [&](size_t a, size_t b) { return sum(part.errors[a]) < sum(part.errors[b]); });
  keys.resize(std::min(keys.size(), kTried));
  double least = INFINITY;
  for (const size_t k : keys) {
    Fit one = fit(k);
    if (one.polygon.empty()) continue;
    const double cost = sum(fit_costs(part, one));
    if (cost >= least) continue;
    least = cost;
    out.clear();
    out.push_back(std::move(one));
  }
  return out;
}

}  // namespace

std::vector<std::vector<Sheet>> fit_view(const PolypostorPlan& plan, const PolypostorTier& tier, const StoredClip& clip,
                                         const ViewBasis& basis, KeyChoice choice) {
  const std::vector<SeenPart> seen = see_parts(plan, tier, clip, basis, choice != KeyChoice::first);
  std::vector<std::vector<Sheet>> out(seen.size());
  for (size_t part = 0; part < seen.size(); ++part) {
    const auto fit = [&](size_t key) {
      return fit_part(seen[part].contours, key, Carrier(plan, tier, basis, clip, part, key), tier.fit);
    };
    for (Fit& one : fit_keys(seen[part], choice, fit)) {
      Sheet sheet;
      sheet.rect = rect_around(seen[part].contours[one.key]);
      if (choice == KeyChoice::two_keys) sheet.costs = fit_costs(seen[part], one);
      sheet.fit = std::move(one);
      for (uint32_t f = 0; f < clip.frames; ++f)
        sheet.planes.push_back(fit_plane(tier.moments[part][clip.first_frame + f], plan.sphere.centre, basis));
      out[part].push_back(std::move(sheet));
    }
  }
  return out;
}

size_t sheet_for(std::span<const Sheet> sheets, size_t f, size_t frames) {
  size_t best = 0;
  if (sheets.size() < 2) return best;
  double least = INFINITY;
  for (size_t s = 0; s < sheets.size(); ++s) {
    const double cost = sheets[s].costs[f] + sheets[s].costs[(f + 1) % frames];
    if (cost < least) {
      least = cost;
      best = s;
    }
  }
  return best;
}

}  // namespace crowdbench::renderers
