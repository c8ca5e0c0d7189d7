#include "studies/plan/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/files.h"
#include "scene/cast/scenario_table.h"
#include "scene/scenario/parse_scenario.h"
#include "scene/scenario/scenario_changes.h"
#include "scene/scenario/scenario_keys.h"
#include "scene/scenario/toml_table.h"
#include "studies/plan/default_texts.h"
#include "studies/plan/design.h"
#include "studies/plan/factors.h"

namespace crowdbench::studies {
namespace {

using scene::TomlNode;
using scene::TomlTable;

// Reads one plan from top to bottom; what makes no sense together is refused where the later of the two stands.
class PlanReader {
 public:
  PlanReader(const TomlNode& document, std::string where, std::filesystem::path folder)
      : document_(document), where_(std::move(where)), folder_(std::move(folder)) {
    document_.line = 1;
  }

  StudyPlan run() {
    const TomlTable top(document_, "", where_,
                        {"name", "title", "seed", "question", "scenario", "conditions", "factors", "stimulus", "method",
                         "catch", "training", "participants", "exclude", "analysis"});
    plan_.where = where_;
    plan_.folder = folder_;
    plan_.name = std::filesystem::path(where_).stem().string();
    top.text("name", plan_.name);
    top.whole("seed", 0, INT64_MAX, plan_.seed);
    top.whole("training", 0, 20, plan_.training);
    read_question(table("question"));
    plan_.title = plan_.question_text;
    top.text("title", plan_.title);
    read_stimulus(table("stimulus"));
    read_conditions();
    read_method(table("method"));
    read_catch(table("catch"));
    read_analysis(table("analysis"));
    read_participants(table("participants"));
    read_exclude(table("exclude"));
    read_texts(table("question"));
    return std::move(plan_);
  }

 private:
  // An empty table where it is missing.
  const TomlNode& table(const char* name) const {
    static const TomlNode none;
    const TomlNode* const node = document_.find(name);
    return node == nullptr ? none : *node;
  }

  renderers::Spec spec(const TomlTable& from, const char* key, const renderers::Spec& otherwise) const {
    std::string text;
    from.text(key, text);
    if (text.empty()) return otherwise;
    try {
      return renderers::parse_spec(renderers::parse_spec(text).text());
    } catch (const Error& error) {
      throw Error(from.place(key), fmt::format("`{}`: {}", key, error.wrong), error.advice);
    }
  }

  void read_question(const TomlNode& node) {
    const TomlTable t(node, "question", where_, {"ask", "task", "text", "consent", "instructions", "debrief"});
    t.choice("ask", question_words(), plan_.question);
    t.choice("task", task_words(), plan_.task);
    if (plan_.task == Task::same_different && plan_.question != Question::differs)
      throw Error(
          t.place("task"),
          fmt::format("`same-different` does not ask \"{}\"", question_words()[static_cast<size_t>(plan_.question)]),
          "set ask = \"differs\", or choose another task");
    if (plan_.task == Task::preference && plan_.question == Question::pop)
      throw Error(t.place("task"), "whether something popped is seen or not, and nothing that one prefers",
                  "set task = \"forced-choice\", or ask = \"better\"");
    plan_.question_text = default_question(plan_.question, plan_.task);
    t.text("text", plan_.question_text);
  }

  void read_stimulus(const TomlNode& node) {
    StimulusSettings& s = plan_.stimulus;
    const TomlTable t(node, "stimulus", where_,
                      {"seconds", "fps", "lead_in_seconds", "seeds", "crowds", "largest_px", "intersect", "bar_px",
                       "replays", "least_psnr", "artefact_share"});
    t.number("seconds", 0.1, 600, s.seconds);
    t.whole("fps", 1, 240, s.fps);
    t.number("lead_in_seconds", 0, 60, s.lead_in_seconds);
    t.choice("seeds", seeds_words(), s.seeds);
    t.whole("crowds", 1, 64, s.crowds);
    t.number("largest_px", 4, 4096, s.largest_px);
    t.flag("intersect", s.intersect);
    t.whole("bar_px", 4, 256, s.bar_px);
    if (s.bar_px % 2 != 0) throw Error(t.place("bar_px"), "`bar_px` is odd", "give an even number");
    t.whole("replays", 0, 100, s.replays);
    t.number("least_psnr", 20, 80, s.least_psnr);
    t.number("artefact_share", 0.01, 0.5, s.artefact_share);
    const double frames = s.seconds * s.fps;
    if (std::abs(frames - std::round(frames)) > 1e-6)
      throw Error(t.place("seconds"), fmt::format("{} s are not a whole number of frames at {} fps", s.seconds, s.fps),
                  "change `seconds` or `fps`");
  }

