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

struct PoseOptions {
  std::string file;
  std::string clip;
  double time = 0.0;
  std::vector<size_t> vertices;
  bool json = false;
};

Json to_json(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

scene::Character open_as_in_file(const std::string& file) {
  scene::LoadOptions load;
  load.normalise.height = std::nullopt;
  load.normalise.turn_deg = 0.0;
  load.undrawn = true;
  return scene::open_character(file, load);
}

// A name comes first, even the name "none". -1: the bind pose.
int clip_or_bind_pose(const scene::Character& character, const std::string& clip) {
  if (clip.empty() || (clip == "none" && !scene::find_clip(character, clip))) return -1;
  return scene::require_clip(character, clip);
}

// The file's own vertices, posed, in its order; at least one.
std::vector<glm::dvec3> pose_vertices(const scene::Character& character, int clip, double time) {
  std::vector<glm::dvec3> drawn = scene::skin_positions(character.mesh, scene::joint_matrices(character, clip, time));
  if (character.mesh.file_vertices.empty()) return drawn;
  std::vector<glm::dvec3> out;
  for (const uint32_t v : character.mesh.file_vertices) out.push_back(drawn[v]);
  return out;
}

struct Extent {
  glm::dvec3 low{std::numeric_limits<double>::max()};
  glm::dvec3 high{std::numeric_limits<double>::lowest()};
  glm::dvec3 mean{0.0};
};

Extent extent_of(const std::vector<glm::dvec3>& points) {
  Extent out;
  glm::dvec3 sum(0.0);
  for (const glm::dvec3& p : points) {
    out.low = glm::min(out.low, p);
    out.high = glm::max(out.high, p);
    sum += p;
  }
  out.mean = sum / static_cast<double>(points.size());
  return out;
}

std::vector<size_t> asked_vertices(const PoseOptions& options, size_t count) {
  const std::vector<size_t> asked = options.vertices.empty() ? std::vector<size_t>{0} : options.vertices;
  for (const size_t v : asked)
    if (v >= count)
      throw Error("--vertex", fmt::format("{} is past the last vertex", v),
                  fmt::format("{} has vertices 0 to {}", printable(options.file), count - 1));
  return asked;
}

int pose(const PoseOptions& options) {
  const scene::Character character = open_as_in_file(options.file);
  const int clip = clip_or_bind_pose(character, options.clip);
  const std::string clip_name = clip >= 0 ? character.clips[static_cast<size_t>(clip)].name : std::string();
  const std::vector<glm::dvec3> points = pose_vertices(character, clip, options.time);
  const std::vector<size_t> asked = asked_vertices(options, points.size());
  const Extent extent = extent_of(points);
  if (options.json) {
    Json samples = Json::object();
    for (const size_t v : asked) samples[std::to_string(v)] = to_json(points[v]);
    const Json out = {{"file", options.file},
                      {"clip", clip_name.empty() ? Json() : Json(clip_name)},
                      {"clip_index", clip >= 0 ? Json(clip) : Json()},
                      {"time", options.time},
                      {"count", points.size()},
                      {"bbox_min", to_json(extent.low)},
                      {"bbox_max", to_json(extent.high)},
                      {"mean", to_json(extent.mean)},
                      {"samples", samples}};
    fmt::print("{}\n", out.dump(2));
    return 0;
  }
  const auto line = [](const std::string& key, const glm::dvec3& v) {
    fmt::print("{:<14}{:12.6f}{:12.6f}{:12.6f}\n", key, v.x, v.y, v.z);
  };
  const std::string name = clip < 0 ? "bind pose" : printable(clip_name, 60);
  fmt::print("{}: {} at {} s, {} vertices, glTF units\n", printable(options.file, 300),
             name.empty() ? fmt::format("clip {} (unnamed)", clip) : name, options.time, points.size());
  line("least", extent.low);
  line("greatest", extent.high);
  line("mean", extent.mean);
  for (const size_t v : asked) line(fmt::format("vertex {}", v), points[v]);
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
  auto options = std::make_shared<PoseOptions>();
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
