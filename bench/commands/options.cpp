#include "bench/commands/options.h"

#include "bench/commands/command_line.h"
#include "core/error.h"

namespace crowdbench::bench {
namespace {

constexpr const char* kCharacterMeaning = "a glTF, FBX or COLLADA file, or mannequin[:triangles=N,joints=N]";

[[noreturn]] void blame(const std::string& where, const Error& error) {
  throw Error(where, error.where.empty() ? error.wrong : error.where + ": " + error.wrong, error.advice);
}

// Of --bones: each "mine=theirs".
void require_pairs(const std::vector<std::string>& bones) {
  for (const std::string& pair : bones)
    if (const size_t equals = pair.find('='); equals == std::string::npos || equals == 0 || equals + 1 == pair.size())
      throw Error("--bones", fmt::format("'{}' is not a pair of nodes", printable(pair, 80)),
                  "write the character's node, =, the other file's: \"LeftArm=upperarm_l\"");
}

}  // namespace

Option* add_representation_option(Command& command, std::string& text, const std::string& meaning) {
  return command
      .add_option("-r,--representation", text, meaning + "; name[:key=value,...], see info --representations")
      ->type_name("R")
      ->capture_default_str();
}

Option* add_representation_option(Command& command, std::vector<std::string>& texts, const std::string& meaning) {
  return command
      .add_option("-r,--representation", texts,
                  meaning + "; name[:key=value,...], repeated or in a list with commas, see info --representations")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false)
      ->type_name("R");
}

void CharacterOptions::change(scene::CharacterEntry& entry) const {
  if (!animations.empty()) entry.animations = animations;
  if (!bones.empty()) entry.bones = bones;
  require_pairs(bones);
  if (!bones.empty() && entry.animations.empty())
    throw Error("--bones", "nothing plays: no other file's clips are used", "name one with --animations");
  if (turn_deg) entry.turn_deg = turn_deg;
  if (up.empty()) return;
  if (up != "y" && up != "z")
    throw Error("--up-axis", fmt::format("'{}' is not an axis that may point up", printable(up, 40)), "give y or z");
  entry.up = up == "y" ? scene::UpAxis::y : scene::UpAxis::z;
}

scene::CharacterEntry CharacterOptions::entry() const {
  scene::CharacterEntry out;
  if (!source.empty()) out.source = source;
  change(out);
  return out;
}

void add_character_options(Command& command, CharacterOptions& options) {
  command.add_option("--character", options.source, kCharacterMeaning)->type_name("C");
  add_character_changes(command, options);
}

void add_character_options(Command& command, std::vector<std::string>& sources, CharacterOptions& all) {
  command
      .add_option("--character", sources, std::string(kCharacterMeaning) + "; may be given several times (mannequin)")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false)
      ->type_name("C");
  add_character_changes(command, all);
}

void add_character_changes(Command& command, CharacterOptions& options) {
  command
      .add_option("--animations", options.animations,
                  "a file whose clips the character plays too, or mannequin; may be given several times")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false)
      ->type_name("FILE");
  command
      .add_option("--bones", options.bones,
                  "which node plays which of --animations, where names do not say; may be given several times")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false)
      ->type_name("MINE=THEIRS");
  command
      .add_option("--turn-deg", options.turn_deg,
                  "turn the character about the vertical, so that it faces +Z (guessed)")
      ->type_name("DEG")
      ->number(-360, 360);
  command.add_option("--up-axis", options.up, "which axis of the character's file points up (y)")->type_name("y|z");
}

Option* add_clip_option(Command& command, std::string& clip) {
  return command.add_option("--clip", clip, "a clip's name, else its index; none for the bind pose (the default clip)")
      ->type_name("CLIP");
}

Option* add_device_option(Command& command, std::string& device) {
  return command
      .add_option("--device", device,
                  "EGL device: its index, software, or surfaceless (default: $CROWDBENCH_DEVICE, else the first GPU)")
      ->type_name("D");
}

Option* add_size_option(Command& command, std::string& size) {
  return command.add_option("--size", size, "size of the picture in pixels")->type_name("WxH")->capture_default_str();
}

void AntialiasingOptions::change(scene::Antialiasing& antialiasing) const {
  if (samples) antialiasing.samples = *samples;
  if (supersample) antialiasing.supersample = *supersample;
}

void add_antialiasing_options(Command& command, AntialiasingOptions& options) {
  command
      .add_option("--samples", options.samples,
                  "samples a pixel of multisampling: 1, 2, 4 or 8, as the driver has them")
      ->type_name("N")
      ->power_of_two(1, 8);
  command.add_option("--supersample", options.supersample, "K x K samples a pixel, averaged in linear light; K is odd")
      ->type_name("K")
      ->odd_number(1, 9);
}

void add_bake_options(Command& command, uint64_t& budget_mib, bool* no_cache) {
  command.add_option("--bake-budget", budget_mib, "MiB that a bake may take")
      ->type_name("MIB")
      ->capture_default_str()
      ->whole_number(1, 1 << 20);
  if (no_cache != nullptr) command.add_flag("--no-cache", *no_cache, "neither read nor write stored bakes");
}

Option* add_display_option(Command& command, std::string& display) {
  return command
      .add_option("--display", display, "where it is looked at: a model's name, or a file with ColorVideoVDP's keys")
      ->type_name("NAME|FILE.json");
}

Option* add_results_option(Command& command, std::string& file) {
  return command.add_option("--db", file, "add what was found to this result file; `correlate` and `report` read it")
      ->type_name("FILE.sqlite")
      ->output_file();
}

Option* add_json_option(Command& command, bool& json, const std::string& meaning) {
  return command.add_flag("--json", json, meaning);
}

renderers::Spec parse_representation(const std::string& text, const std::string& where) {
  try {
    return renderers::parse_spec(text);
  } catch (const Error& error) {
    blame(where, error);
  }
}

std::vector<renderers::Spec> parse_representations(const std::vector<std::string>& texts, const std::string& where) {
  std::vector<renderers::Spec> specs;
  for (const std::string& text : texts) try {
      const std::vector<renderers::Spec> some = renderers::parse_specs(text);
      specs.insert(specs.end(), some.begin(), some.end());
    } catch (const Error& error) {
      blame(where, error);
    }
  return specs;
}

}  // namespace crowdbench::bench
