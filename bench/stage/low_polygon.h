// The levels of detail of the mesh that figures of speed are told against.
#pragma once
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "renderers/representation.h"

namespace crowdbench::bench {

// The reference simplified to so many triangles a character.
inline renderers::Spec level_spec(size_t triangles) {
  renderers::Spec spec = renderers::reference_spec();
  spec.options.emplace_back("triangles", std::to_string(triangles));
  return spec;
}

// Whether it is the reference with options, but not with several levels between which it changes by itself.
inline bool is_level(const renderers::Spec& spec) {
  const auto several = [](const auto& option) { return option.first == "lods"; };
  return spec.name == renderers::reference_spec().name && !spec.options.empty() && !renderers::is_floor(spec) &&
         std::ranges::none_of(spec.options, several);
}

// What a user would reach for instead of an impostor: every figure of speed is also told against it.
inline constexpr size_t kLowPolygonTriangles = 500;
inline renderers::Spec low_polygon_spec() { return level_spec(kLowPolygonTriangles); }

// Levels between which the one of equal error and the one of equal cost are looked for; the whole mesh comes before
// them. The coarsest still passes the check of what it covers: of 125 triangles the built-in character covers 15.3 %
// too little.
inline constexpr std::array<size_t, 3> kLevelTriangles = {2000, kLowPolygonTriangles, 200};
inline std::vector<renderers::Spec> level_specs() {
  std::vector<renderers::Spec> specs;
  for (const size_t triangles : kLevelTriangles) specs.push_back(level_spec(triangles));
  return specs;
}

}  // namespace crowdbench::bench
