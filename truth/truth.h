// Truth: what a frame shows, by casting rays in double precision at the skinned triangles. No GPU, no driver, no float
// after what the frame itself holds: what the mesh and every other representation is judged by.
//
// Where it begins: at scene::Frame and the pose banks, as every representation does. Their floats (places relative to
// the eye, joint matrices, the blend of two samples) are taken at their value; skinning, projection, visibility and
// shading are done in double from there. Weights and normals are the character's own, not those that a vertex format
// leaves of them.
//
// What is drawn: what the mesh draws. One-sided materials show their front; masks are tested against the alpha of their
// texture; the ground hides what is below it; nothing nearer than the camera's near or farther than its far is there.
// Of surfaces at the very same depth the agent that comes first in the frame is seen, and of it the first triangle.
//
// Textures: the filters that the material asks for, in linear light, on mip levels made by halving in linear light and
// stored in 8 bits; the level follows from the exact derivatives of the surface at the sample (OpenGL 4.5, 8.14, the
// larger of both axes, without anisotropy). OpenGL leaves a driver free in how it approximates that level: where a
// texture is magnified a mesh must agree within its weights' 8 bits (1/256 of the difference of neighbouring texels an
// axis); where it is minified only within what one level is from the next.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <span>
#include <vector>

#include "core/image.h"
#include "scene/cast/cast.h"
#include "scene/frame/frame.h"

namespace crowdbench::truth {

struct TruthOptions {
  // Rays a side of a pixel, odd: side x side evenly placed ones, whose mean is the colour and the coverage. 0: as many
  // as Frame::antialiasing::supersample says. Its `samples` have no say: their places are the driver's own.
  int side = 0;
  unsigned threads = 0;  // as of parallel_for; no bit of the result depends on it
  bool shade = true;     // false: no colours, for who wants to know only what is where
};

// All width x height, row 0 on top. But for colours and coverage they are those of the pixel's centre.
struct TruthPicture {
  Image8 colour;           // RGBA, sRGB-encoded, alpha 255; empty without `shade`
  ImageF linear;           // RGBA, linear light, alpha 1; empty without `shade`
  Image<double> depth;     // metres along the view axis, the ground's too; +inf where there is nothing
  Image<double> normal;    // 3 channels: world axes, unit, as it is shaded; 0 0 0 where there is no agent
  ImageU32 ids;            // FrameAgent::id; 0: no agent
  ImageU32 materials;      // index into the materials of the agent's character, + 1; 0: no agent
  Image<double> coverage;  // [0, 1]: of the pixel's rays, those that meet an agent
};

// Every pixel of the frame. Says its progress ("truth") and notices Ctrl-C. Takes about a microsecond a ray and
// hardware thread, and a millisecond an agent of 5,000 triangles; memory follows the picture's size, not the crowd's.
// Throws Error: side is not an odd number from 1 to 63.
TruthPicture cast_truth(const scene::Cast& cast, const scene::Frame& frame, const TruthOptions& options = {});

// What one ray meets.
struct TruthPoint {
  uint32_t id = 0;  // FrameAgent::id; 0: no agent, and then all but depth and colour are as here
  uint32_t character = 0;
  uint32_t agent = 0;     // into Frame::agents[character]
  uint32_t triangle = 0;  // of the character's mesh: its corners are Mesh::indices[3 * triangle], ...
  uint32_t material = 0;  // into Character::materials
  bool back = false;      // seen from behind (double-sided materials alone)
  double depth = std::numeric_limits<double>::infinity();  // metres along the view axis
  glm::dvec3 weights{0.0};                                 // of the triangle's corners, sum 1
  glm::dvec3 normal{0.0};                                  // world axes, unit
  glm::dvec3 linear{0.0};                                  // linear light; 0 without `shade`
};

// At chosen places: pixels from the picture's upper left corner, so that (0.5, 0.5) is the centre of the first; within
// [0, width] x [0, height], others see nothing. One result a place, in their order. No progress; notices Ctrl-C.
// A footprint for the filters is 1 / side of a pixel.
std::vector<TruthPoint> cast_points(const scene::Cast& cast, const scene::Frame& frame,
                                    std::span<const glm::dvec2> places, const TruthOptions& options = {});

// The same of one agent alone: whatever else stands before it, without the ground.
std::vector<TruthPoint> cast_points_at(const scene::Cast& cast, const scene::Frame& frame, uint32_t id,
                                       std::span<const glm::dvec2> places, const TruthOptions& options = {});

}  // namespace crowdbench::truth
