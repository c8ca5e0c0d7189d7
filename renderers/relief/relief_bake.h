// The relief bake: for each joint a box in the joint's own frame, and on its six faces maps of front and back depth,
// colour, normal and slot, captured from the posed mesh. Pure CPU and double precision, so that a bake has the same
// bytes with every driver and thread count.
#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "renderers/bake/bake_progress.h"
#include "renderers/relief/relief_pieces.h"
#include "scene/character/character.h"

namespace crowdbench::renderers {

struct ReliefBakeOptions {
  int map_size = 128;  // texels a side of each face, 16..256
  // By joint, overriding map_size and by_area: 16, 32, ... 256; 0 or none: not given. Of joints that share a box the
  // largest counts.
  std::vector<int> texels_of_joint;
  TriangleRule rule = TriangleRule::threshold;
  double threshold = 1.2;
  CapturePose capture;
  Carriers carriers;  // empty: every joint carries itself
  // Empty: one a joint, by rule, threshold and carriers.
  std::vector<Piece> pieces;
  double longest = 0;  // metres; above 0: a longer box is captured in sections, each with maps of its own
  bool cube = false;   // faces see from the box's middle, as a cube map's
  bool by_area =
      false;         // smaller boxes get maps of fewer texels (halved until a texel is as large as the largest box's)
  double texel = 0;  // metres; by_area: no box gets finer texels than this
};

inline constexpr size_t kHullPoints = 16;

// One piece's box. Unit coordinates [0,1]^3 span the box. At time t it lies where the sum over the shares of
// palette(t)[joint] * bind_from_unit puts it.
struct ReliefBox {
  struct Mover {
    int joint = 0;
    double weight = 0;               // the mean over the box; 0: none
    glm::dmat4 bind_from_unit{0.0};  // homogeneous: the last row is the weight where a point lies
  };
  std::array<Mover, kShares> movers{};  // the heaviest first; without others the first one's is the box's own
  // By the mean of the matrices; normals are in this bind space.
  glm::dmat4 bind_from_unit{1.0};
  int joint() const { return movers[0].joint; }
  glm::dvec3 size{0.0};  // metres along the box's axes at the capture pose
  int texels = 0;        // a side of its maps; a power of two
  size_t first = 0;      // texels of one map of all boxes before it: where its maps begin
  // Corners of a prism around the surface, half a texel inside the box: the box's longest edge with its four long edges
  // cut off.
  std::array<glm::vec3, kHullPoints> hull{};
};

// Maps. A texel is covered when its centre is, so that silhouettes keep their size; beyond that, only as much as keeps
// steep surfaces whole: where the intervals of two neighbours do not meet although one surface crosses the edge between
// them, both are widened to where it crosses; and a texel is widened to a surface in it that neither its own interval
// nor a neighbour's holds (a wall seen edge-on, which its centre misses). Axis a looks along unit coordinate a; its
// picture plane is (u, v) = the coordinates (a+1) mod 3 and (a+2) mod 3, texel (i, j) at ((i+.5)/n, (j+.5)/n). The two
// faces of an axis share one unmirrored (u, v), so that front(high face) = 1 - back(low face) holds by construction and
// three depth maps serve six faces.
struct ReliefModel {
  std::vector<ReliefBox> boxes;
  // From texel 3 `first` on, [axis][v][u], two values each: least and greatest covered coordinate along the axis,
  // 16 bits; empty texels hold (65535, 0).
  // With `cube` [axis][side][v][u] from texel 6 `first` on: relief_cube.h.
  std::vector<uint16_t> depth;
  // The same layout: least and greatest coordinate of whatever surface lies anywhere within the texel's square, for
  // telling what is certainly air. Never narrower than `depth`. With `cube` empty.
  std::vector<uint16_t> extent;
  // From texel 6 `first` on, [axis][side][v][u], four bytes each: sRGB colour; the fourth is 255 where the material is
  // unlit. side 0 is the surface seen from the low face. Behind all boxes,
  // from colour_texel() on, their coarser levels: each texel is one place of the surface, with its texture filtered as
  // the mesh's is where the level is RELIEF_FINER finer than one texel a pixel. So what the mesh filters is filtered,
  // and where one material ends no colour is mixed with the next, which the mesh does not do either.
  std::vector<uint8_t> colour;
  // As `colour` without its coarser levels: the unit normal in bind space, turned toward the face, as 127.5 + 127.5 n;
  // the fourth is the slot.
  std::vector<uint8_t> normal;
  // As `normal`, the light given off (renderers/bake/emission.h), the fourth unused; empty where the peak is 0.
  std::vector<uint8_t> emission;
  float emission_peak = 0;
  bool cube = false;     // ReliefBakeOptions::cube
  bool patches = false;  // some boxes hold cut skin, open and thin
  std::vector<int> triangles_of_box;
  size_t texels() const { return boxes.empty() ? 0 : boxes.back().first + box_texels(boxes.back()); }
  static size_t box_texels(const ReliefBox& b) { return static_cast<size_t>(b.texels) * static_cast<size_t>(b.texels); }
  // Of the coarser levels of a box of n texels a side, n/2, n/4, ..., 4 (atlas_levels), one map has (n^2 - 16) / 3.
  size_t coarse_texels() const { return (texels() - 16 * boxes.size()) / 3; }
  // Where a box's level 1 or coarser begins in `colour`, in texels.
  size_t colour_texel(size_t box, uint32_t level) const {
    const size_t n2 = box_texels(boxes[box]);
    return 6 * (texels() + (boxes[box].first - 16 * box + n2 - (n2 >> (2 * (level - 1)))) / 3);
  }
  size_t depth_maps() const { return cube ? 6 : 3; }  // of a box
  // map: the axis; with `cube` twice that, and one more for the high side.
  const uint16_t* depth_map(size_t box, int map) const {
    return depth.data() + (boxes[box].first * depth_maps() + static_cast<size_t>(map) * box_texels(boxes[box])) * 2;
  }
  // colour or normal
  static const uint8_t* face(const std::vector<uint8_t>& maps, const ReliefBox& b, int axis, int side) {
    return maps.data() + (b.first * 6 + static_cast<size_t>(axis * 2 + side) * box_texels(b)) * 4;
  }
};

// Texels of one map of all boxes that a bake would have: ReliefModel::texels(), without capturing.
size_t relief_texels(const scene::Character& character, const ReliefBakeOptions& options);

// Throws Error when the character has no triangle that any joint moves. Parallel over boxes, which progress counts;
// deterministic.
ReliefModel bake_relief(const scene::Character& character, const ReliefBakeOptions& options,
                        const BakeProgress& progress = {});

// Bytes of the source's two RGBA8 maps on six faces: joints * 6 * 2 * n * n * 4.
uint64_t relief_nominal_bytes(size_t joints, int map_size);

}  // namespace crowdbench::renderers
