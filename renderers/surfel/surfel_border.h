// Where a surface ends: at open edges and where a mask cuts it out. Discs must not reach far beyond.
#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderers/surfel/surfel_level.h"
#include "renderers/surfel/surfel_order.h"
#include "scene/character/character.h"

namespace crowdbench::renderers {

// For each triangle of the mesh's indices, of its three edges (corner k to the next): whether the surface ends there,
// as no other triangle has that edge. Corners in one place are one, and so are triangles with the same three.
std::vector<std::array<bool, 3>> find_borders(const scene::Mesh& mesh);

// Of one thing: a place on it, or, for places beside it, whose surface ends before it.
struct SheetPlace {
  SurfacePlace place;
  uint32_t primitive = 0;  // of the mesh
};

// For the surfels in their order: metres along its plane to the nearest place beside its own surface, of those that
// discs of twice its first level's radius meet; else infinite.
std::vector<float> find_reaches(std::span<const SheetPlace> surfels, std::span<const SheetPlace> beside,
                                std::span<const SurfelLevel> levels);

// The factor of reaches, at least 0.25, with which discs of a level miss as many places of the surface as they reach
// beside it: so that what is there and what is drawn have one area. Places other than those that reaches were found by:
// those say too little of what lies between them. 1 where nothing is beside. radius: of the discs at most, metres.
float fit_reach(std::span<const SheetPlace> surfels, std::span<const float> reaches, std::span<const SheetPlace> on,
                std::span<const SheetPlace> beside, float radius);

}  // namespace crowdbench::renderers
