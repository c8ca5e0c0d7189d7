// Caster: the rays of a frame, agent by agent. Internal to truth.cpp.
//
// Each agent is posed, put under a hierarchy of boxes and shown to the rays that may meet it, and forgotten: memory
// follows the rays and not the crowd. What a ray keeps is the least of a total order (depth, then the agent's place in
// the frame, then the triangle), so that neither the order of agents nor the threads have a say.
#pragma once
#include <functional>
#include <mutex>
#include <vector>

#include "truth/bvh.h"
#include "truth/surface.h"
#include "truth/truth.h"

namespace crowdbench::truth {

// Places of a rectangle of pixels, in the order of its pixels.
struct Places {
  int left = 0, top = 0, width = 0, height = 0;  // pixels
  std::vector<uint32_t> first;                   // by pixel, and the end: into at
  std::vector<glm::dvec2> at;
};

class Caster {
 public:
  // step: of a footprint, pixels. only: id of the one agent that is there; 0: all are.
  Caster(const scene::Cast& cast, const scene::Frame& frame, double step, unsigned threads, uint32_t only = 0);

  struct Hit {
    double depth = std::numeric_limits<double>::infinity();
    double weights[2] = {0, 0};  // of the first two corners
    uint32_t agent = ~0U;        // over all characters
    uint32_t triangle = 0;
    bool back = false;
  };
  using Advanced = std::function<void(double share)>;  // of a call, [0, 1]; from the caller's thread
  // By place. Throws what `advanced` throws.
  std::vector<Hit> cast(const Places& places, const Advanced& advanced) const;
  // What the places show. whole: with normals and, where `shade`, colours; asked by place.
  std::vector<TruthPoint> describe(const Places& places, const std::vector<Hit>& hits, bool shade,
                                   const std::function<bool(size_t place)>& whole) const;
  size_t agents() const { return bounds_.size(); }

 private:
  struct Bounds {
    uint32_t character = 0, agent = 0;
    double nearest = 0;  // depth
    // Pixels, ends included; none where right < left.
    int left = 0, top = 0, right = -1, bottom = -1;
  };
  const scene::FrameAgent& agent_of(const Bounds& bounds) const {
    return frame_.agents[bounds.character][bounds.agent];
  }
  AgentPose pose_of(const Bounds& bounds) const;
  std::vector<glm::dvec3> positions_of(const Bounds& bounds) const;
  void find_bounds(Bounds& bounds) const;
  struct Rows;
  void cast_agent(uint32_t agent, const Places& places, std::vector<Hit>& hits, std::vector<std::mutex>& rows) const;
  TruthPoint describe_one(const Hit& hit, const glm::dvec2& place, bool shade, bool whole) const;

  const scene::Cast& cast_;
  const scene::Frame& frame_;
  View view_;
  double step_;
  unsigned threads_;
  bool alone_;
  std::vector<Surface> surfaces_;  // by character
  std::vector<Bounds> bounds_;     // by agent, over all characters
  std::vector<uint32_t> nearest_first_;
};

}  // namespace crowdbench::truth
