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

// The crowds with which every one of some models was measured at an occupancy (0: the scenario's own view): from the
// least to the most of what lies between their common points, whose convex hull it is over the logarithm of the agents
// and the occupancy.
struct Measured {
  double occupancy = 0, least_agents = 0, most_agents = 0;
};

using Place = std::pair<double, double>;  // occupancy and agents

std::vector<Place> common_places(const std::vector<const CostModel*>& models) {
  std::map<Place, size_t> count;
  for (const CostModel* model : models)
    for (const CostPrediction& one : model->held_out)
      if (one.point.agents > 0) ++count[{one.point.occupancy, one.point.agents}];
  std::vector<Place> out;
  for (const auto& [place, times] : count)
    if (times >= models.size()) out.push_back(place);
  return out;
}

// Of the places' hull at an occupancy; those of the scenario's own view are no neighbours of the others. Ends of a
// hull's section lie on lines between two of its points.
Measured section_of(const std::vector<Place>& places, double occupancy) {
  double least = INFINITY, most = 0;
  const auto take = [&](double agents) {
    least = std::min(least, agents);
    most = std::max(most, agents);
  };
  for (const auto& [o, n] : places) {
    if (o == occupancy) take(n);
    if (occupancy == 0 || o == 0 || !(o < occupancy)) continue;
    for (const auto& [p, m] : places)
      if (p > occupancy) take(n * std::pow(m / n, (occupancy - o) / (p - o)));
  }
  return {occupancy, least, most};
}

std::vector<Measured> measured_ranges(const std::vector<const CostModel*>& models) {
  const std::vector<Place> places = common_places(models);  // by ascending occupancy
  if (places.empty()) return {};
  std::vector<Measured> out;
  if (places.front().first == 0) out.push_back(section_of(places, 0));
  const auto low = std::find_if(places.begin(), places.end(), [](const Place& place) { return place.first > 0; });
  if (low == places.end()) return out;
  const double from = low->first;
  const double to = places.back().first;
  if (from == to) out.push_back(section_of(places, from));
  if (from < to)
    for (size_t i = 0; i < kOccupancySteps; ++i)
      out.push_back(section_of(
          places, i + 1 == kOccupancySteps ? to : from + (to - from) * static_cast<double>(i) / (kOccupancySteps - 1)));
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
                             const Measured& range) {
  BreakEvenPoint out;
  const double occupancy = range.occupancy;
  out.occupancy = occupancy;
  out.from = static_cast<uint32_t>(std::lround(range.least_agents));
  out.to = static_cast<uint32_t>(std::lround(range.most_agents));
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

using Spreads = std::vector<std::vector<Spread>>;  // of two models, by their places

CheapestCell cheapest_cell(const Scene& scene, const std::vector<const CostModel*>& known, const Spreads& spreads,
                           double agents, double occupancy) {
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
  return cell;
}

std::vector<CheapestCell> cheapest_cells(const Scene& scene, const std::vector<const CostModel*>& known,
                                         const Spreads& spreads) {
  const std::vector<Measured> ranges = measured_ranges(known);
  double least = INFINITY, most = 0;
  for (const Measured& range : ranges) {
    least = std::min(least, range.least_agents);
    most = std::max(most, range.most_agents);
  }
  std::vector<CheapestCell> out;
  constexpr double kRounded = 0.5;  // of an agent, as the steps are
  for (const Measured& range : ranges)
    for (const double agents : whole(even_in_log(least, most, kCellSteps)))
      if (agents >= range.least_agents - kRounded && agents <= range.most_agents + kRounded)
        out.push_back(cheapest_cell(scene, known, spreads, agents, range.occupancy));
  return out;
}

}  // namespace

BreakEvenMap break_even_map(const Scene& scene) {
  BreakEvenMap map;
  for (const std::string& name : scene.representations) map.models.push_back(cost_model(scene, name, kTermsBeforehand));
  std::vector<const CostModel*> known;
  for (const CostModel& model : map.models)
    if (model.absent.empty()) known.push_back(&model);
  Spreads spreads(known.size(), std::vector<Spread>(known.size()));
  for (size_t i = 0; i < known.size(); ++i)
    for (size_t j = 0; j < known.size(); ++j)
      if (i != j) spreads[i][j] = spread_of(*known[i], *known[j]);
  for (size_t i = 0; i < known.size(); ++i)
    for (size_t j = i + 1; j < known.size(); ++j) {
      if (!std::isfinite(spreads[i][j].half)) continue;
      BreakEven pair;
      pair.first = known[i]->representation;
      pair.second = known[j]->representation;
      pair.ratio_bias = std::exp(spreads[i][j].bias);
      pair.ratio_factor = std::exp(spreads[i][j].half);
      for (const Measured& range : measured_ranges({known[i], known[j]}))
        pair.contour.push_back(contour_point(scene, *known[i], *known[j], spreads[i][j], range));
      if (!pair.contour.empty()) map.pairs.push_back(std::move(pair));
    }
  if (known.size() >= 2) map.cells = cheapest_cells(scene, known, spreads);
  return map;
}

std::string break_even_text(const BreakEven& pair, const BreakEvenPoint& point) {
  const std::string at = point.occupancy > 0 ? " at " + percent_text(point.occupancy) + " occupancy"
                                             : std::string(" in the scenario's own view");
  const auto count = [](double agents) { return count_text(static_cast<uint64_t>(std::llround(agents))); };
  const std::string within = point.from == point.to ? "with " + agents_text(point.to)
                                                    : "from " + count_text(point.from) + " to " + agents_text(point.to);
  const std::string untold = fmt::format("{} and {} cannot be told apart {}{}", pair.first, pair.second, within, at);
  if (!point.agents) {
    const std::string& cheaper = point.cheaper_below.empty() ? point.cheaper_beyond : point.cheaper_below;
    if (cheaper.empty() || (!point.cheaper_beyond.empty() && point.cheaper_beyond != cheaper)) return untold;
    const bool everywhere = point.cheaper_below == point.cheaper_beyond;
    return fmt::format("{} is cheaper than {} {}{}{}: no break-even there, and nothing is known beyond", cheaper,
                       cheaper == pair.first ? pair.second : pair.first,
                       everywhere ? "" : "wherever they can be told apart ", within, at);
  }
  if (point.low_open && point.high_open) return untold;
  const std::string beyond = !point.cheaper_beyond.empty()       ? point.cheaper_beyond
                             : point.cheaper_below == pair.first ? pair.second
                                                                 : pair.first;
  return fmt::format("{} is the cheaper one from about {} agents on ({} to {}){}", beyond, count(*point.agents),
                     count(*point.low) + (point.low_open ? ", the fewest timed," : ""),
                     count(*point.high) + (point.high_open ? ", the most timed" : ""), at);
}

}  // namespace crowdbench::reports
