#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "bench/commands/level_output.h"
#include "bench/commands/options.h"
#include "core/error.h"
#include "core/json.h"
#include "renderers/representation.h"
#include "scene/cast/open_character.h"
#include "scene/character/drawn.h"
#include "scene/gltf/gltf.h"
#include "scene/pose/pose.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::bench {
namespace {

struct InspectOptions {
  CharacterOptions character;
  std::string out;
  std::string height = "1.75";
  std::vector<std::string> hide;
  std::vector<std::string> clips;
  std::vector<std::string> levels;
  double figure_px = kLevelFigurePx;
  bool no_cache = false;
  bool no_rigid = false;
  bool json = false;
};

constexpr double kPi = 3.14159265358979323846;

std::optional<double> parse_height(const std::string& text) {
  if (text == "as_is") return std::nullopt;
  double metres = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), metres);
  if (error != std::errc{} || stop != text.data() + text.size() || !(metres >= 1e-3 && metres <= 1e3))
    throw Error("--height", fmt::format("'{}' is not a height", printable(text, 40)),
                "give metres from 0.001 to 1000, or as_is");
  return metres;
}

struct Bytes {
  size_t file = 0;  // 0 for the built-in character
  size_t mesh = 0;
  size_t clips = 0;
  size_t images = 0;
  size_t memory() const { return mesh + clips + images; }
};

template <typename T>
size_t bytes_of(const std::vector<T>& v) {
  return v.size() * sizeof(T);
}

Bytes measure_bytes(const scene::Character& c) {
  Bytes bytes;
  std::error_code error;
  const auto size = std::filesystem::file_size(c.source, error);
  if (!error) bytes.file = size;
  const scene::Mesh& m = c.mesh;
  bytes.mesh = bytes_of(m.positions) + bytes_of(m.normals) + bytes_of(m.uvs) + bytes_of(m.emissive_uvs) +
               bytes_of(m.colours) + bytes_of(m.joints) + bytes_of(m.weights) + bytes_of(m.indices);
  for (const scene::Clip& clip : c.clips)
    for (const scene::Channel& channel : clip.channels)
      bytes.clips += bytes_of(channel.times) + bytes_of(channel.values);
  for (const scene::Texture& t : c.images) bytes.images += t.image.data.size();
  return bytes;
}

size_t count_joints(const scene::Character& c, bool rigid) {
  return static_cast<size_t>(std::count_if(c.skeleton.joints.begin(), c.skeleton.joints.end(),
                                           [&](const scene::Joint& j) { return j.rigid == rigid; }));
}

// A built-in character has no file: all that it has is drawn.
size_t file_vertices(const scene::Character& c) {
  return c.file_vertices != 0 ? c.file_vertices : c.mesh.file_vertex_count();
}

size_t file_triangles(const scene::Character& c) { return c.file_triangles != 0 ? c.file_triangles : c.triangles(); }

std::string numbers_text(size_t in_file, size_t drawn) {
  return in_file == drawn ? fmt::format("{}", drawn) : fmt::format("{} in the file, {} drawn", in_file, drawn);
}

std::string clip_text(const scene::Character& c, int clip) {
  if (clip < 0) return "the bind pose";
  const std::string& name = c.clips[static_cast<size_t>(clip)].name;
  return fmt::format("the first pose of clip {} '{}'", clip, printable(name.empty() ? "(unnamed)" : name, 40));
}

Json clip_json(const scene::Character& c, size_t i) {
  const scene::Clip& clip = c.clips[i];
  const scene::ClipMotion& motion = c.motion[i];
  return {{"name", clip.name},
          {"index", i},
          {"seconds", clip.duration()},
          {"start", clip.start},
          {"end", clip.end},
          {"cycle_seconds", scene::cycle_seconds(c, static_cast<int>(i))},
          {"ground_speed", motion.ground_speed},
          {"ground_direction", {motion.direction.x, motion.direction.y}},
          {"yaw_rate_deg", motion.yaw_rate * 180 / kPi},
          {"ground_speed_from", motion.ground_speed <= 0 ? nullptr
                                : motion.from_stance     ? Json("stance foot")
                                                         : Json("root motion")},
          {"default", static_cast<int>(i) == c.placement.default_clip}};
}

