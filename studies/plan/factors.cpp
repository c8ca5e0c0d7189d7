#include "studies/plan/factors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "scene/cast/open_character.h"
#include "scene/cast/scenario_table.h"
#include "scene/scenario/scenario_changes.h"
#include "scene/scenario/scenario_keys.h"

namespace crowdbench::studies {
namespace {

using scene::Key;
using scene::TomlNode;

constexpr size_t kMostLevels = 32;
constexpr size_t kMostFactors = 8;
constexpr int kLastTurn = 3;
constexpr char kDistance[] = "distance";  // the option of what switches by distance

std::string key_name(const Key& key) { return key.table.empty() ? key.name : key.table + "." + key.name; }

const Key* scenario_key(const std::string& name) {
  for (const Key& key : scene::scenario_keys())
    if (key_name(key) == name) return &key;
  return nullptr;
}

const renderers::RepresentationType* type_named(const std::string& name) {
  for (const renderers::RepresentationType& type : renderers::representation_types())
    if (type.name == name) return &type;
  return nullptr;
}

bool has_option(const renderers::RepresentationType& type, const std::string& option) {
  const auto docs = renderers::option_docs(type);
  return std::any_of(docs.begin(), docs.end(), [&](const auto& doc) { return doc.key == option; });
}

// Puts the option into the representation of that name, and into its components. False: there is none.
bool put_option(renderers::Spec& spec, const std::string& name, const std::string& option, const std::string& value) {
  bool any = spec.name == name;
  if (any) {
    std::erase_if(spec.options, [&](const auto& given) { return given.first == option; });
    spec.options.emplace_back(option, value);
  }
  for (renderers::Spec& component : spec.components) any = put_option(component, name, option, value) || any;
  return any;
}

// Whether any of its options is about texels, or the points that stand for them: who has none of either shows geometry.
// What the far one of two has counts.
bool may_have_texels(const renderers::Spec& spec) {
  if (!spec.components.empty()) return may_have_texels(spec.components.back());
  const auto docs = renderers::option_docs(renderers::representation_type(spec.name));
  return std::any_of(docs.begin(), docs.end(), [](const renderers::OptionDoc& doc) {
    return doc.key == "points" || doc.meaning.find("texel") != std::string::npos;
  });
}

// Reads [factors], factor by factor.
class FactorsReader {
 public:
  FactorsReader(std::string where, std::filesystem::path folder)
      : where_(std::move(where)), folder_(std::move(folder)) {}

  std::vector<ReadFactor> run(const TomlNode& table) {
    if (!table.is_table())
      throw Error(table.place(where_), fmt::format("`factors` is {}", table.type_name()), "write [factors]");
    for (const auto& [name, node] : table.table) {
      const bool group = node.is_table() && (type_named(name) != nullptr || is_key_table(name));
      if (!group) {
        factor(name, node);
        continue;
      }
      for (const auto& [part, inner] : node.table) factor(name + "." + part, inner);
    }
    if (factors_.size() > kMostFactors)
      throw Error(table.place(where_), fmt::format("{} factors", factors_.size()),
                  fmt::format("give up to {}", kMostFactors));
    return std::move(factors_);
  }

 private:
  static bool is_key_table(const std::string& name) {
    for (const scene::KeyTable& table : scene::scenario_tables())
      if (!table.name.empty() && table.name == name) return true;
    return false;
  }

  void factor(const std::string& name, const TomlNode& node) {
    ReadFactor made;
    made.factor.name = name;
    made.place = node.place(where_);
    for (const ReadFactor& other : factors_)
      if (other.factor.name == name)
        throw Error(made.place, fmt::format("the factor `{}` is given twice", printable(name, 80)), "keep one of them");
    if (!node.is_list() || node.list.empty() || node.list.size() > kMostLevels)
      throw Error(made.place,
                  fmt::format("the factor `{}` {}", printable(name, 80),
                              node.is_list() ? fmt::format("has {} levels", node.list.size())
                                             : fmt::format("is {}", node.type_name())),
                  fmt::format("give a list of 1 to {} levels", kMostLevels));
    for (const TomlNode& level : node.list) add_level(made, level);
    factors_.push_back(std::move(made));
  }

