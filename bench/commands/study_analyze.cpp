#include <fmt/format.h>

#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/options.h"
#include "bench/commands/study.h"
#include "core/error.h"
#include "core/files.h"
#include "core/json.h"
#include "studies/analysis/analysis.h"
#include "studies/analysis/analysis_output.h"

namespace crowdbench::bench {
namespace {

using namespace studies;

struct Options {
  std::vector<std::string> files, where;
  std::string table, columns, markdown;
  std::string ties = "drop";
  std::string curve = "logistic";
  std::string guess = "0.5";
  std::string lapse = "penalised";
  std::string random = "intercept";
  std::string link = "logit";
  std::string integration = "auto";
  std::optional<double> margin;
  uint64_t seed = 1;
  AnalysisSettings settings;
  bool falling = false;
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
  throw Error(option, fmt::format("there is no '{}'", printable(name, 60)),
              fmt::format("there are {}", nearest_first(name, names)));
}

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

AnalysisSettings settings_of(const Options& o) {
  AnalysisSettings s = o.settings;
  s.seed = o.seed;
  s.margin = o.margin;
  s.ties = chosen<TieRule>(o.ties, "--ties", {{"drop", TieRule::drop}, {"split", TieRule::split}, {"no", TieRule::no}});
  s.curve.curve = chosen<studies::Curve>(o.curve, "--curve",
                                         {{"logistic", studies::Curve::logistic},
                                          {"cumgauss", studies::Curve::cumulative_gaussian},
                                          {"weibull", studies::Curve::weibull}});
  s.curve.falling = o.falling;
  set_rate(o.guess, "--guess", 0.95, s.curve.guess_rate, s.curve.guess);
  set_rate(o.lapse, "--lapse", 0.5, s.curve.lapse_rate, s.curve.lapse);
  s.random = chosen<RandomEffects>(o.random, "--random",
                                   {{"none", RandomEffects::none},
                                    {"intercept", RandomEffects::intercept},
                                    {"slope", RandomEffects::slope},
                                    {"independent-slope", RandomEffects::independent_slope}});
  s.link = chosen<Link>(o.link, "--link", {{"logit", Link::logit}, {"probit", Link::probit}});
  s.integration = chosen<std::optional<Integration>>(o.integration, "--integration",
                                                     {{"auto", std::nullopt},
                                                      {"laplace", Integration::laplace},
                                                      {"laplace-observed", Integration::laplace_observed},
                                                      {"quadrature", Integration::quadrature}});
  if (s.margin && (s.chance - *s.margin < 0 || s.chance + *s.margin > 1))
    throw Error("--margin", fmt::format("{:g} about {:g} reaches beyond 0 or 1", *s.margin, s.chance),
                "choose a smaller margin");
  return s;
}

Table rows_of(const std::string& file, const Options& o) {
  Table out = read_table(file);
  for (const std::string& condition : o.where) {
    const size_t equals = condition.find('=');
    if (equals == std::string::npos)
      throw Error("--where", fmt::format("'{}' is not COLUMN=VALUE", printable(condition, 60)), "as task=trial");
    keep_rows(out, condition.substr(0, equals), condition.substr(equals + 1));
  }
  return out;
}

Answers read_answers(const Options& o) {
  if (o.files.empty() && o.table.empty())
    throw Error("study analyze", "there are no answers to analyse",
                "give files whose columns have the names of roles, or --table FILE --columns MAP");
  Answers out;
  for (const std::string& file : o.files) {
    const Table table = rows_of(file, o);
    add_answers(out, table, columns_by_name(table));
  }
  if (!o.table.empty()) {
    const Table table = rows_of(o.table, o);
    add_answers(out, table, o.columns.empty() ? columns_by_name(table) : parse_column_map(o.columns, "--columns"));
  }
  return out;
}

int run_analyze(const Options& options) {
  const AnalysisSettings settings = settings_of(options);
  const Analysis analysis = analyse(read_answers(options), settings);
  const std::string markdown = analysis_markdown(analysis);
  if (!options.markdown.empty()) write_file(options.markdown, std::string_view(markdown));
  fmt::print("{}", options.json ? analysis_json(analysis).dump(2) + "\n" : markdown);
  return 0;
}

void add_curve_options(Command& command, Options& o) {
  command.add_option("--curve", o.curve, "psychometric function: logistic, cumgauss or weibull")
      ->type_name("NAME")
      ->capture_default_str();
  command.add_flag("--falling", o.falling, "a yes is rarer where the level is higher");
  command
      .add_option("--guess", o.guess,
                  "rate of yes where there is nothing to see: held at R, or free, or penalised; also the mixed model's")
      ->type_name("R|free|penalised")
      ->capture_default_str();
  command.add_option("--lapse", o.lapse, "rate of slips: held at R, or free up to 0.1, or so and penalised")
      ->type_name("R|free|penalised")
      ->capture_default_str();
  command.add_option("--level", o.settings.curve.level, "share of yes at which the threshold is")
      ->capture_default_str()
      ->number(0.01, 0.99);
}

void add_mixed_options(Command& command, Options& o) {
  command
      .add_option("--random", o.random,
                  "of the mixed model, by participant: none (no model), intercept, slope, independent-slope")
      ->type_name("NAME")
      ->capture_default_str();
  command.add_option("--link", o.link, "of the mixed model: logit or probit")->type_name("NAME")->capture_default_str();
  command
      .add_option(
          "--integration", o.integration,
          "of the mixed model: laplace, laplace-observed, quadrature (intercepts of participants alone), or auto")
      ->type_name("NAME")
      ->capture_default_str();
}

void add_options(Command& command, Options& o) {
  command.add_option("ANSWERS", o.files, "tables whose columns have the names of roles")->type_name("FILE.csv");
  command.add_option("--table", o.table, "a table of any other columns")->type_name("FILE.csv");
  command.add_option("--columns", o.columns, "which column of --table plays which role, ROLE=COLUMN,ROLE=COLUMN,...")
      ->type_name("MAP");
  command.add_option("--where", o.where, "only rows with this value in this column; may be given several times")
      ->type_name("COLUMN=VALUE")
      ->expected(1)
      ->take_all();
  command.add_option("--chance", o.settings.chance, "share of yes where nothing is seen, for tests and equivalence")
      ->capture_default_str()
      ->number(0, 1);
  command.add_option("--ties", o.ties, "what \"cannot tell\" counts as: drop, split or no; the ranking models it")
      ->type_name("RULE")
      ->capture_default_str();
  command.add_option("--margin", o.margin, "margin of equivalence about chance; without it no verdict is given")
      ->number(0.001, 0.5);
  command.add_option("--alpha", o.settings.alpha, "level of the tests of equivalence")
      ->capture_default_str()
      ->number(1e-6, 0.49);
  command.add_option("--power", o.settings.power, "that \"how many more\" is for")
      ->capture_default_str()
      ->number(0.01, 0.999);
  command.add_option("--confidence", o.settings.confidence, "of the intervals")
      ->capture_default_str()
      ->number(0.5, 0.9999);
  add_curve_options(command, o);
  add_mixed_options(command, o);
  command
      .add_option("--catch-least", o.settings.catch_least,
                  "share of catch trials that a participant must get right to stay")
      ->capture_default_str()
      ->number(0, 1);
  command.add_option("--resamples", o.settings.resamples, "of bootstrap intervals; 0: none")
      ->capture_default_str()
      ->whole_number(0, 100000);
  command.add_option("--resample-seed", o.seed, "seed of the bootstrap")
      ->capture_default_str()
      ->whole_number(0, UINT64_MAX);
  command.add_option("--markdown", o.markdown, "the tables as a page")->type_name("FILE.md")->output_file();
  add_json_option(command, o.json);
}

}  // namespace

void add_study_analyze(Command& study, Run& run) {
  Command* command = study.add_subcommand("analyze", "Thresholds, rankings and verdicts of answers, with intervals");
  command->footer(
      "Roles of columns: participant, trial, task, condition, clip, level, signal, item_a, item_b, shown_first, "
      "answer,\n"
      "expected, yes, no, ties, total, rt, catch. `answer`, or counts (`yes` and `no` or `total`), is needed; what "
      "else there\n"
      "is decides what is analysed: `level` a psychometric function, `item_a` and `item_b` a ranking, `participant` a\n"
      "mixed model.\n\nExamples:\n"
      "  crowdbench study analyze answers.csv --margin 0.1 --markdown answers.md\n"
      "  crowdbench study analyze --table trials.csv --columns participant=who,level=distance_m,answer=seen --guess 0\n"
      "  crowdbench study analyze --table pairs.csv --columns item_a=left,item_b=right,shown_first=left,answer=choice "
      "--json");
  auto options = std::make_shared<Options>();
  add_options(*command, *options);
  command->callback([options, &run] { run = [options] { return run_analyze(*options); }; });
}

}  // namespace crowdbench::bench