Json material_json(const scene::Material& m) {
  return {{"name", m.name},
          {"slot", m.slot},
          {"base_colour", {m.base_colour.r, m.base_colour.g, m.base_colour.b, m.base_colour.a}},
          {"base_colour_texture", m.base_colour_image < 0 ? Json() : Json(m.base_colour_image)},
          {"emissive", {m.emissive.r, m.emissive.g, m.emissive.b}},
          {"emissive_texture", m.emissive_image < 0 ? Json() : Json(m.emissive_image)},
          {"unlit", m.unlit},
          {"double_sided", m.double_sided},
          {"alpha_cutoff", m.alpha_cutoff}};
}

using Levels = std::vector<renderers::LevelInfo>;

// Of the levels asked for, by the options of the reference that draw them.
Levels levels_asked_for(const InspectOptions& options, const std::shared_ptr<const scene::Character>& character) {
  Levels out;
  if (options.levels.empty()) return out;
  std::vector<int> clips;
  for (const std::string& clip : options.clips) clips.push_back(scene::require_clip_or_none(*character, clip));
  if (clips.empty()) clips.push_back(character->placement.default_clip);
  const auto bank = std::make_shared<const scene::PoseBank>(*character, clips);
  const renderers::RepresentationType& type = renderers::reference_type();
  for (const std::string& text : options.levels) {
    const renderers::Spec spec = parse_representation(type.name + ":" + text, "--level");
    auto level = type.level(spec, character, bank, {.use_cache = !options.no_cache});
    if (!level)
      throw Error("--level", fmt::format("'{}' is the whole mesh", printable(text, 40)), "write triangles=500 or so");
    out.push_back(std::move(level->info));
  }
  return out;
}

Json to_json(const scene::Character& c, const Levels& levels, double figure_px) {
  const Bytes bytes = measure_bytes(c);
  const glm::dvec3 ground(c.placement.model_from_gltf[3]);
  Json out = {{"file", c.source},
              {"name", c.name},
              {"triangles", file_triangles(c)},
              {"drawn_triangles", c.triangles()},
              {"vertices", file_vertices(c)},
              {"drawn_vertices", scene::count_vertices(c.mesh)},
              {"joints", count_joints(c, false) != 0 ? count_joints(c, false) : count_joints(c, true)},
              {"rigid_meshes", count_joints(c, true)},
              {"nodes", c.skeleton.nodes.size()},
              {"influences", c.file_max_influences},
              {"height", c.placement.height},
              {"scale", c.placement.scale},
              {"ground_y", c.placement.scale > 0 ? -ground.y / c.placement.scale : 0.0},
              {"pivot_xz", {-ground.x / c.placement.scale, -ground.z / c.placement.scale}},
              {"height_clip", c.placement.upright_clip < 0 ? Json() : Json(c.placement.upright_clip)},
              {"default_clip", nullptr},
              {"clips", Json::array()},
              {"primitives", c.mesh.primitives.size()},
              {"lods", Json::array()},
              {"levels", levels_json(levels, figure_px)},
              {"materials", Json::array()},
              {"textures", Json::array()},
              {"bytes", bytes.file},
              {"memory_bytes",
               {{"mesh", bytes.mesh}, {"clips", bytes.clips}, {"textures", bytes.images}, {"all", bytes.memory()}}},
              {"content_hash", c.content_hash},
              {"warnings", c.warnings}};
  if (c.placement.default_clip >= 0) out["default_clip"] = c.placement.default_clip;
  for (const scene::Mesh& lod : c.levels) out["lods"].push_back({{"triangles", lod.indices.size() / 3}});
  for (size_t i = 0; i < c.clips.size(); ++i) out["clips"].push_back(clip_json(c, i));
  for (const scene::Material& m : c.materials) out["materials"].push_back(material_json(m));
  for (const scene::Texture& t : c.images)
    out["textures"].push_back({{"width", t.image.width}, {"height", t.image.height}});
  return out;
}

// "1.400 m/s by root motion, 90 degrees to its left, turning 30 degrees a second"
std::string ground_text(const scene::ClipMotion& motion) {
  std::string text = "-";
  if (motion.ground_speed > 0)
    text = fmt::format("{:.3f} m/s by {}", motion.ground_speed, motion.from_stance ? "stance foot" : "root motion");
  const double degrees = std::atan2(motion.direction.x, motion.direction.y) * 180 / kPi;
  if (motion.ground_speed > 0 && std::abs(degrees) > 175)
    text += ", backward";
  else if (motion.ground_speed > 0 && std::abs(degrees) > 5)
    text += fmt::format(", {:.0f} degrees to its {}", std::abs(degrees), degrees > 0 ? "left" : "right");
  if (motion.yaw_rate != 0) text += fmt::format(", turning {:.0f} degrees a second", motion.yaw_rate * 180 / kPi);
  return text;
}

