// Hybrid: a representation made of two, one for the agents that are near and one for those that are far. See README.md.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "renderers/representation.h"

namespace crowdbench::renderers {

extern const RepresentationType hybrid_type;

// Which of two representations an agent gets: a rule on where it stands in one frame, without memory.
//   distance: metres from the eye to the agent's pivot (Euclidean); farther agents are far.
//   height: pixels that the character's height covers at the eye-space depth of its middle; lower ones are far.
//   ratio: pixels that one texel of the far representation covers at that depth (renderers/flat/README.md); agents
//   whose
//          texels cover less than `value` pixels are far.
struct LodPolicy {
  enum class Rule : uint8_t { distance, height, ratio };
  Rule rule = Rule::distance;
  double value = 20;
};

// What the rule needs to know of a character, metres at scale 1.
struct LodCharacter {
  double height = 1.75;
  double texel = 0;  // of the far representation; 0: it has none
};

// Splits lists of agents. near and far keep the order of `agents`.
void split_agents(const LodPolicy& policy, const std::vector<LodCharacter>& characters, const scene::Frame& frame,
                  const AgentLists& agents, AgentLists& near, AgentLists& far);

// The depth or distance in metres at which an agent of scale 1 on the view axis changes over, from the rule itself.
double switch_distance(const LodPolicy& policy, const LodCharacter& character, const scene::Camera& camera, int rows);

// Made of two representations of the same cast.
class HybridRepresentation : public Representation {
 public:
  HybridRepresentation(std::unique_ptr<Representation> near, std::unique_ptr<Representation> far, LodPolicy policy,
                       std::vector<LodCharacter> characters);
  void draw(const scene::Frame& frame, const FrameResources& resources, const AgentLists& agents,
            const Pass& pass) override;
  Footprint footprint() const override;
  BakeInfo bake_info() const override;
  uint64_t triangles(size_t character) const override;
  double texel_metres(size_t character) const override;

  // Agents of the last frame drawn.
  size_t near_agents() const { return near_agents_; }
  size_t far_agents() const { return far_agents_; }

 private:
  std::unique_ptr<Representation> near_, far_;
  LodPolicy policy_;
  std::vector<LodCharacter> characters_;
  AgentLists near_list_, far_list_;
  size_t near_agents_ = 0, far_agents_ = 0;
};

}  // namespace crowdbench::renderers
