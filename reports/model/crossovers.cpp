#include "reports/model/crossovers.h"

#include <fmt/format.h>

#include <cmath>

#include "core/statistics.h"
#include "reports/model/number_text.h"

namespace crowdbench::reports {
namespace {

// Ratios of the reference's time to the other's, by ascending agents: above 1 the other is the cheaper one.
struct Ratios {
  std::vector<double> agents, ratio, low, high, reference_ns;
};

Ratios ratios_of(const Scene& scene, const std::string& name, double occupancy, const std::string& metric) {
  Ratios ratios;
  for (const uint32_t agents : scene.agents) {
    const MeasurementRow* reference = scene.find(scene.reference, agents, occupancy);
    const MeasurementRow* other = scene.find(name, agents, occupancy);
    const RatioRow* row = scene.ratio("speed", name, agents, occupancy, metric);
    if (agents == 0 || row == nullptr || !(row->low > 0) || reference == nullptr || other == nullptr) continue;
    if (!is_timed(*reference) || !is_timed(*other) || !time_of(*reference, metric)) continue;
    ratios.agents.push_back(agents);
    ratios.ratio.push_back(row->ratio);
    ratios.low.push_back(row->low);
    ratios.high.push_back(row->high);
    ratios.reference_ns.push_back(time_of(*reference, metric)->median);
  }
  return ratios;
}

// 1: the other is the cheaper one; -1: the reference is; 0: the interval does not say.
int told(const Ratios& ratios, size_t i) { return ratios.low[i] > 1 ? 1 : ratios.high[i] < 1 ? -1 : 0; }

// Where a curve over the points first..last passes 1, the first or the last time. Its ends lie on either side of 1.
double passes_one(const Ratios& ratios, const std::vector<double>& curve, size_t first, size_t last, bool first_time) {
  const auto slice = [&](const std::vector<double>& of) {
    return std::vector<double>(of.begin() + static_cast<ptrdiff_t>(first),
                               of.begin() + static_cast<ptrdiff_t>(last) + 1);
  };
  const std::vector<double> x = slice(ratios.agents);
  const std::vector<Crossover> found = crossovers({x, slice(curve)}, {x, std::vector<double>(x.size(), 1.0)});
  if (found.empty()) return x.back();
  return first_time ? found.front().x : found.back().x;
}

double reference_time_at(const Ratios& ratios, double agents) {
  size_t i = 0;
  while (i + 2 < ratios.agents.size() && ratios.agents[i + 1] < agents) ++i;
  const double t = std::log(agents / ratios.agents[i]) / std::log(ratios.agents[i + 1] / ratios.agents[i]);
  return ratios.reference_ns[i] * std::pow(ratios.reference_ns[i + 1] / ratios.reference_ns[i], t);
}

// The order changes between two points where it is known, i and j; between them it is not.
void add_crossing(std::vector<CrossoverLine>& lines, CrossoverLine line, const Ratios& ratios, size_t i, size_t j) {
  const bool up = told(ratios, j) > 0;
  line.agents = std::sqrt(passes_one(ratios, ratios.ratio, i, j, true) * passes_one(ratios, ratios.ratio, i, j, false));
  line.agents_low = passes_one(ratios, up ? ratios.high : ratios.low, i, j, true);
  line.agents_high = passes_one(ratios, up ? ratios.low : ratios.high, i, j, false);
  line.time_ns = reference_time_at(ratios, *line.agents);
  line.cheaper_below = up ? line.first : line.second;
  line.cheaper_beyond = up ? line.second : line.first;
  lines.push_back(std::move(line));
}

void add_lines(std::vector<CrossoverLine>& lines, const CrossoverLine& line, const Ratios& ratios) {
  std::optional<size_t> last;
  bool crosses = false;
  CrossoverLine whole = line;
  for (size_t i = 0; i < ratios.agents.size(); ++i) {
    const int side = told(ratios, i);
    if (side == 0) continue;
    if (last && told(ratios, *last) != side) {
      add_crossing(lines, line, ratios, *last, i);
      crosses = true;
    }
    if (!last) whole.told_from = static_cast<uint32_t>(ratios.agents[i]);
    whole.told_to = static_cast<uint32_t>(ratios.agents[i]);
    whole.cheaper_beyond = side > 0 ? line.second : line.first;
    last = i;
  }
  if (!crosses) lines.push_back(std::move(whole));
}

}  // namespace

std::vector<CrossoverLine> crossovers_of(const Scene& scene, const std::string& metric) {
  std::vector<CrossoverLine> lines;
  for (const double occupancy : scene.occupancies)
    for (const std::string& name : scene.representations) {
      if (name == scene.reference) continue;
      const Ratios ratios = ratios_of(scene, name, occupancy, metric);
      if (ratios.agents.size() < 2) continue;
      CrossoverLine line;
      line.occupancy = occupancy;
      line.first = scene.reference;
      line.second = name;
      line.from = static_cast<uint32_t>(ratios.agents.front());
      line.to = static_cast<uint32_t>(ratios.agents.back());
      add_lines(lines, line, ratios);
    }
  return lines;
}

std::string crossover_text(const CrossoverLine& line) {
  const auto whole = [](double agents) { return static_cast<uint64_t>(std::llround(agents)); };
  if (line.agents)
    return fmt::format("from about {} on (95 % interval {} to {}), {} is the cheaper one",
                       agents_text(whole(*line.agents)), count_text(whole(line.agents_low)),
                       count_text(whole(line.agents_high)), line.cheaper_beyond);
  if (line.cheaper_beyond.empty())
    return fmt::format("not distinguishable from {} to {}", count_text(line.from), agents_text(line.to));
  if (line.told_from == line.from && line.told_to == line.to)
    return fmt::format("{} is the cheaper one from {} to {}", line.cheaper_beyond, count_text(line.from),
                       agents_text(line.to));
  const std::string where = line.told_from == line.told_to
                                ? "with " + agents_text(line.told_from)
                                : fmt::format("from {} to {}", count_text(line.told_from), agents_text(line.told_to));
  return fmt::format("{} is the cheaper one {}; elsewhere from {} to {} they are not distinguishable",
                     line.cheaper_beyond, where, count_text(line.from), agents_text(line.to));
}

}  // namespace crowdbench::reports