  void add_level(ReadFactor& made, const TomlNode& node) {
    const std::string& name = made.factor.name;
    if (name == "representation")
      add_representation(made, node);
    else if (name == "switch_m")
      add_switch(made, node);
    else if (name == "height_px" || name == "pixels_per_texel")
      add_camera_distance(made, node);
    else if (name == "character")
      add_character(made, node);
    else if (name == "clip")
      add_clip(made, node);
    else if (name == "camera")
      add_camera(made, node);
    else if (const size_t dot = name.find('.'); dot != std::string::npos && type_named(name.substr(0, dot)) != nullptr)
      add_option(made, node, name.substr(0, dot), name.substr(dot + 1));
    else if (const Key* const key = scenario_key(name))
      add_key(made, node, *key);
    else
      unknown(name, made.place);
    const std::vector<FactorLevel>& levels = made.factor.levels;
    for (size_t i = 0; i + 1 < levels.size(); ++i)
      if (levels[i].text == levels.back().text)
        throw Error(node.place(where_), fmt::format("the factor `{}` has {} twice", name, levels.back().text),
                    "repeats are [method] `repeats`, other crowds [stimulus] `crowds`");
  }

  [[noreturn]] void unknown(const std::string& name, const std::string& place) const {
    std::vector<std::string> known = {"representation", "switch_m", "height_px", "pixels_per_texel",
                                      "character",      "clip",     "camera",    "background"};
    const std::string words = fmt::format("{}", fmt::join(known, ", "));
    for (const Key& key : scene::scenario_keys()) known.push_back(key_name(key));
    const std::string near = nearest_name(name, known);
    throw Error(place, fmt::format("unknown factor `{}`", printable(name, 80)),
                near.empty()
                    ? fmt::format("there are {}, NAME.OPTION of a representation, and keys of a scenario", words)
                    : fmt::format("did you mean `{}`?", near));
  }

  std::string text_of(const ReadFactor& made, const TomlNode& node) const {
    if (!node.is_text() || node.text.empty() || node.text.size() > 300)
      throw Error(node.place(where_), fmt::format("`{}` holds what is not a text of 1 to 300 bytes", made.factor.name),
                  "write it in quotes");
    return node.text;
  }
  double number_of(const ReadFactor& made, const TomlNode& node, double low, double high) const {
    if (!node.is_number() || !(node.as_number() >= low && node.as_number() <= high))
      throw Error(node.place(where_),
                  fmt::format("`{}` holds what is not a number from {} to {}", made.factor.name, low, high),
                  "change it");
    return node.as_number();
  }

  void add_representation(ReadFactor& made, const TomlNode& node) {
    renderers::Spec spec;
    const std::string text = text_of(made, node);
    try {
      spec = renderers::parse_spec(renderers::parse_spec(text).text());
    } catch (const Error& error) {
      throw Error(node.place(where_), "`representation`: " + error.wrong, error.advice);
    }
    made.factor.levels.push_back({spec.text(), std::nullopt});
    made.changes.emplace_back([spec](StudyCondition& condition) { condition.test = spec; });
  }

  // 0: the far one of the two alone. Infinite: the near one alone.
  void add_switch(ReadFactor& made, const TomlNode& node) {
    made.turn = 2;
    const bool infinite = node.is_text() && node.text == "inf";
    const double metres = infinite ? std::numeric_limits<double>::infinity() : number_of(made, node, 0, 1e5);
    made.factor.levels.push_back({infinite ? "inf" : fmt::format("{}", metres), metres});
    made.changes.emplace_back([metres, place = node.place(where_)](StudyCondition& condition) {
      renderers::Spec& spec = condition.test;
      const renderers::RepresentationType* const type = type_named(spec.name);
      if (type == nullptr || spec.components.size() != 2 || !has_option(*type, kDistance))
        throw Error(place, fmt::format("`switch_m` switches between two representations, and '{}' is one", spec.text()),
                    "give [conditions] `test` two of them, as `crowdbench info --representations` shows");
      if (metres == 0 || std::isinf(metres)) {
        spec = renderers::Spec(spec.components[metres == 0 ? 1 : 0]);
        return;
      }
      for (const char* const rule : {"height", "ratio", "nearest"})
        for (const auto& [key, value] : spec.options)
          if (key == rule)
            throw Error(place, fmt::format("`switch_m` beside the rule `{}` of '{}'", rule, spec.text()),
                        "leave that option out");
      std::erase_if(spec.options, [](const auto& given) { return given.first == kDistance; });
      spec.options.emplace_back(kDistance, fmt::format("{}", metres));
    });
  }

