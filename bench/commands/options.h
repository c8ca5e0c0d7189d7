// The options that several commands share: each has one name, one wording and one range.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "renderers/representation.h"

namespace crowdbench::bench {

class Command;
class Option;

// ---- options; the variables must outlive `command`

// --representation: one; or several, repeated or in a list with commas.
Option* add_representation_option(Command& command, std::string& text, const std::string& meaning);
Option* add_representation_option(Command& command, std::vector<std::string>& texts, const std::string& meaning);
// --character: one; or several, repeated.
Option* add_character_option(Command& command, std::string& source);
Option* add_character_option(Command& command, std::vector<std::string>& sources);
Option* add_clip_option(Command& command, std::string& clip);  // --clip; empty: the default clip
Option* add_device_option(Command& command, std::string& device);
Option* add_size_option(Command& command, std::string& size);
Option* add_supersample_option(Command& command, int& samples);
// --bake-budget; --no-cache where the command has it.
void add_bake_options(Command& command, uint64_t& budget_mib, bool* no_cache = nullptr);
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
