// Based on: the area of a union as a number of samples (Monte Carlo integration): for each sample the least factor is
// found with which any disc reaches it, so that the area at every factor is an order statistic of one pass.
#include "renderers/surfel/surfel_area.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace crowdbench::renderers {
namespace {

constexpr int kViews = 32;
constexpr int kSide = 96;  // samples along the longest side
constexpr double kPi = std::numbers::pi;

struct View {
  glm::vec3 right{1, 0, 0}, up{0, 1, 0}, backward{0, 0, 1};
  std::vector<scene::Mat3x4> palette;
  glm::vec2 offset{0.0F};  // of the samples, in steps
};

// All azimuths, elevations and phases in turn; where samples lie between steps follows M. Roberts' sequence (2018).
View view_of(const scene::PoseBank& bank, int i) {
  View v;
  const double azimuth = 2 * kPi * (i + 0.5) / kViews * 5;
  const double elevation = (i % 8) * 5.0 * kPi / 180;
  v.backward =
      glm::vec3(std::cos(elevation) * std::sin(azimuth), std::sin(elevation), std::cos(elevation) * std::cos(azimuth));
  v.right = glm::normalize(glm::cross(glm::vec3(0, 1, 0), v.backward));
  v.up = glm::cross(v.backward, v.right);
  const auto clips = static_cast<int>(bank.clips().size());
  const int round = i / clips;
  v.palette = bank.palette(bank.sample(i % clips, round * 0.6180339887498949));
  v.offset = {static_cast<float>(std::fmod(0.7548776662466927 * i, 1.0)),
              static_cast<float>(std::fmod(0.5698402909980532 * i, 1.0))};
  return v;
}

// Samples of one view of a box around everything, `step` metres apart.
struct Raster {
  glm::vec2 low{0.0F};
  float step = 1;
  int width = 0, height = 0;
  glm::vec2 place(int x, int y) const { return low + step * glm::vec2(static_cast<float>(x), static_cast<float>(y)); }
  // Calls visit(x, y) for the samples of a rectangle.
  template <typename Visit>
  void within(const glm::vec2& from, const glm::vec2& to, const Visit& visit) const {
    const glm::ivec2 a(glm::ceil(glm::max((from - low) / step, glm::vec2(0.0F))));
    const glm::ivec2 b(glm::floor(
        glm::min((to - low) / step, glm::vec2(static_cast<float>(width - 1), static_cast<float>(height - 1)))));
    for (int y = a.y; y <= b.y; ++y)
      for (int x = a.x; x <= b.x; ++x) visit(x, y);
  }
  size_t index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
  }
};

Raster raster_of(const scene::PoseBank& bank, const View& v) {
  Raster r;
  r.step = longest_side(bank) / kSide;
  glm::vec2 low(std::numeric_limits<float>::max());
  glm::vec2 high(-low);
  for (int k = 0; k < 8; ++k) {
    const glm::vec3 p((k & 1) != 0 ? bank.bounds_max().x : bank.bounds_min().x,
                      (k & 2) != 0 ? bank.bounds_max().y : bank.bounds_min().y,
                      (k & 4) != 0 ? bank.bounds_max().z : bank.bounds_min().z);
    low = glm::min(low, glm::vec2(glm::dot(p, v.right), glm::dot(p, v.up)));
    high = glm::max(high, glm::vec2(glm::dot(p, v.right), glm::dot(p, v.up)));
  }
  // Discs reach beyond the box.
  const float around = 0.25F * longest_side(bank);
  r.low = low - around + r.step * v.offset;
  const glm::vec2 size = (high - low + 2 * around) / r.step;
  r.width = static_cast<int>(size.x) + 1;
  r.height = static_cast<int>(size.y) + 1;
  return r;
}

// By sample, whether the character covers it.
std::vector<uint8_t> covered(const scene::Character& character, const View& v, const Raster& raster) {
  const scene::Mesh& mesh = character.mesh;
  const std::vector<glm::vec3> posed = scene::skin_points(mesh, v.palette);
  std::vector<uint8_t> shown(raster.index(0, raster.height), 0);
  for (const scene::Primitive& p : mesh.primitives) {
    const bool both = character.materials[static_cast<size_t>(p.material)].double_sided;
    for (uint32_t i = 0; i + 2 < p.index_count; i += 3) {
      const std::array<uint32_t, 3> c = {mesh.indices[p.first_index + i], mesh.indices[p.first_index + i + 1],
                                         mesh.indices[p.first_index + i + 2]};
      glm::vec2 at[3];
      for (size_t k = 0; k < 3; ++k) at[k] = {glm::dot(posed[c[k]], v.right), glm::dot(posed[c[k]], v.up)};
      const auto cross = [](const glm::vec2& a, const glm::vec2& b) { return a.x * b.y - a.y * b.x; };
      const float area = cross(at[1] - at[0], at[2] - at[0]);
      if (area == 0 || (!both && (area < 0) != p.mirrored)) continue;
      raster.within(glm::min(at[0], glm::min(at[1], at[2])), glm::max(at[0], glm::max(at[1], at[2])),
                    [&](int x, int y) {
                      const glm::vec2 q = raster.place(x, y);
                      const glm::vec3 b(cross(at[1] - q, at[2] - q) / area, cross(at[2] - q, at[0] - q) / area,
                                        cross(at[0] - q, at[1] - q) / area);
                      if (b.x < 0 || b.y < 0 || b.z < 0 || shown[raster.index(x, y)] != 0) return;
                      if (is_there(character, p, c, b)) shown[raster.index(x, y)] = 1;
                    });
    }
  }
  return shown;
}

struct PosedSurfel {
  glm::vec2 at{0.0F}, lean{1.0F, 0.0F};  // lean: which way the disc is narrow, unit
  float facing = 0;                      // cosine to the viewer; below 0: not seen
};

