#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "bench/commands/command_line.h"
#include "bench/commands/compare_region.h"
#include "bench/commands/options.h"
#include "bench/commands/score_bounds.h"
#include "bench/commands/score_commands.h"
#include "bench/commands/score_json.h"
#include "core/colour_tags.h"
#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "core/json.h"
#include "metrics/agents.h"
#include "metrics/difference.h"
#include "metrics/intermediates.h"

namespace crowdbench::bench {
namespace {

using ordered_json = Json;

struct Options {
  std::string reference;
  std::string test;
  std::string maps;
  std::string over;
  std::string ids_reference;
  std::string ids_test;
  RegionOptions region;
  std::vector<std::string> fail_above, fail_below;
  bool json = false;
};

// The two pictures as they were read, brought to one kind of number.
struct Pictures {
  AnyImage reference, test;
  ImageU32 reference_ids, test_ids;  // empty: not asked for
};

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
};

std::array<uint8_t, 3> parse_colour(const std::string& text) {
  const bool shape =
      text.size() == 7 && text[0] == '#' && text.find_first_not_of("0123456789abcdefABCDEF", 1) == text.npos;
  if (!shape) throw Error("--over", fmt::format("'{}' is not a colour", printable(text)), "write it as '#rrggbb'");
  std::array<uint8_t, 3> colour{};
  for (size_t c = 0; c < 3; ++c) colour[c] = static_cast<uint8_t>(std::stoi(text.substr(1 + 2 * c, 2), nullptr, 16));
  return colour;
}

int channels_of(const AnyImage& image) {
  return std::visit([](const auto& i) { return i.channels; }, image);
}

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

void read_both_ids(const Options& options, Pictures& pictures, const Result& result) {
  if (!std::holds_alternative<Image8>(pictures.reference) || !std::holds_alternative<Image8>(pictures.test))
    throw Error("--ids-ref", "scores by agent need 8-bit pictures", "compare the PNG files");
  for (auto& [ids, path] : {std::pair<ImageU32&, const std::string&>{pictures.reference_ids, options.ids_reference},
                            std::pair<ImageU32&, const std::string&>{pictures.test_ids, options.ids_test}}) {
    ids = read_ids(path);
    require_size(ids, result.width, result.height, path, "the pictures are", "name the ids of the same frame");
  }
}

bool has_codes(const AnyImage& image) {
  return std::holds_alternative<Image8>(image) || std::holds_alternative<Image16>(image);
}

// Alpha is composited away where a colour was given, else ignored with a warning; 8 bits beside 16 become 16.
void prepare(const Options& options, Pictures& pictures, Result& result) {
  const auto colour = options.over.empty() ? std::nullopt : std::optional(parse_colour(options.over));
  for (auto& [image, path] : {std::pair<AnyImage&, const std::string&>{pictures.reference, options.reference},
                              std::pair<AnyImage&, const std::string&>{pictures.test, options.test}}) {
    if (channels_of(image) != 4) continue;
    if (!colour || !has_codes(image))
      result.warnings.push_back(printable(path) + ": alpha is ignored" +
                                (has_codes(image) ? "; --over '#rrggbb' composites first" : ""));
    else if (const auto* eight = std::get_if<Image8>(&image))
      image = metrics::over(*eight, *colour);
    else
      image = metrics::over(std::get<Image16>(image), *colour);
  }
  const bool both_have_codes = has_codes(pictures.reference) && has_codes(pictures.test);
  if (both_have_codes && pictures.reference.index() != pictures.test.index())
    for (AnyImage* image : {&pictures.reference, &pictures.test})
      if (const auto* eight = std::get_if<Image8>(image)) *image = metrics::widen(*eight);
  if (both_have_codes) return;
  if (!options.maps.empty()) result.warnings.push_back("no maps: the pictures have no 8-bit code values");
  if (!options.over.empty()) result.warnings.push_back("--over has no effect: the pictures have no 8-bit code values");
}

// Code values are compared as they are stored; where the files give them different colours, that is not what is seen.
void compare_tags(const Options& options, Result& result) {
  const std::string reference = colour_tags(std::filesystem::path(options.reference));
  const std::string test = colour_tags(std::filesystem::path(options.test));
  if (reference == test) return;
  const auto said = [](const std::string& tags) { return tags.empty() ? "sRGB or nothing" : tags; };
  result.warnings.push_back(fmt::format("colour tags differ: {} says {}, {} says {}; values are compared as stored",
                                        printable(options.reference), said(reference), printable(options.test),
                                        said(test)));
}

metrics::Buffers buffers_of(const AnyImage& image, const ImageU32& ids) {
  metrics::Buffers out;
  out.codes = std::get_if<Image8>(&image);
  out.codes16 = std::get_if<Image16>(&image);
  out.linear = std::get_if<ImageF>(&image);
  if (!ids.empty()) out.ids = &ids;
  return out;
}

void write_maps(const std::filesystem::path& folder, const metrics::ScoreInput& input, Result& result) {
  make_folder(folder);
  const auto save = [&](const std::string& name, const Image8& image) {
    write_png(folder / name, image);
    result.maps.push_back((folder / name).string());
  };
  save("absdiff.png", input.reference.codes
                          ? metrics::absolute_difference(*input.reference.codes, *input.test.codes)
                          : metrics::absolute_difference(*input.reference.codes16, *input.test.codes16));
  for (const auto& [score, scored] : result.scores) {
    if (score->map_file.empty()) continue;
    const std::string name = std::string(score->map_file) + ".png";
    if (scored.map)
      save(name, metrics::map_picture(*score, *scored.map));
    else
      result.warnings.push_back(fmt::format("no {}: {}", name, scored.reason));
  }
}

Result compare(const Options& options, metrics::ScoreTable table) {
  const std::vector<ScoreBound> bounds = parse_bounds(options.fail_above, options.fail_below, table);
  Pictures pictures{read_image(options.reference), read_image(options.test), {}, {}};
  Result result;
  std::tie(result.width, result.height) = std::visit(
      [](const auto& i) {
        return std::pair{i.width, i.height};
      },
      pictures.reference);
  require_size(pictures.test, result.width, result.height, options.test, options.reference + " is",
               "compare pictures of one size");
  prepare(options, pictures, result);
  compare_tags(options, result);
  result.region = compare_region(options.region, result.width, result.height);
  if (result.region && pictures.reference.index() == pictures.test.index())
    equal_outside(*result.region, pictures.reference, pictures.test);
  if (!options.ids_reference.empty()) read_both_ids(options, pictures, result);

  metrics::ScoreInput input{buffers_of(pictures.reference, pictures.reference_ids),
                            buffers_of(pictures.test, pictures.test_ids)};
  const bool codes = (metrics::given(input) & metrics::kNeedsCodes) != 0;
  input.maps = codes && !options.maps.empty();
  if (result.region) input.region = &result.region->counted;
  metrics::Shared shared;
  // Scores of code values are what people expect: pictures without them say why there are none.
  result.scores = metrics::score_pictures(table, input, shared, metrics::kNeedsCodes);
  result.verdicts = check_bounds(bounds, result.scores);
  if (codes) result.worst = metrics::region_difference(input, shared);
  if (input.maps) write_maps(options.maps, input, result);
  if (input.reference.ids) result.by_agent = metrics::score_agents(table, input, shared);
  return result;
}

// The scores of the silhouettes alone, under the names that they have among themselves.
ordered_json silhouettes_json(const Result& result, ordered_json& reasons) {
  ordered_json out = ordered_json::object();
  for (const auto& [score, scored] : result.scores) {
    if (score->needs != metrics::kNeedsIds) continue;
    const std::string name(metrics::name_among_silhouettes(*score));
    out[name] = score_json(scored);
    if (!scored.value) reasons["silhouette." + name] = scored.reason;
  }
  return out;
}

ordered_json agents_json(const metrics::AgentScores& scores) {
  ordered_json out = ordered_json::array();
  for (const metrics::AgentRow& agent : scores.agents) {
    ordered_json row = {{"id", agent.id}, {"pixels_ref", agent.pixels_ref}, {"pixels_test", agent.pixels_test}};
    for (size_t s = 0; s < scores.scores.size(); ++s)
      row[std::string(metrics::name_among_silhouettes(*scores.scores[s]))] = json_number(agent.values[s]);
    out.push_back(std::move(row));
  }
  return out;
}

ordered_json to_json(const Options& options, const Result& result) {
  ordered_json scores = ordered_json::object();
  ordered_json reasons = ordered_json::object();
  put_scores(scores, reasons, result.scores);
  ordered_json out = {{"reference", options.reference}, {"test", options.test}, {"width", result.width},
                      {"height", result.height},        {"scores", scores},     {"reasons", reasons}};
  if (result.worst)
    out["worst"] = {{"difference", result.worst->worst}, {"x", result.worst->worst_x}, {"y", result.worst->worst_y}};
  if (!options.over.empty()) out["over"] = options.over;
  if (result.region) out["region"] = region_json(options.region, *result.region);
  if (!result.verdicts.empty()) out["bounds"] = bounds_json(result.verdicts);
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
      fmt::print("{}{}{}; {:g} = equal\n", score->title, score->unit.empty() ? "" : ", ", score->unit,
                 metrics::best_value(*score));
    else
      fmt::print("not available: {}\n", scored.reason);
    for (const auto& [name, value] : scored.pooled)
      fmt::print("    {:<14} {:>12}\n", name, metrics::value_text(*score, value));
  }
  if (result.worst)
    fmt::print("  largest difference {} at pixel ({}, {})\n", result.worst->worst, result.worst->worst_x,
               result.worst->worst_y);
  for (const std::string& map : result.maps) fmt::print("  wrote {}\n", map);
  if (result.by_agent) print_agents(*result.by_agent);
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
  Command* command = app.add_subcommand("compare", "Score how far one picture is from another, and draw where");
  command->footer(
      std::string(
          "Scores are over sRGB code values of 0..255 as they lie in the files, those of structure over BT.601 luma;\n"
          "`crowdbench schema --scores` says what each is.\n") +
      "Maps: absdiff.png |a - b| by channel" + maps_text(table) +
      ".\n\n"
      "Examples:\n"
      "  crowdbench compare mesh.png flat.png\n"
      "  crowdbench compare mesh.png flat.png --maps maps --json\n"
      "  crowdbench compare old.png new.png --ignore 0,0,640,24 --fail-above mae=0.5    status 1 where it is more\n"
      "  crowdbench compare a.png b.png --over '#808080'       pictures with alpha, in front of grey\n"
      "  crowdbench compare a.png b.png --ids-ref a.exr --ids-test b.exr    one row an agent as well");
  auto options = std::make_shared<Options>();
  command->add_option("REFERENCE", options->reference, "the picture that is right (PNG, EXR, JPEG, TIFF ...)")
      ->required();
  command->add_option("TEST", options->test, "the picture that is judged, of the same size")->required();
  command->add_option("--maps", options->maps, "a folder for the pictures of the error; made where missing")
      ->type_name("DIR")
      ->output_folder();
  command->add_option("--over", options->over,
                      "composite pictures with alpha onto this colour first, '#rrggbb' (else alpha is ignored)");
  command
      ->add_option("--ignore", options->region.ignore,
                   "a rectangle that does not count, x,y,width,height from the upper left; may be repeated.\nThe test "
                   "takes the reference's pixels there; mae, mse, psnr and ssim_union are means of the rest")
      ->type_name("X,Y,W,H")
      ->expected(1)
      ->take_all();
  command->add_option("--mask", options->region.mask, "a picture of the same size: black does not count")
      ->type_name("FILE");
  command
      ->add_option("--fail-above", options->fail_above,
                   "exit 1 where a score is above this (or not available), mae=2; may be repeated")
      ->type_name("SCORE=VALUE")
      ->expected(1)
      ->take_all();
  command->add_option("--fail-below", options->fail_below, "the same for scores that are better high, ssim=0.98")
      ->type_name("SCORE=VALUE")
      ->expected(1)
      ->take_all();
  auto* ids_ref = command->add_option("--ids-ref", options->ids_reference,
                                      "EXR with the reference's agent ids: scores by agent and of the silhouettes");
  auto* ids_test = command->add_option("--ids-test", options->ids_test, "EXR with the test's agent ids");
  ids_ref->needs(ids_test);
  ids_test->needs(ids_ref);
  add_json_option(*command, options->json);
  command->callback([options, table, &run] {
    run = [options, table] {
      const Result result = compare(*options, table);
      for (const std::string& warning : result.warnings) fmt::print(stderr, "crowdbench: warning: {}\n", warning);
      if (options->json)
        fmt::print("{}\n", to_json(*options, result).dump(2));
      else
        print_text(result);
      bool kept = true;
      for (const BoundVerdict& verdict : result.verdicts) {
        if (!verdict.pass) fmt::print(stderr, "crowdbench: {}\n", verdict_text(verdict));
        kept = kept && verdict.pass;
      }
      return kept ? 0 : 1;
    };
  });
}

}  // namespace crowdbench::bench