  void read_conditions() {
    StudyCondition base;
    scene::Scenario& scenario = base.scenario;
    scene::KeyPlaces places;
    scenario.ground = true;
    scenario.crowd.motion = scene::MotionKind::lanes;
    if (const TomlNode* const node = document_.find("scenario")) {
      if (!node->is_table())
        throw Error(node->place(where_), fmt::format("`scenario` is {}", node->type_name()), "write [scenario]");
      scene::change_by_table(scenario, *node, where_, folder_, &places);
    }
    const auto place = [&](const char* key) {
      const auto found = places.find(key);
      return found == places.end() ? table("scenario").place(where_) : found->second;
    };
    if (places.contains("representation"))
      throw Error(place("representation"), "`representation` of the scenario is not what a study draws",
                  "give [conditions] `reference` and `test`");

    base.spacing_by_bodies = !places.contains("crowd.spacing");

    const TomlTable t(table("conditions"), "conditions", where_, {"reference", "test"});
    plan_.reference = spec(t, "reference", renderers::reference_spec());
    base.test = spec(t, "test", plan_.reference);
    std::vector<ReadFactor> factors;
    if (const TomlNode* const node = document_.find("factors")) factors = read_factors(*node, where_, folder_);
    const bool chosen = t.find("test") != nullptr || std::any_of(factors.begin(), factors.end(), [](const auto& f) {
                          return f.factor.name == "representation";
                        });
    if (!chosen)
      throw Error(t.place("test"), "nothing is held against the reference",
                  "give [conditions] `test`, or the factor `representation`");
    for (const ReadFactor& factor : factors) plan_.factors.push_back(factor.factor);
    plan_.conditions = combine_factors(factors, base);
    if (plan_.conditions.size() == 1) plan_.conditions[0].name = "test=" + plan_.conditions[0].test.text();
    for (StudyCondition& condition : plan_.conditions) check_condition(condition, place);
    const auto is_reference = [&](const StudyCondition& c) {
      return !c.pixels_per_texel && c.test.text() == plan_.reference.text();
    };
    if (std::all_of(plan_.conditions.begin(), plan_.conditions.end(), is_reference))
      throw Error(t.place("test"), fmt::format("the reference, {}, is held against itself", plan_.reference.text()),
                  "give another `test`, or factors of its options");
    const scene::Scenario& first = plan_.conditions[0].scenario;
    for (const StudyCondition& condition : plan_.conditions)
      if (condition.scenario.width != first.width || condition.scenario.height != first.height)
        throw Error(place("factors"), fmt::format("the picture's size varies ({})", condition.name),
                    "all clips of a study have one size; vary `height_px`, the figures' own");
  }

  void check_condition(StudyCondition& condition, const std::function<std::string(const char*)>& place) {
    scene::Scenario& scenario = condition.scenario;
    const auto fail = [&](const char* key, const std::string& wrong, const std::string& advice) {
      throw Error(place(key), fmt::format("{} ({})", wrong, condition.name), advice);
    };
    scene::check_scenario(scenario, place);
    scenario.representation = "reference";
    if (scenario.occupancy)
      fail("occupancy", "`occupancy` moves camera and crowd until a share of the picture is covered",
           "give the camera, or the factor `height_px`");
    if (scenario.crowd.motion == scene::MotionKind::treadmill && scenario.ground)
      fail("crowd.motion", "a crowd that walks on the spot over a ground shows sliding feet",
           "set crowd.motion = \"lanes\", or ground = false");
    const double ticks = scenario.tick_rate / plan_.stimulus.fps;
    if (ticks < 1 || ticks != std::floor(ticks))
      fail("tick_rate",
           fmt::format("{} ticks a second do not divide into {} frames", scenario.tick_rate, plan_.stimulus.fps),
           "make `tick_rate` a multiple of [stimulus] `fps`");
    if (scenario.width % 2 != 0 || scenario.height % 2 != 0)
      fail(
          scenario.width % 2 != 0 ? "width" : "height",
          fmt::format("a picture of {}x{} has an odd side, which video does not have", scenario.width, scenario.height),
          "make both even");
    if (scenario.width < 16 || scenario.height < 16 || scenario.width > 8192 ||
        2 * scenario.height + plan_.stimulus.bar_px > 8192)
      fail("width", fmt::format("two pictures of {}x{} do not fit into a clip", scenario.width, scenario.height),
           "choose sides of 16 to 4000 pixels");
    if (condition.height_px && *condition.height_px > plan_.stimulus.largest_px)
      fail("factors",
           fmt::format("figures of {} pixels are taller than `largest_px` = {}", *condition.height_px,
                       plan_.stimulus.largest_px),
           "lower `height_px`, or raise [stimulus] `largest_px`");
  }

