// Based on: Tecchia and Chrysanthou 2000, Tecchia, Loscos and Chrysanthou 2002 (azimuth by elevation; samples on the
// faces of a cube, looked up without trigonometry); Sukharev's grid as Yershova and LaValle 2004 describe it (cell
// centres); the octahedral map of Engelhardt and Dachsbacher 2008, its upper half turned by 45 degrees so that it fills
// a square.
// Differs from the source: azimuth and elevation are chosen together, so that the sphere's pick is the nearest by angle
// (rounding both apart is not, near the pole).
#include "renderers/impostor/views/view_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "core/error.h"

namespace crowdbench::renderers {
namespace {

constexpr double kPi = std::numbers::pi;

double azimuth_step(const ViewGrid& grid) {
  if (!grid.mirrored) return 2 * kPi / grid.azimuths;
  return grid.azimuths > 1 ? kPi / (grid.azimuths - 1) : kPi;
}

double elevation_step(const ViewGrid& grid) {
  return grid.elevations > 1 ? (kPi / 2 - grid.el_min) / (grid.elevations - 1) : 1.0;
}

// Faces of the cube in the order of the views: +X, -X, +Y, -Y, +Z, -Z; u and v in [-1, 1]. v is up on the side faces.
glm::dvec3 cube_direction(int face, double u, double v) {
  switch (face) {
    case 0: return {1, v, u};
    case 1: return {-1, v, u};
    case 2: return {u, 1, v};
    case 3: return {u, -1, v};
    case 4: return {u, v, 1};
    default: return {u, v, -1};
  }
}

// Where a direction meets the cube: u and v in [-1, 1], as cube_direction takes them.
struct OnFace {
  int face = 0;
  double u = 0, v = 0;
};
OnFace on_face(const glm::dvec3& d) {
  const glm::dvec3 a = glm::abs(d);
  const double largest = std::max({a.x, a.y, a.z, 1e-30});
  if (a.y >= a.x && a.y >= a.z) return {d.y < 0 ? 3 : 2, d.x / largest, d.z / largest};
  if (a.x >= a.z) return {d.x < 0 ? 1 : 0, d.z / largest, d.y / largest};
  return {d.z < 0 ? 5 : 4, d.x / largest, d.y / largest};
}

int cell(double t, int n) { return std::clamp(static_cast<int>(std::floor((t * 0.5 + 0.5) * n)), 0, n - 1); }

// The view in a column and row of the grid (of a cube's face), one past its ends at most. Past a face's edge it is the
// nearest on the next face, raised to the lowest elevation.
int view_at(const ViewGrid& grid, int face, int column, int row) {
  const int n = grid.n;
  switch (grid.kind) {
    case GridKind::sphere:
      column = grid.mirrored ? std::min(column, grid.azimuths - 1) : column % grid.azimuths;
      return std::min(row, grid.elevations - 1) * grid.azimuths + column;
    case GridKind::cube:
      return grid.pick(cube_direction(face, (2.0 * column + 1) / n - 1, (2.0 * row + 1) / n - 1)).view;
    default: return std::min(row, n - 1) * n + std::min(column, n - 1);
  }
}

glm::dvec3 raised(const ViewGrid& grid, glm::dvec3 d) {
  const double low = grid.kind == GridKind::hemi ? 0.0 : grid.el_min;
  if (low >= kPi / 2) return {0, 1, 0};
  const double floor_y = std::hypot(d.x, d.z) * std::tan(low);
  if (low > -kPi / 2) d.y = std::max(d.y, floor_y);
  return d;
}

}  // namespace

int ViewGrid::size() const {
  switch (kind) {
    case GridKind::sphere: return azimuths * elevations;
    case GridKind::cube: return 6 * n * n;
    default: return n * n;
  }
}

ViewBasis ViewGrid::basis(int view) const {
  double azimuth = 0;
  glm::dvec3 d{0, 1, 0};
  if (kind == GridKind::sphere) {
    azimuth = (view % azimuths) * azimuth_step(*this);
    const int row = view / azimuths;
    // The last row is the pole itself, not a rounding error away from it.
    const double elevation = elevations > 1 && row == elevations - 1 ? kPi / 2 : el_min + row * elevation_step(*this);
    const double c = elevations > 1 && row == elevations - 1 ? 0.0 : std::cos(elevation);
    d = {std::sin(azimuth) * c, std::sin(elevation), std::cos(azimuth) * c};
  } else {
    if (kind == GridKind::cube) {
      const int column = view % n;
      const int row = view / n % n;
      d = cube_direction(view / (n * n), (2 * column + 1.0) / n - 1, (2 * row + 1.0) / n - 1);
    } else {
      const double u = 2.0 * (view % n) / (n - 1) - 1;
      const int row = view / n;
      const double v = 2.0 * row / (n - 1) - 1;
      d = {(u + v) / 2, 0, (u - v) / 2};
      d.y = 1 - std::abs(d.x) - std::abs(d.z);
    }
    d = glm::normalize(d);
    if (std::hypot(d.x, d.z) > 1e-9) azimuth = std::atan2(d.x, d.z);
  }
  ViewBasis basis;
  basis.to_eye = d;
  basis.right = {std::cos(azimuth), 0, -std::sin(azimuth)};
  basis.up = glm::cross(basis.to_eye, basis.right);
  return basis;
}

ViewPick ViewGrid::pick(const glm::dvec3& to_eye) const {
  ViewPick picked;
  if (kind == GridKind::sphere) {
    glm::dvec3 d = to_eye;
    if (mirrored && d.x < 0) {
      picked.mirrored = true;
      d.x = -d.x;
    }
    const double step = azimuth_step(*this);
    const double azimuth = d.x == 0 && d.z == 0 ? 0.0 : std::atan2(d.x, d.z);
    const double nearest = std::floor(azimuth / step + 0.5);
    const double at = nearest * step;
    // Over the samples of one azimuth the angle is least at the elevation of the direction's projection onto their
    // vertical plane.
    const double along = d.x * std::sin(at) + d.z * std::cos(at);
    const double elevation = std::atan2(d.y, along);
    const int row =
        std::clamp(static_cast<int>(std::floor((elevation - el_min) / elevation_step(*this) + 0.5)), 0, elevations - 1);
    const int column = mirrored ? std::clamp(static_cast<int>(nearest), 0, azimuths - 1)
                                : ((static_cast<int>(nearest) % azimuths) + azimuths) % azimuths;
    picked.view = row * azimuths + column;
    return picked;
  }
  const glm::dvec3 d = raised(*this, to_eye);
  if (kind == GridKind::cube) {
    const OnFace on = on_face(d);
    picked.view = (on.face * n + cell(on.v, n)) * n + cell(on.u, n);
    return picked;
  }
  const glm::dvec3 a = glm::abs(d);
  const double sum = std::max(a.x + a.y + a.z, 1e-30);
  const auto at = [&](double t) {
    return std::clamp(static_cast<int>(std::floor((t / sum * 0.5 + 0.5) * (n - 1) + 0.5)), 0, n - 1);
  };
  picked.view = at(d.x - d.z) * n + at(d.x + d.z);
  return picked;
}

ViewBlend ViewGrid::blend(const glm::dvec3& to_eye) const {
  ViewBlend out;
  double x = 0;
  double y = 0;
  int face = 0;
  if (kind == GridKind::sphere) {
    glm::dvec3 d = to_eye;
    if (mirrored && d.x < 0) {
      out.mirrored = true;
      d.x = -d.x;
    }
    const double azimuth = d.x == 0 && d.z == 0 ? 0.0 : std::atan2(d.x, d.z);
    const double elevation = std::atan2(d.y, std::hypot(d.x, d.z));
    x = std::clamp((azimuth < 0 ? azimuth + 2 * kPi : azimuth) / azimuth_step(*this), 0.0,
                   static_cast<double>(mirrored ? azimuths - 1 : azimuths));
    y = std::clamp((elevation - el_min) / elevation_step(*this), 0.0, elevations - 1.0);
  } else {
    const glm::dvec3 d = raised(*this, to_eye);
    if (kind == GridKind::cube) {
      const OnFace on = on_face(d);
      face = on.face;
      x = (on.u * 0.5 + 0.5) * n - 0.5;
      y = (on.v * 0.5 + 0.5) * n - 0.5;
    } else {
      const double sum = std::max(std::abs(d.x) + std::abs(d.y) + std::abs(d.z), 1e-30);
      x = std::clamp(((d.x + d.z) / sum * 0.5 + 0.5) * (n - 1), 0.0, n - 1.0);
      y = std::clamp(((d.x - d.z) / sum * 0.5 + 0.5) * (n - 1), 0.0, n - 1.0);
    }
  }
  const int column = static_cast<int>(std::floor(x));
  const int row = static_cast<int>(std::floor(y));
  const double fx = x - column;
  const double fy = y - row;
  const int far = fx + fy < 1 ? 0 : 1;  // the triangle beyond the cell's diagonal
  out.weights = far == 0 ? std::array{1 - fx - fy, fx, fy} : std::array{fx + fy - 1, 1 - fx, 1 - fy};
  for (int i = 0; i < 3; ++i) {
    const int c = column + (i == 1 ? 1 - far : far);
    const int r = row + (i == 2 ? 1 - far : far);
    out.views[static_cast<size_t>(i)] = view_at(*this, face, c, r);
  }
  return out;
}

void ViewGrid::visit_picks(const glm::dvec3& to_eye, bool blended,
                           const std::function<void(int view, bool mirrored)>& see) const {
  constexpr double kNear = 2e-4;  // of the direction's length: more than single precision leaves open
  const double near = kNear * glm::length(to_eye);
  for (int k = 0; k < 7; ++k) {
    glm::dvec3 beside = to_eye;
    if (k > 0) beside[(k - 1) / 2] += k % 2 == 0 ? near : -near;
    if (!blended) {
      const ViewPick picked = pick(beside);
      see(picked.view, picked.mirrored);
      continue;
    }
    const ViewBlend three = blend(beside);
    for (const int view : three.views) see(view, three.mirrored);
  }
}

bool ViewGrid::reachable(int view) const {
  if (kind != GridKind::cube) return true;
  const int face = view / (n * n);
  const int i = view % (n * n) % n;
  const int j = view % (n * n) / n;
  const auto low = [&](int k) { return 2.0 * k / n - 1; };
  const auto least = [&](int k) {
    return low(k) <= 0 && low(k + 1) >= 0 ? 0.0 : std::min(std::abs(low(k)), std::abs(low(k + 1)));
  };
  const auto most = [&](int k) { return std::max(std::abs(low(k)), std::abs(low(k + 1))); };
  double highest = 0;  // of the directions in the cell
  if (face == 2) {
    highest = std::atan2(1.0, std::hypot(least(i), least(j)));
  } else if (face == 3) {
    highest = std::atan2(-1.0, std::hypot(most(i), most(j)));
  } else {
    const double top = low(j + 1);
    highest = std::atan2(top, std::hypot(1.0, top >= 0 ? least(i) : most(i)));
  }
  // A cell that only touches the lowest elevation is picked for it by rounding alone, and not at all at zero, which the
  // arithmetic hits exactly.
  return el_min == 0 ? highest > 1e-12 : highest >= el_min - 1e-6;
}

std::string ViewGrid::text() const {
  switch (kind) {
    case GridKind::sphere: return fmt::format("sphere-{}x{}{}", azimuths, elevations, mirrored ? "-mirrored" : "");
    case GridKind::cube: return fmt::format("cube-{}", n);
    default: return fmt::format("hemi-{}", n);
  }
}

ViewGrid parse_view_grid(const std::string& text, double el_min, const std::string& where) {
  const auto bad = [&](const std::string& wrong) {
    return Error(where, fmt::format("\"{}\" {}", printable(text, 60), wrong),
                 "use sphere-AxE (17x8), sphere-AxE-mirrored, cube-N or hemi-N");
  };
  const auto number = [&](std::string_view digits, int lowest, int highest) {
    int value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc{} || end != digits.data() + digits.size()) throw bad("is not a view grid");
    if (value < lowest || value > highest)
      throw bad(fmt::format("asks for {}; the range is {} to {}", value, lowest, highest));
    return value;
  };
  ViewGrid grid;
  grid.el_min = el_min;
  std::string_view rest = text;
  const auto take = [&](std::string_view prefix) {
    if (!rest.starts_with(prefix)) return false;
    rest.remove_prefix(prefix.size());
    return true;
  };
  if (take("sphere-")) {
    constexpr std::string_view kMirrored = "-mirrored";
    if (rest.ends_with(kMirrored)) {
      grid.mirrored = true;
      rest.remove_suffix(kMirrored.size());
    }
    const size_t x = rest.find('x');
    if (x == std::string_view::npos) throw bad("is not a view grid");
    grid.azimuths = number(rest.substr(0, x), grid.mirrored ? 2 : 1, 512);
    grid.elevations = number(rest.substr(x + 1), 1, 129);
  } else if (take("cube-")) {
    grid.kind = GridKind::cube;
    grid.n = number(rest, 1, 64);
  } else if (take("hemi-")) {
    grid.kind = GridKind::hemi;
    grid.n = number(rest, 2, 128);
    grid.el_min = 0;
  } else {
    throw bad("is not a view grid");
  }
  return grid;
}

