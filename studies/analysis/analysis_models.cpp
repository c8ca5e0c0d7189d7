// The models of a task: psychometric functions, mixed regressions, rankings.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <set>

#include "core/error.h"
#include "core/probability.h"
#include "studies/analysis/analysis_parts.h"

namespace crowdbench::studies::parts {
namespace {

constexpr double kLeastGuess = 1e-6;        // a rate below it is one at its bound, 0
constexpr size_t kMostBootstrapItems = 20;  // of which every two were compared: a minute

std::vector<Level> levels_of(const Rows& rows, TieRule rule) {
  std::map<double, std::array<uint64_t, 3>> counts;
  for (const Answer* row : rows) {
    auto& [yes, ties, no] = counts[*row->level];
    yes += row->yes;
    ties += row->ties;
    no += row->no;
  }
  std::vector<Level> out;
  for (const auto& [x, c] : counts) {
    const Decided d = decided(c[0], c[1], c[2], rule);
    out.push_back({x, d.yes, d.of});
  }
  return out;
}

// Without the trials in which there was nothing to see: their yes is a false alarm, whatever their level says.
Rows with_signal(const Rows& rows) {
  Rows out;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(out),
               [](const Answer* row) { return row->signal.value_or(true); });
  return out;
}

// Of every participant whose screen was calibrated, in pixels of the clip as it was shown to them.
std::vector<Calibration> calibrations_of(const Rows& rows) {
  std::vector<Calibration> out;
  for (const auto& [participant, theirs] : by_participant(rows)) {
    Calibration mean;
    double count = 0;
    for (const Answer* row : theirs) {
      if (!row->pixels_per_degree) continue;
      mean.pixels_per_degree += *row->pixels_per_degree / row->css_px_per_clip_px;
      mean.standard_error += *row->pixels_per_degree_se / row->css_px_per_clip_px;
      ++count;
    }
    if (count > 0) out.push_back({mean.pixels_per_degree / count, mean.standard_error / count});
  }
  return out;
}

// Empty where a row does not say of which clip it is.
std::vector<std::vector<Level>> levels_by_clip(const Rows& rows, TieRule rule) {
  std::map<uint32_t, Rows> clips;
  for (const Answer* row : rows) {
    if (!row->clip) return {};
    clips[*row->clip].push_back(row);
  }
  std::vector<std::vector<Level>> out;
  for (const auto& [clip, theirs] : clips) out.push_back(levels_of(theirs, rule));
  return out;
}

CurveResult curve_of(const std::string& name, const Rows& rows, const AnalysisSettings& s) {
  CurveResult out;
  out.condition = name;
  const std::vector<Level> levels = levels_of(rows, s.ties);
  CurveSettings settings = s.curve;
  settings.confidence = s.confidence;
  out.fit = fit_curve(levels, settings);
  std::vector<std::vector<Level>> people;
  for (const auto& [participant, theirs] : by_participant(rows)) people.push_back(levels_of(theirs, s.ties));
  const std::vector<std::vector<Level>> clips = levels_by_clip(rows, s.ties);
  out.clips = clips.size();
  if (!people.empty()) out.jackknife = jackknife_threshold(out.fit, people, clips, settings);
  if (people.size() < 2) people.clear();
  out.by_participant = !people.empty();
  out.bootstrap = bootstrap_threshold(out.fit, levels, people, settings, s.seed, s.resamples);
  out.participants = by_participant(rows).size();
  if (s.axis.in_pixels && out.fit.threshold) {
    const ThresholdInterval told = threshold_interval(out).value_or(ThresholdInterval{});
    out.angle = threshold_in_degrees(*out.fit.threshold, told.low, told.high, calibrations_of(rows), s.confidence);
  }
  return out;
}

// The rate of guesses that a mixed model over the level holds. It fits none: it takes the curve's, where that has one.
double held_guess(const AnalysisSettings& s, const CurveFit* curve) {
  if (s.curve.guess_rate == Rate::fixed) return s.curve.guess;
  if (curve == nullptr || curve->state != CurveState::fitted) return 0;
  return curve->at.guess < kLeastGuess ? 0 : curve->at.guess;
}

MixedSettings mixed_settings(const Rows& rows, const AnalysisSettings& s, bool with_level, const CurveFit* curve) {
  MixedSettings out;
  out.link = s.link;
  out.guess = with_level ? held_guess(s, curve) : 0;
  out.slopes = with_level && (s.random == RandomEffects::slope || s.random == RandomEffects::independent_slope);
  out.correlated = s.random == RandomEffects::slope;
  std::set<uint32_t> clips;
  for (const Answer* row : rows)
    if (row->clip) clips.insert(*row->clip);
  out.clips = clips.size() > 1;
  const bool scalar = !out.slopes && !out.clips;
  out.integration = s.integration.value_or(scalar ? Integration::quadrature : Integration::laplace);
  // Quadrature over two dimensions is not offered: the Laplace of the same information stands in.
  if (!scalar && out.integration == Integration::quadrature) out.integration = Integration::laplace_observed;
  return out;
}

GuessSource guess_source(const AnalysisSettings& s, const CurveFit* curve) {
  if (s.curve.guess_rate == Rate::fixed) return GuessSource::settings;
  return curve != nullptr && curve->state == CurveState::fitted ? GuessSource::curve : GuessSource::none;
}

// conditions: those that get a contrast to the first; none where they are fitted apart. curve: of the same answers.
MixedResult mixed_of(const std::string& name, const Rows& rows, const std::vector<uint32_t>& conditions,
                     const Answers& answers, const AnalysisSettings& s, const CurveFit* curve) {
  MixedResult out;
  out.condition = name;
  const bool with_level = rows.front()->level.has_value();
  out.settings = mixed_settings(rows, s, with_level, curve);
  if (with_level) out.guess_from = guess_source(s, curve);
  out.effects = {"intercept"};
  if (with_level) out.effects.emplace_back("level");
  for (size_t i = 1; i < conditions.size(); ++i) out.effects.push_back(answers.conditions[conditions[i]]);
  std::map<uint32_t, uint32_t> participants;
  std::map<uint32_t, uint32_t> clips;
  std::vector<MixedRow> data;
  for (const Answer* row : rows) {
    const Counted d = counted(row->yes, row->ties, row->no, s.ties);
    if (d.of == 0 || !row->participant) continue;
    MixedRow one{.yes = d.yes, .of = d.of, .halves = d.halves};
    one.participant = participants.emplace(*row->participant, static_cast<uint32_t>(participants.size())).first->second;
    if (out.settings.clips)
      one.clip = clips.emplace(row->clip.value_or(0), static_cast<uint32_t>(clips.size())).first->second;
    one.fixed.assign(out.effects.size(), 0);
    one.fixed[0] = 1;
    if (with_level) one.fixed[1] = one.slope = *row->level;
    for (size_t i = 1; i < conditions.size(); ++i)
      one.fixed[(with_level ? 1 : 0) + i] = row->condition == conditions[i] ? 1 : 0;
    data.push_back(std::move(one));
  }
  out.fit = fit_mixed(data, out.settings);
  if (out.fit.state != MixedState::fitted && out.fit.state != MixedState::singular) return out;
  if (with_level) {
    out.ratio = likelihood_ratio(data, out.settings, out.fit, 1);
    out.threshold = mixed_threshold(out.fit, out.settings, s.curve.level, s.confidence);
    if (s.axis.in_pixels && out.threshold) {
      const auto& told = out.threshold->interval;
      out.angle =
          threshold_in_degrees(out.threshold->at, told ? std::optional(told->low) : std::nullopt,
                               told ? std::optional(told->high) : std::nullopt, calibrations_of(rows), s.confidence);
    }
  } else if (out.effects.size() == 1) {
    out.population = population_probability(out.fit, out.settings, {1});
  }
  return out;
}

const CurveFit* curve_named(const std::vector<CurveResult>& curves, const std::string& condition) {
  for (const CurveResult& curve : curves)
    if (curve.condition == condition) return &curve.fit;
  return nullptr;
}

// Items of a task, by their place in Answers::items: those of others and of catch trials are not in its ranking.
using Places = std::map<uint32_t, uint32_t>;
Places places_of(const Rows& rows) {
  Places out;
  for (const Answer* row : rows)
    for (const uint32_t item : {*row->item_a, *row->item_b}) out.emplace(item, 0U);
  uint32_t next = 0;
  for (auto& [item, place] : out) place = next++;
  return out;
}

Wins wins_of(const Rows& rows, const Places& places) {
  Wins out(places.size(), std::vector<double>(places.size(), 0));
  for (const Answer* row : rows) {
    const double half = static_cast<double>(row->ties) / 2;
    const size_t a = places.at(*row->item_a);
    const size_t b = places.at(*row->item_b);
    out[a][b] += static_cast<double>(row->yes) + half;
    out[b][a] += static_cast<double>(row->no) + half;
  }
  return out;
}

}  // namespace

