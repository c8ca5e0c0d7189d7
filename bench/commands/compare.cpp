#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "bench/commands/cause_output.h"
#include "bench/commands/command_line.h"
#include "bench/commands/compare_clips.h"
#include "bench/commands/compare_input.h"
#include "bench/commands/compare_region.h"
#include "bench/commands/score_bounds.h"
#include "bench/commands/score_commands.h"
#include "bench/commands/score_json.h"
#include "bench/experiments/frame_pairs.h"
#include "core/colour_tags.h"
#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "core/json.h"
#include "metrics/agents.h"
#include "metrics/difference.h"
#include "metrics/intermediates.h"
#include "metrics/picture_causes.h"

namespace crowdbench::bench {
namespace {

struct Result {
  int width = 0;
  int height = 0;
  std::vector<metrics::Scored> scores;
  std::vector<BoundVerdict> verdicts;
  std::optional<CompareRegion> region;  // none: every pixel
  std::vector<std::string> warnings;
  std::vector<std::string> maps;
  std::optional<metrics::Difference> worst;      // with code values
  std::optional<metrics::AgentScores> by_agent;  // with ids
  std::optional<NotFinitePair> not_finite;       // with floats
  std::optional<metrics::PictureCauses> causes;  // with 8-bit code values
  CompareSetup setup;
};

ImageU32 read_ids(const std::string& path) {
  AnyImage image = read_image(path);
  auto* ids = std::get_if<ImageU32>(&image);
  if (!ids || ids->channels != 1)
    throw Error(path, "is not a picture of agent ids", "name an EXR with one 32-bit unsigned channel (render --ids)");
  return std::move(*ids);
}

void require_size(const AnyImage& image, int width, int height, const std::string& path, const std::string& of,
                  const std::string& advice) {
  std::visit(
      [&](const auto& i) {
        if (i.width != width || i.height != height)
          throw Error(path, fmt::format("is {} x {} pixels, {} {} x {}", i.width, i.height, of, width, height), advice);
      },
      image);
}

void read_both_ids(const CompareOptions& options, ComparedPictures& pictures, const Result& result) {
  if (!std::holds_alternative<Image8>(pictures.reference) || !std::holds_alternative<Image8>(pictures.test))
    throw Error("--ids-ref", "scores by agent need 8-bit pictures", "compare the PNG files");
  for (auto& [ids, path] : {std::pair<ImageU32&, const std::string&>{pictures.reference_ids, options.ids_reference},
                            std::pair<ImageU32&, const std::string&>{pictures.test_ids, options.ids_test}}) {
    ids = read_ids(path);
    require_size(ids, result.width, result.height, path, "the pictures are", "name the ids of the same frame");
  }
}

ImageF read_depth(const std::string& path, const ImageU32& ids) {
  AnyImage image = read_image(path);
  auto* depth = std::get_if<ImageF>(&image);
  if (!depth || depth->channels != 1)
    throw Error(path, "is not a picture of depths", "name an EXR with one channel of floats (render --depth)");
  require_size(image, ids.width, ids.height, path, "the pictures are", "name the depths of the same frame");
  return std::move(*depth);
}

// Without ids nobody can say which pixels show what: all of the error is residue.
metrics::PictureCauses untold_causes(const ComparedPictures& pictures) {
  const auto& reference = std::get<Image8>(pictures.reference);
  const metrics::CauseStep all{std::nullopt, std::get<Image8>(pictures.test)};
  metrics::PictureCauses out;
  out.errors = metrics::error_by_cause(reference, {&all, 1}, ImageU32(reference.width, reference.height, 1));
  out.errors.reasons = metrics::no_causes("no ids were given (--ids-ref, --ids-test)");
  return out;
}

metrics::PictureCauses read_causes(const CompareOptions& options, const CompareSetup& setup,
                                   const std::optional<CompareRegion>& region, const ComparedPictures& pictures) {
  metrics::PicturesWithIds of{std::get<Image8>(pictures.reference), std::get<Image8>(pictures.test),
                              pictures.reference_ids, pictures.test_ids};
  if (!pictures.reference_depth.empty()) {
    of.reference_depth = &pictures.reference_depth;
    of.test_depth = &pictures.test_depth;
  }
  ComparedPictures posed;
  if (!options.pose_reference.empty()) {
    posed.reference = pictures.reference;
    posed.test = read_image(options.pose_reference);
    if (!std::holds_alternative<Image8>(posed.test))
      throw Error(options.pose_reference, "is not a picture of 8 bits", "name the PNG file");
    require_size(posed.test, of.reference.width, of.reference.height, options.pose_reference, "the pictures are",
                 "name a picture of the same camera");
    std::vector<std::string> warnings;
    bring_together(setup, region, posed, options.reference, options.pose_reference, warnings);
    posed.test_ids = read_ids(options.pose_ids);
    require_size(posed.test_ids, of.reference.width, of.reference.height, options.pose_ids, "the pictures are",
                 "name the ids of that picture");
    of.posed = &std::get<Image8>(posed.test);
    of.posed_ids = &posed.test_ids;
  }
  return metrics::causes_of_pictures(of);
}

// Code values are compared as they are stored; where the files give them different colours, that is not what is seen.
void compare_tags(const CompareOptions& options, Result& result) {
  const std::string reference = colour_tags(std::filesystem::path(options.reference));
  const std::string test = colour_tags(std::filesystem::path(options.test));
  if (reference == test) return;
  const auto said = [](const std::string& tags) { return tags.empty() ? "sRGB or nothing" : tags; };
  result.warnings.push_back(fmt::format("colour tags differ: {} says {}, {} says {}; values are compared as stored",
                                        printable(options.reference), said(reference), printable(options.test),
                                        said(test)));
}

void write_maps(const std::filesystem::path& folder, const CompareSetup& setup, const metrics::ScoreInput& input,
                Result& result) {
  make_folder(folder);
  const bool codes = (metrics::given(input) & metrics::kNeedsCodes) != 0;
  if (codes) {
    const std::filesystem::path file = folder / "absdiff.png";
    write_png(file, input.reference.codes
                        ? metrics::absolute_difference(*input.reference.codes, *input.test.codes)
                        : metrics::absolute_difference(*input.reference.codes16, *input.test.codes16));
    result.maps.push_back(file.string());
  } else {
    result.warnings.emplace_back("no maps of code values: the pictures have none");
  }
  for (const auto& [score, scored] : result.scores) {
    if (score->map_file.empty() || (!codes && (score->needs & metrics::kNeedsCodes) != 0)) continue;
    if (!scored.map) result.warnings.push_back(fmt::format("no {}.png: {}", score->map_file, scored.reason));
    for (std::string& file : write_map(folder, "", *score, scored, setup.colours))
      result.maps.push_back(std::move(file));
  }
}

Result compare(const CompareOptions& options, metrics::ScoreTable table) {
  Result result;
  result.setup = compare_setup(options, table);
  const CompareSetup& setup = result.setup;
  ComparedPictures pictures{read_image(options.reference), read_image(options.test), {}, {}};
  std::tie(result.width, result.height) = std::visit(
      [](const auto& i) {
        return std::pair{i.width, i.height};
      },
      pictures.reference);
  require_size(pictures.test, result.width, result.height, options.test, options.reference + " is",
               "compare pictures of one size");
  result.region = compare_region(options.region, result.width, result.height);
  if (result.region) result.warnings = result.region->notes;
  bring_together(setup, result.region, pictures, options.reference, options.test, result.warnings);
  compare_tags(options, result);
  if (!options.ids_reference.empty()) read_both_ids(options, pictures, result);
  if (!options.depth_reference.empty()) {
    pictures.reference_depth = read_depth(options.depth_reference, pictures.reference_ids);
    pictures.test_depth = read_depth(options.depth_test, pictures.reference_ids);
  }

  metrics::ScoreInput input = score_input(setup, result.region, pictures);
  input.maps = !options.maps.empty();
  metrics::Shared shared;
  result.scores = metrics::score_pictures(setup.table, input, shared, setup.also);
  result.verdicts = check_bounds(setup.bounds, result.scores);
  result.not_finite = not_finite_of(pictures);
  if (result.not_finite)
    if (std::string text = metrics::not_finite_text(result.not_finite->reference, result.not_finite->test);
        !text.empty())
      result.warnings.push_back(std::move(text));
  if ((metrics::given(input) & metrics::kNeedsCodes) != 0) result.worst = metrics::region_difference(input, shared);
  if (input.maps) write_maps(options.maps, setup, input, result);
  if (input.reference.ids)
    result.causes = read_causes(options, setup, result.region, pictures);
  else if (input.reference.codes && input.test.codes)
    result.causes = untold_causes(pictures);
  if (input.reference.ids) result.by_agent = metrics::score_agents(setup.table, input, shared);
  return result;
}

// The scores of the silhouettes alone, under the names that they have among themselves.
Json silhouettes_json(const Result& result, Json& reasons) {
  Json out = Json::object();
  for (const auto& [score, scored] : result.scores) {
    if (score->needs != metrics::kNeedsIds) continue;
    const std::string name(metrics::name_among_silhouettes(*score));
    out[name] = score_json(scored);
    if (!scored.value) reasons["silhouette." + name] = scored.reason;
  }
  return out;
}

Json agents_json(const metrics::AgentScores& scores) {
  Json out = Json::array();
  for (const metrics::AgentRow& agent : scores.agents) {
    Json row = {{"id", agent.id}, {"pixels_ref", agent.pixels_ref}, {"pixels_test", agent.pixels_test}};
    for (size_t s = 0; s < scores.scores.size(); ++s)
      row[std::string(metrics::name_among_silhouettes(*scores.scores[s]))] = json_number(agent.values[s]);
    out.push_back(std::move(row));
  }
  return out;
}

Json not_finite_json(const NotFinitePair& pair) {
  Json out = Json::object();
  for (const auto& [side, found] : {std::pair{"reference", &pair.reference}, std::pair{"test", &pair.test}}) {
    out[side] = {{"nan", found->nan}, {"infinite", found->infinite}};
    if (found->pixels() > 0) out[side]["first"] = {found->x, found->y};
  }
  return out;
}

Json to_json(const CompareOptions& options, const Result& result) {
  Json scores = Json::object();
  Json reasons = Json::object();
  put_scores(scores, reasons, result.scores);
  Json out = {{"reference", options.reference}, {"test", options.test}, {"width", result.width},
              {"height", result.height},        {"scores", scores},     {"reasons", reasons}};
  if (result.worst)
    out["worst"] = {{"difference", result.worst->worst}, {"x", result.worst->worst_x}, {"y", result.worst->worst_y}};
  if (Json conditions = conditions_json(result.scores); !conditions.empty()) out["conditions"] = conditions;
  if (Json details = details_json(result.scores); !details.empty()) out["details"] = details;
  out["display"] = display_json(result.setup.display);
  if (result.not_finite) out["not_finite"] = not_finite_json(*result.not_finite);
  if (!options.over.empty()) {
    out["over"] = options.over;
    out["over_rounding"] = options.over_rounding;
  }
  if (result.region) out["region"] = region_json(options.region, *result.region);
  if (!result.verdicts.empty()) out["bounds"] = bounds_json(result.verdicts);
  if (result.causes) out["causes"] = causes_json(result.causes->errors, result.causes->changes);
  out["warnings"] = result.warnings;
  out["maps"] = result.maps;
  if (!result.by_agent) return out;
  out["silhouette"] = silhouettes_json(result, out["reasons"]);
  out["agents"] = agents_json(*result.by_agent);
  return out;
}

void print_agents(const metrics::AgentScores& scores) {
  fmt::print("{:>8} {:>9} {:>9}", "agent id", "px ref", "px test");
  for (const metrics::Score* score : scores.scores) fmt::print(" {:>9}", score->column);
  fmt::print("\n");
  for (const metrics::AgentRow& agent : scores.agents) {
    fmt::print("{:>8} {:>9} {:>9}", agent.id, agent.pixels_ref, agent.pixels_test);
    for (size_t s = 0; s < scores.scores.size(); ++s)
      fmt::print(" {:>9}", metrics::value_text(*scores.scores[s], agent.values[s]));
    fmt::print("\n");
  }
}

void print_text(const Result& result) {
  fmt::print("{} x {} pixels", result.width, result.height);
  if (result.region) fmt::print(", {} of {} counted", result.region->pixels, int64_t{result.width} * result.height);
  fmt::print("\n");
  for (const auto& [score, scored] : result.scores) {
    fmt::print("  {:<16} {:>12}  ", score->name, metrics::value_text(*score, scored.value));
    if (scored.value)
      fmt::print("{}{}{}; {:g} = equal{}{}\n", score->title, score->unit.empty() ? "" : ", ", score->unit,
                 metrics::best_value(*score), scored.conditions.empty() ? "" : "; at ", scored.conditions);
    else
      fmt::print("not available: {}\n", scored.reason);
    for (const auto* figures : {&scored.pooled, &scored.details})
      for (const metrics::ScoreFigure& of : *figures)
        fmt::print("   {:<15} {:>12}\n", of.name, metrics::value_text(*score, of.value));
  }
  print_display(result.setup, result.scores);
  if (result.worst)
    fmt::print("  largest difference {} at pixel ({}, {})\n", result.worst->worst, result.worst->worst_x,
               result.worst->worst_y);
  for (const std::string& map : result.maps) fmt::print("  wrote {}\n", map);
  if (result.by_agent) print_agents(*result.by_agent);
  if (result.causes && result.by_agent) print_causes(result.causes->errors, result.causes->changes);
}

// "; error_pseudocolour.png mean absolute error; ..."
std::string maps_text(metrics::ScoreTable table) {
  std::string text;
  for (const metrics::Score* score : table)
    if (!score->map_file.empty()) text += fmt::format(";\n  {}.png {}", score->map_file, score->title);
  return text;
}

}  // namespace

void add_compare(Command& app, Run& run) { add_compare(app, run, metrics::scores()); }

void add_compare(Command& app, Run& run, metrics::ScoreTable table) {
  Command* command = app.add_subcommand("compare", "Score how far one picture or clip is from another, and draw where");
  command->footer(
      std::string(
          "Scores are over sRGB code values of 0..255 as they lie in the files, those of structure over BT.601 luma;\n"
          "`crowdbench schema --scores` says what each is.\n") +
      "Maps: absdiff.png |a - b| by channel, as code values" + maps_text(table) +
      ".\n\n"
      "Examples:\n"
      "  crowdbench compare mesh.png flat.png\n"
      "  crowdbench compare mesh.png flat.png --maps maps --json\n"
      "  crowdbench compare old.png new.png --ignore 0,0,640,24 --fail-above mae=0.5    status 1 where it is more\n"
      "  crowdbench compare a.png b.png --over '#808080'       pictures with alpha, in front of grey\n"
      "  crowdbench compare a.mp4 b.mp4 --maps maps --chart c.html    every frame, the worst with its map\n"
      "  crowdbench compare clip.mp4                           the two halves of a clip that `pair` wrote,\n"
      "                                          on the display of its scenario\n"
      "  crowdbench compare a.png b.png --ids-ref a.exr --ids-test b.exr    one row an agent as well,\n"
      "                                          and the squared error by cause (`schema --results` documents it)");
  auto options = std::make_shared<CompareOptions>();
  add_compare_options(*command, *options);
  command->callback([options, table, &run] {
    run = [options, table] {
      if (options->test.empty() || is_sequence(options->reference) || is_sequence(options->test))
        return compare_clips(*options, table);
      if (!options->chart.empty())
        throw Error("--chart", "a chart is of frames over time", "compare two clips or folders of frames");
      const Result result = compare(*options, table);
      for (const std::string& warning : result.warnings) fmt::print(stderr, "crowdbench: warning: {}\n", warning);
      if (options->json)
        fmt::print("{}\n", to_json(*options, result).dump(2));
      else
        print_text(result);
      return say_broken_bounds(result.verdicts);
    };
  });
}

}  // namespace crowdbench::bench
