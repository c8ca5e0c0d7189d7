#include "scene/crowd/crowd_stage.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/portable_math.h"
#include "scene/cast/cast.h"

namespace crowdbench::scene {

double stage_height(const Cast& cast) {
  double height = 0;
  for (size_t c = 0; c < cast.characters.size(); ++c) height += cast.shares[c] * cast.characters[c]->placement.height;
  return static_cast<double>(static_cast<int64_t>(height * 65536.0 + 0.5)) / 65536.0;
}

double half_tangent(const Camera& camera) {
  const SinCos half = sincos_turns(camera.fov_y / 2 / 6.283185307179586);
  return half.sin / half.cos;
}

ViewGround::ViewGround(const StageView& view, double rise)
    : rotation_(view_rotation(view.camera)),
      axes_(glm::transpose(rotation_)),
      tall_(half_tangent(view.camera)),
      wide_(tall_ * view.aspect),
      rise_(rise),
      steep_(axes_[1].y < 0.2),
      near_(view.near_depth),
      far_(view.far_depth) {
  if (steep_) return;
  // In the middle column the plane lies at y = offset + slope * depth in eye space; keep the depths where that is
  // within the picture.
  const double offset = rise_ / axes_[1].y;
  const double slope = axes_[2].y / axes_[1].y;
  for (const double side : {1.0, -1.0}) {  // side * (offset + slope * depth) + tall * depth >= 0
    const double gain = side * slope + tall_;
    if (gain > 0) near_ = std::max(near_, -side * offset / gain);
    if (gain < 0) far_ = std::min(far_, -side * offset / gain);
  }
  if (near_ > far_) {  // the picture misses the stage: take it as it was asked for
    near_ = view.near_depth;
    far_ = view.far_depth;
  }
}

GroundPoint ViewGround::at(double across, double along) const {
  glm::dvec3 point;
  if (steep_) {
    const glm::dvec3 ray{across * wide_, along * tall_, -1.0};
    const double fall = (axes_ * ray).y;
    const double depth = fall != 0 ? rise_ / fall : near_;
    point = ray * (depth > 0 ? depth : near_);
  } else {
    const double depth = std::max((near_ + far_) / 2 + along * (far_ - near_) / 2, 1e-3 * near_);
    const double x = across * wide_ * depth;
    point = {x, (rise_ - axes_[0].y * x + axes_[2].y * depth) / axes_[1].y, -depth};
  }
  const glm::dvec3 from_eye = axes_ * point;
  return {from_eye.x, from_eye.z};
}

double ViewGround::norm(const GroundPoint& point) const {
  const glm::dvec3 q = rotation_ * glm::dvec3{point.x, rise_, point.z};
  const double depth = -q.z;
  if (!(depth > 0)) return std::numeric_limits<double>::infinity();
  const double across = std::abs(q.x) / (wide_ * depth);
  if (steep_) return std::max(across, std::abs(q.y) / (tall_ * depth));
  const double half = (far_ - near_) / 2;
  return std::max(across, half > 0 ? std::abs(depth - near_ - half) / half : 0.0);
}

double ViewGround::area() const {
  const GroundPoint corners[4] = {at(-1, -1), at(1, -1), at(1, 1), at(-1, 1)};
  double twice = 0;
  for (int i = 0; i < 4; ++i) {
    const GroundPoint& a = corners[i];
    const GroundPoint& b = corners[(i + 1) % 4];
    twice += (a.x - corners[0].x) * (b.z - corners[0].z) - (b.x - corners[0].x) * (a.z - corners[0].z);
  }
  return std::abs(twice) / 2;
}

}  // namespace crowdbench::scene
