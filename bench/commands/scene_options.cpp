#include "bench/commands/scene_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <vector>

#include "bench/commands/command_line.h"
#include "bench/stage/scenario_display.h"
#include "core/error.h"
#include "core/version.h"
#include "renderers/gl/context.h"
#include "scene/cast/load_cast.h"
#include "scene/cast/open_character.h"
#include "scene/scenario/parse_scenario.h"
#include "scene/scenario/scenario_writer.h"

namespace crowdbench::bench {

void add_scene_options(Command& command, SceneOptions& options) {
  add_scenario_argument(command, options.file);
  command.add_option("--agents", options.agents, "number of agents")->type_name("N")->whole_number(0, kMostAgents);
  add_seed_option(command, options.seed);
  command.add_option("--occupancy", options.occupancy, "fraction of the picture that the crowd covers, solved for")
      ->type_name("F")
      ->number(0.0001, 1);
  add_size_option(command, options.size);
  add_antialiasing_options(command, options.antialiasing);
  add_character_options(command, options.character);
  add_device_option(command, options.device);
}

void add_scenario_argument(Command& command, std::string& file) {
  command.add_option("SCENARIO", file, "scenario file, see schema; without one, every key is at its default")
      ->type_name("FILE.toml");
}

void add_seed_option(Command& command, std::optional<uint64_t>& seed) {
  command.add_option("--seed", seed, "seed of the crowd")
      ->type_name("S")
      ->whole_number(0, std::numeric_limits<uint64_t>::max());
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
    throw Error(option, fmt::format("'{}' is not a size", printable(text)), "write it as 640x480, sides 1 to 16384");
  }
  return size;
}

namespace {

// The scenario's paths are relative to its folder, those of the command line to where the user is.
void change_in_folder(CharacterOptions options, const std::filesystem::path& folder, scene::CharacterEntry& entry) {
  for (std::string& name : options.animations)
    if (!folder.empty() && !scene::is_built_in(name)) name = std::filesystem::absolute(name).string();
  options.change(entry);
}

}  // namespace

metrics::ChosenDisplay display_of_option(const std::string& text) {
  if (text.empty()) return {};
  return {metrics::display_of(text, "--display"), true};
}

ChosenScenario read_scenario(const SceneOptions& options) {
  ChosenScenario chosen;
  if (!options.file.empty()) {
    chosen.scenario = scene::load_scenario(options.file, &chosen.places);
    if (const auto place = chosen.places.find("representation"); place != chosen.places.end())
      chosen.representation_from = place->second + ": `representation`";
    chosen.folder = std::filesystem::path(options.file).parent_path();
  }
  chosen.display = display_of_scenario(chosen.scenario, chosen.folder, chosen.places);
  scene::Scenario& scenario = chosen.scenario;
  if (!options.display.empty()) {
    chosen.display = display_of_option(options.display);
    scenario.display = {};
    scenario.display.model = options.display;
  }
  if (options.agents) scenario.crowd.agents = *options.agents;
  if (options.seed) scenario.seed = *options.seed;
  if (options.occupancy) scenario.occupancy = options.occupancy;
  if (!options.size.empty()) {
    const PictureSize size = parse_size(options.size);
    scenario.width = size.width;
    scenario.height = size.height;
  }
  options.antialiasing.change(scenario.antialiasing);
  if (!options.character.source.empty()) {
    scenario.characters = {options.character.entry()};
    chosen.places.erase(scene::key_place("character", "clips"));
    chosen.folder.clear();  // a path on the command line is relative to where the user is
  } else if (!options.character.changes_nothing()) {
    for (scene::CharacterEntry& entry : scenario.characters) change_in_folder(options.character, chosen.folder, entry);
  }
  return chosen;
}

void override_representation(ChosenScenario& chosen, const std::string& text) {
  if (text.empty()) return;
  chosen.scenario.representation = text;
  chosen.representation_from = "--representation";
}

renderers::Spec representation_of(const ChosenScenario& chosen) {
  return parse_representation(chosen.scenario.representation, chosen.representation_from);
}

glm::dvec3 parse_vector(const std::string& text, const std::string& option) {
  glm::dvec3 out(0.0);
  const char* at = text.data();
  const char* const end = at + text.size();
  bool fine = true;
  for (int i = 0; fine && i < 3; ++i) {
    const auto [next, fault] = std::from_chars(at, end, out[i]);
    fine = fault == std::errc{} && std::isfinite(out[i]) && (i == 2 ? next == end : next < end && *next == ',');
    at = fine && i < 2 ? next + 1 : next;
  }
  if (!fine) throw Error(option, fmt::format("'{}' is not a point", printable(text)), "write x,y,z: 0,1.5,4");
  return out;
}

glm::u8vec3 parse_colour(const std::string& text, const std::string& option) {
  glm::u8vec3 out(0);
  bool fine = text.size() == 7 && text[0] == '#';
  for (int i = 0; fine && i < 3; ++i) {
    const char* at = text.data() + 1 + static_cast<std::ptrdiff_t>(2) * i;
    uint8_t value = 0;
    const auto [end, fault] = std::from_chars(at, at + 2, value, 16);
    fine = fault == std::errc{} && end == at + 2;
    out[i] = value;
  }
  if (!fine)
    throw Error(option, fmt::format("'{}' is not a colour", printable(text)), "write '#rrggbb' in hexadecimal");
  return out;
}

std::unique_ptr<gl::Context> open_context(const std::string& device) {
  auto context = std::make_unique<gl::Context>(gl::ContextOptions{.device = device});
  for (const std::string& warning : context->warnings()) fmt::print(stderr, "crowdbench: warning: {}\n", warning);
  fmt::print(stderr, "crowdbench: drawing on {} ({}, {})\n", context->renderer(), context->version(),
             context->platform());
  return context;
}

void print_warnings(const scene::Character& character) {
  constexpr size_t kMost = 3;
  const auto& all = character.warnings;
  for (size_t i = 0; i < std::min(all.size(), kMost); ++i)
    fmt::print(stderr, "crowdbench: warning: {}: {}\n", printable(character.name), printable(all[i], 400));
  if (all.size() > kMost)
    fmt::print(stderr, "crowdbench: warning: {}: and {} more; crowdbench inspect tells them\n",
               printable(character.name), all.size() - kMost);
}

std::shared_ptr<const scene::Character> open_subject(const CharacterOptions& options, const std::string& clip) {
  scene::CharacterEntry entry = options.entry();
  if (!clip.empty()) entry.clips = {clip};
  auto character = std::make_shared<const scene::Character>(scene::open_character(entry));
  print_warnings(*character);
  return character;
}

scene::Cast open_cast(const scene::Scenario& scenario, const std::filesystem::path& folder,
                      const scene::KeyPlaces& places) {
  scene::Cast cast = scene::load_cast(scenario, folder, places);
  for (const auto& character : cast.characters) print_warnings(*character);
  return cast;
}

ImageMetadata picture_metadata(const scene::Scenario& scenario, const std::string& representation) {
  return {{"scenario", scene::to_toml(scenario)},
          {"seed", std::to_string(scenario.seed)},
          {"backend", representation},
          {"version", std::string(version())}};
}

}  // namespace crowdbench::bench
