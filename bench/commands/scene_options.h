// What every command that draws a scenario has in common: [SCENARIO], the options that override its keys, and how
// a crowd in front of a camera comes of them.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "bench/commands/options.h"
#include "core/image_io.h"
#include "metrics/display.h"
#include "scene/cast/cast.h"
#include "scene/crowd/crowd.h"
#include "scene/crowd/occupancy.h"
#include "scene/scenario/parse_scenario.h"
#include "scene/scenario/scenario.h"

namespace crowdbench::gl {
class Context;
}

namespace crowdbench::bench {

// What the user gave; empty or nullopt leaves the scenario's own value.
struct SceneOptions {
  std::string file;  // the scenario; empty: every key at its default
  std::optional<uint32_t> agents;
  std::optional<uint64_t> seed;
  std::optional<double> occupancy;
  std::string size;  // "WxH"
  AntialiasingOptions antialiasing;
  CharacterOptions character;  // its source replaces the scenario's characters; its changes are for all of them
  std::string device;          // gl::ContextOptions::device
  std::string display;         // of add_display_option, in commands that score pictures
};

// [SCENARIO] --agents --seed --occupancy --size --device and add_character_options. `options` must outlive `command`.
void add_scene_options(Command& command, SceneOptions& options);
void add_scenario_argument(Command& command, std::string& file);
void add_seed_option(Command& command, std::optional<uint64_t>& seed);
inline constexpr uint64_t kMostAgents = 1'000'000;

// The scenario with the overrides in it, and the folder that its characters' paths are relative to.
struct ChosenScenario {
  scene::Scenario scenario;
  std::filesystem::path folder;
  scene::KeyPlaces places;
  metrics::ChosenDisplay display;                        // --display, else the scenario's
  std::string representation_from = "--representation";  // who is to blame where it cannot be parsed
};
// Throws Error.
ChosenScenario read_scenario(const SceneOptions& options);
// The display of --display; the default one where the text is empty. Throws Error.
metrics::ChosenDisplay display_of_option(const std::string& text);
// The scenario draws this instead, unless the text is empty.
void override_representation(ChosenScenario& chosen, const std::string& text);
// scenario.representation taken apart. Throws Error naming the option or the file's line.
renderers::Spec representation_of(const ChosenScenario& chosen);

// "640x480" taken apart, each side 1..16384. Throws Error naming `option`.
struct PictureSize {
  int width = 0;
  int height = 0;
};
PictureSize parse_size(const std::string& text, const std::string& option = "--size");

// "x,y,z" taken apart, finite. Throws Error naming `option`.
glm::dvec3 parse_vector(const std::string& text, const std::string& option);
// "#rrggbb" to sRGB-encoded bytes. Throws Error naming `option`.
glm::u8vec3 parse_colour(const std::string& text, const std::string& option);

// Opens the context that --device names and says its renderer, and every warning, on stderr.
std::unique_ptr<gl::Context> open_context(const std::string& device);

// What loading found odd in a character, on stderr: three lines at most, and where the rest is told.
void print_warnings(const scene::Character& character);
// The one character of a command that shows no scenario, for `clip` (empty: its default one), and print_warnings of it.
std::shared_ptr<const scene::Character> open_subject(const CharacterOptions& options, const std::string& clip);
// scene::load_cast, and print_warnings of each character.
scene::Cast open_cast(const scene::Scenario& scenario, const std::filesystem::path& folder = {},
                      const scene::KeyPlaces& places = {});

// What every picture file carries: scenario (TOML), seed, backend (the canonical representation), version.
ImageMetadata picture_metadata(const scene::Scenario& scenario, const std::string& representation);

}  // namespace crowdbench::bench