// A line a level, under one heading.
void print_levels(const scene::Character& c, const Levels& levels, const InspectOptions& options) {
  std::string own;
  for (const scene::Mesh& lod : c.levels) own += fmt::format(", {}", lod.indices.size() / 3);
  if (!own.empty()) fmt::print("{:<14}{}{} triangles; lod=1 is the second\n", "levels", c.triangles(), own);
  for (size_t i = 0; i < levels.size(); ++i)
    fmt::print("{:<14}{} of {}\n", i == 0 ? "level" : "", printable(options.levels[i]),
               level_text(levels[i], options.figure_px));
  for (const renderers::LevelInfo& level : levels)
    if (!level.note.empty()) fmt::print("note: {}\n", printable(level.note));
}

void print_text(const scene::Character& c, const Levels& levels, const InspectOptions& options) {
  const Bytes bytes = measure_bytes(c);
  const auto line = [](std::string_view key, const std::string& value) { fmt::print("{:<14}{}\n", key, value); };
  line("character", printable(c.source, 300));
  line("triangles", numbers_text(file_triangles(c), c.triangles()));
  line("vertices", numbers_text(file_vertices(c), scene::count_vertices(c.mesh)));
  line("joints", fmt::format("{} and {} rigid meshes, {} nodes; {} influences a vertex at most", count_joints(c, false),
                             count_joints(c, true), c.skeleton.nodes.size(), c.file_max_influences));
  line("height", fmt::format("{:.4g} m ({:.6g} m a file unit): that of {}", c.placement.height, c.placement.scale,
                             clip_text(c, c.placement.upright_clip)));
  const glm::dvec3 origin = glm::dvec3(c.placement.model_from_gltf[3]) / c.placement.scale;
  line("stands at",
       fmt::format("x {:.4f}, ground y {:.4f}, z {:.4f} in file units; the ground is where its soles, else its "
                   "body, stay for a sixth of that clip's cycle",
                   0.0 - origin.x, 0.0 - origin.y, 0.0 - origin.z));
  std::string textures;
  for (const scene::Texture& t : c.images)
    textures += fmt::format("{}{} x {}", textures.empty() ? "" : ", ", t.image.width, t.image.height);
  line("textures", textures.empty() ? "none" : textures);
  line("bytes", fmt::format("{} in the file; in memory {}: mesh {}, clips {}, textures {}", bytes.file, bytes.memory(),
                            bytes.mesh, bytes.clips, bytes.images));
  print_levels(c, levels, options);
  fmt::print("\n{:>4}  {:<32}{:>9}{:>9}{:>9}  {}\n", "clip", "name", "seconds", "start", "end", "ground speed");
  for (size_t i = 0; i < c.clips.size(); ++i) {
    const scene::Clip& clip = c.clips[i];
    const scene::ClipMotion& motion = c.motion[i];
    fmt::print("{:>4}  {:<32}{:>9.3f}{:>9.3f}{:>9.3f}  {}{}\n", i,
               clip.name.empty() ? "(unnamed)" : printable(clip.name, 31), clip.duration(), clip.start, clip.end,
               ground_text(motion), static_cast<int>(i) == c.placement.default_clip ? "  (default)" : "");
  }
  if (c.clips.empty()) fmt::print("      none\n");
  fmt::print("\n{:>4}  {:<32}{:<28}{}\n", "slot", "material", "base colour (linear)", "texture");
  for (const scene::Material& m : c.materials)
    fmt::print(
        "{:>4}  {:<32}{:<28}{}{}{}{}\n", m.slot, m.name.empty() ? "(unnamed)" : printable(m.name, 31),
        fmt::format("{:.3f} {:.3f} {:.3f} {:.3f}", m.base_colour.r, m.base_colour.g, m.base_colour.b, m.base_colour.a),
        m.base_colour_image < 0 ? "-" : fmt::format("{}", m.base_colour_image), m.unlit ? ", unlit" : "",
        m.double_sided ? ", double-sided" : "",
        m.alpha_cutoff > 0 ? fmt::format(", masked at {:.3g}", m.alpha_cutoff) : "");
  if (!c.warnings.empty()) fmt::print("\n");
  for (const std::string& warning : c.warnings) fmt::print("warning: {}\n", printable(warning, 400));
}

