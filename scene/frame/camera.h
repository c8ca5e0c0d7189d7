// Camera: look-at or a path of keyed views; reversed, optionally infinite depth.
#pragma once
#include <glm/glm.hpp>
#include <vector>

namespace crowdbench::scene {

// World space, metres, double: positions far from the origin keep their precision until the frame makes them
// camera-relative.
struct Camera {
  glm::dvec3 eye{0.0, 1.6, 5.0};
  glm::dvec3 target{0.0, 1.0, 0.0};
  glm::dvec3 up{0.0, 1.0, 0.0};
  double fov_y = 0.7853981633974483;  // radians, vertical, (0, pi)
  double near = 0.1;                  // metres, > 0
  double far = 0.0;                   // metres; 0 = infinite
  bool operator==(const Camera&) const = default;
};

// World to eye without the translation: rows are right, up, backward (eye looks along -Z). An up parallel to the view
// direction is replaced by -Z (looking down) or +Z (looking up). An eye at its target looks along -Z.
glm::dmat3 view_rotation(const Camera& camera);
// Reversed depth in [0, 1]: near maps to 1, far (or infinity) to 0. Column-major, for eye space looking along -Z.
glm::dmat4 projection(const Camera& camera, double aspect);
// Size in metres of one pixel at eye-space depth d: 2 d tan(fov/2) / rows.
double pixel_size_at(const Camera& camera, double depth, int rows);

struct CameraKey {
  double time = 0;  // seconds
  Camera camera;
  bool operator==(const CameraKey&) const = default;
};
// A path of views: eye, target and field of view linear between keys, clamped outside; up, near and far are those of
// the key before. Keys by strictly ascending time.
struct CameraPath {
  std::vector<CameraKey> keys;  // at least one
  Camera at(double seconds) const;
  bool operator==(const CameraPath&) const = default;
};

}  // namespace crowdbench::scene