std::vector<CurveResult> curves_of(const Groups& groups, const AnalysisSettings& s) {
  std::vector<CurveResult> out;
  for (const auto& [condition, theirs] : groups.all)
    if (const Rows shown = with_signal(theirs); !shown.empty()) out.push_back(curve_of(condition, shown, s));
  return out;
}

std::vector<MixedResult> mixed_models(const Answers& answers, const Rows& all, const Groups& groups,
                                      const std::vector<CurveResult>& curves, const AnalysisSettings& s) {
  std::vector<MixedResult> out;
  const Rows rows = with_signal(all);
  if (s.random == RandomEffects::none || rows.empty() || !rows.front()->participant) return out;
  if (rows.front()->level || !rows.front()->condition) {
    for (const auto& [name, theirs] : groups.all)
      if (const Rows shown = with_signal(theirs); !shown.empty())
        out.push_back(mixed_of(name, shown, {}, answers, s, curve_named(curves, name)));
    return out;
  }
  std::vector<uint32_t> conditions;
  for (const Answer* row : rows)
    if (std::find(conditions.begin(), conditions.end(), *row->condition) == conditions.end())
      conditions.push_back(*row->condition);
  out.push_back(mixed_of("", rows, conditions, answers, s, nullptr));
  return out;
}

RankingResult ranking_of(const Answers& answers, const Rows& rows, const AnalysisSettings& s) {
  RankingResult out;
  std::set<std::string> conditions;
  for (const Answer* row : rows) conditions.insert(condition_name(answers, *row));
  out.conditions = conditions.size();
  const Places places = places_of(rows);
  for (const auto& [item, place] : places) out.items.push_back(answers.items[item]);
  std::vector<Comparison> comparisons;
  for (const Answer* row : rows)
    comparisons.push_back(
        {places.at(*row->item_a), places.at(*row->item_b), row->shown_first_is_a, row->yes, row->ties, row->no});
  const auto known = static_cast<size_t>(
      std::count_if(rows.begin(), rows.end(), [](const Answer* row) { return row->shown_first_is_a.has_value(); }));
  if (known != 0 && known != rows.size())
    throw Error(answers.sources.front(), "says of some comparisons only which item stood first",
                "name the column `shown_first` of every table, or of none");
  out.worths = fit_worths(comparisons, out.items.size(), known > 0);
  if (known > 0 && out.worths.state == WorthState::fitted) {
    const Worths without = fit_worths(comparisons, out.items.size(), false);
    const double chi_squared = std::max(0.0, 2 * (out.worths.log_likelihood - without.log_likelihood));
    out.position = LikelihoodRatio{chi_squared, chi_squared_tail(chi_squared, 1)};
  }
  const Wins wins = wins_of(rows, places);
  out.jod = fit_jod(wins, JodPrior::none);
  out.jod_with_prior = fit_jod(wins, JodPrior::gaussian);
  std::vector<Wins> people;
  for (const auto& [participant, theirs] : by_participant(rows)) people.push_back(wins_of(theirs, places));
  if (people.size() > 1 && s.resamples > 0 && out.items.size() <= kMostBootstrapItems &&
      out.jod_with_prior.state == WorthState::fitted)
    out.intervals =
        bootstrap_jod(people, bootstrap_draws(people.size(), s.resamples, s.seed), JodPrior::gaussian, s.confidence);
  return out;
}

}  // namespace crowdbench::studies::parts
