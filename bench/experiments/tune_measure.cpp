#include "bench/experiments/tune_measure.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "bench/experiments/pop_map.h"
#include "bench/experiments/score_rows.h"
#include "core/probability.h"
#include "core/progress.h"
#include "core/random.h"
#include "scene/pose/pose.h"

namespace crowdbench::bench {
namespace {

enum Purpose : uint64_t { kDrawBlock = 1, kDrawRound, kFirstDirection, kFirstElevation };
constexpr double kBeyond = 1e30;  // for infinite values: quantiles need numbers
constexpr double kFinite = 1e20;  // no finite value is beyond; means and quantiles with an infinite one are
// Within its share of the clip a moment lies here, so that stored frames, which begin at 0, seldom lie there too.
constexpr double kWithinMoment = 0.381966;
constexpr size_t kPopViews = 24;  // a switch is judged in no more of the blocks

std::vector<double> badnesses_of(const metrics::Score& score, const std::vector<double>& values) {
  std::vector<double> out;
  for (const double value : values) out.push_back(badness_of(score, value));
  return out;
}

// Blocks by resample: the same ones for every candidate and height, which were seen from the same directions.
std::vector<double> drawn_anew(uint64_t seed, size_t resample, const std::vector<double>& values) {
  std::vector<double> out;
  for (size_t i = 0; i < values.size(); ++i)
    out.push_back(values[random_below(seed, resample * values.size() + i, kDrawBlock, values.size())]);
  return out;
}

double fraction(double x) { return x - std::floor(x); }

}  // namespace

double badness_of(const metrics::Score& score, double value) {
  const double turned = score.direction == metrics::Direction::higher_is_better ? -value : value;
  return std::clamp(turned, -kBeyond, kBeyond);
}
double value_of_badness(const metrics::Score& score, double badness) {
  if (std::abs(badness) > kFinite) badness = std::copysign(std::numeric_limits<double>::infinity(), badness);
  return score.direction == metrics::Direction::higher_is_better ? -badness : badness;
}
double badness_tail(std::span<const double> badnesses) { return quantile(badnesses, 0.95); }

Interval tail_interval(std::vector<double> badnesses) {
  assert(!badnesses.empty());
  std::sort(badnesses.begin(), badnesses.end());
  const uint64_t n = badnesses.size();
  // The k-th smallest is above the percentile with the chance that fewer than k values are below it.
  size_t high = n;
  while (high > 1 && binomial_at_most(high - 2, n, 0.95) >= 0.975) --high;
  size_t low = high;
  while (low > 1 && binomial_at_most(low - 1, n, 0.95) > 0.025) --low;
  return {badnesses[low - 1], badnesses[high - 1]};
}

Moments::Moments(const TuneSubject& subject) {
  if (subject.clip < 0) return;
  const scene::Clip& clip = subject.character->clips[static_cast<size_t>(subject.clip)];
  const double cycle = scene::cycle_seconds(*subject.character, subject.clip);
  start_ = clip.start;
  if (cycle <= 0) return;
  const scene::PoseBank bank(*subject.character, {subject.clip}, 30);
  step_ = cycle / bank.clips()[0].samples;
  // What closes a loop is after the file's last key.
  count_ = 1 + static_cast<size_t>(clip.duration() / step_ * (1 - 1e-9));
}
double Moments::time(double place) const {
  const double sample = std::min(std::floor(place * static_cast<double>(count_)), static_cast<double>(count_) - 1);
  // A hair beyond the sample, so that rounding does not make it the end of the interval before it.
  return start_ + step_ * (sample + (sample > 0 ? 1e-9 : 0));
}

std::vector<QualityView> tune_views(const TuneBlocks& blocks, const TuneSubject& subject, uint64_t seed) {
  std::vector<QualityView> out;
  const Moments moments(subject);
  // More than the clip has samples would be the same pictures again.
  const size_t times = std::min(blocks.moments, moments.count());
  const auto add = [&](double azimuth, double elevation, size_t moment) {
    const double place = (static_cast<double>(moment) + kWithinMoment) / static_cast<double>(times);
    out.push_back({0, azimuth, elevation, subject.clip, moments.time(place)});
  };
  for (const double elevation : blocks.elevations_deg)
    for (const double azimuth : blocks.azimuths_deg)
      for (size_t m = 0; m < times; ++m) add(azimuth, elevation, m);
  if (!out.empty()) return out;
  // Additive recurrences by the powers of the plastic number's inverse: even in both, at no stored view's places.
  // Based on: M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018 (R2).
  constexpr double kPlastic = 1.32471795724474602596;
  const double first = random_unit(seed, 0, kFirstDirection);
  const double second = random_unit(seed, 0, kFirstElevation);
  for (size_t i = 0; i < blocks.views; ++i) {
    const auto n = static_cast<double>(i);
    const double across = fraction(second + n / (kPlastic * kPlastic));
    add(360 * fraction(first + n / kPlastic), blocks.lowest_deg + across * (blocks.highest_deg - blocks.lowest_deg),
        i % times);
  }
  return out;
}

TuneMeasurement::TuneMeasurement(gl::Context& context, const TuneRequest& request, size_t subject)
    : context_(context),
      request_(request),
      index_(subject),
      subject_(request.subjects[subject]),
      blocks_(tune_views(request.blocks, request.subjects[subject], request.seed)) {
  measured_.views = blocks_.size();
  measure_errors();
  measure_costs();
  measured_.table = table_of(measured_.costs.costs);
}

QualitySetup TuneMeasurement::setup_of(const std::vector<size_t>& candidates, const std::vector<double>& heights,
                                       metrics::ScoreTable table) const {
  QualitySetup setup;
  setup.character = subject_.character;
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

void TuneMeasurement::measure_errors() {
  std::vector<size_t> all(request_.candidates.size());
  for (size_t c = 0; c < all.size(); ++c) all[c] = c;
  const metrics::Score* score = request_.error.score;
  const QualitySetup setup = setup_of(all, request_.heights_px, {&score, 1});
  measured_.refused.resize(all.size());
  measured_.errors.assign(all.size(), std::vector<TuneError>(request_.heights_px.size()));
  Progress progress("scoring pictures", all.size() * setup.views.size());
  const std::vector<QualityRow> rows =
      compute_quality(context_, setup, [&](const QualityRow&, const QualityPictures&) { progress.advance(); });
  progress.end();
  for (size_t i = 0; i < rows.size(); ++i) {
    const size_t bin = i % setup.views.size() / blocks_.size();
    if (!rows[i].refused.empty()) measured_.refused[rows[i].index] = rows[i].refused;
    if (const auto value = rows[i].scores.value(score->name))
      measured_.errors[rows[i].index][bin].values.push_back(*value);
  }
  for (auto& row : measured_.errors)
    for (TuneError& error : row) judge(error);
}

// Only where every block has a value: a missing one is a picture that shows nothing.
void TuneMeasurement::judge(TuneError& error) const {
  if (error.values.size() != blocks_.size()) {
    error.values.clear();
    return;
  }
  const metrics::Score& score = *request_.error.score;
  const std::vector<double> bad = badnesses_of(score, error.values);
  double sum = 0;
  for (const double b : bad) sum += b;
  error.mean = value_of_badness(score, sum / static_cast<double>(bad.size()));
  error.tail = value_of_badness(score, badness_tail(bad));
  const Interval tail = tail_interval(bad);
  error.promised = value_of_badness(score, tail.high);
  error.allowed = tail.high <= badness_of(score, request_.error.value);
  const double other = value_of_badness(score, tail.low);
  error.interval = {std::min(other, error.promised), std::max(other, error.promised)};
}

void TuneMeasurement::measure_costs() {
  const std::vector<double>& all = request_.heights_px;
  const size_t count = std::min(request_.cost_heights, all.size());
  for (size_t i = 0; i < count; ++i)
    measured_.cost_heights_px.push_back(all[count == 1 ? 0 : i * (all.size() - 1) / (count - 1)]);
  SwitchCostRequest cost = request_.cost;
  for (size_t c = 0; c < request_.candidates.size(); ++c)
    if (measured_.refused[c].empty()) {
      cost.representations.push_back(request_.candidates[c]);
      timed_.push_back(c);
    }
  cost.heights_px = measured_.cost_heights_px;
  scene::Cast cast;
  cast.characters = {subject_.character};
  cast.banks = {std::make_shared<const scene::PoseBank>(*subject_.character, std::vector<int>{subject_.clip}, 30)};
  cast.shares = {1.0};
  SwitchCosts found = measure_switch_costs(context_, cast, cost);
  measured_.costs.clock = found.clock;
  measured_.costs.agents = found.agents;
  measured_.costs.costs.resize(request_.candidates.size());
  measured_.costs.frame_ns.resize(request_.candidates.size());
  std::vector<double> bases;
  for (size_t i = 0; i < timed_.size(); ++i) {
    for (size_t h = 0; h < found.agents.size(); ++h)
      if (found.costs[i][h].resolved)
        bases.push_back(found.frame_ns[i][h] - static_cast<double>(found.agents[h]) * found.costs[i][h].ns);
    measured_.costs.costs[timed_[i]] = std::move(found.costs[i]);
    measured_.costs.frame_ns[timed_[i]] = std::move(found.frame_ns[i]);
  }
  measured_.base_ns = bases.empty() ? 0 : std::max(0.0, median(bases));
}

// A bin costs what its agents do at their own heights; one without agents what one would at the bin's.
SwitchTable TuneMeasurement::table_of(const std::vector<std::vector<AgentCost>>& costs) const {
  const size_t bins = request_.heights_px.size();
  const metrics::Score& score = *request_.error.score;
  std::vector<double> heights = subject_.agents_px;
  std::sort(heights.rbegin(), heights.rend());
  SwitchTable table;
  table.agents.assign(bins, 0);
  for (const double height : heights) table.agents[bin_of_height(request_.heights_px, height)] += 1;
  for (size_t c = 0; c < request_.candidates.size(); ++c) {
    const std::vector<TuneError>& errors = measured_.errors[c];
    table.cost.emplace_back(bins, kBeyond);
    table.error.emplace_back(bins, kBeyond);
    table.allowed.emplace_back(bins, 0);
    if (!measured_.refused[c].empty()) continue;
    table.cost[c] = costs_at(measured_.cost_heights_px, costs[c], request_.heights_px);
    std::vector<double> sums(bins, 0);
    const std::vector<double> each = costs_at(measured_.cost_heights_px, costs[c], heights);
    for (size_t i = 0; i < heights.size(); ++i) sums[bin_of_height(request_.heights_px, heights[i])] += each[i];
    for (size_t b = 0; b < bins; ++b) {
      if (table.agents[b] > 0) table.cost[c][b] = sums[b] / table.agents[b];
      table.allowed[c][b] = !errors[b].values.empty() && errors[b].allowed;
      if (!errors[b].values.empty()) table.error[c][b] = std::min(kBeyond, loss_of(score, errors[b].mean));
    }
  }
  return table;
}

SwitchTable TuneMeasurement::resampled(size_t resample) const {
  const metrics::Score& score = *request_.error.score;
  std::vector<std::vector<AgentCost>> costs = measured_.costs.costs;
  for (const size_t c : timed_) costs[c] = resampled_costs(std::move(costs[c]), resample);
  SwitchTable table = table_of(costs);
  for (const size_t c : timed_) {
    for (size_t b = 0; b < table.bins(); ++b) {
      const TuneError& error = measured_.errors[c][b];
      if (error.values.empty()) continue;
      const std::vector<double> bad = drawn_anew(request_.seed, resample, badnesses_of(score, error.values));
      table.allowed[c][b] = tail_interval(bad).high <= badness_of(score, request_.error.value);
      double sum = 0;
      for (const double one : bad) sum += one;
      table.error[c][b] =
          std::min(kBeyond, loss_of(score, value_of_badness(score, sum / static_cast<double>(bad.size()))));
    }
  }
  return table;
}

std::vector<AgentCost> TuneMeasurement::resampled_costs(std::vector<AgentCost> costs, size_t resample) const {
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

const TunePop& TuneMeasurement::pop(size_t from, size_t to, size_t bin) {
  const auto [entry, fresh] = pops_.try_emplace({from, to, bin});
  if (fresh) entry->second = measured_pop(from, to, request_.heights_px[bin]);
  return entry->second;
}

TunePop TuneMeasurement::measured_pop(size_t from, size_t to, double height) const {
  const metrics::Score* score = request_.pop.score;
  std::vector<renderers::Capture> before;
  std::vector<double> bad;
  TunePop out;
  out.subject = index_;
  if (!measured_.refused[from].empty() || !measured_.refused[to].empty()) return out;
  QualitySetup setup = setup_of({from, to}, {height}, {&score, 1});
  // The pictures of all of them are held at once.
  const size_t count = std::min(setup.views.size(), kPopViews);
  const auto block = [&](size_t i) { return i * blocks_.size() / count; };
  std::vector<QualityView> some;
  for (size_t i = 0; i < count; ++i) some.push_back(setup.views[block(i)]);
  setup.views = std::move(some);
  compute_quality(context_, setup, [&](const QualityRow& row, const QualityPictures& pictures) {
    if (row.index == 0)
      before.push_back(pictures.test);
    else
      bad.push_back(worst_step(before[bad.size()], pictures.test));
  });
  const double tail = badness_tail(bad);
  out.tail = value_of_badness(*score, tail);
  out.allowed = tail <= badness_of(*score, request_.pop.value);
  const auto worst = std::max_element(bad.begin(), bad.end());
  out.block = block(static_cast<size_t>(worst - bad.begin()));
  out.worst = value_of_badness(*score, *worst);
  return out;
}

// Of a cut, or of the cross-fade.
double TuneMeasurement::worst_step(const renderers::Capture& a, const renderers::Capture& b) const {
  const metrics::Score* score = request_.pop.score;
  std::vector<Image8> pictures{a.colour, b.colour};
  if (request_.fade > 0) pictures = fade_pictures(a.colour, b.colour, request_.fade);
  double worst = badness_of(*score, metrics::best_value(*score));
  for (size_t i = 1; i < pictures.size(); ++i) {
    metrics::Buffers first = buffers_of(a);
    metrics::Buffers second = buffers_of(b);
    first.codes = &pictures[i - 1];
    second.codes = &pictures[i];
    const auto value = metrics::score_figure({&score, 1}, first, second, {&request_.display}).value(score->name);
    if (value) worst = std::max(worst, badness_of(*score, *value));
  }
  return worst;
}

}  // namespace crowdbench::bench
