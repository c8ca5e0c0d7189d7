#include "scene/character/cut_out.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "scene/character/alpha_coverage.h"

namespace crowdbench::scene {
namespace {

constexpr double kStep = 0.5;  // texels between two looks
constexpr double kFewest = 32;
constexpr double kMost = 2048;
constexpr int kStepHalvings = 14;  // of a step, to the edge
constexpr int kMomentSide = 8;
constexpr double kOuter = 0.2;  // of the height

int64_t wrapped(int64_t i, int64_t size, bool repeat, bool mirrored) {
  if (!repeat) return std::clamp<int64_t>(i, 0, size - 1);
  const int64_t period = mirrored ? 2 * size : size;
  const int64_t in = ((i % period) + period) % period;
  return in < size ? in : period - 1 - in;
}

int steps_of(double texels) { return static_cast<int>(std::clamp(std::ceil(texels / kStep), kFewest, kMost)); }

}  // namespace

CutOut::CutOut(const Character& character, const Material& material)
    : mesh_(character.mesh), threshold_(static_cast<double>(alpha_threshold(material))) {
  if (threshold_ <= 0) return;
  if (material.base_colour_image >= 0 && !mesh_.uvs.empty()) {
    const Texture& texture = character.images[static_cast<size_t>(material.base_colour_image)];
    if (texture.image.channels == 4 && !texture.image.empty()) texture_ = &texture;
  }
  cuts_ = threshold_ > 1 || texture_ != nullptr || !mesh_.colours.empty();
}

double CutOut::alpha_of_texel(int64_t x, int64_t y) const {
  const Image8& image = texture_->image;
  const int64_t i = wrapped(x, image.width, texture_->repeat_u, texture_->mirrored_u);
  const int64_t j = wrapped(y, image.height, texture_->repeat_v, texture_->mirrored_v);
  return image.at(static_cast<int>(i), static_cast<int>(j))[3] / 255.0;
}

double CutOut::texture_alpha(const glm::dvec2& uv) const {
  // Far out a texel has no place of its own any more.
  const auto texels = [](double at, int size) { return std::clamp(at * size, -1e15, 1e15); };
  const double x = texels(uv.x, texture_->image.width);
  const double y = texels(uv.y, texture_->image.height);
  if (texture_->nearest)
    return alpha_of_texel(static_cast<int64_t>(std::floor(x)), static_cast<int64_t>(std::floor(y)));
  const double left = std::floor(x - 0.5);
  const double top = std::floor(y - 0.5);
  const double right = x - 0.5 - left;
  const double down = y - 0.5 - top;
  const auto i = static_cast<int64_t>(left);
  const auto j = static_cast<int64_t>(top);
  return (1 - down) * ((1 - right) * alpha_of_texel(i, j) + right * alpha_of_texel(i + 1, j)) +
         down * ((1 - right) * alpha_of_texel(i, j + 1) + right * alpha_of_texel(i + 1, j + 1));
}

// Asked a little within the triangle: what a picture that repeats brings in at its very edge has no area.
bool CutOut::there(const uint32_t* corners, const TrianglePlace& at) const {
  if (!cuts_) return true;
  const TrianglePlace place = at + inset(corners) * (TrianglePlace(1.0 / 3) - at);
  double alpha = 1;
  if (!mesh_.colours.empty()) {
    alpha = 0;
    for (int i = 0; i < 3; ++i) alpha += place[i] * static_cast<double>(mesh_.colours[corners[i]].a);
    if (alpha < threshold_) return false;  // a texture only takes away
  }
  if (texture_ != nullptr) {
    glm::dvec2 uv(0.0);
    for (int i = 0; i < 3; ++i) uv += place[i] * glm::dvec2(mesh_.uvs[corners[i]]);
    alpha *= texture_alpha(uv);
  }
  return alpha >= threshold_;
}

// A quarter of a texel on the way from the edge to the middle.
double CutOut::inset(const uint32_t* corners) const {
  if (texture_ == nullptr) return 0;
  double longest = 0;
  for (int i = 0; i < 3; ++i)
    longest = std::max(longest, glm::length(glm::dvec2(mesh_.uvs[corners[i]] - mesh_.uvs[corners[(i + 1) % 3]]) *
                                            glm::dvec2(texture_->image.width, texture_->image.height)));
  return std::clamp(1.0 / std::max(longest, 1e-9), 1e-4, 0.02);
}

// Between two places, the last one that is there.
TrianglePlace CutOut::edge(const uint32_t* corners, TrianglePlace inside, TrianglePlace outside) const {
  for (int i = 0; i < kStepHalvings; ++i) {
    const TrianglePlace middle = 0.5 * (inside + outside);
    (there(corners, middle) ? inside : outside) = middle;
  }
  return inside;
}

// Rows from one corner to the opposite side, which is the shortest: of each row its first and last place, and what lies
// between the first row with any and the one before it, and likewise at the end.
std::vector<TrianglePlace> CutOut::outline(const uint32_t* corners) const {
  const glm::dvec2 size =
      texture_ != nullptr ? glm::dvec2(texture_->image.width, texture_->image.height) : glm::dvec2();
  const auto texels = [&](int i, int j) {
    return texture_ == nullptr ? 0.0 : glm::length(size * glm::dvec2(mesh_.uvs[corners[i]] - mesh_.uvs[corners[j]]));
  };
  int apex = 0;
  for (int i = 1; i < 3; ++i)
    if (texels((i + 1) % 3, (i + 2) % 3) < texels((apex + 1) % 3, (apex + 2) % 3)) apex = i;
  const int b = (apex + 1) % 3;
  const int c = (apex + 2) % 3;
  const int rows = steps_of(std::max(texels(apex, b), texels(apex, c)));
  const int columns = steps_of(texels(b, c));
  const auto place = [&](int row, double along) {
    TrianglePlace at(0.0);
    const double down = static_cast<double>(row) / rows;
    at[apex] = 1 - down;
    at[b] = down * (1 - along);
    at[c] = down * along;
    return at;
  };

  std::vector<TrianglePlace> out;
  const auto take_across = [&](int row, int beside) {
    const int n = std::max(1, columns * row / rows);
    for (int i = 0; i <= n; ++i) {
      const double along = static_cast<double>(i) / n;
      if (there(corners, place(row, along)) && !there(corners, place(beside, along)))
        out.push_back(edge(corners, place(row, along), place(beside, along)));
    }
  };
  int first_row = -1;
  int last_row = -1;
  for (int row = 0; row <= rows; ++row) {
    const int n = std::max(1, columns * row / rows);
    const auto at = [&](int i) { return place(row, static_cast<double>(i) / n); };
    int first = 0;
    while (first <= n && !there(corners, at(first))) ++first;
    if (first > n) continue;
    int last = n;
    while (!there(corners, at(last))) --last;
    out.push_back(first == 0 ? at(0) : edge(corners, at(first), at(first - 1)));
    out.push_back(last == n ? at(n) : edge(corners, at(last), at(last + 1)));
    if (first_row < 0) first_row = row;
    last_row = row;
  }
  if (first_row > 0) take_across(first_row, first_row - 1);
  if (last_row >= 0 && last_row < rows) take_across(last_row, last_row + 1);
  return out;
}

TrianglePlace CutOut::moment(const uint32_t* corners) const {
  if (!cuts_) return TrianglePlace(1.0 / 3);
  TrianglePlace sum(0.0);
  const auto add = [&](double x, double y) {
    const TrianglePlace place((kMomentSide - x - y) / kMomentSide, x / kMomentSide, y / kMomentSide);
    if (there(corners, place)) sum += place;
  };
  // The middles of equal triangles, those that point as the whole does and those between.
  for (int j = 0; j < kMomentSide; ++j)
    for (int i = 0; i + j < kMomentSide; ++i) {
      add(i + 1.0 / 3, j + 1.0 / 3);
      if (i + j + 1 < kMomentSide) add(i + 2.0 / 3, j + 2.0 / 3);
    }
  return sum / static_cast<double>(kMomentSide * kMomentSide);
}

DrawnExtent::DrawnExtent(const Character& character) {
  for (const Material& material : character.materials) cut_outs_.emplace_back(character, material);
  const Mesh& mesh = character.mesh;
  for (const Primitive& p : mesh.primitives) {
    const auto cut_out = static_cast<size_t>(p.material);
    if (!cut_outs_[cut_out].cuts()) {
      whole_.push_back(&p);
      continue;
    }
    for (size_t i = p.first_index; i + 2 < p.first_index + p.index_count; i += 3)
      cut_.push_back({{mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]}, cut_out, false, {}});
  }
}

