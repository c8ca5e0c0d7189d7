#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "bench/commands/scene_options.h"
#include "bench/commands/score_commands.h"
#include "bench/experiments/bench_run.h"
#include "bench/experiments/quality_rows.h"
#include "bench/experiments/score_rows.h"
#include "bench/stage/cast_name.h"
#include "bench/stage/low_polygon.h"
#include "bench/stage/stage_scenario.h"
#include "bench/timing/run_facts.h"
#include "core/command_line.h"
#include "core/counted.h"
#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "core/progress.h"
#include "metrics/pseudocolour.h"
#include "reports/page/report_page.h"
#include "scene/cast/cast.h"
#include "scene/scenario/scenario.h"
#include "studies/stimuli/pair.h"

namespace crowdbench::bench {
namespace {

struct DemoOptions {
  metrics::ScoreTable table;
  std::vector<std::string> characters;
  CharacterOptions character;  // for all of them
  std::string out = "crowdbench-demo";
  std::string representation = renderers::default_impostor().text();
  std::string device;
  bool no_clip = false;
  bool tiny = false;
};

// About what a character takes on two cores without a GPU, seconds, and how much of that the clip takes.
constexpr double kCharacterSeconds = 180;
constexpr double kClipSeconds = 40;

// Says what is going on and when, one line a step, and how long all of it will take.
class Steps {
 public:
  Steps(size_t total, double expected_s) : total_(total), expected_s_(expected_s), progress_("demo", total) {
    progress_.say(fmt::format("demo: {} steps, about {} on two cores without a GPU", total, duration_text(expected_s)));
  }
  void next(const std::string& text) {
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    progress_.say(fmt::format("[{}/{}, {:.0f} s] {}", ++done_, total_, seconds, text));
    progress_.set_done(done_ - 1);
    progress_.note(text);
    progress_.expect(expected_s_ - seconds);
  }
  void say(const std::string& line) { progress_.say("  " + line); }
  void end() { progress_.end(); }

