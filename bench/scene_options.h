<<<<<<< HEAD
// What every command that draws a scenario has in common: [SCENARIO], the options that override its keys, and the way
// from there to a crowd in front of a camera.
=======
// The options that commands about a scene share: a scenario file, and what overrides its keys.
>>>>>>> 8a4e842 (info and render commands, GPU counters and the timer's self-test)
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
<<<<<<< HEAD

#include "scene/crowd.h"
#include "scene/occupancy.h"
=======
#include <utility>
#include <vector>

#include "core/image_io.h"
#include "renderers/gl/context.h"
>>>>>>> 8a4e842 (info and render commands, GPU counters and the timer's self-test)
#include "scene/scenario.h"

namespace CLI {
class App;
}
<<<<<<< HEAD
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
  std::string size;       // "WxH"
  std::string character;  // replaces the scenario's characters by this one
  std::string device;     // gl::ContextOptions::device
};

// [SCENARIO] --agents --seed --occupancy --size --character --device. `options` must outlive `command`.
void add_scene_options(CLI::App& command, SceneOptions& options);

// The scenario with the overrides in it, and the folder that its characters' paths are relative to.
struct ChosenScenario {
  scene::Scenario scenario;
  std::filesystem::path folder;
};
// Throws Error.
ChosenScenario read_scenario(const SceneOptions& options);

// "640x480" taken apart, each side 1..16384. Throws Error naming `option`.
struct PictureSize {
  int width = 0;
  int height = 0;
};
PictureSize parse_size(const std::string& text, const std::string& option = "--size");

// A crowd in front of a camera. With an occupancy asked for it is solved for, by drawing the mesh.
struct Staged {
  scene::Scenario scenario;  // as solved
  scene::Crowd crowd;
  std::optional<scene::Solved> solved;
};
Staged stage_scenario(const scene::Scenario& scenario, const scene::Cast& cast, gl::Context& context);
=======

namespace crowdbench::bench {

// Filled by CLI11; read it in the command's run function, where every fault becomes an Error.
struct SceneOptions {
  std::string scenario_file;
  std::string representation;
  std::vector<std::string> characters;
  std::vector<std::string> clips;
  std::optional<uint32_t> agents;
  std::optional<uint64_t> seed;
  std::string size;
  uint64_t tick = 0;
  std::string device;

  // Adds [SCENARIO], --character, --clip, --agents, --seed, --size, --device, and with `representation` that option,
  // with `tick` --tick.
  void add_to(CLI::App& command, bool with_representation = true, bool with_tick = true);

  // The scenario of the file (or the default one) with every override in place. Throws Error.
  scene::Scenario scenario() const;
  // What the characters' relative paths are relative to: the scenario's folder, or empty (the working directory) when
  // --character replaced them.
  std::filesystem::path folder() const;
};

// The folder-independent part of `add_to`, for commands that take a device only.
void add_device_option(CLI::App& command, std::string& device);

// "640x480" to (640, 480), each 1..16384. Throws Error naming `option`.
std::pair<int, int> parse_size(const std::string& text, const std::string& option = "--size");
// "x,y,z". Throws Error naming `option`.
glm::dvec3 parse_vector(const std::string& text, const std::string& option);
// "#rrggbb" to sRGB-encoded bytes. Throws Error naming `option`.
glm::u8vec3 parse_colour(const std::string& text, const std::string& option);

// Opens the context that --device names and says its renderer, and every warning, on stderr.
std::unique_ptr<gl::Context> open_context(const std::string& device);

// What every picture file carries: scenario (TOML), seed, backend (the canonical representation), version.
ImageMetadata picture_metadata(const scene::Scenario& scenario, const std::string& representation);
>>>>>>> 8a4e842 (info and render commands, GPU counters and the timer's self-test)

}  // namespace crowdbench::bench
