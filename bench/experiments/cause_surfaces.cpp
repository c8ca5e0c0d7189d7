#include "bench/experiments/cause_surfaces.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "renderers/impostor/tiles/plane.h"
#include "renderers/impostor/tiles/tile_capture.h"
#include "scene/pose/hidden.h"

namespace crowdbench::bench {
namespace {

using metrics::Surfaces;
using renderers::Capture;
using renderers::Target;

// The middle sample of every k x k.
template <typename T>
Image<T> middles(Image<T>&& fine, int k) {
  if (k == 1) return std::move(fine);
  Image<T> out(fine.width / k, fine.height / k, fine.channels);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) std::copy_n(fine.at(x * k + k / 2, y * k + k / 2), out.channels, out.at(x, y));
  return out;
}

// RGB of the frame in linear light under the light given.
ImageF linear_under(const Drawer& drawer, scene::Frame frame, const Target& target, float ambient, float diffuse,
                    int k) {
  frame.light.ambient = ambient;
  frame.light.diffuse = diffuse;
  drawer.renderer.draw(frame, drawer.representation, target);
  const ImageF rgba = middles(target.read().linear, k);
  ImageF rgb(rgba.width, rgba.height, 3);
  for (size_t i = 0; i < rgba.pixels(); ++i) std::copy_n(&rgba.data[4 * i], 3, &rgb.data[3 * i]);
  return rgb;
}

void turn(glm::dvec3& v, const glm::vec2& heading, double sign) {
  const double s = sign * static_cast<double>(heading.x);
  const auto c = static_cast<double>(heading.y);
  v = {c * v.x + s * v.z, v.y, c * v.z - s * v.x};
}
glm::dvec3 world_from_model(glm::dvec3 v, const glm::vec2& heading) {
  turn(v, heading, 1);
  return v;
}
glm::dvec3 model_from_world(glm::dvec3 v, const glm::vec2& heading) {
  turn(v, heading, -1);
  return v;
}

// A stored view of one agent, and the picture that was drawn of it.
struct View {
  renderers::ViewBasis basis;  // model space
  renderers::TilePlane plane;
  glm::dvec3 centre{0.0};  // model space, metres
  double radius = 0;       // metres at scale 1: the picture shows as much on every side of the centre
  double away = 0;         // metres of the world: eye to centre when it was drawn
  Surfaces picture;
};

renderers::ViewBasis picked_basis(const renderers::ViewGrid& grid, const glm::dvec3& to_eye) {
  const renderers::ViewPick pick = grid.pick(to_eye);
  renderers::ViewBasis basis = grid.basis(pick.view);
  if (!pick.mirrored) return basis;
  // The mirror image of the view, right-handed again.
  basis.right = {basis.right.x, -basis.right.y, -basis.right.z};
  basis.up.x = -basis.up.x;
  basis.to_eye.x = -basis.to_eye.x;
  return basis;
}

// Every k-th pixel of a picture k times as wide and high, from column i and row j on.
void interleave(const Surfaces& shifted, int k, int i, int j, Surfaces& whole) {
  const auto put = [&]<typename T>(const Image<T>& from, Image<T>& to) {
    if (to.empty()) to = Image<T>(from.width * k, from.height * k, from.channels);
    for (int y = 0; y < from.height; ++y)
      for (int x = 0; x < from.width; ++x) std::copy_n(from.at(x, y), from.channels, to.at(x * k + i, y * k + j));
  };
  put(shifted.codes, whole.codes);
  put(shifted.ids, whole.ids);
  put(shifted.depth, whole.depth);
  put(shifted.base, whole.base);
  put(shifted.emissive, whole.emissive);
  put(shifted.lambert, whole.lambert);
}

// How a view's picture is drawn: `shifts` x `shifts` pictures of `side` pixels, shifted by fractions of a pixel and
// interleaved. The mesh's textures are filtered for the size at which they are seen, which a finer picture would
// change; where there are none one picture does. Either way odd numbers of samples lie in a pixel of the frame, and an
// even number of its pixels across the picture, so that a figure in the middle of the frame is sampled at the same
// places.
struct Fineness {
  int side, shifts;
  double pixel;  // metres of the world
};
Fineness fineness_of(const scene::Character& character, double diameter, double pixel) {
  constexpr int kShifts = 5;
  constexpr int kFiner = 7;
  constexpr int kLargest = 1500;
  const int finer = character.images.empty() ? kFiner : 1;
  const int side = 2 * std::max(8, static_cast<int>(std::ceil(diameter / pixel / 2))) * finer;
  if (side > kLargest) return {kLargest, 1, diameter / kLargest};
  return {side, finer == 1 ? kShifts : 1, pixel / finer};
}

Surfaces picture_of(const Drawer& drawer, const scene::Frame& seen, size_t character, const scene::FrameAgent& agent,
                    const View& view, const Fineness& fine) {
  scene::Frame frame = seen;
  for (auto& agents : frame.agents) agents.clear();
  const auto scale = static_cast<double>(agent.scale);
  const glm::dvec3 pivot = seen.origin + glm::dvec3(agent.position);
  const glm::dvec3 right = world_from_model(view.basis.right, agent.heading);
  const glm::dvec3 up = world_from_model(view.basis.up, agent.heading);
  frame.camera.up = up;
  frame.camera.fov_y = 2 * std::atan(view.radius * scale / view.away);
  frame.camera.near = 0.5 * view.away;
  frame.camera.far = 0;
  frame.width = frame.height = fine.side;
  frame.ground = false;
  Surfaces out;
  for (int j = 0; j < fine.shifts; ++j)
    for (int i = 0; i < fine.shifts; ++i) {
      const auto shift = [&](int step) { return fine.pixel * (step - 0.5 * (fine.shifts - 1)) / fine.shifts; };
      frame.camera.target =
          pivot + scale * world_from_model(view.centre, agent.heading) + shift(i) * right - shift(j) * up;
      frame.camera.eye = frame.camera.target + view.away * world_from_model(view.basis.to_eye, agent.heading);
      frame.origin = frame.camera.eye;
      scene::FrameAgent alone = agent;
      alone.position = glm::vec3(pivot - frame.origin);
      frame.agents[character] = {alone};
      interleave(draw_surfaces(drawer, frame), fine.shifts, i, j, out);
    }
  return out;
}

View view_of(const Drawer& drawer, const scene::Frame& frame, size_t character, const scene::FrameAgent& agent,
             const renderers::ViewSampling& sampling) {
  View view;
  view.centre = sampling.centre;
  const auto scale = static_cast<double>(agent.scale);
  const glm::dvec3 to_eye = model_from_world(-glm::dvec3(agent.position), agent.heading) / scale - view.centre;
  view.basis = picked_basis(sampling.grid, to_eye);
  const scene::Mesh& mesh = drawer.cast.characters[character]->mesh;
  const auto positions = scene::shown_positions(mesh, drawer.cast.banks[character]->palette(agent.pose));
  if (sampling.lies == renderers::ViewLies::nearest)
    view.plane = renderers::fit_plane(renderers::surface_moments(positions, mesh.indices), view.centre, view.basis);
  for (const glm::vec3& p : positions) view.radius = std::max(view.radius, glm::distance(glm::dvec3(p), view.centre));
  const double depth = std::max(glm::length(to_eye) * scale, frame.camera.near);
  const Fineness fine = fineness_of(*drawer.cast.characters[character], 2.04 * view.radius * scale,
                                    scene::pixel_size_at(frame.camera, depth, frame.height));
  view.radius = 0.5 * fine.side * fine.pixel / scale;
  view.away = 1000 * view.radius * scale;
  view.picture = picture_of(drawer, frame, character, agent, view, fine);
  return view;
}

// From the frame's pixels to places on a view's plane.
class Laid {
 public:
  Laid(const scene::Frame& frame, const scene::FrameAgent& agent, const View& view)
      : frame_(frame),
        agent_(agent),
        view_(view),
        rotation_(scene::view_rotation(frame.camera)),
        tall_(std::tan(frame.camera.fov_y / 2)),
        wide_(tall_ * frame.width / frame.height),
        scale_(static_cast<double>(agent.scale)) {
    eye_ = in_view(model_from_world(-glm::dvec3(agent.position), agent.heading) / scale_ - view.centre);
  }

