#include "reports/model/crossovers.h"

#include "core/statistics.h"

namespace crowdbench::reports {

std::vector<CrossoverLine> crossovers_of(const Scene& scene, const std::string& metric) {
  std::vector<CrossoverLine> lines;
  for (const double occupancy : scene.occupancies) {
    for (size_t i = 0; i < scene.representations.size(); ++i) {
      for (size_t j = i + 1; j < scene.representations.size(); ++j) {
        Curve first;
        Curve second;
        for (const uint32_t agents : scene.agents) {
          const MeasurementRow* a = scene.find(scene.representations[i], agents, occupancy);
          const MeasurementRow* b = scene.find(scene.representations[j], agents, occupancy);
          if (a == nullptr || b == nullptr || !is_timed(*a) || !is_timed(*b)) continue;
          const auto& time_a = time_of(*a, metric);
          const auto& time_b = time_of(*b, metric);
          if (!time_a || !time_b || time_a->median <= 0 || time_b->median <= 0 || agents == 0) continue;
          first.x.push_back(agents);
          first.y.push_back(time_a->median);
          second.x.push_back(agents);
          second.y.push_back(time_b->median);
        }
        if (first.x.size() < 2) continue;
        CrossoverLine line;
        line.occupancy = occupancy;
        line.first = scene.representations[i];
        line.second = scene.representations[j];
        line.from = static_cast<uint32_t>(first.x.front());
        line.to = static_cast<uint32_t>(first.x.back());
        const std::vector<Crossover> found = crossovers(first, second);
        for (const Crossover& crossing : found) {
          line.agents = crossing.x;
          line.time_ns = crossing.y;
          line.cheaper_beyond = crossing.first_is_below_after ? line.first : line.second;
          line.cheaper_below = crossing.first_is_below_after ? line.second : line.first;
          lines.push_back(line);
        }
        if (found.empty()) {
          size_t first_wins = 0;
          for (size_t k = 0; k < first.y.size(); ++k) first_wins += first.y[k] < second.y[k] ? 1 : 0;
          line.cheaper_beyond = first_wins * 2 > first.y.size() ? line.first : line.second;
          lines.push_back(line);
        }
      }
    }
  }
  return lines;
}

}  // namespace crowdbench::reports
