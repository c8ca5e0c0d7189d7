// What a bake of polypostors is made from: the stored frames, and the parts that each range of levels draws, posed.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "renderers/impostor/tiles/plane.h"
#include "renderers/impostor/tiles/stored_frames.h"
#include "renderers/polypostor/polypostor_bake.h"
#include "renderers/polypostor/polypostor_fit.h"
#include "renderers/polypostor/polypostor_parts.h"

namespace crowdbench::renderers {

// The parts that a range of levels draws. The finest two have all parts, coarser ones fewer, of four corners.
struct PolypostorTier {
  CutCharacter cut;
  std::vector<std::vector<uint32_t>> corners;        // by part: the triangles' vertices, anticlockwise from the front
  std::vector<std::vector<uint8_t>> two_sided;       // by part and triangle: seen from behind too
  std::vector<std::vector<glm::vec3>> positions;     // by frame, metres, model space
  std::vector<std::vector<glm::vec3>> normals;       // by frame, of any length
  std::vector<glm::vec3> tones;                      // vertex_tones
  std::vector<std::vector<SurfaceMoments>> moments;  // by part and frame
  uint32_t first_level = 0, levels = 0;
  double texel = 1;  // of its finest level, in texels of level 0: what outlines are traced and fitted in
  FitOptions fit;
};

// Poses of polygons a stored frame: at it, and half-way to the next. Images are of stored frames only.
inline constexpr int kPosesAFrame = 2;

struct PolypostorPlan {
  StoredFrames frames;  // with the poses between them
  CaptureSphere sphere;
  double texel = 0;         // metres, of level 0
  double eye = 0;           // texels in front of the centre: from there outlines are what perspective makes of them
  double slack = 0;         // texels beside an outline where nothing is torn yet: a pixel of a tall figure
  double quantum = 0;       // texels: the unit of stored positions
  float emission_peak = 0;  // of the whole character (renderers/bake/emission.h)
  std::vector<std::vector<scene::Mat3x4>> palettes;  // by frame
  std::vector<PolypostorTier> tiers;
};
inline constexpr double kPolypostorReach = 1.25;  // of the sphere's radius: what stored positions may take

// Throws Error: no extent, unknown joints in options.cuts, more than kPolypostorParts parts.
PolypostorPlan plan_polypostors(const scene::Character& character, const std::shared_ptr<const scene::PoseBank>& bank,
                                const PolypostorBakeOptions& options);

}  // namespace crowdbench::renderers
