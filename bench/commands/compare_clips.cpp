#include "bench/commands/compare_clips.h"

#include <fmt/format.h>

#include <filesystem>
#include <tuple>
#include <utility>
#include <variant>

#include "bench/commands/score_json.h"
#include "bench/experiments/clip_scores.h"
#include "bench/experiments/frame_pairs.h"
#include "bench/experiments/score_rows.h"
#include "bench/stage/scenario_display.h"
#include "core/error.h"
#include "core/files.h"
#include "core/progress.h"
#include "reports/page/clip_page.h"
#include "scene/scenario/parse_scenario.h"

namespace crowdbench::bench {
namespace {

// Float frames' pixels that are not finite, over all frames of one side.
struct NotFiniteFrames {
  metrics::NotFinite all;  // x, y: in `frame`
  size_t frame = 0;

  void add(const metrics::NotFinite& found, size_t of) {
    if (all.pixels() == 0 && found.pixels() > 0) {
      all.x = found.x;
      all.y = found.y;
      frame = of;
    }
    all.nan += found.nan;
    all.infinite += found.infinite;
  }
};

struct ClipResult {
  std::string reference, test;
  int width = 0, height = 0;
  size_t frames = 0;
  size_t equal = 0;  // frames of which both pictures are the same
  double fps = 0;
  std::vector<ClipScore> scores;
  std::vector<BoundVerdict> verdicts;
  std::optional<CompareRegion> region;
  std::vector<std::string> warnings, maps;
  bool floats = false;
  NotFiniteFrames not_finite_reference, not_finite_test;
};

std::unique_ptr<FramePairs> open_pairs(const CompareOptions& options) {
  if (!options.ids_reference.empty())
    throw Error("--ids-ref", "ids are of pictures", "compare two pictures of frames to score agents");
  return options.test.empty() ? open_stacked(options.reference)
                              : open_frame_pairs(options.reference, options.test, options.fps);
}

void take(const CompareSetup& setup, const CompareOptions& options, ComparedPictures& pictures,
          ClipComparison& comparison, ClipResult& result) {
  const bool first = comparison.frames() == 0;
  if (first) {
    std::tie(result.width, result.height) = std::visit(
        [](const auto& i) {
          return std::pair{i.width, i.height};
        },
        pictures.reference);
    result.region = compare_region(options.region, result.width, result.height);
    if (result.region)
      result.warnings.insert(result.warnings.end(), result.region->notes.begin(), result.region->notes.end());
  }
  // What is said of the first frame holds for all.
  std::vector<std::string> later;
  bring_together(setup, result.region, pictures, result.reference, result.test, first ? result.warnings : later);
  if (const auto found = not_finite_of(pictures)) {
    result.floats = true;
    result.not_finite_reference.add(found->reference, comparison.frames());
    result.not_finite_test.add(found->test, comparison.frames());
  }
  result.equal += pictures.reference == pictures.test ? 1 : 0;
  metrics::ScoreInput input = score_input(setup, result.region, pictures);
  input.fps = result.fps;
  input.maps = !options.maps.empty() || !options.chart.empty();
  comparison.take(input);
}

void write_worst_maps(const std::filesystem::path& folder, const CompareSetup& setup, ClipResult& result) {
  make_folder(folder);
  for (const ClipScore& of : result.scores) {
    if (of.score->map_file.empty()) continue;
    if (of.over_time && !of.worst_frame)
      for (std::string& file : write_map(folder, "_worst_frame", *of.score, of.result, setup.colours))
        result.maps.push_back(std::move(file));
    if (!of.worst_frame) continue;
    for (std::string& file :
         write_map(folder, fmt::format("_frame{:04}", *of.worst_frame), *of.score, of.worst, setup.colours))
      result.maps.push_back(std::move(file));
  }
}

std::vector<metrics::Scored> whole_scores(const ClipResult& result) {
  std::vector<metrics::Scored> out;
  for (const ClipScore& of : result.scores) out.push_back({of.score, of.result});
  return out;
}

// A stacked clip is looked at where the scenario that drew it is, unless --display says where.
void look_where_the_scenario_is(const FramePairs& pairs, CompareSetup& setup) {
  if (setup.display.given || pairs.scenario.empty()) return;
  try {
    scene::KeyPlaces places;
    const scene::Scenario scenario = scene::parse_scenario(pairs.scenario, pairs.scenario_in + ": scenario", &places);
    setup.display = display_of_scenario(scenario, std::filesystem::path(pairs.scenario_in).parent_path(), places);
  } catch (const Error& error) {
    throw Error(error.where, error.wrong, "say with --display where the clip is looked at");
  }
  if (setup.display.given) setup.display_from = pairs.scenario_in;
}

ClipResult run(CompareSetup& setup, const CompareOptions& options) {
  const std::unique_ptr<FramePairs> pairs = open_pairs(options);
  look_where_the_scenario_is(*pairs, setup);
  ClipResult result;
  result.reference = pairs->reference;
  result.test = pairs->test;
  result.warnings = pairs->warnings;
  result.fps = options.fps > 0 ? options.fps : pairs->fps;
  ClipComparison comparison(setup.table, setup.also);
  {
    Progress progress("comparing", pairs->frames);
    FramePair pair;
    ComparedPictures pictures;
    while (pairs->next(pair)) {
      std::swap(pictures.reference, pair.reference);
      std::swap(pictures.test, pair.test);
      take(setup, options, pictures, comparison, result);
      std::swap(pictures.reference, pair.reference);
      std::swap(pictures.test, pair.test);
      progress.advance();
    }
  }
  result.frames = comparison.frames();
  if (result.frames == 0) throw Error(result.reference, "has no frames", "name a clip with at least one");
  result.scores = comparison.finish();
  result.verdicts = check_bounds(setup.bounds, whole_scores(result));
  for (const auto& [side, found] :
       {std::pair{"reference", &result.not_finite_reference}, std::pair{"test", &result.not_finite_test}})
    if (found->all.pixels() > 0)
      result.warnings.push_back(
          fmt::format("{}, in frame {}", metrics::not_finite_text(found->all, side), found->frame));
  if (!options.maps.empty()) write_worst_maps(options.maps, setup, result);
  return result;
}

Json not_finite_json(const NotFiniteFrames& found) {
  Json out = {{"nan", found.all.nan}, {"infinite", found.all.infinite}};
  if (found.all.pixels() > 0) {
    out["frame"] = found.frame;
    out["first"] = {found.all.x, found.all.y};
  }
  return out;
}

Json to_json(const CompareOptions& options, const CompareSetup& setup, const ClipResult& result) {
  Json scores = Json::object();
  Json reasons = Json::object();
  const std::vector<metrics::Scored> whole = whole_scores(result);
  put_scores(scores, reasons, whole);
  Json out = {
      {"reference", result.reference}, {"test", result.test}, {"width", result.width}, {"height", result.height},
      {"frames", result.frames},       {"fps", nullptr},      {"scores", scores},      {"reasons", reasons}};
  if (result.fps > 0) out["fps"] = result.fps;
  out["equal_frames"] = result.equal;
  out["pooling"] = out["worst_frames"] = out["by_frame"] = Json::object();
  for (const ClipScore& of : result.scores) {
    const std::string name(of.score->name);
    if (of.result.value) out["pooling"][name] = pooling_of_figures_text(of);
    if (of.worst_frame)
      out["worst_frames"][name] = {{"frame", *of.worst_frame}, {"value", json_number(of.worst.value)}};
    for (const auto& value : of.by_frame) out["by_frame"][name].push_back(json_number(value));
  }
  if (Json conditions = conditions_json(whole); !conditions.empty()) out["conditions"] = conditions;
  if (Json details = details_json(whole); !details.empty()) out["details"] = details;
  out["display"] = display_json(setup.display);
  if (!setup.display_from.empty()) out["display"]["from"] = setup.display_from;
  if (result.floats)
    out["not_finite"] = {{"reference", not_finite_json(result.not_finite_reference)},
                         {"test", not_finite_json(result.not_finite_test)}};
  if (!options.over.empty()) {
    out["over"] = options.over;
    out["over_rounding"] = options.over_rounding;
  }
  if (result.region) out["region"] = region_json(options.region, *result.region);
  if (!result.verdicts.empty()) out["bounds"] = bounds_json(result.verdicts);
  out["warnings"] = result.warnings;
  out["maps"] = result.maps;
  if (!options.chart.empty()) out["chart"] = options.chart;
  return out;
}

void print_text(const CompareOptions& options, const CompareSetup& setup, const ClipResult& result) {
  fmt::print("{} frames of {} x {} pixels{}: {} against {}\n", result.frames, result.width, result.height,
             result.fps > 0 ? fmt::format(", {:g} a second", result.fps) : "", result.test, result.reference);
  fmt::print("  {:<16} {:>12} {:>12} {:>8}\n", "", "whole", "worst frame", "at");
  for (const ClipScore& of : result.scores) {
    fmt::print("  {:<16} {:>12} {:>12} {:>8}  ", of.score->name, metrics::value_text(*of.score, of.result.value),
               metrics::value_text(*of.score, of.worst.value),
               of.worst_frame ? fmt::format("{}", *of.worst_frame) : "-");
    if (of.result.value)
      fmt::print("{}{}{}; {}; {:g} = equal{}{}\n", of.score->title, of.score->unit.empty() ? "" : ", ", of.score->unit,
                 pooling_text(of), metrics::best_value(*of.score), of.result.conditions.empty() ? "" : "; at ",
                 of.result.conditions);
    else
      fmt::print("not available: {}\n", of.result.reason);
  }
  if (result.equal == result.frames) fmt::print("  the clips are equal: no frame is worse than another\n");
  print_display(setup, whole_scores(result));
  for (const std::string& map : result.maps) fmt::print("  wrote {}\n", map);
  if (!options.chart.empty()) fmt::print("  wrote {}\n", options.chart);
}

void write_chart(const CompareOptions& options, const CompareSetup& setup, const ClipResult& result) {
  reports::ClipPage page;
  page.reference = result.reference;
  page.test = result.test;
  page.frames = result.frames;
  page.equal = result.equal;
  page.fps = result.fps;
  page.width = result.width;
  page.height = result.height;
  page.display = setup.display_from.empty() ? metrics::display_text(setup.display) : display_line(setup);
  for (const ClipScore& of : result.scores) {
    reports::ClipSeries& series = page.scores.emplace_back();
    const metrics::Score* score = of.score;
    series.doc = score_docs({&score, 1})[0];
    series.whole = of.result.value;
    series.pooling = pooling_text(of);
    series.conditions = of.result.conditions;
    series.reason = of.result.reason;
    series.by_frame = of.by_frame;
    series.worst_frame = of.worst_frame;
    if (const metrics::ScoreResult& worst = of.worst_frame ? of.worst : of.result; worst.map) {
      const Image8 map = metrics::map_picture(*score, worst, setup.colours);
      series.map = {map.width, map.height, encode_png(map)};
    }
  }
  write_file(options.chart, std::string_view(reports::clip_page(page)));
}

}  // namespace

int compare_clips(const CompareOptions& options, metrics::ScoreTable table) {
  CompareSetup setup = compare_setup(options, table);
  const ClipResult result = run(setup, options);
  if (!options.chart.empty()) write_chart(options, setup, result);
  for (const std::string& warning : result.warnings) fmt::print(stderr, "crowdbench: warning: {}\n", warning);
  if (options.json)
    fmt::print("{}\n", to_json(options, setup, result).dump(2));
  else
    print_text(options, setup, result);
  return say_broken_bounds(result.verdicts);
}

}  // namespace crowdbench::bench
