// Based on: Watson, "QUEST+: A general multidimensional Bayesian adaptive psychometric method" (2017); of pairs the
// expected information of an answer (studies/analysis/active_pairs.h).
#include "studies/plan/adaptive.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "core/error.h"
#include "core/hash.h"
#include "studies/analysis/active_pairs.h"

namespace crowdbench::studies {
namespace {

constexpr size_t kThresholds = 31;
constexpr size_t kSlopes = 9;
constexpr double kEqual = 1e-9;  // nats: of choices that tell equally much, rounding must not choose

// `count` values from low to high, in equal steps or equal ratios.
std::vector<double> steps(double low, double high, size_t count, bool ratios) {
  std::vector<double> out;
  for (size_t k = 0; k < count; ++k) {
    const double part = static_cast<double>(k) / static_cast<double>(count - 1);
    out.push_back(ratios ? low * std::pow(high / low, part) : low + (high - low) * part);
  }
  return out;
}

void fill_grid(AdaptiveRule& rule, const StudyPlan& plan) {
  const CurveSettings& curve = plan.analysis.settings.curve;
  rule.curve = curve.curve;
  rule.falling = curve.falling;
  std::set<double> levels;
  for (const StudyCondition& condition : plan.conditions) levels.insert(*condition.level);
  const double low = *levels.begin();
  const double high = *levels.rbegin();
  if (rule.curve == Curve::weibull) {
    rule.threshold = steps(*levels.upper_bound(0), high, kThresholds, true);
    rule.slope = steps(0.5, 10, kSlopes, true);
  } else {
    rule.threshold = steps(low, high, kThresholds, false);
    rule.slope = steps((high - low) / 50, (high - low) / 2, kSlopes, true);
  }
  rule.guess = {curve.guess};
  if (curve.guess_rate != Rate::fixed) rule.guess = {0.02, 0.1, 0.2, 0.3, 0.4, 0.5};
  rule.lapse = {curve.lapse};
  if (curve.lapse_rate != Rate::fixed) rule.lapse = {0, 0.02, 0.05, 0.1};
}

void add_stimulus(AdaptiveRule& rule, const StudyPlan& plan, const Stimulus& stimulus) {
  if (stimulus.kind == StimulusKind::alike) {
    rule.alike.push_back(stimulus.id);
    rule.yes[stimulus.id] = "different";
    return;
  }
  AdaptiveChoice choice;
  if (stimulus.kind == StimulusKind::pair) {
    const bool on_top = *stimulus.test_on_top;
    const auto item = [&](const std::string& name) {
      return static_cast<size_t>(std::lower_bound(rule.items.begin(), rule.items.end(), name) - rule.items.begin());
    };
    choice.a = item(on_top ? stimulus.item_upper : stimulus.item_lower);
    choice.b = item(on_top ? stimulus.item_lower : stimulus.item_upper);
    rule.yes[stimulus.id] = (choice.a < choice.b) == on_top ? "upper" : "lower";
    if (choice.a > choice.b) std::swap(choice.a, choice.b);
  } else if (stimulus.kind == StimulusKind::test) {
    choice.level = *plan.conditions[stimulus.condition].level;
    rule.yes[stimulus.id] = stimulus.expected;
  } else {
    return;
  }
  const auto same = [&](const AdaptiveChoice& c) {
    return c.level == choice.level && c.a == choice.a && c.b == choice.b;
  };
  auto found = std::find_if(rule.choices.begin(), rule.choices.end(), same);
  if (found == rule.choices.end()) found = rule.choices.insert(found, choice);
  found->stimuli.push_back(stimulus.id);
}

QuestPlus quest_of(const AdaptiveRule& rule) {
  QuestSettings settings;
  settings.falling = rule.falling;
  settings.threshold = rule.threshold;
  settings.slope = rule.slope;
  settings.guess = rule.guess;
  settings.lapse = rule.lapse;
  for (const AdaptiveChoice& choice : rule.choices) settings.stimuli.push_back(choice.level);
  settings.function = rule.curve == Curve::cumulative_gaussian ? QuestFunction::normal : QuestFunction::logistic;
  if (rule.curve == Curve::weibull) {
    settings.function = QuestFunction::weibull_log10;  // of a level of 0 minus infinity: nothing to see
    for (std::vector<double>* values : {&settings.threshold, &settings.stimuli})
      for (double& value : *values) value = std::log10(value);
  }
  return QuestPlus(settings);
}

size_t choice_of(const AdaptiveRule& rule, const std::string& stimulus) {
  const auto shows = [&](const AdaptiveChoice& choice) {
    return std::find(choice.stimuli.begin(), choice.stimuli.end(), stimulus) != choice.stimuli.end();
  };
  return static_cast<size_t>(std::find_if(rule.choices.begin(), rule.choices.end(), shows) - rule.choices.begin());
}

std::vector<double> worths_by_quest(const AdaptiveRule& rule, std::span<const GivenAnswer> before) {
  QuestPlus quest = quest_of(rule);
  for (const GivenAnswer& given : before) {
    const bool yes = given.answer == rule.yes.at(given.stimulus);
    const size_t choice = choice_of(rule, given.stimulus);
    if (choice < rule.choices.size())
      quest.answer(choice, yes);
    else
      quest.answer_to_nothing(yes);
  }
  std::vector<double> out = quest.expected_entropies();
  for (double& value : out) value = -value;
  return out;
}

std::vector<double> worths_of_pairs(const AdaptiveRule& rule, std::span<const GivenAnswer> before) {
  std::vector<PairAnswer> answers;
  for (const GivenAnswer& given : before) {
    const AdaptiveChoice& choice = rule.choices[choice_of(rule, given.stimulus)];
    const double won = given.answer == "cannot-tell" ? 0.5 : given.answer == rule.yes.at(given.stimulus) ? 1 : 0;
    answers.push_back({choice.a, choice.b, won});
  }
  const PairBelief belief = pair_belief(answers, rule.items.size());
  std::vector<double> out;
  for (const AdaptiveChoice& choice : rule.choices) out.push_back(expected_information(belief, choice.a, choice.b));
  return out;
}

Json grid_json(const AdaptiveRule& rule) {
  if (rule.method == Method::active_pairs) return {{"worth_sd", kWorthSd}};
  return {{"curve", curve_name(rule.curve)},
          {"falling", rule.falling},
          {"threshold", rule.threshold},
          {"slope", rule.slope},
          {"guess", rule.guess},
          {"lapse", rule.lapse}};
}

constexpr const char* kFromExport = "name a folder that `crowdbench study export` made";

// Whether choose_stimulus() may be asked: it indexes without looking.
bool is_usable(const AdaptiveRule& rule) {
  const auto chances = [](const std::vector<double>& rates) {
    return !rates.empty() && std::all_of(rates.begin(), rates.end(), [](double r) { return r >= 0 && r < 0.5 + 1e-9; });
  };
  const bool pairs = rule.method == Method::active_pairs;
  if (rule.method == Method::constant || rule.choices.empty()) return false;
  if (!pairs && (rule.threshold.empty() || rule.slope.empty() || !chances(rule.guess) || !chances(rule.lapse)))
    return false;
  const auto known = [&](const std::string& stimulus) { return rule.yes.contains(stimulus); };
  return std::all_of(rule.choices.begin(), rule.choices.end(),
                     [&](const AdaptiveChoice& c) {
                       const bool items = !pairs || (c.a != c.b && c.a < rule.items.size() && c.b < rule.items.size());
                       return items && !c.stimuli.empty() && std::all_of(c.stimuli.begin(), c.stimuli.end(), known);
                     }) &&
         std::all_of(rule.alike.begin(), rule.alike.end(), known);
}

}  // namespace

AdaptiveRule adaptive_rule(const StudyPlan& plan, const StudyDesign& design) {
  assert(plan.method.method != Method::constant);
  AdaptiveRule rule;
  rule.method = plan.method.method;
  if (rule.method == Method::quest_plus) fill_grid(rule, plan);
  std::set<std::string> items;
  for (const Stimulus& stimulus : design.stimuli)
    if (stimulus.kind == StimulusKind::pair) items.insert({stimulus.item_upper, stimulus.item_lower});
  rule.items.assign(items.begin(), items.end());
  for (const Stimulus& stimulus : design.stimuli) add_stimulus(rule, plan, stimulus);
  std::sort(rule.choices.begin(), rule.choices.end(), [](const AdaptiveChoice& a, const AdaptiveChoice& b) {
    return std::tuple(a.level, a.a, a.b) < std::tuple(b.level, b.a, b.b);
  });
  return rule;
}

bool is_chosen(const StudyPlan& plan, const StudyDesign& design, const Trial& trial) {
  if (plan.method.method == Method::constant || trial.kind != TrialKind::main) return false;
  const StimulusKind kind = design.stimuli[trial.stimulus].kind;
  return kind == StimulusKind::test || kind == StimulusKind::pair;
}

std::vector<double> choice_worths(const AdaptiveRule& rule, std::span<const GivenAnswer> before) {
  return rule.method == Method::active_pairs ? worths_of_pairs(rule, before) : worths_by_quest(rule, before);
}

std::string chosen_stimulus(const AdaptiveRule& rule, const std::string& study, const std::string& list,
                            const std::string& trial, std::span<const GivenAnswer> before) {
  const std::string place = study + "/" + list + "/" + trial + "/";
  const std::vector<double> worths = choice_worths(rule, before);
  const double best = *std::max_element(worths.begin(), worths.end());
  std::map<std::string, size_t> equal;
  for (size_t c = 0; c < worths.size(); ++c)
    if (worths[c] >= best - kEqual) equal[sha256_hex(place + fmt::format("{}", c))] = c;
  std::map<std::pair<size_t, std::string>, std::string> by_turn;
  for (const std::string& stimulus : rule.choices[equal.begin()->second].stimuli) {
    const auto shown = static_cast<size_t>(std::count_if(
        before.begin(), before.end(), [&](const GivenAnswer& given) { return given.stimulus == stimulus; }));
    by_turn[{shown, sha256_hex(place + stimulus)}] = stimulus;
  }
  return by_turn.begin()->second;
}

Json adaptive_json(const AdaptiveRule& rule) {
  Json out;
  out["method"] = method_words()[static_cast<size_t>(rule.method)];
  out.update(grid_json(rule));
  const bool pairs = rule.method == Method::active_pairs;
  if (pairs) out["items"] = rule.items.size();
  out["choices"] = Json::array();
  for (const AdaptiveChoice& choice : rule.choices) {
    Json entry = pairs ? Json{{"a", choice.a}, {"b", choice.b}} : Json{{"level", choice.level}};
    entry["stimuli"] = choice.stimuli;
    out["choices"].push_back(std::move(entry));
  }
  out["alike"] = rule.alike;
  out["yes"] = Json::object();
  for (const auto& [stimulus, answer] : rule.yes) out["yes"][stimulus] = answer;
  return out;
}

AdaptiveRule parse_adaptive(const std::string& text, const std::string& where) {
  using nlohmann::json;
  AdaptiveRule rule;
  try {
    const json all = json::parse(text);
    const auto method = std::find(method_words().begin(), method_words().end(), all.at("method").get<std::string>());
    rule.method = static_cast<Method>(method - method_words().begin());
    const bool pairs = rule.method == Method::active_pairs;
    if (pairs) {
      rule.items.resize(std::min<size_t>(all.at("items").get<size_t>(), kMostConditions + 1));
    } else {
      rule.curve = curve_named(all.at("curve").get<std::string>()).value_or(Curve::logistic);
      rule.falling = all.at("falling").get<bool>();
      rule.threshold = all.at("threshold").get<std::vector<double>>();
      rule.slope = all.at("slope").get<std::vector<double>>();
      rule.guess = all.at("guess").get<std::vector<double>>();
      rule.lapse = all.at("lapse").get<std::vector<double>>();
    }
    for (const json& each : all.at("choices")) {
      AdaptiveChoice choice;
      if (pairs) {
        choice.a = each.at("a").get<size_t>();
        choice.b = each.at("b").get<size_t>();
      } else {
        choice.level = each.at("level").get<double>();
      }
      choice.stimuli = each.at("stimuli").get<std::vector<std::string>>();
      rule.choices.push_back(std::move(choice));
    }
    rule.alike = all.at("alike").get<std::vector<std::string>>();
    rule.yes = all.at("yes").get<std::map<std::string, std::string>>();
  } catch (const json::exception&) {
    throw Error(where, "`adaptive` is not a rule by which trials are chosen", kFromExport);
  }
  if (!is_usable(rule)) throw Error(where, "nothing can be chosen by the rule in `adaptive`", kFromExport);
  return rule;
}

Json adaptive_meaning(const StudyPlan& plan) {
  AdaptiveRule rule;
  rule.method = plan.method.method;
  if (rule.method == Method::quest_plus) fill_grid(rule, plan);
  Json out = {{"order", "adaptive: each main trial is chosen by the participant's own answers so far"}};
  out.update(grid_json(rule));
  return out;
}

}  // namespace crowdbench::studies
