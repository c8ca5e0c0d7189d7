// The level of detail that each agent is drawn at, and the order that agents are drawn in.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "scene/frame/frame.h"

namespace crowdbench::renderers {

// Keeps its memory from one frame to the next.
class LevelOrder {
 public:
  // Gives every chosen agent (indices into `all`) the coarsest level whose texels (texel * 2^level metres at scale 1)
  // cover at most sqrt 2 pixels at the depth of the agent's capture centre (model space, metres), and orders the agents
  // by level, and from front to back within one, so that what is hidden is refused by the depth test before it is
  // shaded. Counting sort: the order of agents whose depths differ by less than 1.5 percent is that of `chosen`.
  void sort(const scene::Frame& frame, const std::vector<scene::FrameAgent>& all, std::span<const uint32_t> chosen,
            const glm::vec3& centre, double texel, int levels);

  size_t agents() const { return sorted_.size(); }
  // The agents of one level; of all levels, level after level.
  std::span<const uint32_t> at_level(int level) const;
  std::span<const uint32_t> all() const { return sorted_; }

 private:
  std::vector<uint32_t> keys_, counts_, first_, sorted_;
};

}  // namespace crowdbench::renderers