std::vector<PosedSurfel> pose_surfels(std::span<const Surfel> surfels, const View& v) {
  std::vector<PosedSurfel> out;
  for (const Surfel& surfel : surfels) {
    const Surfel s = in_pose(surfel, v.palette);
    PosedSurfel one;
    one.facing = glm::dot(s.normal, v.backward);
    if (s.double_sided) one.facing = std::abs(one.facing);
    one.at = {glm::dot(s.position, v.right), glm::dot(s.position, v.up)};
    const glm::vec2 lean(glm::dot(s.normal, v.right), glm::dot(s.normal, v.up));
    if (glm::dot(lean, lean) > 1e-12F) one.lean = glm::normalize(lean);
    out.push_back(one);
  }
  return out;
}

// By sample: the least factor, up to 1, of the radii with which a disc reaches it; above 1: none does.
std::vector<float> least_factors(std::span<const PosedSurfel> posed, std::span<const Surfel> surfels,
                                 const SurfelLevel& level, float radius, const Raster& raster) {
  std::vector<float> out(raster.index(0, raster.height), 4.0F);
  for (size_t i = 0; i < level.points; ++i) {
    if (posed[i].facing < 0) continue;
    const float r = std::min(radius, surfels[i].reach * static_cast<float>(level.reach));
    const glm::vec2 lean = posed[i].lean;
    const float narrow = std::max(posed[i].facing, kNarrowest);
    raster.within(posed[i].at - r, posed[i].at + r, [&](int x, int y) {
      const glm::vec2 to = (raster.place(x, y) - posed[i].at) / r;
      const float a = glm::dot(to, lean) / narrow;
      const float b = to.y * lean.x - to.x * lean.y;
      out[raster.index(x, y)] = std::min(out[raster.index(x, y)], a * a + b * b);
    });
  }
  for (float& f : out) f = std::sqrt(f);
  return out;
}

// What one view says of one level.
struct Reached {
  std::vector<float> all;     // the factors of the samples that discs reach
  std::vector<float> inside;  // of those inside of the character's outline
};

Reached reached_of(const std::vector<float>& factors, const std::vector<uint8_t>& shown, const Raster& raster) {
  Reached out;
  const auto row = static_cast<size_t>(raster.width);
  for (size_t i = 0; i < factors.size(); ++i) {
    if (factors[i] > 1) continue;
    out.all.push_back(factors[i]);
    // Nothing is shown at the raster's border, which lies around all discs.
    if (shown[i] != 0 && shown[i - 1] != 0 && shown[i + 1] != 0 && shown[i - row] != 0 && shown[i + row] != 0)
      out.inside.push_back(factors[i]);
  }
  return out;
}

// The n-th smallest, n below their number.
float nth(std::vector<float>& values, size_t n) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(n);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

size_t within(const std::vector<float>& factors, float factor) {
  return static_cast<size_t>(std::count_if(factors.begin(), factors.end(), [&](float f) { return f <= factor; }));
}

// views: of one level. wanted: by view, how many samples are to be reached.
SurfelArea area_of(std::vector<Reached>& views, const std::vector<size_t>& wanted) {
  SurfelArea out;
  std::vector<float> all;
  for (const Reached& view : views) all.insert(all.end(), view.all.begin(), view.all.end());
  const size_t sum = std::accumulate(wanted.begin(), wanted.end(), size_t{0});
  if (sum == 0) return out;
  if (sum < all.size()) out.thin = std::max(nth(all, sum), 1e-3F);
  double squares = 0;
  for (size_t i = 0; i < views.size(); ++i) {
    const double off = static_cast<double>(within(views[i].all, out.thin)) - static_cast<double>(wanted[i]);
    squares += off * off;
  }
  const auto count = static_cast<double>(wanted.size());
  const auto mean = static_cast<double>(sum) / count;
  out.uneven = static_cast<float>(std::sqrt(squares / count) / mean);
  out.closed = out.thin;
  for (Reached& view : views)
    if (const size_t n = view.inside.size(); n > 0)
      out.closed =
          std::max(out.closed, nth(view.inside, static_cast<size_t>(static_cast<double>(n - 1) * (1 - kHoles))));
  out.over = static_cast<float>(static_cast<double>(within(all, out.closed)) / static_cast<double>(sum) - 1);
  return out;
}

}  // namespace

float longest_side(const scene::PoseBank& bank) {
  const glm::vec3 size = bank.bounds_max() - bank.bounds_min();
  return std::max(std::max(size.x, size.y), std::max(size.z, 1e-6F));
}

std::vector<SurfelArea> fit_areas(const scene::Character& character, const scene::PoseBank& bank,
                                  std::span<const Surfel> surfels, std::span<const SurfelLevel> levels, double cover) {
  std::vector<std::vector<Reached>> reached(levels.size());  // by level and view
  std::vector<size_t> wanted;
  for (int i = 0; i < kViews; ++i) {
    const View view = view_of(bank, i);
    const Raster raster = raster_of(bank, view);
    const std::vector<uint8_t> shown = covered(character, view, raster);
    wanted.push_back(static_cast<size_t>(std::count(shown.begin(), shown.end(), 1)));
    const std::vector<PosedSurfel> posed = pose_surfels(surfels, view);
    for (size_t k = 0; k < levels.size(); ++k)
      reached[k].push_back(
          reached_of(least_factors(posed, surfels, levels[k], static_cast<float>(levels[k].radius * cover), raster),
                     shown, raster));
  }
  std::vector<SurfelArea> out;
  for (std::vector<Reached>& views : reached) out.push_back(area_of(views, wanted));
  return out;
}

}  // namespace crowdbench::renderers
