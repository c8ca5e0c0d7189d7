#include "reports/model/shown.h"

namespace crowdbench::reports {

std::vector<uint32_t> shown_agents(const Scene& scene) {
  if (scene.agents.size() <= kMostOnACurve) return scene.agents;
  std::vector<uint32_t> out;
  for (size_t i = 0; i < kMostOnACurve; ++i)
    out.push_back(scene.agents[i * (scene.agents.size() - 1) / (kMostOnACurve - 1)]);
  return out;
}

}  // namespace crowdbench::reports
