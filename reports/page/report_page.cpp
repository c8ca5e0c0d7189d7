#include "reports/page/report_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/error.h"
#include "reports/model/equal_levels.h"
#include "reports/model/side_by_side.h"
#include "reports/model/sweep_settings.h"
#include "reports/page/blocks.h"
#include "reports/page/distance_page.h"
#include "reports/page/findings_section.h"
#include "reports/page/lead_section.h"
#include "reports/page/page_files.h"
#include "reports/page/page_frame.h"
#include "reports/page/points_section.h"
#include "reports/page/sections.h"
#include "reports/page/side_section.h"
#include "reports/page/tuning_section.h"

namespace crowdbench::reports {
namespace {

using Rows = std::vector<TemplateValues>;

std::string title_of(const Scene& scene) {
  const std::string against = fmt::format("{}", fmt::join(subjects_of(scene), ", "));
  return against.empty() ? "What a crowd costs to draw as " + scene.reference
                         : fmt::format("A crowd drawn as {} and as {}: cost and difference", scene.reference, against);
}

// Each once, in the order of the scenes, then of the curves.
std::string characters_of(const std::vector<Scene>& scenes, const std::vector<Scene>& agents,
                          const StoreContents& contents) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const auto* some : {&scenes, &agents})
    for (const Scene& scene : *some) add(scene.character);
  for (const CurveRow& curve : contents.curves) add(curve.character);
  for (const PopRow& pop : contents.pops) add(pop.character);
  for (const TuningRow& tuning : contents.tunings) add(tuning.character);
  return fmt::format("{}", fmt::join(names, ", "));
}

// several: the page tells of more scenes than this one, so that each needs a heading and an answer of its own.
TemplateValues scene_values(const SweepSettings& all_settings, const Scene& scene, const FloorTexts& floors,
                            bool several, int& last_chart) {
  Rows heading;
  std::vector<Html> sections;
  if (several) {
    const std::string settings = all_settings.of_scene(scene);
    heading.push_back({{"character", scene.character},
                       {"width", scene.width},
                       {"height", scene.height},
                       {"scenario", scene.run->scenario_name},
                       {"settings", (settings.empty() ? "" : ", " + settings) +
                                        (scene.source.empty() ? "" : ", of " + scene.source)}});
    sections.push_back(answer_section(scene));
  }
  SceneOnPage page(scene, last_chart);
  sections.push_back(pictures_section(page));
  sections.push_back(cost_section(page));
  sections.push_back(difference_section(page));
  sections.push_back(equal_levels_section(page));
  sections.push_back(model_section(page));
  sections.push_back(memory_section(page));
  sections.push_back(samples_section(page));
  sections.push_back(floors_section(page, floors));
  sections.push_back(work_section(page));
  sections.push_back(untimed_section(page));
  std::erase_if(sections, [](const Html& section) { return section.text.empty(); });
  return {{"heading", std::move(heading)}, {"sections", html_rows(std::move(sections))}};
}

// A run of `quality`: the difference of single agents, and where it comes from.
TemplateValues agent_values(const StoreContents& contents, const Scene& scene, int& last_chart) {
  SceneOnPage page(scene, last_chart);
  return {{"character", scene.character},
          {"run", scene.run->id},
          {"section", difference_section(page)},
          {"causes", causes_section(contents, scene.run->id)}};
}

// source: the file that it is from, where there are several.
TemplateValues run_values(const RunRow& run, const std::string& source) {
  Rows facts;
  const auto fact = [&](const char* title, std::string value) {
    facts.push_back({{"title", title}, {"value", std::move(value)}});
  };
  fact("command", run.arguments.empty() ? run.command : run.arguments);
  fact("crowdbench", fmt::format("{} ({})", run.version, run.revision));
  fact("OpenGL renderer", run.gl_renderer + (run.software ? " (software)" : ""));
  fact("OpenGL version", fmt::format("{}; {}", run.gl_version, run.gl_vendor));
  fact("processor",
       fmt::format("{}, {} hardware threads", run.cpu_model.value_or("not named by the machine"), run.cpu_threads));
  fact("system", run.os);
  fact("cost of reading the clocks", fmt::format("{:.2f} µs", run.timer_cost_ns / 1e3));
  fact("seed", std::to_string(run.seed));
  fact("scenario", fmt::format("{}, SHA-256 {}", run.scenario_name, run.scenario_hash));
  if (!source.empty()) facts.insert(facts.begin(), {{"title", "file"}, {"value", source}});
  return {{"id", run.id}, {"started", run.started}, {"facts", std::move(facts)}, {"scenario", run.scenario}};
}

// Those that `distance` made, in their order.
std::vector<const RunRow*> runs_with_curves(const StoreContents& contents) {
  std::vector<const RunRow*> runs;
  for (const RunRow& run : contents.runs)
    if (std::any_of(contents.curves.begin(), contents.curves.end(), [&](const CurveRow& c) { return c.run == run.id; }))
      runs.push_back(&run);
  return runs;
}

TemplateValues distance_values(const StoreContents& contents, const RunRow& run, const PageOptions& options,
                               int& last_chart) {
  const auto curve =
      std::find_if(contents.curves.begin(), contents.curves.end(), [&](const CurveRow& c) { return c.run == run.id; });
  return {{"character", curve->character},
          {"scenario", run.scenario_name},
          {"reference", curve->reference},
          {"display", curve->display},
          {"run", run.id},
          {"section", distance_section(distance_scores(contents, run.id, options.scores), last_chart)},
          {"causes", causes_section(contents, run.id)}};
}

