#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <optional>

#include "bench/commands/chosen_representation.h"
#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/scene_options.h"
#include "bench/commands/viewer.h"
#include "bench/stage/stage_scenario.h"
#include "core/error.h"
#include "core/image_io.h"
#include "core/progress.h"
#include "renderers/frame/capture.h"
#include "renderers/gl/context.h"
#include "scene/cast/cast.h"
#include "scene/scenario/scenario.h"

namespace crowdbench::bench {
namespace {

struct ViewOptions {
  SceneOptions scene;
  std::vector<std::string> representations;
  std::optional<uint64_t> frames;
  std::string screenshot;
  bool side_by_side = false;
  bool no_ground = false;
};

// What the number keys offer: what was asked for, else the scenario's own and every other that needs no options.
std::vector<renderers::Spec> offered(const std::vector<std::string>& asked, const ChosenScenario& chosen) {
  std::vector<renderers::Spec> specs;
  if (!asked.empty()) return parse_representations(asked);
  specs.push_back(representation_of(chosen));
  for (const renderers::RepresentationType& type : renderers::representation_types()) {
    renderers::Spec spec;
    spec.name = type.name;
    if (!stands_alone(type) || spec.text() == specs.front().text()) continue;
    specs.push_back(spec);
  }
  return specs;
}

// Makes representations when they are first asked for.
class RepresentationPool {
 public:
  // chosen: whose representation the first is, or nobody's.
  RepresentationPool(gl::Context& context, const scene::Cast& cast, const std::vector<renderers::Spec>& specs,
                     const ChosenScenario* chosen)
      : context_(context), cast_(cast), specs_(specs), chosen_(chosen), made_(specs.size()) {}
  bool holds(size_t index) const { return made_[index] != nullptr; }
  size_t first_held() const {
    size_t index = 0;
    while (index < made_.size() && !made_[index]) ++index;
    return index;
  }
  bool holds_any() const { return first_held() < made_.size(); }
  renderers::Representation& get(size_t index) {
    if (!made_[index])
      made_[index] = index == 0 && chosen_ != nullptr
                         ? make_chosen(*chosen_, {context_, cast_}, specs_[index])
                         : renderers::make_representation({context_, cast_}, specs_[index]);
    return *made_[index];
  }

 private:
  gl::Context& context_;
  const scene::Cast& cast_;
  const std::vector<renderers::Spec>& specs_;
  const ChosenScenario* chosen_;
  std::vector<std::unique_ptr<renderers::Representation>> made_;
};

// What the window shows, from one frame to the next.
class Viewing {
 public:
  // names: of the specs, as people read them. chosen: see RepresentationPool. All are referred to.
  Viewing(gl::Context& context, gl::Window& window, const scene::Cast& cast, const Staged& staged,
          const std::vector<renderers::Spec>& specs, const std::vector<std::string>& names,
          const ChosenScenario* chosen)
      : context_(context),
        window_(window),
        cast_(cast),
        staged_(staged),
        names_(names),
        pool_(context, cast, specs, chosen),
        renderer_(context, cast) {
    state.orbit = orbit_of(start_);
    state.beside = specs.size() > 1 ? 1 : 0;
  }
  ViewerState state;

  void apply(const gl::WindowInput& input) {
    apply_input(state, input, names_.size(), staged_.scenario.height, start_);
  }

  // Makes what is to be shown and is not there yet, and says so. What cannot be made gives way to what could; throws
  // Error where nothing could. Whether there was anything to make.
  bool make_shown() {
    bool tried = false;
    for (size_t* which : {&state.current, &state.beside}) {
      if (pool_.holds(*which) || (which == &state.beside && !state.side_by_side)) continue;
      tried = true;
      window_.set_title(fmt::format("crowdbench: making {} ...", names_[*which]));
      Progress progress("making " + names_[*which], 0);
      try {
        pool_.get(*which);
      } catch (const Error& error) {
        if (!pool_.holds_any()) throw;
        fmt::print(stderr, "{}: {}\n", names_[*which], error.what());
        *which = pool_.first_held();
      }
    }
    return tried;
  }

  Image8 picture() {
    const scene::Scenario& scenario = staged_.scenario;
    Image8 picture;
    if (state.side_by_side) {
      const int half = std::max(1, (scenario.width - 2) / 2);
      const Image8 left = draw(state.beside, half);
      picture = beside_each_other(left, draw(state.current, half));
    } else {
      picture = draw(state.current, scenario.width);
    }
    if (state.help) draw_help(picture, names_);
    return picture;
  }

 private:
  Image8 draw(size_t which, int width) {
    const scene::Scenario& scenario = staged_.scenario;
    if (!target_ || target_->width() != width)
      target_.emplace(context_, width, scenario.height, renderers::Pass{.samples = scenario.antialiasing.samples});
    scene::Frame frame = scene::make_frame(scenario, cast_, staged_.crowd, camera_of(state.orbit, start_), state.tick);
    frame.width = width;
    renderer_.draw(frame, pool_.get(which), *target_);
    return target_->read().colour;
  }

