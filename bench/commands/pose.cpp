#include "scene/pose/pose.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/options.h"
#include "core/error.h"
#include "core/json.h"
#include "scene/cast/open_character.h"
#include "scene/gltf/gltf.h"

namespace crowdbench::bench {
namespace {

using ordered_json = Json;

struct Options {
  std::string file;
  std::string clip;
  double time = 0.0;
  std::vector<size_t> vertices;
  bool json = false;
};

ordered_json to_json(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

int pose(const Options& options) {
  scene::LoadOptions load;
  load.normalise.height = std::nullopt;
  load.normalise.turn_deg = 0.0;  // as in the file
  load.undrawn = true;
  const scene::Character character = scene::open_character(options.file, load);
  // A name comes first, even the name "none".
  int clip = -1;
  if (!options.clip.empty() && (options.clip != "none" || scene::find_clip(character, options.clip))) {
    clip = scene::require_clip(character, options.clip);
  }
  const auto drawn = scene::skin_positions(character.mesh, scene::joint_matrices(character, clip, options.time));

  const size_t count = character.mesh.file_vertex_count();
  const auto& drawn_of = character.mesh.file_vertices;
  const auto at = [&](size_t v) { return drawn[drawn_of.empty() ? v : drawn_of[v]]; };
  const std::vector<size_t> asked = options.vertices.empty() ? std::vector<size_t>{0} : options.vertices;
  for (const size_t v : asked) {
    if (v >= count) {
      throw Error("--vertex", fmt::format("{} is past the last vertex", v),
                  fmt::format("{} has vertices 0 to {}", printable(options.file), count - 1));
    }
  }
  glm::dvec3 low(std::numeric_limits<double>::max());
  glm::dvec3 high(std::numeric_limits<double>::lowest());
  glm::dvec3 sum(0.0);
  for (size_t v = 0; v < count; ++v) {
    const glm::dvec3 p = at(v);
    low = glm::min(low, p);
    high = glm::max(high, p);
    sum += p;
  }
  const glm::dvec3 mean = sum / static_cast<double>(count);

  if (options.json) {
    const bool named = clip >= 0 && !character.clips[static_cast<size_t>(clip)].name.empty();
    ordered_json samples = ordered_json::object();
    for (const size_t v : asked) samples[std::to_string(v)] = to_json(at(v));
    const ordered_json out = {
        {"file", options.file},
        {"clip", named ? ordered_json(character.clips[static_cast<size_t>(clip)].name) : ordered_json()},
        {"clip_index", clip >= 0 ? ordered_json(clip) : ordered_json()},
        {"time", options.time},
        {"count", count},
        {"bbox_min", to_json(low)},
        {"bbox_max", to_json(high)},
        {"mean", to_json(mean)},
        {"samples", samples}};
    fmt::print("{}\n", out.dump(2));
    return 0;
  }
  const auto line = [](const std::string& key, const glm::dvec3& v) {
    fmt::print("{:<14}{:12.6f}{:12.6f}{:12.6f}\n", key, v.x, v.y, v.z);
  };
  const std::string name = clip < 0 ? "bind pose" : printable(character.clips[static_cast<size_t>(clip)].name, 60);
  fmt::print("{}: {} at {} s, {} vertices, glTF units\n", printable(options.file, 300),
             name.empty() ? fmt::format("clip {} (unnamed)", clip) : name, options.time, count);
  line("least", low);
  line("greatest", high);
  line("mean", mean);
  for (const size_t v : asked) line(fmt::format("vertex {}", v), at(v));
  return 0;
}

}  // namespace

void add_pose(Command& app, Run& run) {
  Command* command =
      app.add_subcommand("pose", "Skin a character on the CPU and print posed vertices in raw glTF units");
  command->footer(
      "Examples:\n  crowdbench pose knight.glb --clip Walking_A --time 0.25 --vertex 0 --vertex 411 --json\n"
      "  crowdbench pose knight.glb            (the bind pose: the nodes' own transforms)\n\n"
      "Vertices count through the nodes by ascending index, then primitives, then vertices; a mesh on two nodes counts "
      "twice.\nTime is the file's own, clamped to each channel's keys; curves are evaluated in double precision.");
  auto options = std::make_shared<Options>();
  command->add_option("CHARACTER", options->file, "a glTF, FBX or COLLADA file, or mannequin[:triangles=N,joints=N]")
      ->required();
  command->add_option("--clip", options->clip, "a clip's name, else its index; none for the bind pose (none)")
      ->type_name("CLIP");
  command->add_option("--time", options->time, "seconds on the file's own axis")
      ->type_name("S")
      ->capture_default_str()
      ->number(-1e9, 1e9);
  command->add_option("--vertex", options->vertices, "a vertex to print; may be given several times (0)")
      ->type_name("N")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false)
      ->whole_number(0, std::numeric_limits<uint32_t>::max());
  add_json_option(*command, options->json);
  command->callback([options, &run] { run = [options] { return pose(*options); }; });
}

}  // namespace crowdbench::bench