  struct Hit {
    size_t pixel = 0;  // of View::picture
    double depth = 0;  // metres along the frame's view axis, of the surface that is shown
  };
  // What the frame's pixel shows of the view; nothing where that is empty.
  std::optional<Hit> at(int x, int y) const {
    const glm::dvec3 eye_ray{((x + 0.5) / frame_.width * 2 - 1) * wide_, (1 - (y + 0.5) / frame_.height * 2) * tall_,
                             -1.0};
    const glm::dvec3 ray = in_view(model_from_world(glm::transpose(rotation_) * eye_ray, agent_.heading));
    const renderers::TilePlane& plane = view_.plane;
    const double across = ray.z - plane.slope_x * ray.x - plane.slope_y * ray.y;
    const double t = (plane.slope_x * eye_.x + plane.slope_y * eye_.y + plane.height - eye_.z) / across;
    if (!(t > 0)) return std::nullopt;
    const double px = eye_.x + t * ray.x;
    const double py = eye_.y + t * ray.y;
    const int side = view_.picture.codes.width;
    const double column = std::floor((px / view_.radius + 1) / 2 * side);
    const double row = std::floor((1 - py / view_.radius) / 2 * side);
    if (!(column >= 0 && row >= 0 && column < side && row < side)) return std::nullopt;
    Hit hit;
    hit.pixel = static_cast<size_t>(row) * static_cast<size_t>(side) + static_cast<size_t>(column);
    if (view_.picture.ids.data[hit.pixel] == 0) return std::nullopt;
    const double above = (view_.away - static_cast<double>(view_.picture.depth.data[hit.pixel])) / scale_;
    hit.depth = depth_of({px, py, above});
    return hit;
  }

