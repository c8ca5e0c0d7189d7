// Where a character stands: how tall it is, where its ground is, and its middle. Internal to normalise.cpp, apart from
// the rules that it states.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "scene/character/character.h"
#include "scene/character/cut_out.h"
#include "scene/pose/body.h"

namespace crowdbench::scene {

// In the palette's space and unit.
glm::dvec3 skin_one(const Mesh& mesh, uint32_t v, const std::vector<glm::dmat4>& palette);

// Rounded to a billionth of the character's size: poses between keys use libm, whose last bit differs by version, and
// what is kept goes into every bake's key.
double settled(double value, double height);

// From the lowest to the highest point that is drawn, of a posed mesh (scene/pose/hidden.h).
double posed_height(DrawnExtent& extent, std::span<const glm::dvec3> posed);

// By vertex, what the body does not stand on, as it holds it: rigid meshes beside a skin (boots may be rigid too: not
// where they reach lower than the skin) and what hangs on a hand node. Nothing is where all would be. bind: the mesh in
// that pose.
std::vector<bool> find_held(const Character& character, std::span<const glm::dvec3> bind);

// Vertices that can touch the ground: the lowest of the bind pose, as far as they are drawn there. What is held and
// what no clip shows have no say where there is anything else. held: find_held(); unseen: never_shown() of the
// character.
std::vector<uint32_t> find_soles(const Character& character, std::span<const glm::dvec3> bind,
                                 const std::vector<bool>& held, std::span<const uint32_t> unseen);

// The height that carries: the lowest at which the lowest points of a cycle's poses, evenly spaced, stay for a sixth of
// it within a hundredth of the figure's height. A toe or a blade that dips below in a few frames does not lift the
// figure off the ground; where a figure never stays, it is the lowest of all.
double supporting_height(std::vector<double> lowest, double figure_height);

// In glTF units.
struct Stand {
  double height = 0;
  // supporting_height of the soles, or of the whole body, without what it holds, where that is at most a hundredth of
  // the height lower (it is what touches) or more than a twentieth (it does not stand on its soles).
  double ground = 0;
  glm::dvec3 pivot{0.0};
};
// Of the upright clip, which Character::placement and motion hold already. held and soles: of find_held() and
// find_soles().
Stand measure_stand(const Character& character, const Body& body, const std::vector<bool>& held,
                    const std::vector<uint32_t>& soles, double bind_height);

}  // namespace crowdbench::scene
