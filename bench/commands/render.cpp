#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "bench/commands/commands.h"
#include "bench/commands/scene_options.h"
#include "bench/stage/stage_scenario.h"
#include "core/colour.h"
#include "core/error.h"
#include "core/image_io.h"
#include "core/portable_math.h"
#include "core/progress.h"
#include "core/version.h"
#include "renderers/frame/capture.h"
#include "renderers/gl/context.h"
#include "scene/cast/open_character.h"
#include "scene/crowd/crowd.h"
#include "scene/pose/pose.h"

namespace crowdbench::bench {
namespace {

struct RenderOptions {
  SceneOptions scene;
  std::string representation;
  std::string debug;
  std::vector<std::string> clips;
  uint64_t tick = 0;
  std::string out, mask, ids, depth;
  int supersample = 1;
  // --single
  bool single = false;
  double time = 0;
  std::string height = "1.75";
  double heading_deg = 0;
  std::string eye, target, up, background;
  double fov_y_deg = 40;
  double near = 0.1;
};

constexpr double kPi = 3.14159265358979323846;

float to_linear(uint8_t encoded) { return static_cast<float>(srgb_to_linear(encoded / 255.0)); }

void write_pictures(const RenderOptions& options, const renderers::Capture& capture, const ImageMetadata& metadata) {
  // Alpha is 255 everywhere: three channels say all.
  Image8 colour(capture.colour.width, capture.colour.height, 3);
  for (size_t i = 0; i < colour.pixels(); ++i)
    for (size_t c = 0; c < 3; ++c) colour.data[3 * i + c] = capture.colour.data[4 * i + c];
  if (!options.out.empty()) write_png(options.out, colour, metadata);
  if (!options.mask.empty()) {
    Image8 mask(capture.ids.width, capture.ids.height, 1);
    for (size_t i = 0; i < mask.data.size(); ++i) mask.data[i] = capture.ids.data[i] != 0 ? 255 : 0;
    write_png(options.mask, mask, metadata);
  }
  if (!options.ids.empty()) write_exr(options.ids, capture.ids, metadata);
  if (!options.depth.empty()) write_exr(options.depth, capture.depth, metadata);
}

int render_crowd(const RenderOptions& options) {
  ChosenScenario chosen = read_scenario(options.scene);
  if (!options.representation.empty()) chosen.scenario.representation = options.representation;
  if (!options.clips.empty())
    for (scene::CharacterEntry& entry : chosen.scenario.characters) entry.clips = options.clips;
  renderers::Spec spec = renderers::parse_spec(chosen.scenario.representation);
  if (!options.debug.empty()) renderers::set_debug_view(spec, options.debug);
  const scene::Cast cast = scene::load_cast(chosen.scenario, chosen.folder);
  const auto context = open_context(options.scene.device);
  const Staged staged = stage_scenario(chosen.scenario, cast, *context);
  const scene::Scenario& scenario = staged.scenario;
  const scene::Crowd& crowd = staged.crowd;
  if (staged.solved && staged.solved->unreachable)
    fmt::print(stderr, "crowdbench: warning: {} agents cover {:.1f} % of the picture at most, not {:.1f} %\n",
               crowd.size(), 100 * staged.solved->achieved, 100 * staged.solved->requested);
  const auto frame_at = [&](uint64_t tick) {
    const double seconds = static_cast<double>(tick) / scenario.tick_rate;
    return scene::make_frame(scenario, cast, crowd, scenario.camera.at(seconds), tick);
  };
  const auto representation = renderers::make_representation({.context = *context, .cast = cast}, spec);
  if (representation->has_history())
    for (uint64_t tick = 0; tick < options.tick; ++tick) {
      throw_if_interrupted();
      const scene::Frame before = frame_at(tick);
      representation->advance(before, renderers::all_agents(before));
    }
  const scene::Frame frame = frame_at(options.tick);
  renderers::Renderer renderer(*context, cast);
  const renderers::Capture capture = renderer.capture(frame, *representation, {.supersample = options.supersample});
  ImageMetadata metadata = picture_metadata(scenario, spec.text());
  metadata["tick"] = std::to_string(options.tick);
  write_pictures(options, capture, metadata);
  return 0;
}

int render_single(const RenderOptions& options) {
  if (!options.scene.file.empty())
    throw Error("render --single", "a scenario file makes no sense for one agent", "leave it out");
  if (options.clips.size() > 1) throw Error("--clip", "one agent shows one clip", "give --clip once");
  if (!std::isfinite(options.time)) throw Error("--time", "it is not a finite number", "give seconds");

  scene::LoadOptions load;
  if (options.height == "as_is") {
    load.normalise.height.reset();
  } else {
    char* end = nullptr;
    const double height = std::strtod(options.height.c_str(), &end);
    if (end == options.height.c_str() || *end != '\0' || !(height > 0) || !(height <= 1e4))
      throw Error("--height", fmt::format("'{}' is no height", printable(options.height)),
                  "give metres above 0, or as_is for the file's own units");
    load.normalise.height = height;
  }
  const std::string source = options.scene.character.empty() ? "mannequin" : options.scene.character;
  auto character = std::make_shared<const scene::Character>(scene::open_character(source, load));
  int clip = character->placement.default_clip;
  if (!options.clips.empty())
    clip = options.clips.front() == "none" && !scene::find_clip(*character, "none")
               ? -1
               : scene::require_clip(*character, options.clips.front());

  scene::Cast cast;
  cast.banks.push_back(
      std::make_shared<const scene::PoseBank>(scene::PoseBank::exact(*character, clip, options.time, /*raw=*/true)));
  cast.characters.push_back(character);
  cast.shares.push_back(1.0);
  const scene::PoseBank& bank = *cast.banks.front();
  const double scale = character->placement.scale;

  scene::Frame frame;
  if (!options.scene.size.empty()) {
    const PictureSize size = parse_size(options.scene.size);
    frame.width = size.width;
    frame.height = size.height;
  }
  if (!(options.fov_y_deg > 0 && options.fov_y_deg < 180))
    throw Error("--fov-y-deg", fmt::format("{} is no field of view", options.fov_y_deg), "give degrees in (0, 180)");
  if (!(options.near > 0) || !std::isfinite(options.near))
    throw Error("--near", fmt::format("{} is no distance", options.near), "give a distance above 0");
  if (!std::isfinite(options.heading_deg)) throw Error("--heading-deg", "it is not a finite number", "give degrees");
  scene::Camera& camera = frame.camera;
  camera.fov_y = options.fov_y_deg * kPi / 180;
  camera.near = options.near;
  // By default from the front, at the distance from which the posed bounds fill two thirds of the picture's height.
  const glm::dvec3 low = glm::dvec3(bank.bounds_min()) * scale;
  const glm::dvec3 high = glm::dvec3(bank.bounds_max()) * scale;
  camera.target = options.target.empty() ? (low + high) * 0.5 : parse_vector(options.target, "--target");
  const double distance = (high.y - low.y) * 0.75 / std::tan(camera.fov_y / 2) + std::max(high.z - low.z, 0.0);
  camera.eye = options.eye.empty() ? camera.target + glm::dvec3(0, 0, distance) : parse_vector(options.eye, "--eye");
  if (!options.up.empty()) camera.up = parse_vector(options.up, "--up");
  frame.origin = camera.eye;
  if (!options.background.empty()) {
    const glm::u8vec3 rgb = parse_colour(options.background, "--background");
    frame.background = {to_linear(rgb.x), to_linear(rgb.y), to_linear(rgb.z), 1.0F};
  }
  scene::Outfit white;
  for (glm::vec4& c : white.colours) c = glm::vec4(1.0F);
  frame.outfits.push_back(white);
  scene::FrameAgent agent;
  agent.position = glm::vec3(-frame.origin);
  agent.scale = static_cast<float>(scale);
  const SinCos heading = sincos_turns(options.heading_deg / 360.0);
  agent.heading = {static_cast<float>(heading.sin), static_cast<float>(heading.cos)};
  frame.agents.push_back({agent});

  renderers::Spec spec =
      options.representation.empty() ? renderers::reference_spec() : renderers::parse_spec(options.representation);
  if (!options.debug.empty()) renderers::set_debug_view(spec, options.debug);
  const auto context = open_context(options.scene.device);
  const auto representation = renderers::make_representation({.context = *context, .cast = cast}, spec);
  renderers::Renderer renderer(*context, cast);
  const renderers::Capture capture = renderer.capture(frame, *representation, {.supersample = options.supersample});
  const std::string clip_name =
      clip < 0 ? "none" : fmt::format("{} '{}'", clip, character->clips[static_cast<size_t>(clip)].name);
  const ImageMetadata metadata = {
      {"scenario", fmt::format("single: {}, clip {}, time {} s, height {}, heading {} deg", character->name,
                               printable(clip_name), options.time, options.height, options.heading_deg)},
      {"seed", "0"},
      {"backend", spec.text()},
      {"version", std::string(version())}};
  write_pictures(options, capture, metadata);
  return 0;
}

}  // namespace

void add_render(CLI::App& app, Run& run) {
  CLI::App* command = app.add_subcommand("render", "Draw one tick of a scenario, or one agent alone, to pictures");
  command->footer(
      "Examples:\n"
      "  crowdbench render --agents 100 --tick 30 --out crowd.png --ids ids.exr --depth depth.exr\n"
      "  crowdbench render --agents 1000 --occupancy 0.15 --out crowd.png    camera and crowd solved for 15 %\n"
      "  crowdbench render street.toml --representation flat --out flat.png\n"
      "  crowdbench render --agents 60 --occupancy 0.2 --representation relief --debug steps --out steps.png\n"
      "  crowdbench render --single --character knight.glb --clip Walk --time 0.25 --height as_is \\\n"
      "      --eye 0,1,5 --target 0,1,0 --fov-y-deg 40 --size 512x512 --out x.png --mask m.png");
  auto options = std::make_shared<RenderOptions>();
  add_scene_options(*command, options->scene);
  command->add_option("--representation,-r", options->representation,
                      "how agents are drawn (crowdbench info --representations)");
  command->add_option("--debug", options->debug,
                      "a debug view of the representation instead of its picture:\n" + renderers::debug_views_of_all());
  command->add_option("--clip", options->clips, "clip in use, by name or index; repeatable (--single: one, or none)");
  command->add_option("--tick", options->tick, "which tick of the scenario (30 a second by default)");
  command->add_option("--out", options->out, "colour, PNG");
  command->add_option("--mask", options->mask,
                      "silhouettes, PNG: 255 where an agent covers the pixel's centre, else 0");
  command->add_option("--ids", options->ids, "agent index + 1 by pixel, 0 = nothing: EXR, 32-bit unsigned");
  command->add_option("--depth", options->depth, "metres along the view axis, infinite where empty: EXR, float");
  command->add_option("--supersample", options->supersample, "odd k: k x k samples a pixel, averaged in linear light");
  auto* single = command->add_flag("--single", options->single, "one agent, its glTF origin at the world's origin");
  const auto add_single = [&](const char* name, auto& value, const char* text) {
    command->add_option(name, value, std::string("with --single: ") + text)->needs(single);
  };
  add_single("--time", options->time, "the file's own seconds, clamped to the clip");
  add_single("--height", options->height, "metres, or as_is for the file's own units (default 1.75)");
  add_single("--heading-deg", options->heading_deg, "turns +Z towards +X; 0 leaves the glTF axes untouched");
  add_single("--eye", options->eye, "x,y,z of the camera");
  add_single("--target", options->target, "x,y,z looked at");
  add_single("--up", options->up, "x,y,z (default 0,1,0)");
  add_single("--fov-y-deg", options->fov_y_deg, "vertical field of view in degrees (default 40)");
  add_single("--near", options->near, "near plane (default 0.1); the far one is infinite");
  add_single("--background", options->background, "'#rrggbb', sRGB (default #808080)");
  command->callback([options, &run] {
    run = [options] {
      if (options->out.empty() && options->mask.empty() && options->ids.empty() && options->depth.empty())
        throw Error("render", "no picture is asked for", "give --out x.png (or --mask, --ids, --depth)");
      return options->single ? render_single(*options) : render_crowd(*options);
    };
  });
}

}  // namespace crowdbench::bench