  // Pixels that may show it: [left, right) x [top, bottom).
  struct Range {
    int left, top, right, bottom;
  };
  Range range() const {
    glm::dvec2 least{1e300};
    glm::dvec2 most{-1e300};
    for (int corner = 0; corner < 4; ++corner) {
      const double x = view_.radius * ((corner & 1) != 0 ? 1 : -1);
      const double y = view_.radius * ((corner & 2) != 0 ? 1 : -1);
      const glm::dvec3 p = in_eye({x, y, view_.plane.slope_x * x + view_.plane.slope_y * y + view_.plane.height});
      if (-p.z < frame_.camera.near) return {0, 0, frame_.width, frame_.height};
      const glm::dvec2 place{(1 + p.x / (-p.z * wide_)) / 2 * frame_.width,
                             (1 - p.y / (-p.z * tall_)) / 2 * frame_.height};
      least = glm::min(least, place);
      most = glm::max(most, place);
    }
    const auto within = [](double value, int size) {
      return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(size)));
    };
    return {within(std::floor(least.x), frame_.width), within(std::floor(least.y), frame_.height),
            within(std::ceil(most.x) + 1, frame_.width), within(std::ceil(most.y) + 1, frame_.height)};
  }

 private:
  glm::dvec3 in_view(const glm::dvec3& model) const {
    return {glm::dot(view_.basis.right, model), glm::dot(view_.basis.up, model), glm::dot(view_.basis.to_eye, model)};
  }
  glm::dvec3 in_eye(const glm::dvec3& p) const {
    const glm::dvec3 model = view_.centre + view_.basis.right * p.x + view_.basis.up * p.y + view_.basis.to_eye * p.z;
    return rotation_ * (glm::dvec3(agent_.position) + scale_ * world_from_model(model, agent_.heading));
  }
  double depth_of(const glm::dvec3& p) const { return -in_eye(p).z; }

  const scene::Frame& frame_;
  const scene::FrameAgent& agent_;
  const View& view_;
  glm::dmat3 rotation_;
  double tall_, wide_, scale_;
  glm::dvec3 eye_{0.0};  // from the view's centre, in its axes
};