  // What varies is what draws, and nothing else.
  bool one_scene() const {
    return std::all_of(plan_.conditions.begin(), plan_.conditions.end(), [&](const StudyCondition& c) {
      return c.scenario == plan_.conditions[0].scenario && c.height_px == plan_.conditions[0].height_px &&
             !c.pixels_per_texel;
    });
  }

  void read_method(const TomlNode& node) {
    MethodSettings& m = plan_.method;
    const TomlTable t(node, "method", where_, {"kind", "repeats", "blocks", "trials"});
    t.choice("kind", method_words(), m.method);
    t.whole("repeats", 1, 100, m.repeats);
    t.whole("blocks", 1, 50, m.blocks);
    t.whole("trials", 1, 2000, m.trials);
    const auto fail = [&](const char* key, const std::string& wrong, const std::string& advice) {
      throw Error(t.place(key), wrong, advice);
    };
    if (m.method == Method::constant) {
      if (m.trials > 0)
        fail("trials", "`trials` follows from conditions, crowds and repeats", "leave it out, or change those");
      return check_blocks(t);
    }
    if (m.trials == 0)
      fail("kind", "the method chooses trials until there are so many, and `trials` is missing", "add trials = 40");
    check_blocks(t);
    if (m.method == Method::quest_plus) {
      if (plan_.task == Task::preference)
        fail("kind", "QUEST+ needs a right answer, and `preference` has none", "choose the task forced-choice");
      if (plan_.factors.size() != 1 || !finite_levels(plan_.factors[0]) || plan_.factors[0].levels.size() < 3)
        fail("kind", "QUEST+ needs one factor of three or more finite numbers, and no other",
             "give [factors] one such list");
      return;
    }
    if (plan_.question != Question::better || plan_.task == Task::same_different)
      fail("kind", "active pairs rank what looks better", "set ask = \"better\" and another task");
    if (!one_scene() || plan_.conditions.size() < 2)
      fail("kind", "active pairs compare representations within one scene",
           "let `representation`, options or `switch_m` be the only factors, with two levels or more");
  }

  void check_blocks(const TomlTable& t) const {
    const uint64_t trials = main_trials(plan_);
    if (plan_.method.blocks > trials)
      throw Error(t.place("blocks"), fmt::format("{} blocks of {} trials", plan_.method.blocks, trials), "give fewer");
  }

  static bool finite_levels(const Factor& factor) {
    return std::all_of(factor.levels.begin(), factor.levels.end(),
                       [](const FactorLevel& level) { return level.number && std::isfinite(*level.number); });
  }

  void read_catch(const TomlNode& node) {
    CatchSettings& c = plan_.catch_trials;
    const TomlTable t(node, "catch", where_, {"identical", "broken", "broken_by"});
    if (plan_.task == Task::same_different) c.identical = 0;
    t.whole("identical", 0, 50, c.identical);
    t.whole("broken", 0, 50, c.broken);
    if (plan_.task == Task::same_different && c.identical > 0)
      throw Error(t.place("identical"), "half of all same-different trials are identical already", "leave it out");
    c.broken_by = spec(t, "broken_by", renderers::with_floor(plan_.reference));
    if (c.broken_by.text() == plan_.reference.text())
      throw Error(t.place("broken_by"), "`broken_by` is the reference", "choose what anybody sees");
  }

