#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "metrics/agents.h"
#include "metrics/difference.h"
#include "metrics/pseudocolour.h"
#include "metrics/silhouette.h"
#include "metrics/ssim.h"

namespace crowdbench::bench {
namespace {

using nlohmann::ordered_json;

struct Options {
  std::string reference;
  std::string test;
  std::string maps;
  std::string over;
  std::string ids_reference;
  std::string ids_test;
  bool json = false;
};

struct Result {
  int width = 0;
  int height = 0;
  ordered_json scores = ordered_json::object();
  ordered_json reasons = ordered_json::object();
  std::vector<std::string> warnings;
  std::vector<std::string> maps;
  ordered_json worst;       // null without code values
  ordered_json silhouette;  // null without ids
  std::vector<metrics::AgentScore> agents;
};

// JSON has no infinity and no NaN.
ordered_json number(double value) {
  if (std::isnan(value)) return nullptr;
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return value;
}

void put(Result& result, const std::string& score, std::optional<double> value, const std::string& reason) {
  result.scores[score] = value ? number(*value) : ordered_json(nullptr);
  if (result.scores[score].is_null()) result.reasons[score] = reason;
}

std::array<uint8_t, 3> parse_colour(const std::string& text) {
  const bool shape =
      text.size() == 7 && text[0] == '#' && text.find_first_not_of("0123456789abcdefABCDEF", 1) == text.npos;
  if (!shape) throw Error("--over", fmt::format("'{}' is no colour", printable(text)), "write it as '#rrggbb'");
  std::array<uint8_t, 3> colour{};
  for (size_t c = 0; c < 3; ++c) colour[c] = static_cast<uint8_t>(std::stoi(text.substr(1 + 2 * c, 2), nullptr, 16));
  return colour;
}

int channels_of(const AnyImage& image) {
  return std::visit([](const auto& i) { return i.channels; }, image);
}

// The scores and maps of a pair of integer pictures. Returns SSIM for what is scored by agent.
template <typename T>
std::optional<metrics::Ssim> score_codes(const Image<T>& reference, const Image<T>& test, const Options& options,
                                         Result& result) {
  const auto d = metrics::difference(reference, test);
  const auto a = metrics::luma601(reference);
  const auto b = metrics::luma601(test);
  auto similarity = metrics::ssim(a, b);
  put(result, "mae", d->mae, "");
  put(result, "mse", d->mse, "");
  put(result, "psnr", d->psnr, "");
  put(result, "ssim", similarity ? std::optional(similarity->mean) : std::nullopt,
      fmt::format("a side is below the window's {} pixels", metrics::kSsimWindow));
  put(result, "ms_ssim", metrics::ms_ssim(a, b, similarity ? &*similarity : nullptr),
      fmt::format("a side is below {} pixels, the least for five scales", metrics::kMsSsimSmallest));
  put(result, "gmsd", metrics::gmsd(a, b), "");
  result.worst = {{"difference", d->worst}, {"x", d->worst_x}, {"y", d->worst_y}};
  if (options.maps.empty()) return similarity;

  const std::filesystem::path folder = options.maps;
  make_folder(folder);
  const auto save = [&](const char* name, const Image8& image) {
    write_png(folder / name, image);
    result.maps.push_back((folder / name).string());
  };
  save("absdiff.png", metrics::absolute_difference(reference, test));
  save("error_pseudocolour.png", metrics::with_colour_bar(metrics::pseudocolour(metrics::error_levels(reference, test)),
                                                          "absolute difference, mean of R, G, B (code values)"));
  if (similarity)
    save("ssim_map.png", metrics::ssim_picture(*similarity));
  else
    result.warnings.push_back("no ssim_map.png: " + result.reasons["ssim"].get<std::string>());
  return similarity;
}

// Neither has code values: say so for each, and give what there is.
void score_floats(const AnyImage& reference, const AnyImage& test, const Options& options, Result& result) {
  const auto* a = std::get_if<ImageF>(&reference);
  const auto* b = std::get_if<ImageF>(&test);
  const std::string why =
      a && b ? "float pictures have no 8-bit code values" : "float or 32-bit pictures have no 8-bit code values";
  for (const char* score : {"mae", "mse", "psnr", "ssim", "ms_ssim", "gmsd"}) put(result, score, std::nullopt, why);
  if (a && b) {
    const auto d = metrics::linear_difference(*a, *b);
    put(result, "linear_mae", d.mae, "a pixel is not a number");
    put(result, "linear_rms", d.rms, "a pixel is not a number");
  }
  if (!options.maps.empty()) result.warnings.push_back("no maps: " + why);
  if (!options.over.empty()) result.warnings.push_back("--over has no effect: " + why);
}

ImageU32 read_ids(const std::string& path) {
  AnyImage image = read_image(path);
  auto* ids = std::get_if<ImageU32>(&image);
  if (!ids || ids->channels != 1)
    throw Error(path, "is no picture of agent ids", "name an EXR with one 32-bit unsigned channel (render --ids)");
  return std::move(*ids);
}

void score_ids(const AnyImage& reference, const AnyImage& test, const Options& options, Result& result,
               const metrics::Ssim* similarity) {
  const auto* a = std::get_if<Image8>(&reference);
  const auto* b = std::get_if<Image8>(&test);
  if (!a || !b) throw Error("--ids-ref", "scores by agent need 8-bit pictures", "compare the PNG files");
  const ImageU32 ids_a = read_ids(options.ids_reference);
  const ImageU32 ids_b = read_ids(options.ids_test);
  for (const auto& [ids, path] : {std::pair{&ids_a, &options.ids_reference}, std::pair{&ids_b, &options.ids_test}})
    if (ids->width != a->width || ids->height != a->height)
      throw Error(
          *path,
          fmt::format("is {} x {} pixels, the pictures are {} x {}", ids->width, ids->height, a->width, a->height),
          "name the ids of the same frame");
  result.agents = metrics::score_agents(*a, *b, ids_a, ids_b, {}, similarity);
  const auto mask_a = metrics::mask_of(ids_a);
  const auto mask_b = metrics::mask_of(ids_b);
  const auto iou = metrics::silhouette_iou(mask_a, mask_b);
  const auto boundary = metrics::boundary_distance(mask_a, mask_b);
  result.silhouette = {{"iou", iou ? number(*iou) : nullptr},
                       {"boundary_px_mean", boundary ? number(boundary->mean) : nullptr},
                       {"boundary_px_p95", boundary ? number(boundary->p95) : nullptr}};
  if (!iou) result.reasons["silhouette.iou"] = "both id pictures are empty";
  if (!boundary) result.reasons["silhouette.boundary_px_mean"] = "an id picture has no boundary";
}

Result compare(const Options& options) {
  const auto colour = options.over.empty() ? std::nullopt : std::optional(parse_colour(options.over));
  AnyImage reference = read_image(options.reference);
  AnyImage test = read_image(options.test);
  Result result;
  const auto size = [](const AnyImage& image) {
    return std::visit([](const auto& i) { return std::pair{i.width, i.height}; }, image);
  };
  std::tie(result.width, result.height) = size(reference);
  const auto [width, height] = size(test);
  if (width != result.width || height != result.height)
    throw Error(
        options.test,
        fmt::format("is {} x {} pixels, {} is {} x {}", width, height, options.reference, result.width, result.height),
        "compare pictures of one size");

  const auto has_codes = [](const AnyImage& image) {
    return std::holds_alternative<Image8>(image) || std::holds_alternative<Image16>(image);
  };
  for (auto& [image, path] : {std::pair<AnyImage&, const std::string&>{reference, options.reference},
                              std::pair<AnyImage&, const std::string&>{test, options.test}}) {
    if (channels_of(image) != 4) continue;
    if (!colour || !has_codes(image))
      result.warnings.push_back(printable(path) + ": alpha is ignored" +
                                (has_codes(image) ? "; --over '#rrggbb' composites first" : ""));
    else if (const auto* eight = std::get_if<Image8>(&image))
      image = metrics::over(*eight, *colour);
    else
      image = metrics::over(std::get<Image16>(image), *colour);
  }

  std::optional<metrics::Ssim> similarity;
  if (!has_codes(reference) || !has_codes(test)) {
    score_floats(reference, test, options, result);
  } else if (std::holds_alternative<Image8>(reference) && std::holds_alternative<Image8>(test)) {
    similarity = score_codes(std::get<Image8>(reference), std::get<Image8>(test), options, result);
  } else {
    const auto wide = [](const AnyImage& image) {
      const auto* sixteen = std::get_if<Image16>(&image);
      return sixteen ? *sixteen : metrics::widen(std::get<Image8>(image));
    };
    score_codes(wide(reference), wide(test), options, result);
  }
  if (!options.ids_reference.empty()) score_ids(reference, test, options, result, similarity ? &*similarity : nullptr);
  return result;
}

ordered_json to_json(const Options& options, const Result& result) {
  ordered_json out = {{"reference", options.reference}, {"test", options.test},    {"width", result.width},
                      {"height", result.height},        {"scores", result.scores}, {"reasons", result.reasons}};
  if (!result.worst.is_null()) out["worst"] = result.worst;
  if (!options.over.empty()) out["over"] = options.over;
  out["warnings"] = result.warnings;
  out["maps"] = result.maps;
  if (result.silhouette.is_null()) return out;
  out["silhouette"] = result.silhouette;
  out["agents"] = ordered_json::array();
  for (const metrics::AgentScore& agent : result.agents)
    out["agents"].push_back({{"id", agent.id},
                             {"pixels_ref", agent.pixels_ref},
                             {"pixels_test", agent.pixels_test},
                             {"iou", agent.iou},
                             {"mae", agent.mae},
                             {"mse", agent.mse},
                             {"psnr", number(agent.psnr)},
                             {"ssim_union", agent.ssim_union ? ordered_json(*agent.ssim_union) : nullptr}});
  return out;
}

std::string text_of(const ordered_json& value) {
  return value.is_null()     ? "-"
         : value.is_string() ? value.get<std::string>()
                             : fmt::format("{:.6f}", value.get<double>());
}

void print_text(const Result& result) {
  const std::map<std::string, std::string> meanings = {
      {"mae", "mean absolute error, code values; 0 = equal, 255 = the most"},
      {"mse", "mean squared error, code values squared; 0 = equal"},
      {"psnr", "peak signal to noise, dB; inf = equal"},
      {"ssim", "structural similarity (luma); 1 = equal"},
      {"ms_ssim", "structural similarity over five scales; 1 = equal"},
      {"gmsd", "gradient magnitude similarity deviation; 0 = equal"},
      {"linear_mae", "mean absolute error in the pictures' own unit"},
      {"linear_rms", "root mean square error in the pictures' own unit"}};
  fmt::print("{} x {} pixels\n", result.width, result.height);
  for (const auto& [name, value] : result.scores.items())
    fmt::print("  {:<10} {:>14}  {}\n", name, text_of(value),
               value.is_null() ? "not available: " + result.reasons[name].get<std::string>() : meanings.at(name));
  if (!result.worst.is_null())
    fmt::print("  largest difference {} at pixel ({}, {})\n", result.worst["difference"].get<double>(),
               result.worst["x"].get<int>(), result.worst["y"].get<int>());
  for (const std::string& map : result.maps) fmt::print("  wrote {}\n", map);
  if (result.silhouette.is_null()) return;
  fmt::print("silhouettes: IoU {}, boundary {} px on average, {} px at the 95th percentile\n",
             text_of(result.silhouette["iou"]), text_of(result.silhouette["boundary_px_mean"]),
             text_of(result.silhouette["boundary_px_p95"]));
  fmt::print("{:>8} {:>9} {:>9} {:>8} {:>9} {:>9} {:>10}\n", "agent id", "px ref", "px test", "IoU", "MAE", "PSNR",
             "SSIM union");
  for (const metrics::AgentScore& a : result.agents)
    fmt::print("{:>8} {:>9} {:>9} {:>8.4f} {:>9.3f} {:>9.3f} {:>10}\n", a.id, a.pixels_ref, a.pixels_test, a.iou, a.mae,
               a.psnr, a.ssim_union ? fmt::format("{:.4f}", *a.ssim_union) : "-");
}

}  // namespace

void add_compare(Command& app, Run& run) {
  Command* command = app.add_subcommand("compare", "Score how far one picture is from another, and draw where");
  command->footer(
      "Scores are over sRGB code values of 0..255 as they lie in the files; SSIM, MS-SSIM and GMSD are of BT.601 "
      "luma.\n"
      "Maps: absdiff.png |a - b| by channel; error_pseudocolour.png dark blue (equal) to red (the most), with its "
      "colour\n"
      "bar; ssim_map.png white (equal) to black, one pixel a window, so 10 pixels narrower and lower.\n\n"
      "Examples:\n"
      "  crowdbench compare mesh.png flat.png\n"
      "  crowdbench compare mesh.png flat.png --maps maps --json\n"
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
  auto* ids_ref = command->add_option("--ids-ref", options->ids_reference,
                                      "EXR with the reference's agent ids: scores by agent and of the silhouettes");
  auto* ids_test = command->add_option("--ids-test", options->ids_test, "EXR with the test's agent ids");
  ids_ref->needs(ids_test);
  ids_test->needs(ids_ref);
  add_json_option(*command, options->json);
  command->callback([options, &run] {
    run = [options] {
      const Result result = compare(*options);
      for (const std::string& warning : result.warnings) fmt::print(stderr, "crowdbench: warning: {}\n", warning);
      if (options->json)
        fmt::print("{}\n", to_json(*options, result).dump(2, ' ', false, ordered_json::error_handler_t::replace));
      else
        print_text(result);
      return 0;
    };
  });
}

}  // namespace crowdbench::bench
