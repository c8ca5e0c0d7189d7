#include "reports/model/break_even.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "core/probability.h"
#include "reports/model/number_text.h"

namespace crowdbench::reports {
namespace {

constexpr size_t kAgentSteps = 60;  // of a contour
constexpr size_t kCellSteps = 13;   // of the map
constexpr size_t kOccupancySteps = 7;

// The ranges in which every one of some models was measured.
struct Measured {
  double least_agents = 1, most_agents = 0;  // none where the most is below the least
  std::vector<double> occupancies;           // 0: the scenario's own view
};
Measured measured_range(const std::vector<const CostModel*>& models) {
  Measured out;
  out.most_agents = INFINITY;
  double low = 0;
  double high = INFINITY;
  bool own_view = true;
  for (const CostModel* model : models) {
    double least = INFINITY, most = 0, lowest = INFINITY, highest = 0;
    bool seen = false;
    for (const CostPrediction& one : model->held_out) {
      if (one.point.agents > 0) least = std::min<double>(least, one.point.agents);
      most = std::max<double>(most, one.point.agents);
      if (one.point.occupancy > 0) lowest = std::min(lowest, one.point.occupancy);
      highest = std::max(highest, one.point.occupancy);
      seen = seen || one.point.occupancy == 0;
    }
    out.least_agents = std::max(out.least_agents, least);
    out.most_agents = std::min(out.most_agents, most);
    low = std::max(low, lowest);
    high = std::min(high, highest);
    own_view = own_view && seen;
  }
  if (out.most_agents < out.least_agents) return out;
  if (own_view) out.occupancies.push_back(0);
  if (low == high) out.occupancies.push_back(low);
  if (low < high)
    for (size_t i = 0; i < kOccupancySteps; ++i)
      out.occupancies.push_back(low + (high - low) * static_cast<double>(i) / (kOccupancySteps - 1));
  return out;
}

std::vector<double> even_in_log(double low, double high, size_t steps) {
  if (!(high > low)) return {low};
  std::vector<double> out;
  for (size_t i = 0; i < steps; ++i)
    out.push_back(low * std::pow(high / low, static_cast<double>(i) / static_cast<double>(steps - 1)));
  return out;
}

// Rounded, each once.
std::vector<double> whole(std::vector<double> values) {
  for (double& value : values) value = std::round(value);
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

// The covered pixels of an occupancy; where the camera is the scenario's own (0) what was covered there, straight in
// logarithms between the neighbouring crowds.
double covered_px(const Scene& scene, const CostModel& model, double agents, double occupancy) {
  if (occupancy > 0) return occupancy * scene.width * scene.height;
  std::map<double, double> covered;  // by agents
  for (const CostPrediction& one : model.held_out)
    if (const auto& count = one.point.counts[static_cast<size_t>(CostTerm::covered)];
        count && one.point.occupancy == occupancy && one.point.agents > 0)
      covered[one.point.agents] = std::max(*count, 1.0);
  if (covered.empty()) return 0;
  const auto above = covered.lower_bound(agents);
  if (above == covered.end()) return covered.rbegin()->second;
  if (above == covered.begin() || above->first == agents) return above->second;
  const auto below = std::prev(above);
  const double along = std::log(agents / below->first) / std::log(above->first / below->first);
  return below->second * std::pow(above->second / below->second, along);
}

double time_at(const Scene& scene, const CostModel& model, double agents, double occupancy) {
  CostPoint point;
  const double covered = covered_px(scene, model, agents, occupancy);
  const double picture = static_cast<double>(scene.width) * scene.height;
  point.counts = {1.0, agents, covered, fine_pixels(picture, agents, covered), {}, {}, {}, {}};
  return predicted_ns(model.fit, point);
}

// Half the width of the interval of a predicted ratio's logarithm, and its bias.
struct Spread {
  double bias = 0, half = INFINITY;
};
Spread spread_of(const CostModel& first, const CostModel& second) {
  std::vector<double> errors;
  for (const CostPrediction& a : first.held_out)
    for (const CostPrediction& b : second.held_out)
      if (a.point.agents == b.point.agents && a.point.occupancy == b.point.occupancy)
        errors.push_back(std::log(a.point.time_ns / b.point.time_ns) - std::log(a.predicted_ns / b.predicted_ns));
  if (errors.size() < 3) return {};
  const auto n = static_cast<double>(errors.size());
  double sum = 0;
  for (const double e : errors) sum += e;
  double squares = 0;
  for (const double e : errors) squares += (e - sum / n) * (e - sum / n);
  return {sum / n, student_t_quantile(0.975, n - 1) * std::sqrt(squares / (n - 1) * (1 + 1 / n))};
}

// Where the logarithm of the ratio, straight between the steps, is first at `level`; nothing where it is not.
std::optional<double> first_at(const std::vector<double>& agents, const std::vector<double>& logs, double level) {
  for (size_t i = 1; i < logs.size(); ++i) {
    const double a = logs[i - 1] - level;
    const double b = logs[i] - level;
    if ((a < 0) == (b < 0)) continue;
    return std::exp(std::log(agents[i - 1]) + a / (a - b) * std::log(agents[i] / agents[i - 1]));
  }
  return std::nullopt;
}

BreakEvenPoint contour_point(const Scene& scene, const CostModel& first, const CostModel& second, const Spread& spread,
                             const Measured& range, double occupancy) {
  BreakEvenPoint out;
  out.occupancy = occupancy;
  const std::vector<double> agents = even_in_log(range.least_agents, range.most_agents, kAgentSteps);
  std::vector<double> logs;  // above 0: the second is cheaper
  for (const double n : agents)
    logs.push_back(std::log(time_at(scene, first, n, occupancy) / time_at(scene, second, n, occupancy)) + spread.bias);
  const auto cheaper = [&](double log) -> std::string {
    return log > spread.half ? second.representation : log < -spread.half ? first.representation : std::string();
  };
  out.cheaper_below = cheaper(logs.front());
  out.cheaper_beyond = cheaper(logs.back());
  out.agents = first_at(agents, logs, 0);
  if (!out.agents) return out;
  const double side = logs.back() > logs.front() ? 1 : -1;
  const auto low = first_at(agents, logs, -side * spread.half);
  const auto high = first_at(agents, logs, side * spread.half);
  out.low_open = !low || *low > *out.agents;
  out.high_open = !high || *high < *out.agents;
  out.low = out.low_open ? agents.front() : *low;
  out.high = out.high_open ? agents.back() : *high;
  return out;
}

}  // namespace

BreakEvenMap break_even_map(const Scene& scene) {
  BreakEvenMap map;
  for (const std::string& name : scene.representations) map.models.push_back(cost_model(scene, name, kTermsBeforehand));
  std::vector<const CostModel*> known;
  for (const CostModel& model : map.models)
    if (model.absent.empty()) known.push_back(&model);
  std::vector<std::vector<Spread>> spreads(known.size(), std::vector<Spread>(known.size()));
  for (size_t i = 0; i < known.size(); ++i)
    for (size_t j = 0; j < known.size(); ++j)
      if (i != j) spreads[i][j] = spread_of(*known[i], *known[j]);
  for (size_t i = 0; i < known.size(); ++i)
    for (size_t j = i + 1; j < known.size(); ++j) {
      if (!std::isfinite(spreads[i][j].half)) continue;
      const Measured range = measured_range({known[i], known[j]});
      if (range.occupancies.empty()) continue;
      BreakEven pair;
      pair.first = known[i]->representation;
      pair.second = known[j]->representation;
      pair.ratio_bias = std::exp(spreads[i][j].bias);
      pair.ratio_factor = std::exp(spreads[i][j].half);
      pair.from = static_cast<uint32_t>(range.least_agents);
      pair.to = static_cast<uint32_t>(range.most_agents);
      for (const double occupancy : range.occupancies)
        pair.contour.push_back(contour_point(scene, *known[i], *known[j], spreads[i][j], range, occupancy));
      map.pairs.push_back(std::move(pair));
    }
  if (known.size() < 2) return map;
  const Measured range = measured_range(known);
  for (const double occupancy : range.occupancies)
    for (const double agents : whole(even_in_log(range.least_agents, range.most_agents, kCellSteps))) {
      const auto time = [&](size_t k) { return time_at(scene, *known[k], agents, occupancy); };
      size_t best = 0;
      for (size_t k = 1; k < known.size(); ++k)
        if (std::log(time(k) / time(best)) + spreads[k][best].bias < 0) best = k;
      CheapestCell cell{agents, occupancy, known[best]->representation, {}};
      for (size_t k = 0; k < known.size(); ++k) {
        if (k == best) continue;
        const Spread& spread = spreads[k][best];
        if (!(std::log(time(k) / time(best)) + spread.bias > spread.half))
          cell.not_told_apart.push_back(known[k]->representation);
      }
      map.cells.push_back(std::move(cell));
    }
  return map;
}

std::string break_even_text(const BreakEven& pair, const BreakEvenPoint& point) {
  const std::string at = point.occupancy > 0 ? " at " + percent_text(point.occupancy) + " occupancy"
                                             : std::string(" in the scenario's own view");
  const auto count = [](double agents) { return count_text(static_cast<uint64_t>(std::llround(agents))); };
  const std::string from = count_text(pair.from);
  const std::string to = agents_text(pair.to);
  if (!point.agents) {
    const std::string& cheaper = point.cheaper_below.empty() ? point.cheaper_beyond : point.cheaper_below;
    if (cheaper.empty() || (!point.cheaper_beyond.empty() && point.cheaper_beyond != cheaper))
      return fmt::format("{} and {} cannot be told apart from {} to {}{}", pair.first, pair.second, from, to, at);
    const bool everywhere = point.cheaper_below == point.cheaper_beyond;
    return fmt::format("{} is cheaper than {} {}from {} to {}{}", cheaper,
                       cheaper == pair.first ? pair.second : pair.first,
                       everywhere ? "" : "wherever they can be told apart ", from, to, at);
  }
  if (point.low_open && point.high_open)
    return fmt::format("{} and {} cannot be told apart from {} to {}{}", pair.first, pair.second, from, to, at);
  const std::string beyond = !point.cheaper_beyond.empty()       ? point.cheaper_beyond
                             : point.cheaper_below == pair.first ? pair.second
                                                                 : pair.first;
  return fmt::format("{} is the cheaper one from about {} agents on ({} to {}){}", beyond, count(*point.agents),
                     point.low_open ? "fewer than " + count(*point.low) : count(*point.low),
                     point.high_open ? "more than " + count(*point.high) : count(*point.high), at);
}

}  // namespace crowdbench::reports