std::string limits_text() {
  const scene::GltfLimits l;
  return fmt::format(
      "\nLimits (a file beyond them is refused): {} MiB of files, {} MiB of JSON with {} values and {} levels, {} "
      "nodes,\n{} joints, {} primitives, {} vertices, {} triangles, {} animation numbers, {} clips of {} s,\n{} "
      "influences a vertex, pictures of {} a side and {} MiB decoded in all, compressed meshes of {} MiB decoded in "
      "all",
      l.file_bytes >> 20, l.json_bytes >> 20, l.json_values, l.json_depth, l.nodes, l.joints, l.primitives, l.vertices,
      l.triangles, l.keys, l.clips, l.clip_seconds, l.influence_sets * 4, l.image_side, l.image_bytes >> 20,
      l.decoded_bytes >> 20);
}

int inspect(const InspectOptions& options) {
  scene::CharacterEntry entry = options.character.entry();
  entry.height = parse_height(options.height);
  entry.rigid_meshes = !options.no_rigid;
  entry.hide = options.hide;
  entry.clips = options.clips;
  const auto character = std::make_shared<const scene::Character>(scene::open_character(entry));
  for (const std::string& clip : options.clips) scene::require_clip_or_none(*character, clip);
  if (!options.out.empty()) scene::save_character(*character, options.out);
  const Levels levels = levels_asked_for(options, character);
  if (options.json)
    fmt::print("{}\n", to_json(*character, levels, options.figure_px).dump(2));
  else
    print_text(*character, levels, options);
  return 0;
}

}  // namespace

void add_inspect(Command& app, Run& run) {
  Command* command = app.add_subcommand("inspect", "Say what a character file holds; write it as glTF");
  command->footer(
      "Examples:\n  crowdbench inspect knight.glb\n  crowdbench inspect knight.glb --json --hide 2H_Sword\n"
      "  crowdbench inspect mannequin:joints=53 --out mannequin.glb\n  crowdbench inspect hero.fbx --out hero.glb\n"
      "  crowdbench inspect mannequin --level triangles=500 --level ratio=0.05 --height-px 60\n"
      "\nFBX (2011 or later) and COLLADA are read by Assimp, in metres and with +Y up whatever the file's unit and "
      "axes\n"
      "are. Lost, with a warning: blend shapes, cameras, lights, constraints, pictures other than of base colour and\n"
      "emission, bent curves between keys; COLLADA's animation clips play at once, as one.\n" +
      limits_text());
  auto options = std::make_shared<InspectOptions>();
  command
      ->add_option("CHARACTER", options->character.source,
                   "a glTF, FBX or COLLADA file, or mannequin[:triangles=N,joints=N]")
      ->required();
  add_json_option(*command, options->json);
  command->add_option("--out", options->out, "write the character as a self-contained file")
      ->type_name("FILE.glb")
      ->output_file();
  command->add_option("--height", options->height, "height to scale it to, in metres, or as_is")
      ->type_name("M")
      ->capture_default_str();
  command
      ->add_option("--hide", options->hide,
                   "drop the meshes at and below the node of this name (may be given several times)")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command
      ->add_option(
          "--clip", options->clips,
          "a clip in use, by name or index (may be given several times): the tallest first pose gives the height")
      ->type_name("CLIP")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command
      ->add_option("--level", options->levels,
                   "also a level of detail and how far its surface is from the whole mesh's over the clips in use:\n"
                   "triangles=N, ratio=F, error=METRES or lod=K (the file's own); may be given several times")
      ->type_name("KEY=VALUE")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command->add_option("--height-px", options->figure_px, "a figure's height, in whose pixels that is told as well")
      ->type_name("H")
      ->capture_default_str()
      ->number(1, 16384);
  command->add_flag("--no-cache", options->no_cache, "neither read nor write stored bakes");
  add_character_changes(*command, options->character);
  command->add_flag("--no-rigid", options->no_rigid, "drop the unskinned meshes of a skinned character");
  command->callback([options, &run] { run = [options] { return inspect(*options); }; });
}

}  // namespace crowdbench::bench