 private:
  size_t total_;
  double expected_s_;
  Progress progress_;
  size_t done_ = 0;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::string file_stem(const scene::Cast& cast) {
  std::string stem;
  for (const char c : cast_name(cast))
    stem += (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ? c : '_';
  return stem.substr(0, 60);
}

scene::Scenario demo_scenario(const std::string& source, const CharacterOptions& character) {
  scene::Scenario scenario;
  scenario.name = "demo";
  scene::CharacterEntry entry = character.entry();
  entry.source = source;
  scenario.characters = {entry};
  return scenario;
}

// A larger, anti-aliased view of the crowd on its ground: for looking at, not for measuring.
void draw_heroes(gl::Context& context, const scene::Cast& cast, scene::Scenario scenario, const DemoOptions& options,
                 StoreWriter& store, int64_t run) {
  scenario.width = options.tiny ? 160 : 1280;
  scenario.height = options.tiny ? 90 : 720;
  scenario.ground = true;
  scenario.crowd.agents = options.tiny ? 10 : 250;
  scenario.crowd.spacing = 1.3;
  scenario.camera.keys = {{0.0, scene::Camera{{5.5, 3.4, 11.5}, {0.0, 0.7, 0.0}}}};
  const Staged staged = stage_scenario(scenario, cast, context);
  scene::Frame frame = scene::make_frame(staged.scenario, cast, staged.crowd, staged.camera, 20);
  if (!options.tiny) frame.antialiasing.supersample = 3;
  renderers::Renderer renderer(context, cast);
  for (const std::string& name : {renderers::reference_spec().text(), options.representation}) {
    const auto representation = renderers::make_representation({context, cast}, renderers::parse_spec(name));
    const renderers::Capture capture = renderer.capture(frame, *representation);
    Image8 rgb(capture.colour.width, capture.colour.height, 3);
    for (size_t i = 0; i < rgb.pixels(); ++i)
      for (size_t c = 0; c < 3; ++c) rgb.data[3 * i + c] = capture.colour.data[4 * i + c];
    const std::filesystem::path path =
        std::filesystem::path(options.out) / fmt::format("{}-{}.png", file_stem(cast), name.substr(0, name.find(':')));
    write_png(path, rgb, picture_metadata(scenario, name));
    store.write(PictureRow{0, run, std::nullopt, "hero",
                           fmt::format("{} as {}", counted(staged.crowd.size(), "agent", "agents"), name), rgb.width,
                           rgb.height, encode_png(rgb)});
    throw_if_interrupted();
  }
}

void judge_agents(gl::Context& context, const scene::Cast& cast, const DemoOptions& options, StoreWriter& store,
                  int64_t run) {
  QualitySetup setup;
  setup.table = options.table;
  setup.character = cast.characters.front();
  setup.representations = {options.representation};
  const int clip = setup.character->placement.default_clip;
  const scene::Clip* motion = clip >= 0 ? &setup.character->clips[static_cast<size_t>(clip)] : nullptr;
  const std::vector<double> heights =
      options.tiny ? std::vector<double>{48} : std::vector<double>{16, 32, 64, 128, 256};
  const std::vector<double> azimuths = options.tiny ? std::vector<double>{0} : std::vector<double>{0, 37, 101, 180};
  for (const double height : heights)
    for (const double elevation : {0.0, 15.0})
      for (const double azimuth : azimuths)
        for (const double phase : {0.1, 0.6}) {
          QualityView view;
          view.height_px = height;
          view.azimuth_deg = azimuth;
          view.elevation_deg = elevation;
          view.clip = clip;
          view.time = motion != nullptr ? motion->start + phase * motion->duration() : 0;
          setup.views.push_back(view);
        }
  const QualitySubject subject{cast_name(cast), motion != nullptr ? motion->name : "none"};
  Progress progress("comparing", setup.views.size());
  store.begin();
  write_legend(store, run);
  compute_quality(context, setup, [&](const QualityRow& row, const QualityPictures& pictures) {
    progress.advance();
    const int64_t id = store.write(quality_row(run, subject, row, setup.display));
    // One view of each height is shown.
    if (row.view.azimuth_deg != azimuths[azimuths.size() / 4] || row.view.elevation_deg != 15.0 ||
        row.view.time != setup.views.front().time)
      return;
    write_quality_pictures(store, run, id, row, pictures);
  });
  store.commit();
}

std::string make_clip(gl::Context& context, const scene::Cast& cast, scene::Scenario scenario,
                      const DemoOptions& options) {
  studies::PairRequest request;
  scenario.width = options.tiny ? 64 : 640;
  scenario.height = options.tiny ? 48 : 320;
  scenario.ground = true;
  scenario.crowd.agents = options.tiny ? 4 : 100;
  scenario.camera.keys = {{0.0, scene::Camera{{3.0, 2.6, 8.5}, {0.0, 0.8, 0.0}}}};
  Staged staged = stage_scenario(scenario, cast, context);
  request.scenario = std::move(staged.scenario);
  request.crowd = std::move(staged.crowd);
  request.a = renderers::reference_spec();
  request.b = renderers::parse_spec(options.representation);
  request.frames = options.tiny ? 3 : 90;
  request.clip.title = "crowdbench demo";
  const auto path = std::filesystem::path(options.out) / (file_stem(cast) + "-pair.mp4");
  const studies::Pair pair = studies::export_pair(context, cast, request, path);
  return pair.clip.accurate ? path.string() : std::string();
}

// The demonstration always starts anew: its own results go, nothing else does.
void remove_results(const std::filesystem::path& results) {
  std::error_code ignored;
  for (const char* suffix : {"", "-wal", "-shm"}) std::filesystem::remove(results.string() + suffix, ignored);
}

BenchSummary time_crowds(gl::Context& context, const scene::Cast& cast, const TimingMethod& method, const RunRow& run,
                         const scene::Scenario& scenario, const DemoOptions& options, StoreWriter& store) {
  BenchRequest request;
  request.table = options.table;
  request.scenario = scenario;
  // A level of as many triangles as the character has is the whole mesh.
  const size_t whole = cast.characters.front()->triangles();
  for (const size_t triangles : kLevelTriangles)
    if (triangles < whole) request.representations.push_back(level_spec(triangles));
  request.representations.insert(request.representations.begin(), renderers::parse_spec(options.representation));
  request.budget_ms = 6000;
  request.time_limit_s = options.tiny ? 0.1 : 7;
  request.rounds = options.tiny ? 10 : 24;
  using AgentsByOccupancy = std::vector<std::pair<double, std::vector<uint32_t>>>;
  const AgentsByOccupancy crowds =
      options.tiny ? AgentsByOccupancy{{0.15, {1, 5}}}
                   : AgentsByOccupancy{{0.15, {1, 10, 30, 100, 250, 1000}}, {0.9, {10, 30, 100, 250}}};
  BenchSummary summary;
  Progress progress("timing", 0);
  for (const auto& [occupancy, agents] : crowds) {
    request.occupancies = {occupancy};
    request.agents = agents;
    const BenchSummary timed =
        run_bench(context, cast, method, run, request, store, [&](const std::string& now) { progress.note(now); });
    summary.invalid += timed.invalid;
    summary.remarks.insert(summary.remarks.end(), timed.remarks.begin(), timed.remarks.end());
  }
  return summary;
}

// All of one character. The exit status: 1 where a point failed its picture check.
int show_character(gl::Context& context, const TimingMethod& method, const std::string& character,
                   const DemoOptions& options, StoreWriter& store, Steps& steps) {
  const scene::Scenario scenario = demo_scenario(character, options.character);
  const scene::Cast cast = open_cast(scenario);
  RunRow run = describe_run(context, method, scenario, "demo", command_line());
  run.id = store.write(run);

  steps.next(fmt::format("{}: baking {} and drawing the crowd", cast_name(cast), options.representation));
  draw_heroes(context, cast, scenario, options, store, run.id);

  steps.next(fmt::format("{}: timing {} and {} in rounds", cast_name(cast), renderers::reference_spec().text(),
                         options.representation));
  const BenchSummary summary = time_crowds(context, cast, method, run, scenario, options, store);
  for (const std::string& remark : summary.remarks) steps.say(remark);

  steps.next(fmt::format("{}: comparing single agents with the mesh", cast_name(cast)));
  judge_agents(context, cast, options, store, run.id);

  if (!options.no_clip) {
    steps.next(fmt::format("{}: encoding both as one clip", cast_name(cast)));
    try {
      const std::string path = make_clip(context, cast, scenario, options);
      steps.say(path.empty() ? "the clip missed its accuracy and was not kept" : path);
    } catch (const Error& error) {
      // A bundle without FFmpeg still makes its report.
      steps.say(fmt::format("no clip: {}", error.what()));
    }
  }
  return summary.invalid > 0 ? 1 : 0;
}

int run_demo(const DemoOptions& options) {
  const std::vector<std::string> characters =
      options.characters.empty() ? std::vector<std::string>{"mannequin"} : options.characters;
  (void)parse_representation(options.representation);  // refused before anything is made
  const std::filesystem::path folder = options.out;
  make_folder(folder);
  const std::filesystem::path results = folder / "results.sqlite";
  remove_results(results);
  StoreWriter store(results);
  const std::unique_ptr<gl::Context> context = open_context(options.device);
  const TimingMethod method = choose_timing_method(*context);
  const double each = options.tiny ? 5 : kCharacterSeconds - (options.no_clip ? kClipSeconds : 0);
  Steps steps(characters.size() * (options.no_clip ? 3 : 4) + 1, each * static_cast<double>(characters.size()));
  int status = 0;
  for (const std::string& character : characters)
    status = std::max(status, show_character(*context, method, character, options, store, steps));
  steps.next("writing the report");
  const std::filesystem::path page = folder / "report.html";
  write_file(page, std::string_view(reports::report_page(
                       read_store(results),
                       {results.filename().string(), score_docs(options.table), renderers::floors_by_name()})));
  steps.end();
  fmt::print("{}\n", std::filesystem::absolute(page).lexically_normal().string());
  return status;
}

}  // namespace

void add_demo(Command& app, Run& run) { add_demo(app, run, metrics::scores()); }

void add_demo(Command& app, Run& run, metrics::ScoreTable table) {
  Command* command =
      app.add_subcommand("demo", "All of it in one go: pictures, times, differences, a clip and the report");
  command->footer(
      "Takes a few minutes on two cores without a GPU. Prints the path of the report last.\nExamples:\n  crowdbench "
      "demo\n  crowdbench demo --character robot.glb --out robot-demo");
  auto options = std::make_shared<DemoOptions>();
  options->table = table;
  add_character_options(*command, options->characters, options->character);
  add_representation_option(*command, options->representation, "what is held against the mesh");
  command->add_option("--out", options->out, "folder for the report, the result file, pictures and clips")
      ->type_name("DIR")
      ->capture_default_str()
      ->output_folder();
  add_device_option(*command, options->device);
  command->add_flag("--no-clip", options->no_clip, "leave the clip out");
  command->add_flag("--tiny", options->tiny, "a few agents and small pictures: to see that it runs, not to learn from");
  command->callback([options, &run] { run = [options] { return run_demo(*options); }; });
}

}  // namespace crowdbench::bench