void copy_surface(const Surfaces& from, size_t source, Surfaces& to, size_t place) {
  std::copy_n(&from.codes.data[4 * source], 4, &to.codes.data[4 * place]);
  std::copy_n(&from.base.data[3 * source], 3, &to.base.data[3 * place]);
  std::copy_n(&from.emissive.data[3 * source], 3, &to.emissive.data[3 * place]);
  to.lambert.data[place] = from.lambert.data[source];
  to.ids.data[place] = from.ids.data[source];
}

// Where it is nearer than what is there; covered: every pixel of it.
void lay(const Laid& laid, const View& view, Surfaces& surfaces, std::vector<size_t>& covered) {
  const Laid::Range range = laid.range();
  for (int y = range.top; y < range.bottom; ++y)
    for (int x = range.left; x < range.right; ++x) {
      const auto hit = laid.at(x, y);
      if (!hit) continue;
      const size_t place = static_cast<size_t>(y) * static_cast<size_t>(surfaces.ids.width) + static_cast<size_t>(x);
      covered.push_back(place);
      if (!(hit->depth < static_cast<double>(surfaces.depth.data[place]))) continue;
      copy_surface(view.picture, hit->pixel, surfaces, place);
      surfaces.depth.data[place] = static_cast<float>(hit->depth);
    }
}

}  // namespace

Surfaces draw_surfaces(const Drawer& drawer, const scene::Frame& frame, int samples) {
  assert(samples >= 1 && samples % 2 == 1);
  scene::Frame drawn = frame;
  drawn.width *= samples;
  drawn.height *= samples;
  Surfaces out;
  {
    const Target target(drawer.context, drawn.width, drawn.height, renderers::Pass{.ids = true});
    drawer.renderer.draw(drawn, drawer.representation, target);
    Capture seen = target.read();
    out.codes = middles(std::move(seen.colour), samples);
    out.ids = middles(std::move(seen.ids), samples);
    out.depth = middles(std::move(seen.depth), samples);
  }
  const Target target(drawer.context, drawn.width, drawn.height, renderers::Pass{.ids = true, .linear = true});
  out.emissive = linear_under(drawer, drawn, target, 0, 0, samples);
  out.base = linear_under(drawer, drawn, target, 1, 0, samples);
  const ImageF directed = linear_under(drawer, drawn, target, 0, 1, samples);
  out.lambert = ImageF(out.ids.width, out.ids.height, 1);
  for (size_t i = 0; i < out.ids.pixels(); ++i) {
    double base = 0;
    double lit = 0;
    for (size_t c = 3 * i; c < 3 * i + 3; ++c) {
      out.base.data[c] -= out.emissive.data[c];
      base += static_cast<double>(out.base.data[c]);
      lit += static_cast<double>(directed.data[c] - out.emissive.data[c]);
    }
    constexpr double kBlack = 1e-4;  // no code value shows whether light falls on it
    out.lambert.data[i] = base > kBlack ? static_cast<float>(lit / base) : -1.0F;
  }
  return out;
}

StoredViews draw_stored_views(const Drawer& drawer, const scene::Frame& frame, const ViewsOfAgent& views) {
  StoredViews out;
  scene::Frame others = frame;
  for (size_t c = 0; c < frame.agents.size(); ++c) {
    others.agents[c].clear();
    for (size_t i = 0; i < frame.agents[c].size(); ++i)
      if (views(c, i) == nullptr) others.agents[c].push_back(frame.agents[c][i]);
  }
  out.surfaces = draw_surfaces(drawer, others);
  // The ground stands before nobody.
  for (size_t i = 0; i < out.surfaces.ids.pixels(); ++i)
    if (out.surfaces.ids.data[i] == 0) out.surfaces.depth.data[i] = std::numeric_limits<float>::infinity();
  for (size_t c = 0; c < frame.agents.size(); ++c)
    for (size_t i = 0; i < frame.agents[c].size(); ++i) {
      const renderers::ViewSampling* sampling = views(c, i);
      if (sampling == nullptr) continue;
      const scene::FrameAgent& agent = frame.agents[c][i];
      const View view = view_of(drawer, frame, c, agent, *sampling);
      lay(Laid(frame, agent, view), view, out.surfaces,
          out.covered.emplace_back(agent.id, std::vector<size_t>{}).second);
    }
  return out;
}

}  // namespace crowdbench::bench
