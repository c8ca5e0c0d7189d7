#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/options.h"
#include "bench/commands/study.h"
#include "bench/commands/study_report.h"
#include "core/error.h"
#include "core/files.h"
#include "core/json.h"
#include "studies/analysis/analysis.h"
#include "studies/analysis/exports.h"
#include "studies/plan/frozen.h"
#include "studies/server/answers_export.h"
#include "studies/server/study_folder.h"

namespace crowdbench::bench {
namespace {

using namespace studies;

// What is not given stays empty: the plan's, or the default.
struct StudyAnalyzeOptions {
  std::vector<std::string> files, where;
  std::string table, columns, plan, scores, study;
  std::string markdown, page, out, exports;
  std::string axis;  // what `level` is
  std::string ties, curve, guess, lapse, random, link, integration;
  std::optional<double> chance, margin, between, alpha, power, confidence, level, catch_least, shortest_rt;
  std::optional<uint64_t> most_dropped, seed, resamples;
  bool falling = false;
  bool hidden = false;
  bool in_pixels = false;
  bool json = false;
};

// The value of the choice that has this name.
template <typename T>
T chosen(const std::string& name, const std::string& option, const std::vector<std::pair<std::string, T>>& choices) {
  std::vector<std::string> names;
  for (const auto& [each, value] : choices) {
    if (each == name) return value;
    names.push_back(each);
  }
  const std::string near = nearest_name(name, names);
  throw Error(
      option, fmt::format("there is no '{}'", printable(name, 60)),
      near.empty() ? fmt::format("there are {}", fmt::join(names, ", ")) : fmt::format("did you mean '{}'?", near));
}

// Puts what the command line says in place of what a plan, or a default, says, and remembers where that is a change.
class Changes {
 public:
  template <typename T, typename Given>
  void take(T& value, const std::optional<Given>& given, const char* option) {
    if (!given) return;
    set(value, T(*given), option, fmt::format("{}", *given));
  }
  template <typename T>
  void choose(T& value, const std::string& given, const char* option,
              const std::vector<std::pair<std::string, T>>& choices) {
    if (!given.empty()) set(value, chosen<T>(given, option, choices), option, given);
  }
  template <typename T>
  void set(T& value, T to, const char* option, const std::string& text) {
    if (value != to) changed.push_back(text.empty() ? option : fmt::format("{} {}", option, text));
    value = to;
  }

