#include "bench/commands/compare_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <variant>

#include "bench/commands/command_line.h"
#include "bench/commands/options.h"
#include "bench/commands/scene_options.h"
#include "bench/commands/score_json.h"
#include "core/error.h"
#include "metrics/difference.h"

namespace crowdbench::bench {
namespace {

metrics::MapColours parse_colours(const std::string& text) {
  const std::pair<const char*, metrics::MapColours> known[] = {{"own", metrics::MapColours::own},
                                                               {"plain", metrics::MapColours::plain},
                                                               {"error", metrics::MapColours::error},
                                                               {"magma", metrics::MapColours::magma},
                                                               {"viridis", metrics::MapColours::viridis}};
  for (const auto& [name, colours] : known)
    if (text == name) return colours;
  throw Error("--colours", fmt::format("there are no colours '{}'", printable(text)),
              "choose own, plain, error, magma or viridis");
}

metrics::Padding parse_padding(const std::string& text) {
  if (text == "replicate") return metrics::Padding::replicate;
  if (text == "symmetric") return metrics::Padding::symmetric;
  throw Error("--padding", fmt::format("there is no padding '{}'", printable(text)), "choose replicate or symmetric");
}

metrics::OverRounding parse_over_rounding(const std::string& text) {
  if (text == "down") return metrics::OverRounding::down;
  if (text == "nearest") return metrics::OverRounding::nearest;
  throw Error("--over-rounding", fmt::format("there is no rounding '{}'", printable(text)), "choose down or nearest");
}

const char* kind_of(const AnyImage& image) {
  if (has_codes(image)) return "code values";
  return std::holds_alternative<ImageF>(image) ? "floats" : "32-bit ids";
}

int channels_of(const AnyImage& image) {
  return std::visit([](const auto& i) { return i.channels; }, image);
}

metrics::Buffers buffers_of(const AnyImage& image, const ImageU32& ids, const ImageF& depth) {
  metrics::Buffers out;
  out.codes = std::get_if<Image8>(&image);
  out.codes16 = std::get_if<Image16>(&image);
  out.linear = std::get_if<ImageF>(&image);
  if (!ids.empty()) out.ids = &ids;
  if (!depth.empty()) out.depth = &depth;
  return out;
}

// What is compared, by what, and what is written.
void add_inputs_and_outputs(Command& command, CompareOptions& options) {
  command
      .add_option("REFERENCE", options.reference,
                  "what is right: a picture (PNG, EXR, JPEG, TIFF ...), a clip, or a folder of frames")
      ->required();
  command.add_option("TEST", options.test,
                     "what is judged, of the same size and length; not needed for a clip that `pair` stacked");
  command.add_option("--scores", options.scores, "only these, name,name,...; `crowdbench schema --scores` lists them")
      ->type_name("LIST")
      ->capture_default_str();
  add_display_option(command, options.display);
  command.add_option("--fps", options.fps, "frames a second, where clips do not say or frames are in folders")
      ->type_name("F")
      ->number(0.1, 1000);
  command.add_option("--maps", options.maps, "a folder for the pictures of the error; made where missing")
      ->type_name("DIR")
      ->output_folder();
  command
      .add_option("--padding", options.padding,
                  "what stands for the frames before a clip's first: replicate (the first) or symmetric (backwards)")
      ->type_name("KIND")
      ->capture_default_str();
  command
      .add_option(
          "--colours", options.colours,
          "of maps: own (of the score's source), error, magma or viridis, with a bar; or plain:\nown without the bar")
      ->type_name("NAME")
      ->capture_default_str();
  command.add_option("--chart", options.chart, "of clips: a page with every score against time")
      ->type_name("FILE.html")
      ->output_file();
  const Option* over = command.add_option(
      "--over", options.over,
      "composite pictures with alpha onto this colour first, '#rrggbb', on encoded values; else alpha\n"
      "is ignored");
  command
      .add_option("--over-rounding", options.over_rounding,
                  "with --over, to code values: down, as ImageMagick does, or nearest")
      ->type_name("KIND")
      ->capture_default_str()
      ->needs(over);
}

// What counts, and what decides the exit status.
void add_region_and_bounds(Command& command, CompareOptions& options) {
  command
      .add_option("--ignore", options.region.ignore,
                  "a rectangle that does not count, x,y,width,height from the upper left; may be given several "
                  "times.\nThe test "
                  "takes the reference's pixels there; mae, mse, psnr and ssim_union are means of the rest")
      ->type_name("X,Y,W,H")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  command
      .add_option("--mask", options.region.mask,
                  "a picture of the same size: black does not count, all else does, whatever its alpha")
      ->type_name("FILE");
  command
      .add_option("--fail-above", options.fail_above,
                  "exit 1 where a score is above this (or not available), mae=2; may be given several times")
      ->type_name("SCORE=VALUE")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  command.add_option("--fail-below", options.fail_below, "the same for scores that are better high, ssim=0.98")
      ->type_name("SCORE=VALUE")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  auto* ids_ref = command.add_option("--ids-ref", options.ids_reference,
                                     "EXR with the reference's agent ids: scores by agent and of the silhouettes");
  auto* ids_test = command.add_option("--ids-test", options.ids_test, "EXR with the test's agent ids");
  ids_ref->needs(ids_test);
  ids_test->needs(ids_ref);
  const auto add_pair = [&](const char* first, std::string& a, const char* a_text, const char* second, std::string& b,
                            const char* b_text) {
    auto* one = command.add_option(first, a, a_text)->type_name("FILE")->needs(ids_ref);
    auto* other = command.add_option(second, b, b_text)->type_name("FILE")->needs(ids_ref);
    one->needs(other);
    other->needs(one);
  };
  add_pair("--depth-ref", options.depth_reference,
           "EXR with the reference's depth (render --depth): the error by cause then has wrong surfaces",
           "--depth-test", options.depth_test, "EXR with the test's depth");
  add_pair("--pose-ref", options.pose_reference,
           "the reference in other poses, one stored frame earlier say: the error by cause then says which agents show "
           "these",
           "--ids-pose", options.pose_ids, "EXR with the agent ids of that picture");
}

}  // namespace

void add_compare_options(Command& command, CompareOptions& options) {
  add_inputs_and_outputs(command, options);
  add_region_and_bounds(command, options);
  add_json_option(command, options.json);
}

CompareSetup compare_setup(const CompareOptions& options, metrics::ScoreTable table) {
  CompareSetup setup;
  setup.table = options.scores == "all" ? std::vector(table.begin(), table.end())
                                        : chosen_scores(options.scores, "--scores", table);
  // Scores of code values are what people expect, and so is what was asked for by name.
  setup.also = metrics::kNeedsCodes;
  if (options.scores != "all")
    for (const metrics::Score* score : setup.table) setup.also |= score->needs;
  setup.bounds = parse_bounds(options.fail_above, options.fail_below, setup.table);
  if (!options.over.empty()) {
    const glm::u8vec3 over = parse_colour(options.over, "--over");
    setup.over = {over.r, over.g, over.b};
  }
  setup.over_rounding = parse_over_rounding(options.over_rounding);
  setup.colours = parse_colours(options.colours);
  setup.padding = parse_padding(options.padding);
  setup.display = display_of_option(options.display);
  return setup;
}

bool has_codes(const AnyImage& image) {
  return std::holds_alternative<Image8>(image) || std::holds_alternative<Image16>(image);
}

void bring_together(const CompareSetup& setup, const std::optional<CompareRegion>& region, ComparedPictures& pictures,
                    const std::string& reference, const std::string& test, std::vector<std::string>& warnings) {
  for (auto& [image, name] : {std::pair<AnyImage&, const std::string&>{pictures.reference, reference},
                              std::pair<AnyImage&, const std::string&>{pictures.test, test}}) {
    if (channels_of(image) != 4) continue;
    if (!setup.over || !has_codes(image))
      warnings.push_back(printable(name) + ": alpha is ignored" +
                         (has_codes(image) ? "; --over '#rrggbb' composites first" : ""));
    else if (const auto* eight = std::get_if<Image8>(&image))
      image = metrics::over(*eight, *setup.over, setup.over_rounding);
    else
      image = metrics::over(std::get<Image16>(image), *setup.over, setup.over_rounding);
  }
  const bool both_have_codes = has_codes(pictures.reference) && has_codes(pictures.test);
  if (both_have_codes && pictures.reference.index() != pictures.test.index())
    for (AnyImage* image : {&pictures.reference, &pictures.test})
      if (const auto* eight = std::get_if<Image8>(image)) *image = metrics::widen(*eight);
  if (pictures.reference.index() != pictures.test.index())
    throw Error(
        test, fmt::format("holds {}, {} {}", kind_of(pictures.test), printable(reference), kind_of(pictures.reference)),
        "compare two of one kind");
  if (!both_have_codes && setup.over)
    warnings.emplace_back("--over has no effect: the pictures have no 8-bit code values");
  if (region) equal_outside(*region, pictures.reference, pictures.test);
}

metrics::ScoreInput score_input(const CompareSetup& setup, const std::optional<CompareRegion>& region,
                                const ComparedPictures& pictures) {
  metrics::ScoreInput input{buffers_of(pictures.reference, pictures.reference_ids, pictures.reference_depth),
                            buffers_of(pictures.test, pictures.test_ids, pictures.test_depth)};
  if (region) input.region = &region->counted;
  metrics::look_at(setup.display, input);
  input.padding = setup.padding;
  return input;
}

std::optional<NotFinitePair> not_finite_of(const ComparedPictures& pictures) {
  const auto* reference = std::get_if<ImageF>(&pictures.reference);
  const auto* test = std::get_if<ImageF>(&pictures.test);
  if (!reference || !test) return std::nullopt;
  return NotFinitePair{metrics::not_finite(*reference), metrics::not_finite(*test)};
}

std::vector<std::string> write_map(const std::filesystem::path& folder, const std::string& suffix,
                                   const metrics::Score& score, const metrics::ScoreResult& result,
                                   metrics::MapColours colours) {
  std::vector<std::string> files;
  const auto save = [&](const std::string& name, const Image8& image) {
    const std::filesystem::path file = folder / (name + suffix + ".png");
    write_png(file, image);
    files.push_back(file.string());
  };
  if (result.map) save(std::string(score.map_file), metrics::map_picture(score, result, colours));
  for (const metrics::ScoreDrawing& drawing : result.drawings)
    save(drawing.file, metrics::drawing_picture(drawing, colours));
  return files;
}

std::string display_line(const CompareSetup& setup) {
  if (setup.display_from.empty()) return display_line(setup.display);
  return fmt::format("{}; by the scenario in {}, --display goes first", metrics::display_text(setup.display),
                     printable(setup.display_from));
}

void print_display(const CompareSetup& setup, std::span<const metrics::Scored> scores) {
  if (std::none_of(scores.begin(), scores.end(), [](const metrics::Scored& scored) {
        return (scored.score->needs & metrics::kNeedsDisplay) != 0 && scored.result.value;
      }))
    return;
  fmt::print("  display {}\n", display_line(setup));
}

}  // namespace crowdbench::bench
