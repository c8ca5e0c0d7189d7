// The bake of per-joint impostors: a picture a piece and view, at every level, of the rest pose. Bytes depend on the
// character and the options, not on how many clips it has or how long they are.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderers/impostor/views/view_grid.h"
#include "scene/character/character.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::gl {
class Context;
}

namespace crowdbench::renderers {

struct PerJointOptions {
  ViewGrid grid;         // of each joint's own space: its el_min is -90 degrees or near
  int texels = 128;      // across the sphere round the rest pose
  double least = 0.006;  // of the surface: a smaller piece goes with the joint above
  float border = 0;      // share of weight that pieces end at, (0, 0.5]; 0: chosen by the clips (perjoint_border.h)
  unsigned threads = 0;  // as parallel_for; the bytes do not depend on it
};

struct PerJointBake {
  float texel = 0;  // metres, of level 0
  uint32_t pieces = 0, views = 0, levels = 0;
  std::vector<uint32_t> joints;               // by piece: the joint that carries it
  std::vector<std::array<float, 4>> inverse;  // three rows a piece: model space of the rest pose to the joint's
  std::vector<std::array<float, 4>> centres;  // by piece: model space of the rest pose, metres; w: metres that the ends
                                              // of stored depths stand for
  std::vector<float> borders;                 // by piece
  std::array<float, 4> torn{};                // BorderChoice's holes, strays, and both with cuts alone; 0 where given
  // Two a tile, level-major, then by piece, then by view: offset from lattice coordinates to texels on the page (x, y),
  // layer, covered texels; the plane's slopes and height, metres, and the tile's width in texels (0: empty).
  std::vector<std::array<float, 4>> tiles;
  std::vector<std::array<float, 2>> outlines;  // CB_PERJOINT_CORNERS a tile, lattice coordinates, in strip order
  int width = 0, height = 0, layers = 0;       // of the pages, row 0 lowest
  std::vector<uint8_t> albedo, surface;        // as Tile's
  std::vector<uint8_t> emission;
  float emission_peak = 0;
  uint64_t texture_bytes() const { return albedo.size() + surface.size() + emission.size(); }
};

std::string perjoint_cache_key(const scene::Character& character, const scene::PoseBank& bank,
                               const PerJointOptions& options, const std::string& gl_renderer,
                               const std::string& gl_version);

// Throws Error where the pages need more than `budget` bytes, before anything is drawn, or are larger than the driver's
// textures.
PerJointBake bake_perjoint(gl::Context& context, const std::shared_ptr<const scene::Character>& character,
                           const scene::PoseBank& bank, const PerJointOptions& options, uint64_t budget,
                           const std::function<void(size_t done, size_t tiles)>& progress = {});

std::vector<uint8_t> serialise(const PerJointBake& bake);
std::optional<PerJointBake> deserialise_perjoint(std::span<const uint8_t> bytes);

}  // namespace crowdbench::renderers