  std::vector<std::string> changed;
};

// "free", "penalised", or a rate from 0 to `most` at which it is held.
void set_rate(const std::string& text, const std::string& option, double most, Rate& rate, double& value) {
  if (text == "free" || text == "penalised") {
    rate = text == "free" ? Rate::free : Rate::penalised;
    return;
  }
  size_t used = 0;
  double held = -1;
  try {
    held = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used != text.size() || !(held >= 0 && held <= most))
    throw Error(option, fmt::format("'{}' is not a rate from 0 to {:g}", printable(text, 60), most),
                "or free, or penalised");
  rate = Rate::fixed;
  value = held;
}

void change_rate(Changes& to, Rate& rate, double& value, const std::string& given, const char* option, double most) {
  if (given.empty()) return;
  Rate new_rate = rate;
  double new_value = value;
  set_rate(given, option, most, new_rate, new_value);
  if (new_rate != rate || (new_rate == Rate::fixed && new_value != value))
    to.changed.push_back(fmt::format("{} {}", option, printable(given, 60)));
  rate = new_rate;
  value = new_value;
}

void change_models(const StudyAnalyzeOptions& o, AnalysisSettings& s, Changes& to) {
  to.choose(s.curve.curve, o.curve, "--curve",
            {{"logistic", studies::Curve::logistic},
             {"cumgauss", studies::Curve::cumulative_gaussian},
             {"weibull", studies::Curve::weibull}});
  if (o.falling) to.set(s.curve.falling, true, "--falling", "");
  change_rate(to, s.curve.guess_rate, s.curve.guess, o.guess, "--guess", 0.95);
  change_rate(to, s.curve.lapse_rate, s.curve.lapse, o.lapse, "--lapse", 0.5);
  to.take(s.curve.level, o.level, "--level");
  if (!o.axis.empty()) to.set(s.axis.name, o.axis, "--level-name", printable(o.axis, 60));
  if (!o.axis.empty() || o.in_pixels)
    to.set(s.axis.in_pixels, o.in_pixels || axis_of_factor(s.axis.name).in_pixels, "--level-in-pixels", "");
  to.choose(s.random, o.random, "--random",
            {{"none", RandomEffects::none},
             {"intercept", RandomEffects::intercept},
             {"slope", RandomEffects::slope},
             {"independent-slope", RandomEffects::independent_slope}});
  to.choose(s.link, o.link, "--link", {{"logit", Link::logit}, {"probit", Link::probit}});
  to.choose(s.integration, o.integration, "--integration",
            {{"auto", std::nullopt},
             {"laplace", Integration::laplace},
             {"laplace-observed", Integration::laplace_observed},
             {"quadrature", Integration::quadrature}});
}

// In place of the settings `s`; says what that changes.
std::vector<std::string> change_settings(const StudyAnalyzeOptions& o, AnalysisSettings& s) {
  Changes to;
  to.choose(s.ties, o.ties, "--ties", {{"drop", TieRule::drop}, {"split", TieRule::split}, {"no", TieRule::no}});
  to.take(s.chance, o.chance, "--chance");
  to.take(s.margin, o.margin, "--margin");
  to.take(s.between, o.between, "--between");
  to.take(s.alpha, o.alpha, "--alpha");
  to.take(s.power, o.power, "--power");
  to.take(s.confidence, o.confidence, "--confidence");
  to.take(s.catch_least, o.catch_least, "--catch-least");
  to.take(s.trials.shortest_rt_ms, o.shortest_rt, "--shortest-rt");
  to.take(s.trials.most_frames_dropped, o.most_dropped, "--most-dropped");
  if (o.hidden) to.set(s.trials.hidden, true, "--leave-out-hidden", "");
  to.take(s.resamples, o.resamples, "--resamples");
  to.take(s.seed, o.seed, "--resample-seed");
  change_models(o, s, to);
  // Both are how often "yes" is said of what is not seen: of three alternatives, 1/3.
  if (!o.chance && !o.guess.empty() && o.plan.empty() && s.curve.guess_rate == Rate::fixed && s.curve.guess > 0)
    s.chance = s.curve.guess;
  if (s.margin && (s.chance - *s.margin < 0 || s.chance + *s.margin > 1))
    throw Error("--margin", fmt::format("{:g} about {:g} reaches beyond 0 or 1", *s.margin, s.chance),
                "choose a smaller margin");
  return to.changed;
}

// What "yes" stands for in the answers to an exported study. task: a plan's word; reference: what the half under test
// stands beside; empty: not known.
std::string meaning_of_yes(const std::string& task, const std::string& reference) {
  const std::string to = reference.empty() ? "the reference" : fmt::format("the reference, {}", reference);
  if (task == task_words()[static_cast<size_t>(Task::same_different)]) return "that the halves were called different";
  if (task == task_words()[static_cast<size_t>(Task::preference)])
    return fmt::format("that the half under test was chosen, and \"no\" {}", to);
  return fmt::format("that the half under test was named, and \"no\" {}", to);
}

// The plan's analysis and exclusions, and what it is now and was when it was frozen.
AnalysisSettings settings_of_plan(const std::string& file, PlanFacts& facts) {
  const StudyPlan plan = read_study_plan(file);
  facts.file = file;
  facts.hash = plan.hash();
  if (const std::optional<FrozenPlan> frozen = read_frozen(file)) {
    facts.frozen = frozen->hash;
    for (const Deviation& each : frozen->deviations) facts.deviations.push_back({each.hash, each.reason});
  }
  AnalysisSettings out = plan.analysis.settings;
  out.asked.text = plan.question_text;
  // Of pairs that are ranked both items are named.
  if (plan.method.method != Method::active_pairs)
    out.asked.yes = meaning_of_yes(task_words()[static_cast<size_t>(plan.task)], plan.reference.text());
  out.axis = axis_of_factor(plan.analysis.level);
  out.catch_least = plan.exclude.catch_least;
  out.trials.shortest_rt_ms = plan.exclude.shortest_rt_ms;
  // 0.29 of 100 frames are 29, whatever is lost in the product.
  out.trials.most_frames_dropped =
      static_cast<uint64_t>(std::floor(plan.exclude.most_dropped * static_cast<double>(plan.frames()) + 1e-9));
  out.trials.hidden = plan.exclude.hidden;
  return out;
}

// The answers that a study's server kept, by what was shown: the exported folder's sides.json says it. asked: set where
// it is not known yet.
Table kept_answers(const std::string& file, const std::string& study, AskedQuestion& asked) {
  const std::filesystem::path beside = std::filesystem::absolute(file).parent_path();
  const std::filesystem::path folder = study.empty() ? beside : std::filesystem::path(study);
  if (!std::filesystem::exists(folder / "sides.json"))
    throw Error(file, "is not in the folder of its study", "name that folder: --study OUT");
  const StudyFolder shown = read_study_folder(folder);
  if (asked.text.empty()) {
    asked.text = shown.question;
    const bool ranked = !shown.adaptive.empty() && shown.task == task_words()[static_cast<size_t>(Task::preference)];
    if (!ranked) asked.yes = meaning_of_yes(shown.task, "");
  }
  return parse_table(answers_csv(read_study_answers({file}, shown.study), folder), file);
}

Table rows_of(const std::string& file, const StudyAnalyzeOptions& o, AskedQuestion& asked) {
  const std::filesystem::path extension = std::filesystem::path(file).extension();
  const bool kept = extension == ".sqlite" || extension == ".json";
  Table out = kept ? kept_answers(file, o.study, asked) : read_table(file);
  for (const std::string& condition : o.where) {
    const size_t equals = condition.find('=');
    if (equals == std::string::npos)
      throw Error("--where", fmt::format("'{}' is not COLUMN=VALUE", printable(condition, 60)), "as task=trial");
    keep_rows(out, condition.substr(0, equals), condition.substr(equals + 1));
  }
  return out;
}

Answers read_answers(const StudyAnalyzeOptions& o, AskedQuestion& asked) {
  if (o.files.empty() && o.table.empty())
    throw Error("study analyze", "there are no answers to analyse",
                "give files whose columns have the names of roles, or --table FILE --columns MAP");
  Answers out;
  for (const std::string& file : o.files) {
    const Table table = rows_of(file, o, asked);
    add_answers(out, table, columns_by_name(table));
  }
  if (!o.table.empty()) {
    const Table table = rows_of(o.table, o, asked);
    add_answers(out, table, o.columns.empty() ? columns_by_name(table) : parse_column_map(o.columns, "--columns"));
  }
  return out;
}

void write_outputs(const StudyAnalyzeOptions& o, const StudyReport& report) {
  const std::filesystem::path folder = o.out;
  if (!o.out.empty()) make_folder(folder);
  const auto write = [&](const std::string& named, const char* in_folder, const std::string& text) {
    if (!named.empty()) write_file(named, std::string_view(text));
    if (!o.out.empty()) write_file(folder / in_folder, std::string_view(text));
  };
  if (!o.page.empty() || !o.out.empty()) write(o.page, "report.html", study_report_page(report));
  write(o.markdown, "report.md", study_report_markdown(report));
  if (!o.out.empty()) write("", "analysis.json", study_report_json(report).dump(2) + "\n");
  if (!o.exports.empty()) write_exports(report.analysis, o.exports);
}

int run_analyze(const StudyAnalyzeOptions& options) {
  AnalysisSettings settings;
  PlanFacts plan;
  if (!options.plan.empty()) settings = settings_of_plan(options.plan, plan);
  std::vector<std::string> changed = change_settings(options, settings);
  // Rows that were chosen, and columns that stand for others, are no part of a plan.
  for (const std::string& where : options.where) changed.push_back("--where " + where);
  if (!options.columns.empty()) changed.push_back("--columns " + options.columns);
  const ScoreTable scores = options.scores.empty() ? ScoreTable{} : read_scores(options.scores);
  StudyReport report;
  Answers answers = read_answers(options, settings.asked);
  if (!options.plan.empty()) report.standing = plan_standing(plan, answers, changed);
  report.analysis = analyse(std::move(answers), settings, scores);
  write_outputs(options, report);
  fmt::print("{}", options.json ? study_report_json(report).dump(2) + "\n" : study_report_plain(report));
  return 0;
}

void add_curve_options(Command& command, StudyAnalyzeOptions& o) {
  command.add_option("--curve", o.curve, "psychometric function: logistic (which it is), cumgauss or weibull")
      ->type_name("NAME");
  command.add_flag("--falling", o.falling, "a yes is rarer where the level is higher");
  command
      .add_option("--guess", o.guess,
                  "rate of yes where there is nothing to see: held at R (0.5), or free, or penalised; also the mixed "
                  "model's")
      ->type_name("R|free|penalised");
  command
      .add_option("--lapse", o.lapse, "rate of slips: held at R, or free up to 0.1, or so and penalised (which it is)")
      ->type_name("R|free|penalised");
  command.add_option("--level", o.level, "share of yes at which the threshold is (0.75)")
      ->type_name("SHARE")
      ->number(0.01, 0.99);
  command
      .add_option("--level-name", o.axis, "what the column `level` holds, for sentences and charts (a plan's factor)")
      ->type_name("NAME");
  command.add_flag("--level-in-pixels", o.in_pixels,
                   "levels are sizes in pixels of the clip (names that end in _px are): thresholds are told in degrees "
                   "of\nvisual angle, too, where the answers have `pixels_per_degree` and `pixels_per_degree_se`");
}

void add_mixed_options(Command& command, StudyAnalyzeOptions& o) {
  command
      .add_option("--random", o.random,
                  "of the mixed model, by participant: none (no model), intercept (which it is), slope, "
                  "independent-slope")
      ->type_name("NAME");
  command.add_option("--link", o.link, "of the mixed model: logit (which it is) or probit")->type_name("NAME");
  command
      .add_option("--integration", o.integration,
                  "of the mixed model: laplace, laplace-observed, quadrature (intercepts of participants alone), or "
                  "auto (which it is)")
      ->type_name("NAME");
}

void add_exclusion_options(Command& command, StudyAnalyzeOptions& o) {
  command
      .add_option("--catch-least", o.catch_least, "share of catch trials that a participant must get right to stay (0)")
      ->type_name("SHARE")
      ->number(0, 1);
  command.add_option("--shortest-rt", o.shortest_rt, "leave out trials that were answered sooner (0)")
      ->type_name("MS")
      ->number(0, 1e6);
  command.add_option("--most-dropped", o.most_dropped, "leave out trials of which more frames were not shown")
      ->type_name("FRAMES")
      ->whole_number(0, 1000000);
  command.add_flag("--leave-out-hidden", o.hidden, "leave out trials during which the page was out of sight");
}

void add_test_options(Command& command, StudyAnalyzeOptions& o) {
  command
      .add_option("--chance", o.chance,
                  "share of yes where nothing is seen, for tests and equivalence (without a plan R of --guess above 0; "
                  "else 0.5)")
      ->type_name("SHARE")
      ->number(0, 1);
  command
      .add_option("--ties", o.ties,
                  "what \"cannot tell\" counts as: drop (which it is), split or no; the ranking models it")
      ->type_name("RULE");
  command.add_option("--margin", o.margin, "margin of equivalence about chance; without it no verdict is given")
      ->type_name("SHARE")
      ->number(0.001, 0.5);
  command.add_option("--between", o.between, "margin of equivalence of every two conditions' shares")
      ->type_name("SHARE")
      ->number(0.001, 0.99);
  command.add_option("--alpha", o.alpha, "level of the tests of equivalence (0.05)")
      ->type_name("P")
      ->number(1e-6, 0.49);
  command.add_option("--power", o.power, "that \"how many more\" is for (0.8)")->type_name("P")->number(0.01, 0.999);
  command.add_option("--confidence", o.confidence, "of the intervals (0.95)")->type_name("P")->number(0.5, 0.9999);
  command.add_option("--resamples", o.resamples, "of bootstrap intervals (1000); 0: none")
      ->type_name("N")
      ->whole_number(0, 100000);
  command.add_option("--resample-seed", o.seed, "seed of the bootstrap (1)")
      ->type_name("N")
      ->whole_number(0, UINT64_MAX);
}

void add_output_options(Command& command, StudyAnalyzeOptions& o) {
  command.add_option("--markdown", o.markdown, "the tables as a page of text")->type_name("FILE.md")->output_file();
  command.add_option("--page", o.page, "the report with charts, one self-contained page")
      ->type_name("FILE.html")
      ->output_file();
  command.add_option("--out", o.out, "report.html, report.md and analysis.json in this folder; made where missing")
      ->type_name("DIR")
      ->output_folder();
  command
      .add_option(
          "--export", o.exports,
          "the answers in other tools' forms (pwcmp, psignifit, a Psych-DS-like data set) and an R script that\n"
          "repeats the mixed models by lme4; made where missing")
      ->type_name("DIR")
      ->output_folder();
  add_json_option(command, o.json);
}

void add_options(Command& command, StudyAnalyzeOptions& o) {
  command
      .add_option("ANSWERS", o.files,
                  "tables whose columns have the names of roles, or what `study serve` kept or the page saved")
      ->type_name("FILE.csv|FILE.sqlite|FILE.json");
  command
      .add_option("--study", o.study, "folder that `study export` made, where FILE.sqlite or FILE.json is not in it")
      ->type_name("OUT");
  command.add_option("--table", o.table, "a table of any other columns")->type_name("FILE.csv");
  command.add_option("--columns", o.columns, "which column of --table plays which role, ROLE=COLUMN,ROLE=COLUMN,...")
      ->type_name("MAP");
  command.add_option("--where", o.where, "only rows with this value in this column; may be given several times")
      ->type_name("COLUMN=VALUE")
      ->expected(1)
      ->take_all();
  command
      .add_option("--plan", o.plan,
                  "the study's plan: its analysis and its exclusions; says whether this is what was frozen, and what "
                  "deviates")
      ->type_name("PLAN.toml");
  command
      .add_option("--scores", o.scores,
                  "objective scores to be held against the answers: study.json of `study export`, or a table with a "
                  "column\n`stimulus`, `clip`, `condition` or `item` and one a score")
      ->type_name("FILE");
  add_test_options(command, o);
  add_curve_options(command, o);
  add_mixed_options(command, o);
  add_exclusion_options(command, o);
  add_output_options(command, o);
}

}  // namespace

void add_study_analyze(Command& study, Run& run) {
  Command* command = study.add_subcommand("analyze", "Thresholds, rankings and verdicts of answers, with intervals");
  command->footer(
      "Roles of columns: participant, trial, task, condition, clip, stimulus, level, signal, item_a, item_b, "
      "shown_first,\n"
      "answer, expected, yes, no, ties, total, rt, frames_dropped, hidden, study (the plan's hash), catch,\n"
      "pixels_per_degree, pixels_per_degree_se, css_px_per_clip_px, yes_first. `answer`, or counts\n"
      "(`yes` and `no` or `total`), is needed; what else there is decides what is analysed: `level` a psychometric\n"
      "function, `item_a` and `item_b` a ranking, `participant` a mixed model.\n\nExamples:\n"
      "  crowdbench study analyze answers.csv --margin 0.1 --markdown answers.md\n"
      "  crowdbench study analyze out/answers.sqlite --plan study.toml --json\n"
      "  crowdbench study analyze --table trials.csv --columns participant=who,level=distance_m,answer=seen --guess 0\n"
      "  crowdbench study analyze answers.csv --plan study.toml --scores out/study.json --out report\n"
      "  crowdbench study analyze --table pairs.csv --columns item_a=left,item_b=right,shown_first=left,answer=choice "
      "--json");
  auto options = std::make_shared<StudyAnalyzeOptions>();
  add_options(*command, *options);
  command->callback([options, &run] { run = [options] { return run_analyze(*options); }; });
}

}  // namespace crowdbench::bench
