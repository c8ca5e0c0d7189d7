// Hybrid: a representation made of two, one for the agents that are near and one for those that are far. See README.md.
#pragma once
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "renderers/hybrid/lod_switch.h"
#include "renderers/representation.h"

namespace crowdbench::renderers {

extern const RepresentationType hybrid_type;

// Made of two representations of the same cast.
class HybridRepresentation : public Representation {
 public:
  // names: of near and far, as components() says them.
  HybridRepresentation(std::unique_ptr<Representation> near, std::unique_ptr<Representation> far,
                       std::array<std::string, 2> names, const LodPolicy& policy, std::vector<LodCharacter> characters,
                       std::vector<std::shared_ptr<const scene::PoseBank>> banks);
  void draw(const scene::Frame& frame, const FrameResources& resources, const AgentLists& agents,
            const Pass& pass) override;
  Footprint footprint() const override;
  BakeInfo bake_info() const override;
  uint64_t triangles(size_t character) const override;
  double texel_metres(size_t character) const override;
  // Of the near one: that is what is seen where a coarser hybrid changes over to this one.
  double shown_phase(size_t character, int bank_clip, double phase) const override;
  bool has_history() const override;
  void advance(const scene::Frame& frame, const AgentLists& agents) override;
  std::vector<std::string> components() const override;
  std::vector<AgentShares> shares(const scene::Frame& frame, const AgentLists& agents) override;
  void hold(const std::vector<AgentShares>& held) override;

  // Agents of the last frame drawn; those that fade are neither.
  size_t near_agents() const { return near_agents_; }
  size_t far_agents() const { return far_agents_; }
  size_t fading_agents() const { return fading_agents_; }

 private:
  // The frame with the matched agents' poses, or the frame itself where they have theirs already.
  const scene::Frame& pose_matched(const scene::Frame& frame, const LodSplit& split);

  std::unique_ptr<Representation> near_, far_;
  std::array<std::string, 2> names_;
  LodSwitch switch_;
  HeldShares held_;  // none: nobody is held
  std::vector<std::shared_ptr<const scene::PoseBank>> banks_;
  scene::Frame matched_;
  size_t near_agents_ = 0, far_agents_ = 0, fading_agents_ = 0;
};

}  // namespace crowdbench::renderers