  gl::Context& context_;
  gl::Window& window_;
  const scene::Cast& cast_;
  const Staged& staged_;
  const std::vector<std::string>& names_;
  const scene::Camera start_ = staged_.scenario.camera.at(0);
  RepresentationPool pool_;
  renderers::Renderer renderer_;
  std::optional<renderers::Target> target_;
};

// Ticks by the clock on the wall.
class TickClock {
 public:
  explicit TickClock(double ticks_per_second) : rate_(ticks_per_second) {}
  // What has passed since the last call does not count.
  void skip() { before_ = Clock::now(); }
  // Whole ticks since the last call; what is left of one counts later. None pass while paused.
  uint64_t passed(bool paused) {
    const auto now = Clock::now();
    if (!paused) waiting_ += std::chrono::duration<double>(now - before_).count() * rate_;
    before_ = now;
    const double whole = std::floor(waiting_);
    waiting_ -= whole;
    return static_cast<uint64_t>(whole);
  }

 private:
  using Clock = std::chrono::steady_clock;
  double rate_;
  double waiting_ = 0;  // ticks not yet shown
  Clock::time_point before_ = Clock::now();
};

// Frame after frame until somebody quits, or --frames are over.
void show_frames(const ViewOptions& options, gl::Window& window, const Staged& staged,
                 const std::vector<std::string>& names, Viewing& viewing) {
  ViewerState& state = viewing.state;
  TickClock clock(staged.scenario.tick_rate);
  for (uint64_t shown = 0; !options.frames || shown < *options.frames; ++shown) {
    throw_if_interrupted();
    viewing.apply(window.poll());
    if (state.quit) break;
    if (options.frames) state.tick = shown;  // no clock: frame n shows tick n
    if (viewing.make_shown()) clock.skip();
    window.set_title(viewer_title(state, names, staged.crowd.size()));
    const Image8 picture = viewing.picture();
    if (!options.screenshot.empty() && shown + 1 == *options.frames)
      write_png(options.screenshot, window.show_and_read(picture));
    else
      window.show(picture);
    const uint64_t ticks = clock.passed(state.paused);
    if (!options.frames) state.tick += ticks;
  }
}

int run_view(const ViewOptions& options) {
  if (!options.screenshot.empty() && !options.frames)
    throw Error("--screenshot", "needs --frames", "say after how many frames the picture is taken");
  ChosenScenario chosen = read_scenario(options.scene);
  chosen.scenario.ground = !options.no_ground;
  const std::vector<renderers::Spec> specs = offered(options.representations, chosen);
  std::vector<std::string> names;
  names.reserve(specs.size());
  for (const renderers::Spec& spec : specs) names.push_back(spec.text());

  gl::Window window(chosen.scenario.width, chosen.scenario.height, "crowdbench");  // first: no display is said at once
  const scene::Cast cast = open_cast(chosen.scenario, chosen.folder, chosen.places);
  const auto context = open_context(options.scene.device);
  const Staged staged = stage_scenario(chosen.scenario, cast, *context);

  Viewing viewing(*context, window, cast, staged, specs, names, options.representations.empty() ? &chosen : nullptr);
  viewing.state.side_by_side = options.side_by_side;
  viewing.state.help = !options.frames;
  if (options.side_by_side) std::swap(viewing.state.beside, viewing.state.current);  // the first on the left
  show_frames(options, window, staged, names, viewing);
  return 0;
}

}  // namespace

void add_view(Command& app, Run& run) {
  Command* command = app.add_subcommand("view", "Look at a scenario in a window; switch representations with 1..9");
  command->footer(
      "Left drag orbits, right drag pans, the wheel zooms; space pauses, '.' steps, 1..9 switch, s shows two side by\n"
      "side, h hides the help text, Esc quits. Everything is drawn off screen, as it is measured, and shown as it is.\n"
      "Examples:\n  crowdbench view --agents 200\n"
      "  crowdbench view --representation mesh --representation flat --side-by-side");
  auto options = std::make_shared<ViewOptions>();
  add_scene_options(*command, options->scene);
  add_representation_option(*command, options->representations,
                            "what the keys 1..9 show (the scenario's, then all others)");
  command->add_flag("--side-by-side", options->side_by_side, "start with the first two beside each other");
  command->add_option("--frames", options->frames, "end after N frames, frame n showing tick n")
      ->type_name("N")
      ->whole_number(1, 1'000'000'000);
  command->add_option("--screenshot", options->screenshot, "what stood in the window at the last of --frames")
      ->type_name("FILE.png")
      ->output_file();
  command->add_flag("--no-ground", options->no_ground, "leave the grey grid out");
  command->callback([options, &run] { run = [options] { return run_view(*options); }; });
}

}  // namespace crowdbench::bench
