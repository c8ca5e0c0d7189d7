// Tile capture: images of a posed character, by parallel rays or from an eye, drawn by the mesh's own code.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "renderers/impostor/tiles/tile.h"
#include "renderers/impostor/views/view_grid.h"
#include "scene/character/character.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::gl {
class Context;
}

namespace crowdbench::renderers {

// The sphere around a character in all its captured poses: the point that impostors' planes go through, metres, model
// space.
struct CaptureSphere {
  glm::dvec3 centre{0.0};
  double radius = 0;
};

// A sphere that holds all the points, within about one percent of the smallest one. Points: any number of sets.
CaptureSphere enclosing_sphere(const std::vector<std::vector<glm::vec3>>& sets);
// The whole texels of level 0 that hold the projection of the points onto a view's plane. Triangles lie between their
// vertices, so this bounds the silhouette exactly.
TileRect tile_bounds(const std::vector<glm::vec3>& points, const glm::dvec3& centre, const ViewBasis& basis,
                     double texel);

// One tile to capture. pose: into the capture's bank.
struct CaptureTile {
  scene::PoseSample pose;
  ViewBasis basis;
  TileRect rect;
  // False: it only keeps its place, so that what others look like does not depend, by the rounding of a place, on which
  // tiles are wanted.
  bool wanted = true;
};

// What the numbers of a captured tile stand for.
struct CaptureScale {
  glm::dvec3 centre{0.0};  // that the planes of all views go through: metres, model space
  double texel = 0;        // metres
  double range = 0;        // metres that the depth code's ends stand for
  // Metres from the centre at which an eye sees what is captured: places are those of the rays through the plane, as
  // rect counts them, and depth codes are of no use. More than range; 0: parallel rays.
  double eye = 0;
  float peak = 0;  // of the light that the whole character gives off (renderers/bake/emission.h); 0: none is captured
};

class TileCapture {
 public:
  // Poses come from `bank`.
  TileCapture(gl::Context& context, std::shared_ptr<const scene::Character> character,
              std::shared_ptr<const scene::PoseBank> bank, const CaptureScale& scale);
  ~TileCapture();
  TileCapture(const TileCapture&) = delete;
  TileCapture& operator=(const TileCapture&) = delete;

  // Draws every tile with 3 x 3 samples a texel, page by page. `done(page, texels)` is called from this thread for each
  // page: indices into `tiles`, and the texels of each in the form that build_tile_levels takes. Tiles without a
  // rectangle and tiles that are not wanted are left out. Throws Error when a tile is larger than this driver's
  // targets.
  using Done = std::function<void(std::span<const size_t> page, std::span<const std::vector<CapturedTexel>> texels)>;
  void capture(std::span<const CaptureTile> tiles, const Done& done);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace crowdbench::renderers