const std::vector<TrianglePlace>& DrawnExtent::outline(Triangle& triangle) {
  if (!triangle.looked_at) triangle.outline = cut_outs_[triangle.cut_out].outline(triangle.corners.data());
  triangle.looked_at = true;
  return triangle.outline;
}

std::vector<glm::dvec3> DrawnExtent::outer_points(std::span<const glm::dvec3> posed) {
  std::vector<double> heights;
  for (const glm::dvec3& p : posed) heights.push_back(p.y);
  const double high = most(heights);
  for (double& height : heights) height = -height;
  const double low = -most(heights);
  const double margin = kOuter * (high - low);
  std::vector<glm::dvec3> out;
  for (const Primitive* p : whole_)
    for (const glm::dvec3& point : posed.subspan(p->first_vertex, p->vertex_count)) out.push_back(point);
  for (Triangle& triangle : cut_) {
    const std::array<glm::dvec3, 3> corners = {posed[triangle.corners[0]], posed[triangle.corners[1]],
                                               posed[triangle.corners[2]]};
    const auto [bottom, top] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
    if (top < high - margin && bottom > low + margin)
      out.insert(out.end(), corners.begin(), corners.end());
    else
      for (const TrianglePlace& place : outline(triangle))
        out.push_back(place.x * corners[0] + place.y * corners[1] + place.z * corners[2]);
  }
  if (out.empty()) out.assign(posed.begin(), posed.end());
  return out;
}

double DrawnExtent::most(std::span<const double> values) {
  double best = std::numeric_limits<double>::lowest();
  for (const Primitive* p : whole_)
    for (const double value : values.subspan(p->first_vertex, p->vertex_count)) best = std::max(best, value);
  std::vector<std::pair<double, Triangle*>> farther;
  for (Triangle& triangle : cut_) {
    double reach = std::numeric_limits<double>::lowest();
    for (const uint32_t v : triangle.corners) reach = std::max(reach, values[v]);
    if (reach > best) farther.emplace_back(reach, &triangle);
  }
  std::ranges::sort(farther, [](const auto& a, const auto& b) { return a.first > b.first; });
  for (const auto& [reach, triangle] : farther) {
    if (reach <= best) break;
    for (const TrianglePlace& place : outline(*triangle)) {
      double value = 0;
      for (int i = 0; i < 3; ++i) value += place[i] * values[triangle->corners[static_cast<size_t>(i)]];
      best = std::max(best, value);
    }
  }
  if (best > std::numeric_limits<double>::lowest()) return best;
  return values.empty() ? 0.0 : *std::ranges::max_element(values);
}

}  // namespace crowdbench::scene
