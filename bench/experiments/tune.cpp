#include "bench/experiments/tune.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "bench/experiments/pop_map.h"
#include "bench/experiments/score_rows.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/random.h"
#include "scene/pose/pose.h"

namespace crowdbench::bench {
namespace {

enum Purpose : uint64_t { kDrawBlock = 1, kDrawRound };
constexpr double kBeyond = 1e30;  // for infinite values: quantiles need numbers

// Turned so that more is worse.
double badness(const metrics::Score& score, double value) {
  const double turned = score.direction == metrics::Direction::higher_is_better ? -value : value;
  return std::clamp(turned, -kBeyond, kBeyond);
}
double value_of(const metrics::Score& score, double badness) {
  return score.direction == metrics::Direction::higher_is_better ? -badness : badness;
}

double tail_of(std::span<const double> badnesses) { return quantile(badnesses, 0.95); }

std::vector<double> badnesses_of(const metrics::Score& score, const std::vector<double>& values) {
  std::vector<double> out;
  for (const double value : values) out.push_back(badness(score, value));
  return out;
}

// Blocks by resample: the same ones for every candidate and height, which were seen from the same directions.
std::vector<size_t> drawn_blocks(uint64_t seed, size_t resample, size_t blocks) {
  std::vector<size_t> out;
  for (size_t i = 0; i < blocks; ++i) out.push_back(random_below(seed, resample * blocks + i, kDrawBlock, blocks));
  return out;
}

class Tuning {
 public:
  Tuning(gl::Context& context, const TuneRequest& request) : context_(context), request_(request) {
    const TuneRequest& r = request;
    for (const double elevation : r.elevations_deg)
      for (const double azimuth : r.azimuths_deg)
        for (size_t m = 0; m < r.moments; ++m) blocks_.push_back({0, azimuth, elevation, r.clip, time_of(m)});
  }

  TuneResult run() {
    measure_errors();
    measure_costs();
    fill_table();
    const auto change_allowed = [&](size_t from, size_t to, size_t bin) { return pop(from, to, bin).allowed; };
    result_.plan = cheapest_plan(result_.table, change_allowed);
    resample(change_allowed);
    if (result_.plan) describe_switches();
    return std::move(result_);
  }

 private:
  double time_of(size_t moment) const {
    if (request_.clip < 0) return 0;
    const scene::Clip& clip = request_.character->clips[static_cast<size_t>(request_.clip)];
    return clip.start + clip.duration() * static_cast<double>(moment) / static_cast<double>(request_.moments);
  }

  QualitySetup setup_of(const std::vector<size_t>& candidates, const std::vector<double>& heights,
                        metrics::ScoreTable table) const {
    QualitySetup setup;
    setup.character = request_.character;
    for (const size_t c : candidates) setup.representations.push_back(request_.candidates[c].text());
    for (const double height : heights)
      for (QualityView view : blocks_) {
        view.height_px = height;
        setup.views.push_back(view);
      }
    setup.antialiasing = request_.cost.antialiasing;
    setup.bake_budget = request_.cost.bake_budget;
    setup.use_cache = request_.cost.use_cache;
    setup.display = request_.display;
    setup.table = table;
    return setup;
  }

  void measure_errors() {
    std::vector<size_t> all(request_.candidates.size());
    for (size_t c = 0; c < all.size(); ++c) all[c] = c;
    const metrics::Score* score = request_.error.score;
    const QualitySetup setup = setup_of(all, request_.heights_px, {&score, 1});
    result_.refused.resize(all.size());
    result_.errors.assign(all.size(), std::vector<TuneError>(request_.heights_px.size()));
    Progress progress("scoring pictures", all.size() * setup.views.size());
    const std::vector<QualityRow> rows =
        compute_quality(context_, setup, [&](const QualityRow&, const QualityPictures&) { progress.advance(); });
    progress.end();
    for (size_t i = 0; i < rows.size(); ++i) {
      const size_t bin = i % setup.views.size() / blocks_.size();
      if (!rows[i].refused.empty()) result_.refused[rows[i].index] = rows[i].refused;
      if (const auto value = rows[i].scores.value(score->name))
        result_.errors[rows[i].index][bin].values.push_back(*value);
    }
    for (auto& row : result_.errors)
      for (TuneError& error : row) judge(error);
  }

