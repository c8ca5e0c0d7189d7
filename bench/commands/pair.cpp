#include "studies/stimuli/pair.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/scene_options.h"
#include "bench/stage/stage_scenario.h"
#include "core/counted.h"
#include "core/error.h"
#include "renderers/gl/context.h"
#include "scene/cast/cast.h"
#include "studies/stimuli/bodies.h"

namespace crowdbench::bench {
namespace {

struct PairOptions {
  SceneOptions scene;
  std::string a;
  std::string b;
  std::string out;
  double seconds = 25;
  std::optional<size_t> frames;
  uint64_t fps = 30;
  bool no_ground = false;
  bool json = false;
  studies::ClipSettings clip;
};

std::string decibels(double db) { return std::isinf(db) ? "exact" : fmt::format("{:.2f} dB", db); }

// Whether every character has a clip in use that walks straight on.
bool all_walk(const scene::Cast& cast) {
  return std::all_of(cast.banks.begin(), cast.banks.end(), [](const auto& bank) {
    const auto& clips = bank->clips();
    return std::any_of(clips.begin(), clips.end(),
                       [](const scene::BankClip& clip) { return clip.ground_speed > 0.05 && clip.turns == 0; });
  });
}

// A crowd that walks on the spot over a ground gives itself away: where the scenario does not say how it moves, it
// walks in lanes, as far apart as its bodies need.
void let_walk(ChosenScenario& chosen, const scene::Cast& cast) {
  for (const char* const key : {"crowd.motion", "crowd.placement", "crowd.stage", "occupancy"})
    if (chosen.places.contains(key)) return;
  if (chosen.scenario.occupancy || !all_walk(cast)) return;
  chosen.scenario.crowd.motion = scene::MotionKind::lanes;
  if (!chosen.places.contains("crowd.spacing"))
    chosen.scenario.crowd.spacing = std::min(100.0, studies::spacing_of_bodies(chosen.scenario, cast));
}

int run_pair(const PairOptions& options) {
  studies::PairRequest request;
  request.a = parse_representation(options.a, "--a");
  request.b = parse_representation(options.b, "--b");
  request.clip = options.clip;
  request.clip.fps = static_cast<int>(options.fps);
  request.clip.title = "crowdbench pair";
  if (options.frames) {
    request.frames = *options.frames;
  } else {
    request.frames = static_cast<size_t>(std::max(1LL, std::llround(options.seconds * request.clip.fps)));
  }

  ChosenScenario chosen = read_scenario(options.scene);
  chosen.scenario.ground = !options.no_ground;
  const scene::Cast cast = open_cast(chosen.scenario, chosen.folder, chosen.places);
  let_walk(chosen, cast);
  const auto opened = open_context(options.scene.device);
  gl::Context& context = *opened;
  Staged staged = stage_scenario(chosen.scenario, cast, context);
  if (staged.solved && staged.solved->unreachable) {
    fmt::print(stderr, "warning: occupancy {:.3f} is out of reach; the clip has {:.3f}\n", staged.solved->requested,
               staged.solved->achieved);
  }
  request.scenario = std::move(staged.scenario);
  request.crowd = std::move(staged.crowd);
  const studies::Pair pair = studies::export_pair(context, cast, request, options.out);

  const studies::Clip& clip = pair.clip;
  if (!clip.accurate) {
    const studies::ClipError& error = clip.files[0].error;
    fmt::print(stderr, "crowdbench: {}: decoded frame {} is at {}, less than {} dB, even at crf {}; nothing written\n",
               options.out, error.worst_frame, decibels(error.psnr_worst_frame), request.clip.least_psnr,
               clip.attempts.back().crf);
    return 1;
  }
  if (pair.equal)
    fmt::print(stderr, "crowdbench: {} and {} draw equal pictures: there is nothing to tell apart in this clip\n",
               request.a.text(), request.b.text());
  if (options.json) {
    fmt::print("{}", pair.manifest);
    return 0;
  }
  fmt::print("{} of {}x{} at {} fps; {} on top, {} below (by the seed)\n",
             counted(clip.frame_sha256.size(), "frame", "frames"), clip.width, clip.height, clip.fps,
             (pair.a_on_top ? request.a : request.b).text(), (pair.a_on_top ? request.b : request.a).text());
  for (const studies::ClipFile& file : clip.files) {
    fmt::print("{}  {}, {}, {:.1f} MB; decoded: mean {}, worst frame {}{}\n", file.path.string(), file.role,
               file.crf ? fmt::format("{} crf {}", file.pixel_format, *file.crf) : file.pixel_format + " lossless",
               static_cast<double>(file.bytes) / 1e6, decibels(file.error.psnr_mean),
               decibels(file.error.psnr_worst_frame), file.role == "compatibility" ? "  (NOT for studies)" : "");
  }
  fmt::print("{}\n", std::filesystem::path(options.out).replace_extension(".json").string());
  return 0;
}

}  // namespace

void add_pair(Command& app, Run& run) {
  Command* command = app.add_subcommand("pair", "Two representations of one crowd as one stacked clip, for a study");
  command->footer(
      "Where the scenario does not say how the crowd moves, it walks over the ground in lanes.\n"
      "The same scenario and seed give the same bytes on one machine and build. A manifest (JSON) beside the clip "
      "says\n"
      "which half is which, by what rule, and how far the decoded frames lie from the drawn ones.\n"
      "The clip is H.264 with all colour samples (4:4:4), which Chromium plays; Safari, and Firefox on some systems,\n"
      "refuse it.\n"
      "Example:\n  crowdbench pair --a mesh --b flat --agents 250 --seconds 10 --out clip.mp4");
  auto options = std::make_shared<PairOptions>();
  add_scene_options(*command, options->scene);
  command->add_option("--a", options->a, "one representation, name[:key=value,...]")->required()->type_name("R");
  command->add_option("--b", options->b, "the other; a hash of the seed says which is on top")
      ->required()
      ->type_name("R");
  command->add_option("--out", options->out, "the clip to write")->required()->type_name("FILE.mp4")->output_file();
  command->add_option("--fps", options->fps, "frames a second; the scenario's tick rate must be a multiple of it")
      ->type_name("N")
      ->capture_default_str()
      ->whole_number(1, 240);
  auto* seconds = command->add_option("--seconds", options->seconds, "length, in seconds")
                      ->type_name("S")
                      ->capture_default_str()
                      ->number(0.01, 3600);
  command->add_option("--frames", options->frames, "length in frames")
      ->type_name("N")
      ->excludes(seconds)
      ->whole_number(1, 108'000);
  command->add_flag("--no-ground", options->no_ground, "leave the grey grid out");
  command->add_option("--crf", options->clip.crf, "x264's rate factor to start from; lowered until accurate enough")
      ->type_name("N")
      ->capture_default_str()
      ->whole_number(0, 51);
  command->add_option("--least-psnr", options->clip.least_psnr, "decoded accuracy of the worst frame, dB; else exit 1")
      ->type_name("DB")
      ->capture_default_str()
      ->number(0, 200);
  command->add_flag("--compat", options->clip.compat, "also a 4:2:0 copy, marked as not for studies");
  command->add_flag("--master", options->clip.master, "also a lossless RGB copy");
  add_json_option(*command, options->json, "print the manifest");
  command->callback([options, &run] { run = [options] { return run_pair(*options); }; });
}

}  // namespace crowdbench::bench
