// View grids: the directions from which impostors are captured, and which of them stands in for a given direction.
//
// A direction points from the capture centre to the eye, in the character's model space (+Y up, the character faces
// +Z). Azimuth 0 is the front (+Z) and grows towards the character's left (+X); elevation 0 is level, 90 degrees is
// from straight above. view_grid.glsl picks on the GPU by the same formulas.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace crowdbench::renderers {

enum class GridKind : uint8_t { sphere, cube, hemi };

// What an impostor's plane is spanned by: unit, right-handed, right x up = to_eye.
struct ViewBasis {
  glm::dvec3 right{1, 0, 0};
  glm::dvec3 up{0, 1, 0};
  glm::dvec3 to_eye{0, 0, 1};
};

// A view and, for a mirrored grid, whether its image is to be flipped left to right (and half a cycle later).
struct ViewPick {
  int view = 0;
  bool mirrored = false;
  bool operator==(const ViewPick&) const = default;
};

// Three views around a direction and what each of them counts for: barycentric weights, sum 1, none negative. A view
// may occur twice, at the grid's ends.
struct ViewBlend {
  std::array<int, 3> views{};
  std::array<double, 3> weights{1, 0, 0};
  bool mirrored = false;
};

struct ViewGrid {
  GridKind kind = GridKind::sphere;
  int azimuths = 17;      // sphere: samples of the full turn, or of the half turn [0, 180] when mirrored
  int elevations = 8;     // sphere: samples of [el_min, 90 degrees], both ends included; 1 = el_min alone
  int n = 8;              // cube: samples along a face's edge; hemi: samples along the square's edge
  double el_min = 0;      // radians, the lowest elevation; lower directions use its views. hemi: always 0
  bool mirrored = false;  // sphere only: for a character and cycle that repeat themselves mirrored, half a cycle later

  int size() const;  // views, counted with those that `reachable` rules out
  ViewBasis basis(int view) const;
  // The nearest view. sphere: by angle, exactly. cube, hemi: by the cell of the grid (no trigonometry), which is the
  // nearest by angle except within a few degrees of a cell's border. Directions below el_min are raised to it. The
  // direction need not be a unit vector; the zero vector picks some view.
  ViewPick pick(const glm::dvec3& to_eye) const;
  // The corners of the triangle of the grid that the direction lies in (each cell of four views split along its
  // diagonal). Views and weights together change continuously with the direction: all over sphere and hemi, and over a
  // cube but for where three faces meet. At a view's own direction it is that view alone.
  ViewBlend blend(const glm::dvec3& to_eye) const;
  // Calls `see` for every view that the GPU may pick (or, with `blended`, mix) for a direction: it picks in single
  // precision, so that what lies within rounding of a border may fall to either side of it. A view may be seen twice.
  void visit_picks(const glm::dvec3& to_eye, bool blended,
                   const std::function<void(int view, bool mirrored)>& see) const;
  // False for views that no direction picks (cube: cells wholly below el_min); they are not captured.
  bool reachable(int view) const;
  std::string text() const;  // "sphere-17x8", "sphere-17x8-mirrored", "cube-4", "hemi-12"
};

// Parses what text() writes. Throws Error naming `where` and the forms that are known. Limits: 1..512 azimuths,
// 1..129 elevations, 1..64 for n (hemi: 2..128).
ViewGrid parse_view_grid(const std::string& text, double el_min, const std::string& where);

// What pick_view of view_grid.glsl takes.
struct ViewGridUniforms {
  glm::ivec4 grid;
  glm::vec4 span;
};
ViewGridUniforms view_grid_uniforms(const ViewGrid& grid);

// Right and up of every view, one after the other; the fourth coordinates are 0.
std::vector<glm::vec4> view_axes(const ViewGrid& grid);

// Angle in radians between a direction (raised to el_min) and the direction of the view picked for it, as the mirrored
// flag places it.
double view_error(const ViewGrid& grid, const glm::dvec3& to_eye);

// Largest and mean view_error over the directions at or above el_min, sampled evenly on the sphere (a golden-angle
// spiral). radians.
struct ViewErrors {
  double largest = 0;
  double mean = 0;
};
ViewErrors compute_view_errors(const ViewGrid& grid, int samples = 20000);

// Angles between views that lie next to each other on the grid (cells that share an edge; rows of one direction, as at
// the pole, left out): by how much the picture turns at once when an agent turns. radians.
struct ViewSteps {
  double largest = 0;
  double mean = 0;
};
ViewSteps compute_view_steps(const ViewGrid& grid);
// The smallest grid of the same kind (and el_min, and mirroring) whose largest step is at most `step` radians.
ViewGrid grid_for_step(const ViewGrid& grid, double step);

}  // namespace crowdbench::renderers