  // Only where every block has a value: a missing one is a picture that shows nothing.
  void judge(TuneError& error) const {
    if (error.values.size() != blocks_.size()) {
      error.values.clear();
      return;
    }
    const metrics::Score& score = *request_.error.score;
    const std::vector<double> bad = badnesses_of(score, error.values);
    double sum = 0;
    for (const double b : bad) sum += b;
    error.mean = value_of(score, sum / static_cast<double>(bad.size()));
    error.tail = value_of(score, tail_of(bad));
    std::vector<double> tails;
    for (size_t i = 0; i < kTuneResamples; ++i) tails.push_back(resampled_tail(bad, i));
    const double low = quantile(tails, 0.025);
    const double high = quantile(tails, 0.975);
    error.allowed = high <= badness(score, request_.error.value);
    error.interval = {std::min(value_of(score, low), value_of(score, high)),
                      std::max(value_of(score, low), value_of(score, high))};
  }
  double resampled_tail(const std::vector<double>& bad, size_t resample) const {
    std::vector<double> drawn;
    for (const size_t block : drawn_blocks(request_.seed, resample, bad.size())) drawn.push_back(bad[block]);
    return tail_of(drawn);
  }

  void measure_costs() {
    const std::vector<double>& all = request_.heights_px;
    const size_t count = std::min(request_.cost_heights, all.size());
    for (size_t i = 0; i < count; ++i)
      result_.cost_heights_px.push_back(all[count == 1 ? 0 : i * (all.size() - 1) / (count - 1)]);
    SwitchCostRequest cost = request_.cost;
    for (size_t c = 0; c < request_.candidates.size(); ++c)
      if (result_.refused[c].empty()) {
        cost.representations.push_back(request_.candidates[c]);
        timed_.push_back(c);
      }
    cost.heights_px = result_.cost_heights_px;
    scene::Cast cast;
    cast.characters = {request_.character};
    cast.banks = {std::make_shared<const scene::PoseBank>(*request_.character, std::vector<int>{request_.clip}, 30)};
    cast.shares = {1.0};
    SwitchCosts measured = measure_switch_costs(context_, cast, cost);
    result_.costs.clock = measured.clock;
    result_.costs.agents = measured.agents;
    result_.costs.costs.resize(request_.candidates.size());
    result_.costs.frame_ns.resize(request_.candidates.size());
    for (size_t i = 0; i < timed_.size(); ++i) {
      result_.costs.costs[timed_[i]] = std::move(measured.costs[i]);
      result_.costs.frame_ns[timed_[i]] = std::move(measured.frame_ns[i]);
    }
  }

  void fill_table() {
    SwitchTable& table = result_.table;
    table.agents = request_.agents;
    const size_t bins = request_.heights_px.size();
    for (size_t c = 0; c < request_.candidates.size(); ++c) {
      const bool measured = result_.refused[c].empty();
      table.cost.push_back(measured ? costs_at(result_.cost_heights_px, result_.costs.costs[c], request_.heights_px)
                                    : std::vector<double>(bins, kBeyond));
      table.allowed.emplace_back();
      for (const TuneError& error : result_.errors[c])
        table.allowed.back().push_back(measured && !error.values.empty() && error.allowed);
    }
  }

  // What changing from one candidate to the other shows at a height, measured once.
  const TunePop& pop(size_t from, size_t to, size_t bin) {
    const auto [entry, fresh] = pops_.try_emplace({from, to, bin});
    if (fresh) entry->second = measured_pop(from, to, request_.heights_px[bin]);
    return entry->second;
  }
  TunePop measured_pop(size_t from, size_t to, double height) const {
    const metrics::Score* score = request_.pop.score;
    std::vector<renderers::Capture> before;
    std::vector<double> bad;
    const QualitySetup setup = setup_of({from, to}, {height}, {&score, 1});
    compute_quality(context_, setup, [&](const QualityRow& row, const QualityPictures& pictures) {
      if (row.index == 0)
        before.push_back(pictures.test);
      else
        bad.push_back(worst_step(before[bad.size()], pictures.test));
    });
    TunePop out;
    const double tail = tail_of(bad);
    out.tail = value_of(*score, tail);
    out.allowed = tail <= badness(*score, request_.pop.value);
    return out;
  }
  // Of a cut, or of the cross-fade.
  double worst_step(const renderers::Capture& a, const renderers::Capture& b) const {
    const metrics::Score* score = request_.pop.score;
    std::vector<Image8> pictures{a.colour, b.colour};
    if (request_.fade > 0) pictures = fade_pictures(a.colour, b.colour, request_.fade);
    double worst = badness(*score, metrics::best_value(*score));
    for (size_t i = 1; i < pictures.size(); ++i) {
      metrics::Buffers first = buffers_of(a);
      metrics::Buffers second = buffers_of(b);
      first.codes = &pictures[i - 1];
      second.codes = &pictures[i];
      const auto value = metrics::score_figure({&score, 1}, first, second, {&request_.display}).value(score->name);
      if (value) worst = std::max(worst, badness(*score, *value));
    }
    return worst;
  }