ViewGridUniforms view_grid_uniforms(const ViewGrid& grid) {
  const double turn = 2 * std::numbers::pi;
  const double azimuth_step = grid.mirrored ? turn / 2 / (grid.azimuths - 1) : turn / grid.azimuths;
  const double elevation_step = grid.elevations > 1 ? (turn / 4 - grid.el_min) / (grid.elevations - 1) : 1.0;
  const double low = grid.kind == GridKind::hemi ? 0.0 : grid.el_min;
  return {{static_cast<int>(grid.kind), grid.kind == GridKind::sphere ? grid.azimuths : grid.n, grid.elevations,
           grid.mirrored ? 1 : 0},
          {static_cast<float>(azimuth_step), static_cast<float>(grid.el_min), static_cast<float>(elevation_step),
           static_cast<float>(std::tan(low))}};
}

std::vector<glm::vec4> view_axes(const ViewGrid& grid) {
  std::vector<glm::vec4> axes;
  for (int v = 0; v < grid.size(); ++v) {
    const ViewBasis basis = grid.basis(v);
    axes.emplace_back(glm::vec3(basis.right), 0.0F);
    axes.emplace_back(glm::vec3(basis.up), 0.0F);
  }
  return axes;
}

double view_error(const ViewGrid& grid, const glm::dvec3& to_eye) {
  const ViewPick picked = grid.pick(to_eye);
  glm::dvec3 view = grid.basis(picked.view).to_eye;
  if (picked.mirrored) view.x = -view.x;
  const glm::dvec3 d = glm::normalize(raised(grid, to_eye));
  // atan2 of cross and dot is exact for small angles, where acos is not.
  return std::atan2(glm::length(glm::cross(d, view)), glm::dot(d, view));
}

