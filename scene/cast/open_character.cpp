#include "scene/cast/open_character.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <span>

#include "core/error.h"
#include "core/files.h"
#include "scene/assimp/assimp.h"
#include "scene/mannequin/mannequin.h"
#include "scene/pose/retarget.h"

namespace crowdbench::scene {
namespace {

int whole_number(std::string_view key, std::string_view text) {
  int value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || stop != text.data() + text.size())
    throw Error("mannequin", fmt::format("{}={} is not a whole number", key, printable(text, 40)),
                "write mannequin:triangles=500|2200|5000,joints=20|53");
  return value;
}

Character open_file(const std::filesystem::path& path, const LoadOptions& options) {
  const std::vector<uint8_t> bytes = read_file(path, options.limits.file_bytes);
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const auto format = assimp_format(std::span(bytes).first(std::min<size_t>(bytes.size(), 4096)), path);
  return format ? load_assimp_character(bytes, *format, path.string(), folder, options)
                : load_character(bytes, path.string(), folder, options);
}

Character open_one(const std::string& name_or_path, const LoadOptions& options) {
  constexpr std::string_view kBuiltIn = "mannequin";
  const std::string_view name = name_or_path;
  if (!is_built_in(name)) {
    std::error_code ignored;
    const std::string near = nearest_name(name_or_path.substr(0, name_or_path.find(':')), {std::string(kBuiltIn)});
    if (!near.empty() && !std::filesystem::exists(name_or_path, ignored))
      throw Error(printable(name_or_path, 60), "is not a file", fmt::format("did you mean '{}'?", near));
    return open_file(name_or_path, options);
  }
  MannequinOptions mannequin;
  mannequin.normalise = options.normalise;
  std::string_view rest = name.size() > kBuiltIn.size() ? name.substr(kBuiltIn.size() + 1) : std::string_view{};
  while (!rest.empty()) {
    const std::string_view one = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), one.size() + 1));
    const size_t equals = one.find('=');
    const std::string_view key = one.substr(0, equals);
    const std::string_view value = equals == std::string_view::npos ? std::string_view{} : one.substr(equals + 1);
    if (key == "triangles")
      mannequin.triangles = whole_number(key, value);
    else if (key == "joints")
      mannequin.joints = whole_number(key, value);
    else
      throw Error("mannequin", fmt::format("has no option {}", printable(key, 40)), "it has triangles and joints");
  }
  if (!options.hide.empty())
    throw Error("mannequin", fmt::format("has no node named {} to hide", printable(options.hide.front(), 60)),
                "it is one mesh");
  return make_mannequin(mannequin);
}

bool has_node(const Character& character, std::string_view name) {
  return std::ranges::any_of(character.skeleton.nodes, [&](const Node& node) { return node.name == name; });
}

// The pairs that are about this file: those whose node it has, or no file has, which is then refused.
std::vector<std::string> pairs_for(const Character& source, const std::vector<Character>& sources,
                                   const std::vector<std::string>& bones) {
  std::vector<std::string> out;
  for (const std::string& pair : bones) {
    const size_t equals = pair.find('=');
    const std::string theirs = equals == std::string::npos ? std::string() : pair.substr(equals + 1);
    const bool elsewhere = std::ranges::any_of(sources, [&](const Character& c) { return has_node(c, theirs); });
    if (has_node(source, theirs) || !elsewhere) out.push_back(pair);
  }
  return out;
}

// A name stands for the first clip that has it, and where none has, a number for the clip of that index: which clips
// are behind others.
void warn_of_names(Character& character) {
  constexpr size_t kListed = 8;
  std::map<std::string, std::vector<size_t>> named;
  for (size_t i = 0; i < character.clips.size(); ++i)
    if (!character.clips[i].name.empty()) named[character.clips[i].name].push_back(i);
  std::vector<std::string> warnings;
  for (const auto& [name, clips] : named) {
    const std::string shown = printable(name, 40);
    if (clips.size() > 1) {
      const auto others = std::span(clips).subspan(1, std::min(clips.size() - 1, kListed));
      warnings.push_back(fmt::format("{} clips are named '{}': the name stands for clip {}; name {} by {}: {}{}",
                                     clips.size(), shown, clips.front(), clips.size() == 2 ? "the other" : "the others",
                                     clips.size() == 2 ? "its number" : "their numbers", fmt::join(others, ", "),
                                     clips.size() - 1 > kListed ? ", ..." : ""));
    }
    size_t number = 0;
    const auto [stop, error] = std::from_chars(name.data(), name.data() + name.size(), number);
    const bool is_number = error == std::errc{} && stop == name.data() + name.size();
    if (is_number && number < character.clips.size() && number != clips.front())
      warnings.push_back(
          fmt::format("clip {} is named '{}': that stands for it, and not for clip {}", clips.front(), shown, number));
  }
  const size_t listed = std::min(warnings.size(), kListed);
  for (size_t i = 0; i < listed; ++i) character.warnings.push_back(std::move(warnings[i]));
  if (listed < warnings.size())
    character.warnings.push_back(fmt::format("{} more names stand for several clips", warnings.size() - listed));
}

}  // namespace

bool is_built_in(std::string_view name) { return name == "mannequin" || name.starts_with("mannequin:"); }

Character open_character(const std::string& name_or_path, const LoadOptions& options, const BorrowedClips& borrowed) {
  Character character = open_one(name_or_path, options);
  if (borrowed.animations.empty()) {
    if (!borrowed.bones.empty())
      throw Error("bones", "nothing plays: no other file's clips are used",
                  "name one with `animations` or --animations");
    warn_of_names(character);
    return character;
  }
  RetargetOptions retarget;
  retarget.keys = options.limits.keys;
  retarget.clips = options.limits.clips;
  LoadOptions of_clips;
  of_clips.limits = options.limits;
  of_clips.normalise.height.reset();
  of_clips.may_lack_mesh = true;
  std::vector<Character> sources;
  for (const std::string& name : borrowed.animations) sources.push_back(open_one(name, of_clips));
  for (const Character& source : sources) {
    retarget.bones = pairs_for(source, sources, borrowed.bones);
    add_clips_of(source, character, retarget);
  }
  NormaliseOptions again = options.normalise;
  if (again.turn_deg) again.turn_deg = 0.0;  // turned already
  again.up = UpAxis::y;
  normalise(character, again);
  warn_of_names(character);
  return character;
}

std::string path_of_character(const std::string& name, const std::filesystem::path& folder) {
  return is_built_in(name) || folder.empty() ? name : (folder / name).string();
}

Character open_character(const CharacterEntry& entry, const std::filesystem::path& folder) {
  LoadOptions options;
  options.normalise.height = entry.height;
  options.normalise.turn_deg = entry.turn_deg;
  options.normalise.up = entry.up;
  options.normalise.clips = entry.clips;
  options.rigid_meshes = entry.rigid_meshes;
  options.hide = entry.hide;
  const auto resolved = [&](const std::string& name) { return path_of_character(name, folder); };
  BorrowedClips borrowed;
  for (const std::string& name : entry.animations) borrowed.animations.push_back(resolved(name));
  borrowed.bones = entry.bones;
  return open_character(resolved(entry.source), options, borrowed);
}

}  // namespace crowdbench::scene