  // Errors by blocks drawn anew, costs by rounds drawn anew; changes as they were measured.
  void resample(const ChangeAllowed& change_allowed) {
    const metrics::Score& score = *request_.error.score;
    std::vector<double> savings;
    for (size_t i = 0; i < kTuneResamples; ++i) {
      SwitchTable table = result_.table;
      for (const size_t c : timed_) {
        for (size_t b = 0; b < table.bins(); ++b) {
          const TuneError& error = result_.errors[c][b];
          table.allowed[c][b] = !error.values.empty() && resampled_tail(badnesses_of(score, error.values), i) <=
                                                             badness(score, request_.error.value);
        }
        table.cost[c] =
            costs_at(result_.cost_heights_px, resampled_costs(result_.costs.costs[c], i), request_.heights_px);
      }
      result_.again.push_back(cheapest_plan(table, change_allowed));
      if (result_.plan) savings.push_back(cost_of_reference(table) / cost_of(table, result_.plan->candidate));
    }
    result_.reference_cost = cost_of_reference(result_.table);
    if (!savings.empty()) result_.saving = {quantile(savings, 0.025), quantile(savings, 0.975)};
  }
  std::vector<AgentCost> resampled_costs(std::vector<AgentCost> costs, size_t resample) const {
    for (AgentCost& cost : costs) {
      if (!cost.resolved) continue;
      std::vector<double> drawn;
      const size_t n = cost.differences.size();
      for (size_t k = 0; k < n; ++k)
        drawn.push_back(cost.differences[random_below(request_.seed, resample * n + k, kDrawRound, n)]);
      const double again = median(drawn);
      if (again > 0) cost.ns = again;
    }
    return costs;
  }
  static double cost_of(const SwitchTable& table, const std::vector<size_t>& path) {
    double sum = 0;
    for (size_t b = 0; b < path.size(); ++b) sum += std::max(table.agents[b], 1e-9) * table.cost[path[b]][b];
    return sum;
  }
  double cost_of_reference(const SwitchTable& table) const {
    const std::string name = renderers::reference_spec().text();
    for (size_t c = 0; c < request_.candidates.size(); ++c)
      if (request_.candidates[c].text() == name) return cost_of(table, std::vector<size_t>(table.bins(), c));
    assert(false);
    return 0;
  }

  void describe_switches() {
    for (const PlannedSwitch& change : switches_of(*result_.plan)) {
      TuneSwitch one;
      one.change = change;
      one.height_px = request_.heights_px[change.bin];
      one.certainty = certainty_of(change, result_.again, request_.heights_px);
      one.pop = pop(change.from, change.to, change.bin);
      if (one.certainty.decided())
        one.hysteresis = std::sqrt(one.certainty.height_px->high / one.certainty.height_px->low) - 1;
      result_.switches.push_back(one);
    }
  }

  gl::Context& context_;
  const TuneRequest& request_;
  std::vector<QualityView> blocks_;  // at no height yet
  std::vector<size_t> timed_;        // candidates that were not refused
  std::map<std::tuple<size_t, size_t, size_t>, TunePop> pops_;
  TuneResult result_;
};

// The representation made of two, switched by height.
const renderers::RepresentationType& switching_type() {
  for (const renderers::RepresentationType& type : renderers::representation_types())
    for (const renderers::OptionDoc& option : type.options)
      if (type.components == 2 && option.key == "height") return type;
  throw Error("tune", "no representation switches by height", "");
}

}  // namespace

TuneResult tune(gl::Context& context, const TuneRequest& request) { return Tuning(context, request).run(); }

renderers::Spec tuned_representation(const TuneRequest& request, const TuneResult& result) {
  assert(result.plan);
  renderers::Spec spec = request.candidates[result.plan->candidate.back()];
  for (size_t i = result.switches.size(); i-- > 0;) {
    const TuneSwitch& change = result.switches[i];
    renderers::Spec outer;
    outer.name = switching_type().name;
    outer.components = {request.candidates[change.change.from], spec};
    outer.options = {{"height", fmt::format("{:.4g}", change.height_px)}};
    if (change.hysteresis > 0) outer.options.emplace_back("hysteresis", fmt::format("{:.3g}", change.hysteresis));
    if (request.fade > 0) outer.options.emplace_back("fade", std::to_string(request.fade));
    spec = outer;
  }
  return spec;
}

double depth_of_height(double height, double height_px, int rows, double fov_y) {
  return height * rows / (height_px * 2 * std::tan(fov_y / 2));
}

}  // namespace crowdbench::bench