ViewErrors compute_view_errors(const ViewGrid& grid, int samples) {
  ViewErrors errors;
  const double low = std::sin(grid.kind == GridKind::hemi ? 0.0 : grid.el_min);
  const double golden = kPi * (3 - std::sqrt(5.0));
  for (int i = 0; i < samples; ++i) {
    const double y = low + (1 - low) * (i + 0.5) / samples;
    const double h = std::sqrt(std::max(0.0, 1 - y * y));
    const double error = view_error(grid, {h * std::sin(i * golden), y, h * std::cos(i * golden)});
    errors.largest = std::max(errors.largest, error);
    errors.mean += error / samples;
  }
  return errors;
}

ViewSteps compute_view_steps(const ViewGrid& grid) {
  ViewSteps steps;
  int count = 0;
  const int columns = grid.kind == GridKind::sphere ? grid.azimuths : grid.n;
  for (int view = 0; view < grid.size(); ++view) {
    if (!grid.reachable(view)) continue;
    const int face = grid.kind == GridKind::cube ? view / (columns * columns) : 0;
    const int column = view % columns;
    const int row = view / columns - face * columns;
    const glm::dvec3 here = grid.basis(view).to_eye;
    for (const auto& [right, up] : {std::pair{1, 0}, {0, 1}}) {
      const int next = view_at(grid, face, column + right, row + up);
      if (next == view || !grid.reachable(next)) continue;
      const glm::dvec3 there = grid.basis(next).to_eye;
      const double angle = std::atan2(glm::length(glm::cross(here, there)), glm::dot(here, there));
      if (angle < 1e-9) continue;
      steps.largest = std::max(steps.largest, angle);
      steps.mean += angle;
      ++count;
    }
  }
  steps.mean /= std::max(count, 1);
  return steps;
}

ViewGrid grid_for_step(const ViewGrid& grid, double step) {
  ViewGrid out = grid;
  if (grid.kind == GridKind::sphere) {
    // On the row nearest to the horizon azimuths lie farthest apart.
    const double turn = (grid.mirrored ? kPi : 2 * kPi) * std::cos(std::clamp(0.0, grid.el_min, kPi / 2));
    out.azimuths = std::max(static_cast<int>(std::ceil(turn / step - 1e-9)) + (grid.mirrored ? 1 : 0), 2);
    out.elevations = std::max(static_cast<int>(std::ceil((kPi / 2 - grid.el_min) / step - 1e-9)) + 1, 2);
    return out;
  }
  constexpr int kMost = 128;
  out.n = 2;
  while (out.n < kMost && compute_view_steps(out).largest > step) ++out.n;
  return out;
}

}  // namespace crowdbench::renderers
