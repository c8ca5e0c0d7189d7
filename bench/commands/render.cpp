#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "bench/commands/chosen_representation.h"
#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/level_output.h"
#include "bench/commands/scene_options.h"
#include "bench/stage/stage_facts.h"
#include "bench/stage/stage_scenario.h"
#include "bench/stage/truth_capture.h"
#include "core/colour.h"
#include "core/counted.h"
#include "core/error.h"
#include "core/image_io.h"
#include "core/json.h"
#include "core/portable_math.h"
#include "core/progress.h"
#include "core/version.h"
#include "renderers/frame/capture.h"
#include "renderers/gl/context.h"
#include "scene/cast/open_character.h"
#include "scene/crowd/crowd.h"
#include "scene/pose/pose.h"
#include "scene/scenario/parse_scenario.h"

namespace crowdbench::bench {
namespace {

struct RenderOptions {
  SceneOptions scene;
  std::string representation;
  std::string debug;
  std::vector<std::string> clips;
  uint64_t tick = 0;
  std::string out, mask, ids, depth;
  bool json = false;
  bool truth = false;
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

// Writes what was asked for, and says on stdout what was drawn.
void write_pictures(const RenderOptions& options, const renderers::Capture& capture, const ImageMetadata& metadata,
                    const std::string& drawn) {
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
  std::string files;
  for (const std::string* file : {&options.out, &options.mask, &options.ids, &options.depth})
    if (!file->empty()) files += (files.empty() ? "" : ", ") + printable(*file);
  fmt::print(options.json ? stderr : stdout, "drew {}, {}x{} pixels: {}\n", drawn, capture.colour.width,
             capture.colour.height, files);
}

std::string json_of(const Staged& staged, const scene::Cast& cast, gl::Context& context, const renderers::Spec& spec,
                    std::span<const renderers::LevelInfo> levels, const RenderOptions& options) {
  const Json facts = {{"representation", spec.text()},
                      {"tick", options.tick},
                      {"renderer", context.renderer()},
                      {"levels", levels_json(levels)},
                      {"stage", stage_json(measure_stage(staged, cast, context))}};
  return facts.dump(2) + "\n";
}

// --truth: the picture, and with --json what it says of the reference as this device draws it.
int render_truth(const RenderOptions& options, const ChosenScenario& chosen) {
  Progress progress("render", 0);
  progress.note("loading the characters");
  const scene::Cast cast = open_cast(chosen.scenario, chosen.folder, chosen.places);
  // Without either no driver is needed.
  std::unique_ptr<gl::Context> context;
  if (options.json || must_solve(chosen.scenario)) context = open_context(options.scene.device);
  progress.note("placing the agents");
  const Staged staged =
      context ? stage_scenario(chosen.scenario, cast, *context) : stage_as_given(chosen.scenario, cast);
  const double seconds = static_cast<double>(options.tick) / staged.scenario.tick_rate;
  const scene::Frame frame =
      scene::make_frame(staged.scenario, cast, staged.crowd, staged.scenario.camera.at(seconds), options.tick);
  progress.note("");
  const truth::TruthPicture picture = truth::cast_truth(cast, frame);
  std::string facts;
  if (options.json) {
    const renderers::Spec judged = renderers::reference_spec();
    const auto representation = renderers::make_representation({.context = *context, .cast = cast}, judged);
    const renderers::Capture drawn = renderers::Renderer(*context, cast).capture(frame, *representation);
    const truth::Judgement judgement = truth::judge(cast, frame, picture, {drawn.ids, drawn.depth, drawn.colour});
    facts = Json({{"representation", kTruthName},
                  {"tick", options.tick},
                  {"renderer", context->renderer()},
                  {"stage", stage_json(measure_stage(staged, cast, *context))},
                  {kTruthName, judgement_json(judgement, judged.text())}})
                .dump(2) +
            "\n";
    fmt::print(stderr, "{}\n", judgement_line(judgement, judged.text()));
  }
  ImageMetadata metadata = picture_metadata(staged.scenario, kTruthName);
  metadata["tick"] = std::to_string(options.tick);
  progress.end();
  write_pictures(options, capture_of(picture), metadata,
                 fmt::format("{} agent{} as the {}, tick {}", staged.crowd.size(), staged.crowd.size() == 1 ? "" : "s",
                             kTruthName, options.tick));
  fmt::print("{}", facts);
  return 0;
}

int render_crowd(const RenderOptions& options) {
  ChosenScenario chosen = read_scenario(options.scene);
  override_representation(chosen, options.representation);
  if (!options.clips.empty())
    for (size_t i = 0; i < chosen.scenario.characters.size(); ++i) {
      chosen.scenario.characters[i].clips = options.clips;
      chosen.places[scene::key_place("character", "clips", i)] = "--clip";
    }
  if (options.truth) return render_truth(options, chosen);
  renderers::Spec spec = representation_of(chosen);
  if (!options.debug.empty()) renderers::set_debug_view(spec, options.debug);
  Progress progress("render", 0);
  progress.note("loading the characters");
  const scene::Cast cast = open_cast(chosen.scenario, chosen.folder, chosen.places);
  const auto context = open_context(options.scene.device);
  progress.note(fmt::format("placing {}", counted(chosen.scenario.crowd.agents, "agent", "agents")));
  const Staged staged = stage_scenario(chosen.scenario, cast, *context);
  const scene::Scenario& scenario = staged.scenario;
  const scene::Crowd& crowd = staged.crowd;
  if (staged.solved && staged.solved->unreachable)
    fmt::print(stderr, "crowdbench: warning: {} {} {:.1f} % of the picture at most, not {:.1f} %\n",
               counted(crowd.size(), "agent", "agents"), crowd.size() == 1 ? "covers" : "cover",
               100 * staged.solved->achieved, 100 * staged.solved->requested);
  const auto frame_at = [&](uint64_t tick) {
    const double seconds = static_cast<double>(tick) / scenario.tick_rate;
    return scene::make_frame(scenario, cast, crowd, scenario.camera.at(seconds), tick);
  };
  progress.note("making " + spec.text());
  const auto representation = make_chosen(chosen, {.context = *context, .cast = cast}, spec);
  if (representation->has_history()) {
    Progress played("playing the ticks before", options.tick);
    for (uint64_t tick = 0; tick < options.tick; ++tick) {
      played.advance();
      const scene::Frame before = frame_at(tick);
      representation->advance(before, renderers::all_agents(before));
    }
  }
  progress.note(fmt::format("drawing {} agent{} as {}", crowd.size(), crowd.size() == 1 ? "" : "s", spec.text()));
  const scene::Frame frame = frame_at(options.tick);
  renderers::Renderer renderer(*context, cast);
  const renderers::Capture capture = renderer.capture(frame, *representation);
  ImageMetadata metadata = picture_metadata(scenario, spec.text());
  metadata["tick"] = std::to_string(options.tick);
  progress.end();
  size_t in_view = 0;
  for (const auto& agents : frame.agents) in_view += agents.size();
  const std::string drawn = fmt::format("{} agent{} ({} in view) as {}, tick {}", crowd.size(),
                                        crowd.size() == 1 ? "" : "s", in_view, spec.text(), options.tick);
  const std::vector<renderers::LevelInfo> levels = representation->bake_info().levels;
  for (const renderers::LevelInfo& level : levels)
    fmt::print(options.json ? stderr : stdout, "level of {}\n", level_text(level));
  write_pictures(options, capture, metadata, drawn);
  if (options.json) fmt::print("{}", json_of(staged, cast, *context, spec, levels, options));
  return 0;
}

scene::CharacterEntry single_entry(const RenderOptions& options) {
  scene::CharacterEntry entry = options.scene.character.entry();
  if (!entry.turn_deg) entry.turn_deg = 0.0;  // one agent stands as it is in its file; --heading-deg turns it
  entry.clips = options.clips;
  if (options.height == "as_is") {
    entry.height.reset();
    return entry;
  }
  char* end = nullptr;
  const double height = std::strtod(options.height.c_str(), &end);
  if (end == options.height.c_str() || *end != '\0' || !(height > 0) || !(height <= 1e4))
    throw Error("--height", fmt::format("'{}' is not a height", printable(options.height)),
                "give metres above 0, or as_is for the file's own units");
  entry.height = height;
  return entry;
}

// By default from the front, at the distance from which the posed bounds fill two thirds of the picture's height.
scene::Camera single_camera(const RenderOptions& options, const scene::PoseBank& bank, double scale) {
  scene::Camera camera;
  camera.fov_y = options.fov_y_deg * kPi / 180;
  camera.near = options.near;
  const glm::dvec3 low = glm::dvec3(bank.bounds_min()) * scale;
  const glm::dvec3 high = glm::dvec3(bank.bounds_max()) * scale;
  camera.target = options.target.empty() ? (low + high) * 0.5 : parse_vector(options.target, "--target");
  const double distance = (high.y - low.y) * 0.75 / std::tan(camera.fov_y / 2) + std::max(high.z - low.z, 0.0);
  camera.eye = options.eye.empty() ? camera.target + glm::dvec3(0, 0, distance) : parse_vector(options.eye, "--eye");
  if (!options.up.empty()) camera.up = parse_vector(options.up, "--up");
  return camera;
}

// One agent in the middle of the world, without a tint.
scene::Frame single_frame(const RenderOptions& options, const scene::PoseBank& bank, double scale) {
  scene::Frame frame;
  if (!options.scene.size.empty()) {
    const PictureSize size = parse_size(options.scene.size);
    frame.width = size.width;
    frame.height = size.height;
  }
  options.scene.antialiasing.change(frame.antialiasing);
  frame.camera = single_camera(options, bank, scale);
  frame.origin = frame.camera.eye;
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
  return frame;
}

// The picture, and what it was drawn as.
std::pair<renderers::Capture, std::string> capture_single(const RenderOptions& options, const scene::Cast& cast,
                                                          const scene::Frame& frame) {
  if (options.truth) return {capture_of(truth::cast_truth(cast, frame)), kTruthName};
  renderers::Spec spec =
      options.representation.empty() ? renderers::reference_spec() : parse_representation(options.representation);
  if (!options.debug.empty()) renderers::set_debug_view(spec, options.debug);
  const auto context = open_context(options.scene.device);
  const auto representation = renderers::make_representation({.context = *context, .cast = cast}, spec);
  renderers::Renderer renderer(*context, cast);
  return {renderer.capture(frame, *representation), spec.text()};
}

int render_single(const RenderOptions& options) {
  if (!options.scene.file.empty())
    throw Error("render --single", "a scenario file makes no sense for one agent", "leave it out");
  if (options.clips.size() > 1) throw Error("--clip", "one agent shows one clip", "give --clip once");
  auto character = std::make_shared<const scene::Character>(scene::open_character(single_entry(options)));
  print_warnings(*character);
  int clip = character->placement.default_clip;
  if (!options.clips.empty()) clip = scene::require_clip_or_none(*character, options.clips.front());

  scene::Cast cast;
  cast.banks.push_back(
      std::make_shared<const scene::PoseBank>(scene::PoseBank::exact(*character, clip, options.time, /*raw=*/true)));
  cast.characters.push_back(character);
  cast.shares.push_back(1.0);
  const scene::Frame frame = single_frame(options, *cast.banks.front(), character->placement.scale);

  const auto [capture, drawn_as] = capture_single(options, cast, frame);
  const std::string clip_name =
      printable(clip < 0 ? "none" : fmt::format("{} '{}'", clip, character->clips[static_cast<size_t>(clip)].name));
  const ImageMetadata metadata = {
      {"scenario", fmt::format("single: {}, clip {}, time {} s, height {}, heading {} deg", character->name, clip_name,
                               options.time, options.height, options.heading_deg)},
      {"seed", "0"},
      {"backend", drawn_as},
      {"version", std::string(version())}};
  write_pictures(options, capture, metadata,
                 fmt::format("{} (clip {}) as {}", printable(character->name), clip_name, drawn_as));
  return 0;
}

// What is drawn instead of a representation, or of its picture.
void add_truth_and_debug(Command& command, RenderOptions& options) {
  command
      .add_flag(
          "--truth", options.truth,
          "instead of a representation what there is to see, by rays in double precision on the CPU (truth/truth.h\n"
          "says how textures are filtered); --supersample says how many a pixel, --samples has no say. With --json\n"
          "also the reference as this device draws it, judged pixel by pixel")
      ->excludes("--representation");
  command
      .add_option("--debug", options.debug,
                  "a debug view of the representation instead of its picture:\n" + renderers::debug_views_of_all())
      ->excludes("--truth");
}

}  // namespace

void add_render(Command& app, Run& run) {
  Command* command = app.add_subcommand("render", "Draw one tick of a scenario, or one agent alone, to pictures");
  command->footer(
      "Examples:\n"
      "  crowdbench render --agents 100 --tick 30 --out crowd.png --ids ids.exr --depth depth.exr\n"
      "  crowdbench render --agents 1000 --occupancy 0.15 --out crowd.png    camera and crowd solved for 15 %\n"
      "  crowdbench render street.toml --representation flat --out flat.png\n"
      "  crowdbench render --agents 60 --occupancy 0.2 --representation relief --debug steps --out steps.png\n"
      "  crowdbench render --agents 100 --truth --supersample 3 --out truth.png     for `crowdbench compare`\n"
      "  crowdbench render --single --character knight.glb --clip Walk --time 0.25 --height as_is \\\n"
      "      --eye 0,1,5 --target 0,1,0 --fov-y-deg 40 --size 512x512 --out x.png --mask m.png");
  auto options = std::make_shared<RenderOptions>();
  add_scene_options(*command, options->scene);
  add_representation_option(*command, options->representation,
                            "how agents are drawn (the scenario's, else the reference)");
  add_truth_and_debug(*command, *options);
  command
      ->add_option("--clip", options->clips,
                   "clip in use, by name or index; may be given several times (--single: one, or none)")
      ->type_name("CLIP")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command->add_option("--tick", options->tick, "which tick of the scenario (30 a second by default)")
      ->type_name("N")
      ->capture_default_str()
      ->whole_number(0, 1'000'000'000);
  const auto add_picture = [&](const char* name, std::string& file, const char* type, const char* text) {
    command->add_option(name, file, text)->type_name(type)->output_file();
  };
  add_picture("--out", options->out, "FILE.png", "colour");
  add_picture("--mask", options->mask, "FILE.png", "silhouettes: 255 where an agent covers the pixel's centre, else 0");
  add_picture("--ids", options->ids, "FILE.exr", "agent index + 1 by pixel, 0 = nothing: 32-bit unsigned");
  add_picture("--depth", options->depth, "FILE.exr", "metres along the view axis, infinite where empty: float");
  auto* json = add_json_option(*command, options->json,
                               "print what stands on the stage: the camera, the crowd's placement, the occupancy");
  auto* single = command->add_flag("--single", options->single, "one agent, its glTF origin at the world's origin")
                     ->excludes(json);
  const auto add_single = [&](const char* name, auto& value, const char* text) {
    return command->add_option(name, value, std::string("with --single: ") + text)->needs(single);
  };
  add_single("--time", options->time, "the file's own seconds, clamped to the clip")->number(-1e9, 1e9);
  add_single("--height", options->height, "metres, or as_is for the file's own units (default 1.75)");
  add_single("--heading-deg", options->heading_deg, "turns +Z towards +X; 0 leaves the glTF axes untouched")
      ->number(-360, 360);
  add_single("--eye", options->eye, "x,y,z of the camera");
  add_single("--target", options->target, "x,y,z looked at");
  add_single("--up", options->up, "x,y,z (default 0,1,0)");
  add_single("--fov-y-deg", options->fov_y_deg, "vertical field of view in degrees (default 40)")->number(0.1, 179);
  add_single("--near", options->near, "near plane (default 0.1); the far one is infinite")->number(1e-6, 1e6);
  add_single("--background", options->background, "'#rrggbb', sRGB (default #808080)");
  command->callback([options, &run] {
    run = [options] {
      if (options->out.empty() && options->mask.empty() && options->ids.empty() && options->depth.empty() &&
          !options->json)
        throw Error("render", "no picture is asked for", "give --out x.png (or --mask, --ids, --depth, --json)");
      return options->single ? render_single(*options) : render_crowd(*options);
    };
  });
}

}  // namespace crowdbench::bench
