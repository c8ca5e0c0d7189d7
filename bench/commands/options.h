// The options that several commands share: each has one name, one wording and one range.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "renderers/representation.h"
#include "scene/scenario/scenario.h"

namespace crowdbench::bench {

class Command;
class Option;

// ---- options; the variables must outlive `command`

// --representation: one; or several, repeated or in a list with commas.
Option* add_representation_option(Command& command, std::string& text, const std::string& meaning);
Option* add_representation_option(Command& command, std::vector<std::string>& texts, const std::string& meaning);
// A character and what is changed in it as it is loaded.
struct CharacterOptions {
  std::string source;                   // as scene::open_character takes it
  std::vector<std::string> animations;  // scene::CharacterEntry
  std::vector<std::string> bones;
  std::optional<double> turn_deg;
  std::string up;  // empty: y

  bool changes_nothing() const { return animations.empty() && bones.empty() && !turn_deg && up.empty(); }
  // Puts all but the source, where given, into the entry. Throws Error naming the option.
  void change(scene::CharacterEntry& entry) const;
  // An entry of that source, so changed; of the mannequin where there is none.
  scene::CharacterEntry entry() const;
};
// --character and --animations --bones --turn-deg --up-axis.
void add_character_options(Command& command, CharacterOptions& options);
// Of several characters, --character repeated; the other options are for all of them.
void add_character_options(Command& command, std::vector<std::string>& sources, CharacterOptions& all);
// Without --character.
void add_character_changes(Command& command, CharacterOptions& options);
Option* add_clip_option(Command& command, std::string& clip);  // --clip; empty: the default clip
Option* add_device_option(Command& command, std::string& device);
Option* add_size_option(Command& command, std::string& size);
// --samples and --supersample (scene::Antialiasing); what is not given stays empty.
struct AntialiasingOptions {
  std::optional<int> samples, supersample;
  void change(scene::Antialiasing& antialiasing) const;
};
void add_antialiasing_options(Command& command, AntialiasingOptions& options);
// --bake-budget; --no-cache where the command has it.
void add_bake_options(Command& command, uint64_t& budget_mib, bool* no_cache = nullptr);
// --display: a ColorVideoVDP model's name, FILE.json or FILE.json:NAME.
Option* add_display_option(Command& command, std::string& display);
// --db: a result file that rows are added to; made where missing.
Option* add_results_option(Command& command, std::string& file);
Option* add_json_option(Command& command, bool& json, const std::string& meaning = "print JSON");

inline constexpr uint64_t kDefaultBakeBudgetMiB = 512;

// ---- values

// parse_spec; an error says `where` the text was given: an option, or "plaza.toml:3: `representation`".
renderers::Spec parse_representation(const std::string& text, const std::string& where = "--representation");
// "mesh,flat:views=64,frames=8,hybrid(mesh,flat,distance=10)" to three representations: a comma separates where the
// next piece does not read key=value, and never within brackets.
std::vector<renderers::Spec> parse_representations(const std::vector<std::string>& texts,
                                                   const std::string& where = "--representation");

}  // namespace crowdbench::bench