  void add_camera_distance(ReadFactor& made, const TomlNode& node) {
    const bool height = made.factor.name == "height_px";
    const double value = height ? number_of(made, node, 4, 4096) : number_of(made, node, 0.05, 20);
    made.factor.levels.push_back({fmt::format("{}", value), value});
    made.turn = kLastTurn;
    made.changes.emplace_back([height, value, place = node.place(where_)](StudyCondition& condition) {
      (height ? condition.height_px : condition.pixels_per_texel) = value;
      if (condition.height_px && condition.pixels_per_texel)
        throw Error(place, "`height_px` and `pixels_per_texel` both move the camera", "keep one of them");
      if (!height && !may_have_texels(condition.test))
        throw Error(place, fmt::format("'{}' has no texels that pixels could be counted by", condition.test.text()),
                    "use `height_px`");
      if (condition.scenario.camera.keys.size() > 1)
        throw Error(place, "this moves the camera, which follows a path", "give [scenario] one camera");
    });
  }

  void add_character(ReadFactor& made, const TomlNode& node) {
    const std::string source = text_of(made, node);
    made.factor.levels.push_back({source, std::nullopt});
    made.changes.emplace_back([source](StudyCondition& condition) {
      for (scene::CharacterEntry& entry : condition.scenario.characters) entry.source = source;
    });
  }

  void add_clip(ReadFactor& made, const TomlNode& node) {
    const std::string clip = text_of(made, node);
    made.factor.levels.push_back({clip, std::nullopt});
    made.turn = 1;
    made.changes.emplace_back([clip](StudyCondition& condition) {
      for (scene::CharacterEntry& entry : condition.scenario.characters) entry.clips = {clip};
    });
  }

  // { label = "balcony", eye = [...], target = [...], ... }
  void add_camera(ReadFactor& made, const TomlNode& node) {
    const TomlNode* const label = node.is_table() ? node.find("label") : nullptr;
    if (label == nullptr)
      throw Error(node.place(where_), "`camera` holds what is not a table with a label",
                  "write { label = \"balcony\", eye = [0, 5, 17], target = [0, 1, 0] }");
    made.factor.levels.push_back({text_of(made, *label), std::nullopt});
    TomlNode changes;
    changes.line = node.line;
    changes.table.push_back({"camera", node});
    std::erase_if(changes.table[0].second.table, [](const TomlNode::Entry& entry) { return entry.first == "label"; });
    scene::Scenario tried;
    scene::change_scenario(tried, changes, where_);
    made.changes.emplace_back([changes, where = where_](StudyCondition& condition) {
      scene::change_scenario(condition.scenario, changes, where);
    });
  }

  void add_option(ReadFactor& made, const TomlNode& node, const std::string& name, const std::string& option) {
    const renderers::RepresentationType& type = *type_named(name);
    if (!has_option(type, option)) {
      std::vector<std::string> known;
      for (const renderers::OptionDoc& doc : renderers::option_docs(type)) known.push_back(doc.key);
      const std::string near = nearest_name(option, known);
      throw Error(made.place, fmt::format("{} has no option '{}'", name, printable(option, 60)),
                  near.empty() ? "see `crowdbench info --representations`" : fmt::format("did you mean `{}`?", near));
    }
    std::string value;
    if (node.is_text()) value = node.text;
    if (node.is_number()) value = node.is_integer() ? fmt::format("{}", node.integer) : fmt::format("{}", node.number);
    if (value.empty() || value.find_first_of(",:()= \t\n") != std::string::npos)
      throw Error(node.place(where_), fmt::format("`{}.{}` holds what no option takes", name, option),
                  "give texts without commas, colons and brackets, or numbers");
    require_value(type, option, value, node);
    made.turn = 1;
    made.factor.levels.push_back({value, node.is_number() ? std::optional(node.as_number()) : std::nullopt});
    made.changes.emplace_back([name, option, value, place = made.place](StudyCondition& condition) {
      if (!put_option(condition.test, name, option, value))
        throw Error(place, fmt::format("`{}.{}`: '{}' is not drawn by it", name, option, condition.test.text()),
                    "let [conditions] `test` or the factor `representation` name it");
    });
  }

