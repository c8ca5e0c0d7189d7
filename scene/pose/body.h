// The body of a character: what is drawn of it, as mass on its joints. How it travels is measured on this and not on a
// node, because files animate travel on any node: the root, a hips joint below a root that stands, several at once.
#pragma once
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "scene/character/character.h"

namespace crowdbench::scene {

class Body {
 public:
  // A triangle's mass is its area in the bind pose, as far as its mask leaves it, shared out on its corners. Things
  // held (rigid meshes beside a skin) are not the body. Where nothing has area, every drawn corner has the same mass.
  // unseen: vertices that have no area (never_shown() of scene/pose/hidden.h).
  explicit Body(const Character& character, std::span<const uint32_t> unseen = {});

  // Does this entry of Skeleton::joints carry any of it?
  bool carried_by(size_t joint) const { return lumps_[joint].mass > 0; }
  // Does it carry anything that is seen, of the body or of what is held?
  bool shown_by(size_t joint) const { return carried_by(joint) || holds_[joint]; }
  // The centre of mass as posed, in the palette's space and unit.
  glm::dvec3 centre(const std::vector<glm::dmat4>& palette) const;
  // Points that stand for it: four a joint, from its mass and how far that spreads.
  struct Point {
    glm::dvec3 at;
    double mass;
  };
  std::vector<Point> points(const std::vector<glm::dmat4>& palette) const;

 private:
  struct Lump {
    double mass = 0;
    glm::dvec3 centre{0.0};  // bind space
    double spread = 0;       // root of the mean square distance from the centre
  };
  std::vector<Lump> lumps_;  // by joint
  std::vector<bool> holds_;  // by joint: a thing with an area
  double mass_ = 0;
};

// The motion over the ground that brings one pose nearest to another: turned by `yaw` about +Y (from +Z towards +X),
// then moved. `left` is what remains: the root of the mass's mean square distance, all three axes.
struct GroundFit {
  glm::dvec3 displacement{0.0};  // of the centre of mass; y as far as it rises or sinks with the whole body
  double yaw = 0;                // radians, (-pi, pi]
  double left = 0;
  double left_unturned = 0;  // the same for the displacement alone
};
GroundFit fit_on_ground(const Body& body, const std::vector<glm::dmat4>& from, const std::vector<glm::dmat4>& to);

}  // namespace crowdbench::scene
