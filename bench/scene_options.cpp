#include "bench/scene_options.h"

<<<<<<< HEAD
#include <CLI/CLI.hpp>
#include <charconv>
#include <vector>

#include "core/error.h"
#include "renderers/capture.h"
#include "renderers/gl/context.h"

namespace crowdbench::bench {

void add_scene_options(CLI::App& command, SceneOptions& options) {
  command.add_option("scenario", options.file, "scenario file (TOML); see crowdbench schema")->type_name("SCENARIO");
  command.add_option("--agents", options.agents, "number of agents")->type_name("N");
  command.add_option("--seed", options.seed, "seed of the crowd")->type_name("S");
  command.add_option("--occupancy", options.occupancy, "fraction of the picture that the crowd covers, solved for")
      ->type_name("F");
  command.add_option("--size", options.size, "size of the picture in pixels")->type_name("WxH");
  command.add_option("--character", options.character, "mannequin[:triangles=N,joints=N] or a glTF file")
      ->type_name("C");
  command.add_option("--device", options.device, "EGL device: its index, software, or surfaceless")->type_name("D");
}

PictureSize parse_size(const std::string& text, const std::string& option) {
  PictureSize size;
  const char* end = text.data() + text.size();
  const auto [cross, fault] = std::from_chars(text.data(), end, size.width);
  bool fine = fault == std::errc{} && cross < end && *cross == 'x';
  if (fine) {
    const auto [last, second_fault] = std::from_chars(cross + 1, end, size.height);
    fine = second_fault == std::errc{} && last == end;
  }
  const auto in_range = [](int side) { return side >= 1 && side <= 16384; };
  if (!fine || !in_range(size.width) || !in_range(size.height)) {
    throw Error(option, fmt::format("'{}' is no size", printable(text)), "write it as 640x480, sides 1 to 16384");
  }
  return size;
}

ChosenScenario read_scenario(const SceneOptions& options) {
  ChosenScenario chosen;
  if (!options.file.empty()) {
    chosen.scenario = scene::load_scenario(options.file);
    chosen.folder = std::filesystem::path(options.file).parent_path();
  }
  scene::Scenario& scenario = chosen.scenario;
  if (options.agents) {
    if (*options.agents > 1'000'000) throw Error("--agents", fmt::format("{} is more than 1000000", *options.agents));
    scenario.crowd.agents = *options.agents;
  }
  if (options.seed) scenario.seed = *options.seed;
  if (options.occupancy) {
    if (!(*options.occupancy > 0 && *options.occupancy <= 1)) {
      throw Error("--occupancy", fmt::format("{} is not above 0 and at most 1", *options.occupancy),
                  "0.15 is 15 % of the picture");
    }
    scenario.occupancy = options.occupancy;
  }
  if (!options.size.empty()) {
    const PictureSize size = parse_size(options.size);
    scenario.width = size.width;
    scenario.height = size.height;
  }
  if (!options.character.empty()) {
    scene::CharacterEntry entry;
    entry.source = options.character;
    scenario.characters = {entry};
    chosen.folder.clear();  // a path on the command line is relative to where the user is
  }
  return chosen;
}

Staged stage_scenario(const scene::Scenario& scenario, const scene::Cast& cast, gl::Context& context) {
  if (!scenario.occupancy) {
    return {scenario, scene::make_crowd(scenario, cast, scene::stage_view(scenario)), std::nullopt};
  }
  renderers::Renderer renderer(context, cast);
  const auto mesh = renderers::make_representation({context, cast}, renderers::parse_spec("mesh"));
  const auto measure = [&](const scene::Frame& frame) {
    const renderers::Capture capture = renderer.capture(frame, *mesh);
    scene::Coverage coverage;
    std::vector<bool> seen(scenario.crowd.agents + 1, false);
    for (const uint32_t id : capture.ids.data) {
      if (id == 0) continue;
      ++coverage.covered_px;
      if (id < seen.size() && !seen[id]) {
        seen[id] = true;
        ++coverage.agents_visible;
      }
    }
    coverage.occupancy = static_cast<double>(coverage.covered_px) / static_cast<double>(capture.ids.pixels());
    return coverage;
  };
  scene::Solved solved = scene::solve_occupancy(scenario, cast, measure);
  return {solved.scenario, solved.crowd, std::move(solved)};
=======
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>

#include "core/error.h"
#include "core/version.h"

namespace crowdbench::bench {
namespace {

constexpr int kMaxSide = 16384;
constexpr uint32_t kMaxAgents = 1'000'000;

template <typename T>
bool parse_number(std::string_view text, T& value) {
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  return fault == std::errc{} && end == text.data() + text.size();
}

}  // namespace

void add_device_option(CLI::App& command, std::string& device) {
  command.add_option("--device", device,
                     "EGL device: an index, software or surfaceless (default: $CROWDBENCH_DEVICE, else the first GPU)");
}

void SceneOptions::add_to(CLI::App& command, bool with_representation, bool with_tick) {
  command.add_option("scenario", scenario_file, "scenario file (TOML; see crowdbench schema); default: built in");
  if (with_representation)
    command.add_option("--representation,-r", representation,
                       "how agents are drawn (crowdbench info --representations)");
  command.add_option("--character", characters, "FILE.glb, FILE.gltf or mannequin[:triangles=N,joints=N]; repeatable")
      ->delimiter('\0');
  command.add_option("--clip", clips, "clip in use, by name or index; repeatable");
  command.add_option("--agents", agents, "number of agents, 0..1000000");
  command.add_option("--seed", seed, "seed of everything random");
  command.add_option("--size", size, "WIDTHxHEIGHT in pixels");
  if (with_tick) command.add_option("--tick", tick, "which tick of the scenario (30 a second by default)");
  add_device_option(command, device);
}

scene::Scenario SceneOptions::scenario() const {
  scene::Scenario out = scenario_file.empty() ? scene::Scenario{} : scene::load_scenario(scenario_file);
  if (!representation.empty()) out.representation = representation;
  if (!characters.empty()) {
    out.characters.clear();
    for (const std::string& source : characters) {
      scene::CharacterEntry entry;
      entry.source = source;
      out.characters.push_back(std::move(entry));
    }
  }
  if (!clips.empty())
    for (scene::CharacterEntry& entry : out.characters) entry.clips = clips;
  if (agents) {
    if (*agents > kMaxAgents)
      throw Error("--agents", fmt::format("{} is more than {}", *agents, kMaxAgents), "give a smaller number");
    out.crowd.agents = *agents;
  }
  if (seed) out.seed = *seed;
  if (!size.empty()) std::tie(out.width, out.height) = parse_size(size);
  return out;
}

std::filesystem::path SceneOptions::folder() const {
  if (scenario_file.empty() || !characters.empty()) return {};
  return std::filesystem::path(scenario_file).parent_path();
}

std::pair<int, int> parse_size(const std::string& text, const std::string& option) {
  const size_t x = text.find('x');
  int width = 0;
  int height = 0;
  const bool fine = x != std::string::npos && parse_number(std::string_view(text).substr(0, x), width) &&
                    parse_number(std::string_view(text).substr(x + 1), height);
  if (!fine || width < 1 || height < 1 || width > kMaxSide || height > kMaxSide)
    throw Error(option, fmt::format("'{}' is no size", printable(text)),
                fmt::format("write WIDTHxHEIGHT, 1 to {} pixels each: 640x480", kMaxSide));
  return {width, height};
}

glm::dvec3 parse_vector(const std::string& text, const std::string& option) {
  glm::dvec3 out(0.0);
  std::string_view rest(text);
  for (int i = 0; i < 3; ++i) {
    const size_t comma = rest.find(',');
    const bool last = i == 2;
    if ((comma == std::string_view::npos) != last || !parse_number(rest.substr(0, comma), out[i]) ||
        !std::isfinite(out[i]))
      throw Error(option, fmt::format("'{}' is no point", printable(text)), "write x,y,z: 0,1.5,4");
    if (!last) rest.remove_prefix(comma + 1);
  }
  return out;
}

glm::u8vec3 parse_colour(const std::string& text, const std::string& option) {
  glm::u8vec3 out(0);
  bool fine = text.size() == 7 && text[0] == '#';
  for (int i = 0; fine && i < 3; ++i) {
    unsigned value = 0;
    const char* at = text.data() + 1 + 2 * static_cast<ptrdiff_t>(i);
    const auto [end, fault] = std::from_chars(at, at + 2, value, 16);
    fine = fault == std::errc{} && end == at + 2;
    out[i] = static_cast<uint8_t>(value);
  }
  if (!fine) throw Error(option, fmt::format("'{}' is no colour", printable(text)), "write '#rrggbb' in hexadecimal");
  return out;
}

std::unique_ptr<gl::Context> open_context(const std::string& device) {
  gl::ContextOptions options;
  options.device = device;
  auto context = std::make_unique<gl::Context>(options);
  for (const std::string& warning : context->warnings()) fmt::print(stderr, "crowdbench: warning: {}\n", warning);
  fmt::print(stderr, "crowdbench: drawing on {} ({}, {})\n", context->renderer(), context->version(),
             context->platform());
  return context;
}

ImageMetadata picture_metadata(const scene::Scenario& scenario, const std::string& representation) {
  return {{"scenario", scene::to_toml(scenario)},
          {"seed", std::to_string(scenario.seed)},
          {"backend", representation},
          {"version", std::string(version())}};
>>>>>>> 8a4e842 (info and render commands, GPU counters and the timer's self-test)
}

}  // namespace crowdbench::bench