  void read_participants(const TomlNode& node) {
    ParticipantSettings& p = plan_.participants;
    const TomlTable t(node, "participants", where_, {"planned", "lists", "calibration", "demographics"});
    const uint32_t whole = balanced_lists(plan_);
    p.lists = whole;
    t.whole("lists", 1, 1000, p.lists);
    if (p.lists % whole != 0)
      throw Error(t.place("lists"),
                  fmt::format("{} lists do not balance orders and sides of {} conditions", p.lists, order_items(plan_)),
                  fmt::format("give a multiple of {}", whole));
    p.planned = p.lists;
    t.whole("planned", 1, 100'000, p.planned);
    if (p.planned % p.lists != 0)
      throw Error(t.place("planned"), fmt::format("{} participants do not fill {} lists evenly", p.planned, p.lists),
                  fmt::format("plan {}", (p.planned / p.lists + 1) * p.lists));
    t.flag("calibration", p.calibration);
    t.texts("demographics", p.demographics);
    const uint64_t trials = trials_of_participant(plan_);
    if (trials > 2000)
      throw Error(node.place(where_), fmt::format("{} trials a participant", trials),
                  "give fewer conditions, crowds or repeats");
  }

  void read_exclude(const TomlNode& node) {
    ExclusionRules& e = plan_.exclude;
    const TomlTable t(node, "exclude", where_, {"catch_least", "shortest_rt_ms", "most_dropped", "hidden"});
    if (plan_.catch_trials.broken == 0) e.catch_least = 0;
    t.number("catch_least", 0, 1, e.catch_least);
    t.number("shortest_rt_ms", 0, 60'000, e.shortest_rt_ms);
    t.number("most_dropped", 0, 1, e.most_dropped);
    t.flag("hidden", e.hidden);
    if (e.catch_least > 0 && plan_.catch_trials.broken == 0)
      throw Error(t.place("catch_least"), "there are no broken catch trials to get right",
                  "set [catch] `broken`, or leave this out");
  }

  void set_rate(const TomlTable& t, const char* key, double most, Rate& rate, double& value) const {
    const TomlNode* const node = t.find(key);
    if (node == nullptr) return;
    if (node->is_text() && (node->text == "free" || node->text == "penalised")) {
      rate = node->text == "free" ? Rate::free : Rate::penalised;
      return;
    }
    t.number(key, 0, most, value);
    rate = Rate::fixed;
  }

  void read_analysis(const TomlNode& node) {
    PlannedAnalysis& a = plan_.analysis;
    AnalysisSettings& s = a.settings;
    const TomlTable t(node, "analysis", where_,
                      {"level", "curve", "falling", "guess", "lapse", "threshold", "ties", "random", "link", "margin",
                       "alpha", "power", "confidence", "resamples", "seed"});
    s.chance = 0.5;
    s.curve.guess = s.chance;
    // How often "different" is said of halves that are alike is what a participant likes to say, and no chance level.
    if (plan_.task == Task::same_different) s.curve.guess_rate = Rate::free;
    t.choice("curve", {"logistic", "cumgauss", "weibull"}, s.curve.curve);
    t.flag("falling", s.curve.falling);
    set_rate(t, "guess", 0.95, s.curve.guess_rate, s.curve.guess);
    set_rate(t, "lapse", 0.5, s.curve.lapse_rate, s.curve.lapse);
    t.number("threshold", 0.01, 0.99, s.curve.level);
    t.choice("ties", {"drop", "split", "no"}, s.ties);
    t.choice("random", {"none", "intercept", "slope", "independent-slope"}, s.random);
    t.choice("link", {"logit", "probit"}, s.link);
    t.number("margin", 0.001, 0.5, s.margin);
    t.number("alpha", 1e-6, 0.49, s.alpha);
    t.number("power", 0.01, 0.999, s.power);
    t.number("confidence", 0.5, 0.9999, s.confidence);
    s.curve.confidence = s.confidence;
    t.whole("resamples", 0, 100'000, s.resamples);
    t.whole("seed", 0, INT64_MAX, s.seed);
    if (t.find("ties") != nullptr && plan_.task != Task::preference)
      throw Error(t.place("ties"), "`ties` is a rule for \"cannot tell\", which only `preference` has", "leave it out");
    if (s.margin && plan_.task == Task::same_different)
      throw Error(t.place("margin"), "same-different answers have no chance level to be equivalent to",
                  "choose another task");
    if (s.margin && (s.chance - *s.margin < 0 || s.chance + *s.margin > 1))
      throw Error(t.place("margin"), fmt::format("{} about {} reaches beyond 0 or 1", *s.margin, s.chance),
                  "choose a smaller margin");
    set_level(t);
    if (plan_.method.method == Method::quest_plus) check_grid(t);
  }

  // What QUEST+ computes with.
  void check_grid(const TomlTable& t) const {
    const CurveSettings& curve = plan_.analysis.settings.curve;
    const double lapse = curve.lapse_rate == Rate::fixed ? curve.lapse : curve.most_lapse;
    const double guess = curve.guess_rate == Rate::fixed ? curve.guess : curve.most_guess;
    if (guess + lapse >= 1)
      throw Error(t.place("guess"), fmt::format("guess {:g} and lapse {:g} leave nothing to see", guess, lapse),
                  "give smaller ones: their sum is to be below 1");
    if (curve.curve != Curve::weibull) return;
    for (const StudyCondition& condition : plan_.conditions)
      if (*condition.level < 0)
        throw Error(t.place("curve"), fmt::format("a Weibull function has no value at {:g}", *condition.level),
                    "choose logistic or cumgauss");
  }

  void set_level(const TomlTable& t) {
    PlannedAnalysis& a = plan_.analysis;
    t.text("level", a.level);
    if (a.level.empty() && plan_.method.method == Method::quest_plus) a.level = plan_.factors[0].name;
    if (a.level.empty()) {
      for (const char* const key : {"curve", "falling", "threshold"})
        if (t.find(key) != nullptr)
          throw Error(t.place(key), fmt::format("`{}` is of the psychometric function, and `level` is missing", key),
                      "name the factor that it is over: level = \"switch_m\"");
      return;
    }
    std::vector<std::string> names;
    for (const Factor& factor : plan_.factors) names.push_back(factor.name);
    const auto found = std::find(names.begin(), names.end(), a.level);
    if (found == names.end()) {
      const std::string near = nearest_name(a.level, names);
      throw Error(t.place("level"), fmt::format("there is no factor `{}`", printable(a.level, 60)),
                  near.empty() ? "name one of [factors]" : fmt::format("did you mean `{}`?", near));
    }
    const auto index = static_cast<size_t>(found - names.begin());
    size_t finite = 0;
    for (const FactorLevel& level : plan_.factors[index].levels) {
      if (!level.number)
        throw Error(t.place("level"),
                    fmt::format("`{}` has the level '{}', which is not a number", a.level, level.text),
                    "a psychometric function is over numbers");
      finite += std::isfinite(*level.number) ? 1 : 0;
    }
    if (finite < 2)
      throw Error(t.place("level"), fmt::format("`{}` has fewer than two finite levels", a.level), "give more");
    for (StudyCondition& condition : plan_.conditions)
      if (std::isfinite(*condition.levels[index].number)) condition.level = condition.levels[index].number;
  }

  void read_texts(const TomlNode& node) {
    const TomlTable t(node, "question", where_, {"ask", "task", "text", "consent", "instructions", "debrief"});
    const auto read = [&](const char* key, const std::string& otherwise, std::string& out) {
      std::string file;
      t.text(key, file);
      out = otherwise;
      if (file.empty()) return;
      try {
        out = read_text(folder_ / file, size_t{256} << 10);
      } catch (const Error& error) {
        throw Error(t.place(key), fmt::format("`{}`: {}: {}", key, error.where, error.wrong),
                    "its path is seen from the plan's folder");
      }
    };
    read("consent", default_consent(), plan_.consent);
    read("instructions", default_instructions(plan_), plan_.instructions);
    read("debrief", default_debrief(), plan_.debrief);
  }

  TomlNode document_;
  std::string where_;
  std::filesystem::path folder_;
  StudyPlan plan_;
};

}  // namespace

const std::vector<std::string>& question_words() {
  static const std::vector<std::string> words = {"better", "differs", "pop"};
  return words;
}
const std::vector<std::string>& task_words() {
  static const std::vector<std::string> words = {"forced-choice", "preference", "same-different"};
  return words;
}
const std::vector<std::string>& method_words() {
  static const std::vector<std::string> words = {"constant", "quest-plus", "active-pairs"};
  return words;
}
const std::vector<std::string>& seeds_words() {
  static const std::vector<std::string> words = {"same", "independent"};
  return words;
}

size_t StudyPlan::frames() const { return static_cast<size_t>(std::llround(stimulus.seconds * stimulus.fps)); }

StudyPlan parse_study_plan(const std::string& toml, const std::string& where, const std::filesystem::path& folder) {
  return PlanReader(scene::parse_toml(toml, where), where, folder).run();
}

StudyPlan read_study_plan(const std::filesystem::path& file) {
  return parse_study_plan(read_text(file, scene::kScenarioBytes), file.string(), file.parent_path());
}

}  // namespace crowdbench::studies
