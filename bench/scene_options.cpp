#include "bench/scene_options.h"

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
}

}  // namespace crowdbench::bench
