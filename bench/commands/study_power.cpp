#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <set>

#include "bench/commands/command_line.h"
#include "bench/commands/options.h"
#include "bench/commands/study.h"
#include "core/counted.h"
#include "core/error.h"
#include "core/json.h"
#include "core/progress.h"
#include "studies/analysis/power.h"
#include "studies/plan/plan.h"

namespace crowdbench::bench {
namespace {

struct StudyPowerOptions {
  std::string plan;
  std::vector<uint32_t> participants;
  studies::PowerSettings settings;
  std::optional<double> effect, intercept;
  std::optional<uint32_t> clips, repeats;  // the plan's, or the default, where they are not given
  std::optional<double> alpha;
  std::optional<double> threshold, slope, guess;
  uint64_t simulations = 1000;
  bool json = false;
};

// What is not given is the plan's: how many take part, the crowds and repeats of a condition, the level of its tests.
void take_plan(StudyPowerOptions& o, const studies::StudyPlan& plan) {
  if (o.participants.empty() && plan.participants.planned >= 2) o.participants = {plan.participants.planned};
  if (!o.clips) o.clips = plan.stimulus.crowds;
  if (!o.repeats) o.repeats = plan.method.repeats;
  if (!o.alpha) o.alpha = plan.analysis.settings.alpha;
}

void take_defaults(StudyPowerOptions& o) {
  if (o.participants.empty()) o.participants = {8, 16, 24, 32};
  studies::PowerSettings& s = o.settings;
  s.clips = o.clips.value_or(s.clips);
  s.repeats = o.repeats.value_or(s.repeats);
  s.alpha = o.alpha.value_or(s.alpha);
  s.effect = o.effect.value_or(s.effect);
  s.intercept = o.intercept.value_or(s.intercept);
  s.simulations = o.simulations;
}

// ---- rows, one for each number of participants

// simulate: with a Progress that it advances by participants. Its end is that of all rows that are left; it is gone
// before print: rows are told as they come.
template <typename Simulate, typename Print>
void each_row(const StudyPowerOptions& o, const Simulate& simulate, const Print& print) {
  uint64_t left = 0;
  for (const uint32_t participants : o.participants) left += o.simulations * participants;
  for (size_t row = 0; row < o.participants.size(); ++row) {
    const uint32_t participants = o.participants[row];
    Progress progress(fmt::format("row {} of {}, simulated participants", row + 1, o.participants.size()), left);
    const auto got = simulate(participants, progress);
    progress.end();
    print(participants, got);
    left -= o.simulations * participants;
    std::fflush(stdout);
  }
}

// ---- two conditions

int print_two_conditions(const StudyPowerOptions& options) {
  Json rows = Json::array();
  if (!options.json)
    fmt::print(
        "simulated: {:g} logits between two conditions, {} x {} in either, {} a row\n"
        "{:>12} {:>8} {:>7} {:>10} {:>10} {:>9} {:>7}\n",
        options.settings.effect, counted(options.settings.clips, "clip", "clips"),
        counted(options.settings.repeats, "repeat", "repeats"), counted(options.simulations, "study", "studies"),
        "participants", "trials", "power", "+-", "CI width", "singular", "failed");
  studies::PowerSettings s = options.settings;
  const uint64_t trials = uint64_t{2} * s.clips * s.repeats;
  const auto simulate = [&](uint32_t participants, Progress& progress) {
    s.participants = participants;
    s.progress = &progress;
    return studies::simulate_power(s);
  };
  each_row(options, simulate, [&](uint32_t participants, const studies::Power& got) {
    rows.push_back({{"participants", participants},
                    {"trials_per_participant", trials},
                    {"simulations", s.simulations},
                    {"power", got.power},
                    {"power_se", got.power_se},
                    {"mean_estimate", got.mean_estimate},
                    {"sd_estimate", got.sd_estimate},
                    {"mean_se", got.mean_se},
                    {"interval_width", got.interval_width},
                    {"singular", got.singular},
                    {"failed", got.failed}});
    if (!options.json)
      fmt::print("{:>12} {:>8} {:>7.3f} {:>10.3f} {:>10.3f} {:>9} {:>7}\n", participants, trials, got.power,
                 got.power_se, got.interval_width, got.singular, got.failed);
  });
  if (options.json)
    fmt::print("{}\n", Json{{"observers", "simulated"},
                            {"plan", options.plan.empty() ? Json() : Json(options.plan)},
                            {"effect", options.settings.effect},
                            {"clips", options.settings.clips},
                            {"repeats", options.settings.repeats},
                            {"alpha", options.settings.alpha},
                            {"rows", rows}}
                           .dump(2));
  return 0;
}

// ---- a plan's own threshold

// 0.1 of same-different, as `study simulate` has it; else what the analysis holds, or chance.
double guess_of(const StudyPowerOptions& o, const studies::StudyPlan& plan) {
  return o.guess.value_or(plan.task == studies::Task::same_different ? 0.1 : plan.analysis.settings.curve.guess);
}

studies::ThresholdPowerSettings threshold_settings(const StudyPowerOptions& o, const studies::StudyPlan& plan) {
  studies::ThresholdPowerSettings out;
  out.analysis = plan.analysis.settings;
  out.analysis.alpha = o.settings.alpha;
  if (out.analysis.random == studies::RandomEffects::none)
    throw Error(plan.where, "plans no mixed model ([analysis] random = \"none\")", "say `random = \"intercept\"`");
  std::set<double> levels;
  for (const studies::StudyCondition& condition : plan.conditions)
    if (condition.level) levels.insert(*condition.level);
  out.design = {.participants = 2,
                .levels = {levels.begin(), levels.end()},
                .clips = o.settings.clips,
                .repeats = o.settings.repeats};
  const double low = *levels.begin();
  const double high = *levels.rbegin();
  studies::SimulatedObservers& who = out.observers;
  // From 1 in 20 seen at one end of the levels to 19 in 20 at the other.
  const double spanning = 2 * std::log(19.0) / (high - low) * (out.analysis.curve.falling ? -1 : 1);
  who.slope = o.slope.value_or(spanning);
  who.guess = guess_of(o, plan);
  const double reach = (out.analysis.curve.level - who.guess) / (1 - who.guess);
  if (!(reach > 0 && reach < 1))
    throw Error(
        "--guess",
        fmt::format("{:g} is above the level {:g} that the threshold is at", who.guess, out.analysis.curve.level),
        "give a smaller one");
  if (who.slope == 0) throw Error("--slope", "is 0: there is no threshold", "give another one");
  who.threshold = o.threshold.value_or((low + high) / 2) - std::log(reach / (1 - reach)) / who.slope;
  who.threshold_sd = o.settings.participant_sd / std::abs(who.slope);
  who.clip_sd = o.settings.clip_sd;
  out.simulations = o.simulations;
  out.seed = o.settings.seed;
  return out;
}

Json json_of(const studies::ThresholdPower& p) {
  return {{"mean_estimate", p.mean_estimate},
          {"sd_estimate", p.sd_estimate},
          {"median_width", p.closed > 0 ? Json(p.median_width) : Json()},
          {"held", p.closed > 0 ? Json(p.held) : Json()},
          {"held_se", p.closed > 0 ? Json(p.held_se) : Json()},
          {"closed", p.closed},
          {"open", p.open},
          {"failed", p.failed}};
}

Json json_of(const studies::EquivalencePower& p) {
  return {{"power", p.power}, {"power_se", p.power_se}, {"at_margin", p.at_margin}, {"at_margin_se", p.at_margin_se}};
}

studies::EquivalencePowerSettings equivalence_settings(const StudyPowerOptions& o, const studies::StudyPlan& plan) {
  const studies::AnalysisSettings& s = plan.analysis.settings;
  return {.participants = 2,
          .trials = o.settings.clips * o.settings.repeats,
          .equivalence = {.chance = s.chance, .margin = *s.margin, .alpha = o.settings.alpha, .power = s.power},
          .simulations = o.simulations,
          .seed = o.settings.seed};
}

// Width and share held are of the studies that end in an interval with two ends: whoever plans must know how many do
// not.
void print_without_interval(uint32_t participants, const studies::ThresholdPower& got, uint64_t simulations) {
  if (got.open + got.failed == 0) return;
  const auto share = [&](size_t n) { return 100 * static_cast<double>(n) / static_cast<double>(simulations); };
  fmt::print(
      "  with {}, {} of {} end without an interval ({:.0f} %: {} open, since the slope is not told from none; {} "
      "without "
      "a fit);\n  width and held are of the others. More repeats, crowds or participants, or levels nearer to the "
      "threshold, mend it\n",
      counted(participants, "participant", "participants"), got.open + got.failed,
      counted(simulations, "study", "studies"), share(got.open + got.failed), got.open, got.failed);
}

Json threshold_rows(const StudyPowerOptions& o, studies::ThresholdPowerSettings s) {
  const double truth = studies::true_threshold(s);
  Json rows = Json::array();
  if (!o.json)
    fmt::print(
        "simulated: threshold {:g} (at {:g}), slope {:g}, guess {:g}; {} x {} x {}; the planned mixed model, {} a row\n"
        "{:>12} {:>8} {:>14} {:>7} {:>7} {:>7} {:>7}\n",
        truth, s.analysis.curve.level, s.observers.slope, s.observers.guess,
        counted(s.design.levels.size(), "level", "levels"), counted(s.design.clips, "clip", "clips"),
        counted(s.design.repeats, "repeat", "repeats"), counted(o.simulations, "study", "studies"), "participants",
        "trials", fmt::format("{:g} % CI width", 100 * s.analysis.confidence), "held", "+-", "open", "failed");
  const uint64_t trials = s.design.levels.size() * s.design.clips * s.design.repeats;
  const auto simulate = [&](uint32_t participants, Progress& progress) {
    s.design.participants = participants;
    s.progress = &progress;
    return studies::simulate_threshold_power(s);
  };
  each_row(o, simulate, [&](uint32_t participants, const studies::ThresholdPower& got) {
    Json row = {{"participants", participants}, {"trials_per_participant", trials}, {"simulations", s.simulations}};
    row["threshold"] = json_of(got);
    rows.push_back(std::move(row));
    if (!o.json)
      fmt::print("{:>12} {:>8} {:>14.4g} {:>7.3f} {:>7.3f} {:>7} {:>7}\n", participants, trials, got.median_width,
                 got.held, got.held_se, got.open, got.failed);
    if (!o.json) print_without_interval(participants, got, o.simulations);
  });
  return {{"threshold", truth},           {"slope", s.observers.slope}, {"guess", s.observers.guess},
          {"at", s.analysis.curve.level}, {"levels", s.design.levels},  {"confidence", s.analysis.confidence},
          {"rows", std::move(rows)}};
}

Json equivalence_rows(const StudyPowerOptions& o, studies::EquivalencePowerSettings s) {
  const studies::EquivalenceSettings& e = s.equivalence;
  Json rows = Json::array();
  if (!o.json)
    fmt::print(
        "simulated: \"equivalent\" said of one condition, margin {:g} about {:g}, alpha {:g}, {} a row\n"
        "{:>12} {:>8} {:>12} {:>7} {:>13} {:>7}\n",
        e.margin, e.chance, e.alpha, counted(o.simulations, "study", "studies"), "participants", "trials",
        "nothing seen", "+-", "at the margin", "+-");
  const auto simulate = [&](uint32_t participants, Progress& progress) {
    s.participants = participants;
    s.progress = &progress;
    return studies::simulate_equivalence_power(s);
  };
  each_row(o, simulate, [&](uint32_t participants, const studies::EquivalencePower& got) {
    Json row = {{"participants", participants}, {"trials_per_participant", s.trials}, {"simulations", s.simulations}};
    row["equivalent"] = json_of(got);
    rows.push_back(std::move(row));
    if (!o.json)
      fmt::print("{:>12} {:>8} {:>12.3f} {:>7.3f} {:>13.3f} {:>7.3f}\n", participants, s.trials, got.power,
                 got.power_se, got.at_margin, got.at_margin_se);
  });
  return {{"margin", e.margin}, {"chance", e.chance}, {"alpha", e.alpha}, {"rows", std::move(rows)}};
}

int print_planned(const StudyPowerOptions& o, const studies::StudyPlan& plan) {
  if (o.effect || o.intercept)
    throw Error(o.effect ? "--effect" : "--intercept", "is of two conditions, and the plan has a level or a margin",
                "say --threshold and --slope, or leave PLAN out");
  Json out = {{"observers", "simulated"}, {"plan", o.plan}};
  out["threshold"] = plan.analysis.level.empty() ? Json() : threshold_rows(o, threshold_settings(o, plan));
  out["equivalence"] = plan.analysis.settings.margin ? equivalence_rows(o, equivalence_settings(o, plan)) : Json();
  if (o.json) fmt::print("{}\n", out.dump(2));
  return 0;
}

int run_power(StudyPowerOptions options) {
  std::optional<studies::StudyPlan> plan;
  if (!options.plan.empty()) {
    plan = studies::read_study_plan(options.plan);
    if (plan->method.method != studies::Method::constant)
      throw Error(options.plan, "chooses its trials by the answers",
                  "plan the study that its pilot is for: constant stimuli");
    take_plan(options, *plan);
  }
  take_defaults(options);
  const bool level = plan && !plan->analysis.level.empty();
  for (const auto& [option, given] :
       {std::pair{"--threshold", options.threshold.has_value()}, std::pair{"--slope", options.slope.has_value()},
        std::pair{"--guess", options.guess.has_value()}})
    if (given && !level)
      throw Error(option, "is of a psychometric function", "name a plan whose [analysis] has a `level`");
  return level || (plan && plan->analysis.settings.margin) ? print_planned(options, *plan)
                                                           : print_two_conditions(options);
}

}  // namespace

void add_study_power(Command& study, Run& run) {
  Command* command = study.add_subcommand("power", "How many participants it takes, by simulated studies");
  command->footer(
      "Of a PLAN with a level: its own levels, crowds, repeats and analysis; how wide the threshold's interval is, and "
      "how often it\nholds the truth. Of one with a margin: how often \"equivalent\" is said where nothing is seen, "
      "and "
      "at the margin.\n"
      "Otherwise two conditions within every participant; answers by a logistic model with participants (and clips, "
      "with\n--clip-sd) that differ; each simulated study is analysed by the mixed model that `study analyze` fits, "
      "Wald "
      "test of the effect.\nParticipants, clips, repeats and alpha are the plan's where they are not given.\n\n"
      "Examples:\n  crowdbench study power --effect 0.5 --participants 8,16,24\n"
      "  crowdbench study power studies/plans/equivalence.toml --json\n"
      "  crowdbench study power studies/plans/pilot.toml --threshold 150 --slope -0.03 --simulations 200\n"
      "  crowdbench study power --effect 0.4 --participant-sd 0.6 --clip-sd 0.5 --clips 12 --simulations 200 --json");
  auto options = std::make_shared<StudyPowerOptions>();
  StudyPowerOptions& o = *options;
  command->add_option("PLAN", o.plan, "a study's plan")->type_name("FILE.toml");
  command->add_option("--participants", o.participants, "numbers of participants to try (8, 16, 24, 32)")
      ->delimiter(',')
      ->whole_number(2, 10000);
  command->add_option("--effect", o.effect, "between the two conditions, in logits (0.5)")->number(-20, 20);
  command->add_option("--intercept", o.intercept, "half way between them, in logits (0)")->number(-20, 20);
  command
      ->add_option("--threshold", o.threshold,
                   "of the typical observer, in units of the plan's level (the middle of its levels)")
      ->number(-1e9, 1e9);
  command
      ->add_option("--slope", o.slope,
                   "logits by unit of level, below 0 where it falls (1 to 19 of 20 seen over the plan's levels)")
      ->number(-1e9, 1e9);
  command->add_option("--guess", o.guess, "share right, or \"different\", of what is not seen (by the plan's task)")
      ->number(0, 0.95);
  command->add_option("--participant-sd", o.settings.participant_sd, "between participants, in logits")
      ->capture_default_str()
      ->number(0, 20);
  command
      ->add_option("--clip-sd", o.settings.clip_sd,
                   "between clips, in logits; 0: clips are alike, and not random in the model")
      ->capture_default_str()
      ->number(0, 20);
  command->add_option("--clips", o.clips, "clips a condition (10)")->whole_number(1, 1000);
  command->add_option("--repeats", o.repeats, "of each clip in each condition, by every participant (2)")
      ->whole_number(1, 1000);
  command->add_option("--alpha", o.alpha, "level of the test (0.05)")->number(1e-6, 0.5);
  command->add_option("--simulations", o.simulations, "studies that are simulated")
      ->capture_default_str()
      ->whole_number(1, 100000);
  command->add_option("--seed", o.settings.seed, "seed of the simulated observers")
      ->capture_default_str()
      ->whole_number(0, UINT64_MAX);
  add_json_option(*command, o.json);
  command->callback([options, &run] { run = [options] { return run_power(*options); }; });
}

}  // namespace crowdbench::bench
