#include "studies/plan/page_files.h"

#include <fmt/format.h>

#include "core/files.h"
#include "core/version.h"
#include "scene/scenario/scenario_writer.h"
#include "studies/plan/adaptive.h"
#include "studies/stimuli/clip.h"
#include "studies/stimuli/stack.h"

namespace crowdbench::studies {
namespace {

Json vector_json(const glm::dvec3& v) { return Json::array({v.x, v.y, v.z}); }
Json text_or_null(const std::string& text) { return text.empty() ? Json() : Json(text); }

Json answers_json(Task task) {
  Json out = Json::array();
  for (const AnswerChoice& answer : answer_choices(task))
    out.push_back({{"value", answer.value}, {"label", answer.label}, {"key", answer.key}});
  return out;
}

Json lists_json(const StudyPlan& plan, const StudyDesign& design) {
  Json out = Json::array();
  for (size_t list = 0; list < design.lists.size(); ++list) {
    Json trials = Json::array();
    for (size_t k = 0; k < design.lists[list].size(); ++k) {
      const Trial& trial = design.lists[list][k];
      const bool chosen = is_chosen(plan, design, trial);
      trials.push_back({{"trial", fmt::format("t{:03}", k + 1)},
                        {"stimulus", chosen ? Json() : Json(design.stimuli[trial.stimulus].id)},
                        {"block", trial.block},
                        {"kind", trial_word(trial.kind)}});
    }
    out.push_back({{"id", fmt::format("{}", list + 1)}, {"trials", std::move(trials)}});
  }
  return out;
}

// The condition's name without the level that the psychometric function is over: of one series, conditions differ in
// that level alone. Empty where there is no other factor.
std::string series_name(const StudyPlan& plan, const StudyCondition& condition) {
  std::string out;
  for (size_t f = 0; f < plan.factors.size(); ++f)
    if (plan.factors[f].name != plan.analysis.level)
      out += fmt::format("{}{}={}", out.empty() ? "" : " ", plan.factors[f].name, condition.levels[f].text);
  return out;
}

}  // namespace

Json half_json(const PlannedHalf& half, const scene::Scenario& drawn) {
  return {{"representation", half.spec.text()},
          {"seed", drawn.seed},
          {"spacing_m", drawn.crowd.spacing},
          {"eye", vector_json(drawn.camera.keys[0].camera.eye)},
          {"scenario", scene::to_toml(drawn)}};
}

Json stimulus_json(const StudyPlan& plan, const StudyDesign& design, const Stimulus& stimulus) {
  const StudyCondition& condition = plan.conditions[stimulus.condition];
  const auto side = [&](size_t half, const std::string& item) {
    return Json{{"item", item}, {"seed", design.halves[half].scenario.seed}};
  };
  Json out;
  out["id"] = stimulus.id;
  out["kind"] = stimulus_word(stimulus.kind);
  // Of two that are ranked, each may be of another condition: all that a plan lets vary there makes the items.
  const bool ranked = stimulus.kind == StimulusKind::pair;
  out["condition"] = ranked ? Json() : Json(condition.id);
  out["condition_name"] = ranked ? std::string() : condition.name;
  out["series"] = ranked ? std::string() : series_name(plan, condition);
  out["level"] = condition.level ? Json(*condition.level) : Json();
  out["crowd"] = stimulus.crowd;
  out["upper"] = side(stimulus.upper, stimulus.item_upper);
  out["lower"] = side(stimulus.lower, stimulus.item_lower);
  out["test_on_top"] = stimulus.test_on_top ? Json(*stimulus.test_on_top) : Json();
  out["expected"] = text_or_null(stimulus.expected);
  return out;
}

Json trials_json(const ExportFacts& facts) {
  const StudyPlan& plan = facts.plan;
  const scene::Scenario& scenario = plan.conditions[0].scenario;
  StackStyle style;
  style.bar_height = plan.stimulus.bar_px;
  const StackSize size = stack_size(scenario.width, scenario.height, style);
  Json out;
  out["format"] = 1;
  out["study"] = facts.frozen.current_hash();
  out["title"] = plan.title;
  out["question"] = plan.question_text;
  out["task"] = task_words()[static_cast<size_t>(plan.task)];
  out["answers"] = answers_json(plan.task);
  out["replays"] = plan.stimulus.replays;
  out["fps"] = plan.stimulus.fps;
  out["frames"] = plan.frames();
  out["width"] = size.width;
  out["height"] = size.height;
  out["display"] = {{"bar_top", scenario.height}, {"bar_height", plan.stimulus.bar_px}};
  out["calibration"] = plan.participants.calibration;
  out["consent"] = "consent.md";
  out["instructions"] = "instructions.md";
  out["debrief"] = "debrief.md";
  out["demographics"] = plan.participants.demographics;
  out["stimuli"] = Json::object();
  for (const Json& stimulus : facts.stimuli.elements())
    out["stimuli"][stimulus.at("id").text()] = {{"files", stimulus.at("files")},
                                                {"check_frame", stimulus.at("check_frame")}};
  out["lists"] = lists_json(plan, facts.design);
  out["breaks"] = breaks_of(plan);
  if (plan.method.method != Method::constant) out["adaptive"] = adaptive_json(adaptive_rule(plan, facts.design));
  return out;
}

Json sides_json(const ExportFacts& facts) {
  Json sides = Json::object();
  for (const Json& stimulus : facts.stimuli.elements()) {
    Json& entry = sides[stimulus.at("id").text()];
    for (const char* const key :
         {"kind", "condition", "condition_name", "series", "level", "crowd", "test_on_top", "expected"})
      entry[key] = stimulus.at(key);
    for (const char* const half : {"upper", "lower"}) entry[half] = stimulus.at(half).at("item");
  }
  return {{"format", 1}, {"study", facts.frozen.current_hash()}, {"stimuli", std::move(sides)}};
}

Json study_json(const ExportFacts& facts) {
  const StudyPlan& plan = facts.plan;
  Json deviations = Json::array();
  for (const Deviation& deviation : facts.frozen.deviations)
    deviations.push_back({{"hash", deviation.hash}, {"reason", deviation.reason}});
  Json out;
  out["format"] = 1;
  out["crowdbench"] = fmt::format("{} ({})", version(), git_revision());
  out["hash"] = facts.frozen.current_hash();
  out["frozen"] = facts.frozen.hash;
  out["deviations"] = std::move(deviations);
  out["name"] = plan.name;
  out["plan"] = plan.meaning();
  out["renderer"] = {{"name", facts.renderer}, {"version", facts.renderer_version}};
  out["rules"] = {
      {"largest_px", "no figure of any half covers more rows in any frame, by agent id"},
      {"artefact_share",
       "over the pixels where the half under test and its crowd by the reference differ by more than 8 code values, "
       "the "
       "root mean square of (decoded - raw) is at most this share of that of (test - reference)"},
      {"bar",
       "the middle half of the bar's rows is within 12 code values of its colour, and the 8 rows on either side "
       "are at most twice as far off as the others"}};
  out["browsers"] = {{"clips/*.mp4", players_text("h264")}};
  if (facts.settings.webm) out["browsers"]["clips/*.webm"] = players_text("vp9");
  out["scores_display"] = metrics::display_text(facts.settings.display.display);
  out["halves"] = facts.halves;
  out["stimuli"] = facts.stimuli;
  out["lists"] = lists_json(plan, facts.design);
  out["breaks"] = breaks_of(plan);
  out["adaptive"] = plan.method.method == Method::constant ? Json() : adaptive_json(adaptive_rule(plan, facts.design));
  return out;
}

void write_page_files(const ExportFacts& facts, const std::filesystem::path& page) {
  write_file(page / "consent.md", facts.plan.consent);
  write_file(page / "instructions.md", facts.plan.instructions);
  write_file(page / "debrief.md", facts.plan.debrief);
  write_file(page / "trials.json", trials_json(facts).dump(1) + "\n");
  // The order in which clips were made would tell them apart.
  const auto date = std::filesystem::last_write_time(page / "trials.json");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(page))
    if (entry.is_regular_file()) std::filesystem::last_write_time(entry.path(), date);
}

}  // namespace crowdbench::studies
