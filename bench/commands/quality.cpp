#include "bench/experiments/quality.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "core/progress.h"
#include "metrics/pseudocolour.h"
#include "metrics/temporal.h"
#include "renderers/gl/context.h"
#include "scene/cast/open_character.h"
#include "scene/gltf/gltf.h"

namespace crowdbench::bench {
namespace {

using nlohmann::ordered_json;

struct Options {
  std::vector<std::string> representations;
  std::string debug;
  std::string character = "mannequin";
  std::string heights = "120";
  std::string azimuths = "0";
  std::string elevations = "0";
  std::string clip;
  std::string times;
  std::string maps;
  std::string device;
  uint64_t bake_budget_mib = kDefaultBakeBudgetMiB;
  int rows = 480;
  bool exact_pose = false;
  bool flicker = false;
  bool no_cache = false;
  bool causes = false;
  bool json = false;
};

ordered_json number(std::optional<double> value) {
  if (!value || std::isnan(*value)) return nullptr;
  if (std::isinf(*value)) return *value > 0 ? "inf" : "-inf";
  return *value;
}

ordered_json to_json(const QualityRow& row, const std::string& clip) {
  const metrics::FigureScores& s = row.scores;
  return {{"representation", row.representation},
          {"height_px", row.view.height_px},
          {"azimuth_deg", row.view.azimuth_deg},
          {"elevation_deg", row.view.elevation_deg},
          {"clip", clip},
          {"time", row.view.time},
          {"phase", row.phase},
          {"distance_m", row.distance},
          {"silhouette_iou", number(s.silhouette_iou)},
          {"boundary_px_mean", number(s.boundary ? std::optional(s.boundary->mean) : std::nullopt)},
          {"boundary_px_p95", number(s.boundary ? std::optional(s.boundary->p95) : std::nullopt)},
          {"ssim", number(s.ssim)},
          {"ssim_union", number(s.ssim_union)},
          {"psnr", number(s.psnr)},
          {"mae", number(s.mae)}};
}

// Two pictures of one height next to each other, four grey pixels between them.
Image8 side_by_side(const Image8& a, const Image8& b) {
  constexpr int kGap = 4;
  Image8 out(a.width + kGap + b.width, a.height, 3);
  std::fill(out.data.begin(), out.data.end(), uint8_t{64});
  for (int y = 0; y < a.height; ++y)
    for (const auto& [picture, left] : {std::pair{&a, 0}, std::pair{&b, a.width + kGap}})
      for (int x = 0; x < picture->width; ++x) std::copy_n(picture->at(x, y), 3, out.at(left + x, y));
  return out;
}

void write_maps(const std::filesystem::path& folder, const QualityRow& row, const QualityPictures& pictures,
                size_t representation) {
  const auto box = metrics::crop_box(metrics::mask_of(pictures.reference.ids), metrics::mask_of(pictures.test.ids));
  if (!box) return;
  const Image8 reference = metrics::crop(pictures.reference.colour, *box);
  const Image8 test = metrics::crop(pictures.test.colour, *box);
  const std::string name =
      fmt::format("{}h{:g}_a{:g}_e{:g}_t{:g}", representation == 0 ? "" : fmt::format("r{}_", representation),
                  row.view.height_px, row.view.azimuth_deg, row.view.elevation_deg, row.view.time);
  write_png(folder / (name + "_reference.png"), reference);
  write_png(folder / (name + "_test.png"), test);
  write_png(folder / (name + "_side_by_side.png"), side_by_side(reference, test));
  write_png(folder / (name + "_difference.png"),
            metrics::with_colour_bar(metrics::pseudocolour(metrics::error_levels(reference, test)),
                                     "absolute difference, mean of R, G, B (code values)"));
}

// A view's pictures in the order of the times: representation, height, elevation, azimuth.
using FilmKey = std::tuple<size_t, double, double, double>;
struct Film {
  std::vector<Image8> reference, test;
  std::vector<metrics::Mask> silhouettes;
};

std::string cell(std::optional<double> value, int digits) {
  if (!value) return "-";
  return std::isinf(*value) ? "inf" : fmt::format("{:.{}f}", *value, digits);
}

int run_quality(const Options& options) {
  QualitySetup setup;
  for (renderers::Spec spec : parse_representations(options.representations)) {
    if (!options.debug.empty()) renderers::set_debug_view(spec, options.debug);
    setup.representations.push_back(spec.text());
  }
  setup.character = std::make_shared<const scene::Character>(scene::open_character(options.character));
  const scene::Character& character = *setup.character;
  setup.rows = options.rows;
  setup.exact_pose = options.exact_pose;
  setup.use_cache = !options.no_cache;
  setup.causes = options.causes;
  setup.bake_budget = options.bake_budget_mib << 20;

  QualityView view;
  view.clip = options.clip.empty() ? character.placement.default_clip
              : options.clip == "none" && !scene::find_clip(character, "none")
                  ? -1
                  : scene::require_clip(character, options.clip);
  const double start = view.clip < 0 ? 0.0 : character.clips[static_cast<size_t>(view.clip)].start;
  if (options.flicker && options.exact_pose)
    throw Error("--flicker", "an exact pose has no frames between which it could jump", "leave --exact-pose out");
  const std::vector<double> times =
      options.times.empty() ? std::vector<double>{start} : parse_numbers(options.times, "--time", -1e6, 1e6);
  std::vector<double> azimuths;
  for (const double a : parse_numbers(options.azimuths, "--azimuth-deg", -3600, 3600))
    if (std::none_of(azimuths.begin(), azimuths.end(),
                     [&](double b) { return std::abs(std::remainder(a - b, 360.0)) < 1e-9; }))
      azimuths.push_back(a);
  for (const double time : times)
    for (const double height : parse_numbers(options.heights, "--height-px", 4, 4096))
      for (const double elevation : parse_numbers(options.elevations, "--elevation-deg", -90, 90))
        for (const double azimuth : azimuths) {
          view.time = time;
          view.height_px = height;
          view.elevation_deg = elevation;
          view.azimuth_deg = azimuth;
          setup.views.push_back(view);
        }

  if (!options.maps.empty()) make_folder(options.maps);
  gl::Context context({.device = options.device});
  Progress progress("quality", setup.views.size() * setup.representations.size());
  size_t done = 0;
  std::map<FilmKey, Film> films;
  const auto rows = compute_quality(context, setup, [&](const QualityRow& row, const QualityPictures& pictures) {
    if (options.flicker) {
      Film& film = films[{done / setup.views.size(), row.view.height_px, row.view.elevation_deg, row.view.azimuth_deg}];
      film.reference.push_back(pictures.reference.colour);
      film.test.push_back(pictures.test.colour);
      film.silhouettes.push_back(
          metrics::union_of(metrics::mask_of(pictures.reference.ids), metrics::mask_of(pictures.test.ids)));
    }
    if (!options.maps.empty()) write_maps(options.maps, row, pictures, done / setup.views.size());
    ++done;
    progress.advance();
  });

  progress.end();

  const std::string clip = view.clip < 0 ? "none" : character.clips[static_cast<size_t>(view.clip)].name;
  if (options.json) {
    ordered_json out = {{"representations", setup.representations},
                        {"character", character.name},
                        {"renderer", context.renderer()},
                        {"exact_pose", setup.exact_pose}};
    out["rows"] = ordered_json::array();
    for (const QualityRow& row : rows) {
      out["rows"].push_back(to_json(row, clip));
      if (options.causes)
        out["rows"].back()["ssim_if_right"] = {{"silhouette", number(row.causes.silhouette)},
                                               {"surface", number(row.causes.surface)},
                                               {"shading", number(row.causes.shading)}};
    }
    for (const auto& [key, film] : films) {
      const auto& [spec, height, elevation, azimuth] = key;
      const auto score = metrics::flicker(film.reference, film.test, film.silhouettes);
      out["flicker"].push_back({{"representation", setup.representations[spec]},
                                {"height_px", height},
                                {"elevation_deg", elevation},
                                {"azimuth_deg", azimuth},
                                {"frames", film.test.size()},
                                {"flicker", score ? ordered_json(*score) : ordered_json(nullptr)}});
    }
    fmt::print("{}\n", out.dump(2, ' ', false, ordered_json::error_handler_t::replace));
    return 0;
  }
  fmt::print("{}, clip {}, against the mesh at the same view; {}\n", character.name, printable(clip),
             context.renderer());
  std::string shown;
  for (const QualityRow& row : rows) {
    if (row.representation != shown) {
      shown = row.representation;
      fmt::print("{}\n{:>7} {:>7} {:>7} {:>7} | {:>7} {:>7} {:>7} {:>7} {:>7} {:>7}\n", shown, "height", "azimuth",
                 "elev", "time", "IoU", "bound", "b p95", "ssim", "union", "psnr");
    }
    const metrics::FigureScores& s = row.scores;
    fmt::print("{:>7g} {:>7g} {:>7g} {:>7.3f} | {:>7} {:>7} {:>7} {:>7} {:>7} {:>7}", row.view.height_px,
               row.view.azimuth_deg, row.view.elevation_deg, row.view.time, cell(s.silhouette_iou, 4),
               cell(s.boundary ? std::optional(s.boundary->mean) : std::nullopt, 3),
               cell(s.boundary ? std::optional(s.boundary->p95) : std::nullopt, 2), cell(s.ssim, 4),
               cell(s.ssim_union, 4), cell(s.psnr, 2));
    if (options.causes)
      fmt::print(" | ssim with the mesh's silhouette {}, surface {}, shading {}", cell(row.causes.silhouette, 4),
                 cell(row.causes.surface, 4), cell(row.causes.shading, 4));
    fmt::print("\n");
  }
  if (!films.empty()) {
    fmt::print("\nflicker over {} times: mean |second difference in time, less the mesh's| over the silhouettes\n",
               times.size());
    for (const auto& [key, film] : films) {
      const auto& [spec, height_px, elevation, azimuth] = key;
      fmt::print("{:>7g} {:>7g} {:>7g} | {:>7}  {}\n", height_px, azimuth, elevation,
                 cell(metrics::flicker(film.reference, film.test, film.silhouettes), 3), setup.representations[spec]);
    }
  }
  return 0;
}

}  // namespace

void add_quality(Command& app, Run& run) {
  Command* command =
      app.add_subcommand("quality", "Score one agent, drawn by a representation, against the mesh at the same view");
  command->footer(
      "Vertical field of view 30 degrees, background sRGB 128, light fixed to the scene. Lists (30,60,120) and ranges\n"
      "(0:315:45) give a row each. IoU: of the silhouettes; bound: mean and 95th percentile of the distance between\n"
      "their boundaries, pixels; ssim: over the crop; union, psnr: over the pixels of either silhouette.\n"
      "The mesh shows the exact time; the representation shows the frame that it stored for it, unless "
      "--exact-pose.\n\n"
      "Examples:\n"
      "  crowdbench quality --representation flat\n"
      "  crowdbench quality --representation flat --height-px 30,60,120 --azimuth-deg 0:315:45 --elevation-deg 0,30\n"
      "  crowdbench quality --representation flat:views=hemi-12 --clip walk --time 0.25 --maps maps --json");
  auto options = std::make_shared<Options>();
  add_representation_option(*command, options->representations, "what is judged")->required();
  add_character_option(*command, options->character);
  const auto add_list = [&](const char* name, std::string& list, const char* text) {
    command->add_option(name, list, text)->type_name("LIST")->capture_default_str();
  };
  add_list("--height-px", options->heights, "the character's height in pixels, 4 to 4096");
  add_list("--azimuth-deg", options->azimuths, "0 = from the front, 90 = from the character's left");
  add_list("--elevation-deg", options->elevations, "0 = level, 90 = from straight above");
  add_clip_option(*command, options->clip);
  add_list("--time", options->times, "seconds on the file's own axis (the clip's start)");
  command->add_option("--maps", options->maps, "a folder for the pictures and their differences; made where missing")
      ->type_name("DIR")
      ->output_folder();
  command->add_option("--debug", options->debug,
                      "a debug view of the representation instead of its picture, for --maps: relief has boxes, steps "
                      "(taps a ray),\nhit-face and misses, polypostor wire, lines, parts and stretch");
  command->add_option("--rows", options->rows, "rows of the picture, 4:3; taller figures get a larger one")
      ->type_name("N")
      ->capture_default_str()
      ->whole_number(16, 8192);
  command->add_flag("--flicker", options->flicker,
                    "also the flicker of each view, over the times as successive frames (three at least)");
  command->add_flag("--exact-pose", options->exact_pose, "the representation too is given the exact time");
  command->add_flag("--causes", options->causes,
                    "ssim had the pixels of one kind been the mesh's own: outside one silhouette, on another surface, "
                    "otherwise shaded");
  add_bake_options(*command, options->bake_budget_mib, &options->no_cache);
  add_device_option(*command, options->device);
  add_json_option(*command, options->json);
  command->callback([options, &run] { run = [options] { return run_quality(*options); }; });
}

}  // namespace crowdbench::bench