  // What the table of options says of its values is known before anything is drawn.
  void require_value(const renderers::RepresentationType& type, const std::string& option, const std::string& value,
                     const TomlNode& node) const {
    try {
      renderers::require_option_value(type, option, value);
    } catch (const Error& error) {
      throw Error(node.place(where_), fmt::format("`{}.{}`: {}", type.name, option, error.wrong),
                  error.advice.empty() ? "see `crowdbench info --representations`" : error.advice);
    }
  }

  void add_key(ReadFactor& made, const TomlNode& node, const Key& key) {
    const scene::KeyTable* repeated = nullptr;
    for (const scene::KeyTable& table : scene::scenario_tables())
      if (table.name == key.table && table.list) repeated = &table;
    if (key.name == "seed" || key.name == "representation" || key.name == "occupancy" || repeated != nullptr)
      throw Error(made.place, fmt::format("the factor `{}` has no meaning in a study", made.factor.name),
                  "crowds are [stimulus] `crowds`; characters and clips are the factors `character` and `clip`");
    const scene::KeyValue value = scene::read_key(key, node, where_);
    std::string text = scene::toml_value(key, value);
    if (text.size() >= 2 && text.front() == '"') text = text.substr(1, text.size() - 2);
    made.factor.levels.push_back({text, node.is_number() ? std::optional(node.as_number()) : std::nullopt});
    const bool spacing = made.factor.name == "crowd.spacing";
    made.changes.emplace_back([&key, value, spacing](StudyCondition& condition) {
      key.set(condition.scenario, 0, value);
      condition.spacing_by_bodies = condition.spacing_by_bodies && !spacing;
    });
  }

  std::string where_;
  std::filesystem::path folder_;
  std::vector<ReadFactor> factors_;
};

}  // namespace

std::vector<ReadFactor> read_factors(const TomlNode& table, const std::string& where,
                                     const std::filesystem::path& folder) {
  return FactorsReader(where, folder).run(table);
}

std::vector<StudyCondition> combine_factors(const std::vector<ReadFactor>& factors, const StudyCondition& base) {
  size_t count = 1;
  for (const ReadFactor& factor : factors) {
    count *= factor.changes.size();
    if (count > kMostConditions)
      throw Error(factor.place, fmt::format("the factors make more than {} conditions", kMostConditions),
                  "leave out levels, or make several studies of it");
  }
  std::vector<StudyCondition> out;
  for (size_t i = 0; i < count; ++i) {
    StudyCondition condition = base;
    condition.id = fmt::format("c{:02}", i + 1);
    std::vector<size_t> chosen(factors.size());
    size_t rest = i;
    for (size_t f = factors.size(); f-- > 0; rest /= factors[f].changes.size())
      chosen[f] = rest % factors[f].changes.size();
    for (size_t f = 0; f < factors.size(); ++f) {
      const FactorLevel& level = factors[f].factor.levels[chosen[f]];
      condition.levels.push_back(level);
      condition.name += fmt::format("{}{}={}", f == 0 ? "" : " ", factors[f].factor.name, level.text);
    }
    for (int turn = 0; turn <= kLastTurn; ++turn)
      for (size_t f = 0; f < factors.size(); ++f)
        if (factors[f].turn == turn) factors[f].changes[chosen[f]](condition);
    out.push_back(std::move(condition));
  }
  return out;
}

}  // namespace crowdbench::studies
