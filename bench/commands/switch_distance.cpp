#include "bench/experiments/switch_distance.h"

#include <fmt/format.h>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "bench/commands/scene_options.h"
#include "bench/experiments/quality.h"
#include "core/error.h"
#include "core/json.h"
#include "core/progress.h"
#include "scene/gltf/gltf.h"
#include "scene/pose/normalise.h"

namespace crowdbench::bench {
namespace {

struct SwitchDistanceOptions {
  std::string representation = renderers::default_impostor().text();
  CharacterOptions character;
  std::string clip;
  std::string ratios = "0.5,1,2";
  std::string size = "640x480";
  std::string device;
  uint64_t bake_budget_mib = kDefaultBakeBudgetMiB;
  SwitchRequest request;
  bool no_cache = false;
  bool json = false;
};

Json number(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

std::optional<double> error_percent(const SwitchRow& row) {
  if (!row.measured_depth) return std::nullopt;
  return 100 * (*row.measured_depth / row.depth - 1);
}

Json to_json(const SwitchRow& row) {
  return {{"ratio", row.ratio},
          {"depth_m", row.depth},
          {"distance_m", row.distance},
          {"height_px", row.height_px},
          {"stretch", row.stretch},
          {"measured_depth_m", number(row.measured_depth)},
          {"measured_over_derived_percent", number(error_percent(row))},
          {"measured_stretch", number(row.measured_stretch)},
          {"unity_screen_relative_height", row.engines.unity_height},
          {"unreal_screen_size", row.engines.unreal_size},
          {"godot_visibility_range_m", row.engines.godot_metres}};
}

Json to_json(const SwitchRequest& request, const SwitchReport& report, const std::string& renderer) {
  Json out = {{"character", request.character->name},
              {"representation", request.representation.text()},
              {"texel_m", report.texel * request.scale},
              {"height_m", report.height * request.scale},
              {"width", request.width},
              {"height", request.height},
              {"fov_y_deg", request.fov_y_deg},
              {"azimuth_deg", request.azimuth_deg},
              {"elevation_deg", request.elevation_deg},
              {"off_axis_deg", request.off_axis_deg},
              {"renderer", renderer},
              {"measured", report.measured},
              {"rows", Json::array()}};
  for (const SwitchRow& row : report.rows) out["rows"].push_back(to_json(row));
  return out;
}

void print_table(const SwitchRequest& request, const SwitchReport& report) {
  fmt::print("{} of {}: texels of {:.2f} mm, {}x{}, {:g} degrees tall, {:g} degrees off the axis\n",
             request.representation.text(), printable(request.character->name), 1000 * report.texel * request.scale,
             request.width, request.height, request.fov_y_deg, request.off_axis_deg);
  fmt::print("{:>6} {:>9} {:>9} {:>7} {:>9} {:>9} {:>8}  {:>7} {:>7} {:>8}\n", "pixels", "depth", "measured", "error",
             "stretch", "measured", "height", "Unity", "Unreal", "Godot");
  fmt::print("{:>6} {:>9} {:>9} {:>7} {:>9} {:>9} {:>8}  {:>7} {:>7} {:>8}\n", "/texel", "m", "m", "%", "", "",
             "pixels", "height", "size", "m");
  const auto text = [](const std::optional<double>& v, const char* form) {
    return v ? fmt::format(fmt::runtime(form), *v) : std::string("n/a");
  };
  for (const SwitchRow& row : report.rows)
    fmt::print("{:>6g} {:>9.3f} {:>9} {:>7} {:>9.4f} {:>9} {:>8.1f}  {:>7.4f} {:>7.4f} {:>8.3f}\n", row.ratio,
               row.depth, text(row.measured_depth, "{:.3f}"), text(error_percent(row), "{:+.2f}"), row.stretch,
               text(row.measured_stretch, "{:.4f}"), row.height_px, row.engines.unity_height, row.engines.unreal_size,
               row.engines.godot_metres);
  if (!report.measured)
    fmt::print(
        "not measured: {} does not draw the places of its texels; derived from the texel that it was captured with\n",
        request.representation.name);
  fmt::print(
      "depth: along the view axis, derived and as measured from pictures of the impostor. Nearer than that draw the "
      "mesh.\n"
      "stretch: of a texel towards the picture's edge; perspective stretches the mesh alike. Unity: fraction of the\n"
      "screen's height of LODGroup.size at lodBias 1; Unreal: ComputeBoundsScreenSize; Godot: visibility range, "
      "Euclidean.\n");
}

SwitchRequest read_request(const SwitchDistanceOptions& options) {
  SwitchRequest request = options.request;
  request.representation = parse_representation(options.representation);
  request.ratios = parse_numbers(options.ratios, "--ratio", 0.01, 100);
  const PictureSize size = parse_size(options.size);
  request.width = size.width;
  request.height = size.height;
  request.character = open_subject(options.character, options.clip);
  request.clip = request.character->placement.default_clip;
  if (!options.clip.empty()) request.clip = scene::require_clip_or_none(*request.character, options.clip);
  request.bake_budget = options.bake_budget_mib << 20;
  request.use_cache = !options.no_cache;
  return request;
}

int run_switch_distance(const SwitchDistanceOptions& options) {
  const SwitchRequest request = read_request(options);
  const auto context = open_context(options.device);
  Progress progress("switch-distance", 0);
  const SwitchReport report = measure_switch_distance(*context, request);
  progress.end();
  if (options.json)
    fmt::print("{}\n", to_json(request, report, context->renderer()).dump(2));
  else
    print_table(request, report);
  return 0;
}

}  // namespace

void add_switch_distance(Command& app, Run& run) {
  Command* command =
      app.add_subcommand("switch-distance", "Where a texel of an impostor covers a pixel: derived and measured");
  command->footer(
      "Derived: d = texel * rows / (2 * ratio * tan(fov / 2)). Measured: the impostor is drawn as texel coordinates, "
      "and\n"
      "moved until a texel at its middle spans that many pixels.\n\n"
      "Examples:\n"
      "  crowdbench switch-distance --representation flat:texels=64\n"
      "  crowdbench switch-distance --character knight.glb --ratio 0.5:2:0.5 --fov-y-deg 60 --size 1920x1080 "
      "--off-axis-deg 30 --json");
  auto options = std::make_shared<SwitchDistanceOptions>();
  SwitchRequest& request = options->request;
  add_representation_option(*command, options->representation, "an impostor with texels");
  add_character_options(*command, options->character);
  add_clip_option(*command, options->clip);
  command->add_option("--ratio", options->ratios, "pixels that a texel spans, 0.01 to 100")
      ->type_name("LIST")
      ->capture_default_str();
  add_size_option(*command, options->size);
  const auto add_number = [&](const char* name, double& value, double low, double high, const char* text) {
    command->add_option(name, value, text)->type_name("X")->capture_default_str()->number(low, high);
  };
  add_number("--fov-y-deg", request.fov_y_deg, 1, 170, "vertical field of view in degrees");
  add_number("--azimuth-deg", request.azimuth_deg, -360, 360, "0 = seen from the front, 90 = from its left");
  add_number("--elevation-deg", request.elevation_deg, -89, 90, "0 = level, 90 = from straight above");
  add_number("--off-axis-deg", request.off_axis_deg, 0, 85, "the agent's angle off the view axis");
  add_number("--scale", request.scale, 0.01, 100, "of the agent");
  add_bake_options(*command, options->bake_budget_mib, &options->no_cache);
  add_device_option(*command, options->device);
  add_json_option(*command, options->json);
  command->callback([options, &run] { run = [options] { return run_switch_distance(*options); }; });
}

}  // namespace crowdbench::bench
