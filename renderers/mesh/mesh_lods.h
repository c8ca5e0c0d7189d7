// The mesh with levels of detail: what every game has, as one representation. Each agent is drawn by the coarsest of
// its character's levels whose own error spans no more than so many pixels where the agent stands.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "renderers/representation.h"

namespace crowdbench::renderers {

// "2000/500/0.02/own": from fine to coarse, each a number of triangles, a share of the character's (below 1), or
// "own": the levels that the characters' files hold, those that all of them have. One spec of the mesh each; none of
// the whole mesh, which comes before them. Throws Error: not of that form, not from fine to coarse, no own levels.
std::vector<Spec> lod_specs(const std::string& lods, const scene::Cast& cast);
// What can be said of a value of the option, "none" included, without a cast. Throws Error.
void check_lods(const std::string& value, const std::string& where);

// The coarsest level, counted from 1, of those that are allowed to be seen; 0: the whole mesh. errors: metres at scale
// 1, by level, from fine to coarse. metres_a_pixel: at the agent, positive; at its scale 1.
size_t coarsest_within(std::span<const double> errors, double metres_a_pixel, double pixels);

// What all agents of a frame have in common.
struct PixelScale {
  glm::vec3 forward{0.0F};  // of the camera, unit
  double metres = 0;        // that a pixel covers a metre deep
};
PixelScale pixel_scale(const scene::Frame& frame);
// Metres that a pixel covers at the eye-space depth of an agent's middle, over its scale. 0 where that is not in front
// of the eye. height: metres, of the character at scale 1.
double metres_a_pixel(const PixelScale& scale, const scene::FrameAgent& agent, double height);

class MeshLods : public Representation {
 public:
  // levels: the whole mesh first, each with its BakeInfo::levels but the first; names: as components() says them.
  // pixels: the most that the error of what is drawn may span.
  MeshLods(std::vector<std::unique_ptr<Representation>> levels, std::vector<std::string> names, const scene::Cast& cast,
           double pixels);
  void draw(const scene::Frame& frame, const FrameResources& resources, const AgentLists& agents,
            const Pass& pass) override;
  Footprint footprint() const override;  // the sum: every level keeps the character's textures
  BakeInfo bake_info() const override;
  uint64_t triangles(size_t character) const override { return levels_.front()->triangles(character); }
  std::vector<std::string> components() const override { return names_; }
  std::vector<AgentShares> shares(const scene::Frame& frame, const AgentLists& agents) override;
  void hold(const std::vector<AgentShares>& held) override;

  // Agents of the last frame drawn, by level.
  const std::vector<size_t>& drawn() const { return drawn_; }

 private:
  size_t level_of(const PixelScale& scale, size_t character, const scene::FrameAgent& agent) const;

  std::vector<std::unique_ptr<Representation>> levels_;
  std::vector<std::string> names_;
  std::vector<std::vector<double>> errors_;  // by character and level, without the whole mesh
  std::vector<double> heights_;
  double pixels_;
  std::vector<int> held_;  // by id: a level, or -1; none: nobody is held
  std::vector<size_t> drawn_;
  std::vector<AgentLists> split_;  // of the last frame, by level: kept for its memory
};

// Of a spec of the mesh with the option `lods`; what else it says (floor, passes) goes for all levels. pixels: that a
// level's error may span.
std::unique_ptr<Representation> make_mesh_lods(const MakeContext& context, const Spec& spec, double pixels);

}  // namespace crowdbench::renderers