std::string title_of_untimed(const StoreContents& contents, const std::vector<Scene>& agents, bool curves) {
  if (!contents.tunings.empty()) return "Which representation from which distance on";
  if (curves) return "Difference over distance";
  return agents.empty() ? "Switches of agents, and how visible they are" : "Difference of single agents";
}

// Where nothing was timed: the first run that the page tells of.
const RunRow& first_run(const StoreContents& contents, const std::vector<Scene>& scenes,
                        const std::vector<const RunRow*>& distances, const std::vector<Scene>& agents) {
  if (!scenes.empty()) return *scenes.front().run;
  if (!distances.empty()) return *distances.front();
  return agents.empty() ? contents.runs.front() : *agents.front().run;
}

// All runs; where there are more scenes than are told in full, those of the scenes that are and those that timed
// nothing.
std::vector<const RunRow*> runs_in_full(const StoreContents& contents, const std::vector<Scene>& scenes) {
  std::set<int64_t> left_out;
  if (scenes.size() > kScenesInFull) {
    for (const MeasurementRow& row : contents.measurements) left_out.insert(row.run);
    for (size_t i = 0; i < kScenesInFull; ++i) left_out.erase(scenes[i].run->id);
  }
  std::vector<const RunRow*> out;
  for (const RunRow& run : contents.runs)
    if (!left_out.contains(run.id)) out.push_back(&run);
  return out;
}

// Of one program, driver and machine.
bool runs_are_alike(const std::vector<RunRow>& runs) {
  const auto same = [&](const RunRow& run) {
    const RunRow& first = runs.front();
    return run.version == first.version && run.revision == first.revision && run.gl_renderer == first.gl_renderer &&
           run.gl_version == first.gl_version && run.gl_vendor == first.gl_vendor && run.cpu_model == first.cpu_model &&
           run.cpu_threads == first.cpu_threads && run.os == first.os;
  };
  return std::ranges::all_of(runs, same);
}

}  // namespace

std::string report_page(const StoreContents& contents, const PageOptions& options) {
  const std::vector<Scene> scenes = scenes_of(contents, options.scores);
  const std::vector<Scene> agents = scenes_of_agents(contents, scenes, options.scores);
  const std::vector<const RunRow*> distances = runs_with_curves(contents);
  if (contents.runs.empty() ||
      (scenes.empty() && agents.empty() && distances.empty() && contents.pops.empty() && contents.tunings.empty()))
    throw Error(options.source,
                "holds no measurement, no curve, no single agent, no switch and no tuned rule to make a page of",
                "run `crowdbench bench --out " + options.source + "` first, or another command with --db");
  const bool several = scenes.size() > 1;
  const RunRow& run = first_run(contents, scenes, distances, agents);
  std::vector<Html> answers;
  if (scenes.size() == 1) answers.push_back(answer_section(scenes.front()));
  answers.push_back(findings_section(contents, options.pop_scores));
  std::erase_if(answers, [](const Html& answer) { return answer.text.empty(); });
  int last_chart = 0;
  const SweepSettings all_settings(contents);
  const Html sides = side_section(side_by_side(scenes), last_chart);
  Rows on_page;
  const size_t in_full = std::min(scenes.size(), kScenesInFull);
  for (size_t i = 0; i < in_full; ++i)
    on_page.push_back(scene_values(all_settings, scenes[i], options.floors, several, last_chart));
  Rows over_distance;
  for (const RunRow* each : distances) over_distance.push_back(distance_values(contents, *each, options, last_chart));
  Rows alone;
  for (const Scene& scene : agents) alone.push_back(agent_values(contents, scene, last_chart));
  std::vector<Html> pops;
  for (const RunRow& each : contents.runs)
    if (Html section = pops_section(contents, each, options.pop_scores); !section.text.empty())
      pops.push_back(std::move(section));
  Rows runs;
  const std::vector<const RunRow*> told = runs_in_full(contents, scenes);
  for (const RunRow* each : told) {
    const auto source = contents.sources.find(each->id);
    runs.push_back(run_values(*each, source == contents.sources.end() ? "" : source->second));
  }
  Rows more;
  if (told.size() < contents.runs.size())
    more.push_back({{"count", contents.runs.size() - told.size()}, {"alike", runs_are_alike(contents.runs)}});
  Html content = fill_template(
      page_file("report.html"),
      {{"characters", characters_of(scenes, agents, contents)},
       {"started", run.started},
       {"processor", run.cpu_model.value_or("an unnamed processor")},
       {"renderer", run.gl_renderer},
       {"version", run.version},
       {"revision", run.revision},
       {"lead", lead_section(lead_of(contents, scenes, options.scores))},
       {"tuning", tuning_section(contents, options.scores)},
       {"sides", sides},
       {"answer", html_rows(std::move(answers))},
       {"software", std::any_of(scenes.begin(), scenes.end(), [](const Scene& scene) { return scene.run->software; })},
       {"scenes", std::move(on_page)},
       {"distances", std::move(over_distance)},
       {"agents", std::move(alone)},
       {"pops", html_rows(std::move(pops))},
       {"points", points_section(contents, scenes)},
       {"undrawn", undrawn_section(contents)},
       {"timed", !scenes.empty()},
       {"runs", std::move(runs)},
       {"more_runs", std::move(more)}});
  return page_frame(scenes.empty() ? title_of_untimed(contents, agents, !distances.empty()) : title_of(scenes.front()),
                    std::move(content), options.source);
}

}  // namespace crowdbench::reports
