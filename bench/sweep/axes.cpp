#include "bench/sweep/axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "core/error.h"
#include "core/random.h"
#include "scene/cast/scenario_table.h"

namespace crowdbench::bench::sweep {
namespace {

using scene::Key;
using scene::KeyType;
using scene::TomlNode;

constexpr size_t kMostAxes = 32;
constexpr size_t kMostValues = 10'000;

// "crowd.agents"; a list's table stands for each of its entries.
std::string name_of(const Key& key) { return key.table.empty() ? key.name : key.table + "." + key.name; }

const Key* find_key(const std::string& name) {
  for (const Key& key : scene::scenario_keys())
    if (name_of(key) == name) return &key;
  return nullptr;
}

bool is_table_of_keys(const std::string& name) {
  for (const scene::KeyTable& table : scene::scenario_tables())
    if (!table.name.empty() && table.name == name) return true;
  return false;
}

const renderers::RepresentationType* find_type(const std::string& name) {
  for (const renderers::RepresentationType& type : renderers::representation_types())
    if (type.name == name) return &type;
  return nullptr;
}

// A value as plain text: without the quotes of TOML.
std::string plain_text(const Key& key, const scene::KeyValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  const std::string toml = scene::toml_value(key, value);
  if (toml.size() >= 2 && toml.front() == '"') return toml.substr(1, toml.size() - 2);
  if (const auto* number = std::get_if<double>(&value)) return fmt::format("{}", *number);
  return toml;
}

std::optional<double> number_of(const scene::KeyValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return *number;
  if (const auto* integer = std::get_if<int64_t>(&value)) return static_cast<double>(*integer);
  if (const auto* seed = std::get_if<uint64_t>(&value)) return static_cast<double>(*seed);
  return std::nullopt;
}

void set_key(scene::Scenario& scenario, const Key& key, const scene::KeyValue& value, const std::string& place) {
  if (key.table == "camera" && scenario.camera.keys.size() > 1)
    throw Error(place, fmt::format("`{}` is an axis, and the scenario's camera follows a path", name_of(key)),
                "vary it by named settings that hold the whole path");
  const size_t entries = key.table == "character" ? scenario.characters.size() : 1;
  for (size_t i = 0; i < entries; ++i) key.set(scenario, i, value);
}

AxisValue value_of_key(const Key& key, const TomlNode& node, const std::string& where) {
  const scene::KeyValue value = scene::read_key(key, node, where);
  AxisValue out;
  const bool choice = key.type == KeyType::choice || key.type == KeyType::flag;
  out.setting = {name_of(key), plain_text(key, value), choice ? std::nullopt : number_of(value)};
  // A representation that there is not is refused where it stands.
  if (key.table.empty() && key.name == "representation") try {
      out.setting.text = renderers::parse_spec(out.setting.text).text();
    } catch (const Error& error) {
      throw Error(node.place(where),
                  "`representation`: " + error.where + (error.where.empty() ? "" : ": ") + error.wrong, error.advice);
    }
  out.change = [&key, value, place = node.place(where)](scene::Scenario& scenario) {
    set_key(scenario, key, value, place);
  };
  return out;
}

AxisValue value_of_option(const renderers::RepresentationType& type, const std::string& option, const TomlNode& node,
                          const std::string& where) {
  AxisValue out;
  std::string text;
  if (node.is_text())
    text = node.text;
  else if (node.is_integer())
    text = fmt::format("{}", node.integer);
  else if (node.is_number())
    text = fmt::format("{}", node.number);
  else if (node.is_boolean())
    text = node.boolean ? "1" : "0";
  else
    throw Error(node.place(where), fmt::format("`{}.{}` holds {}", type.name, option, node.type_name()),
                "give texts or numbers");
  if (text.empty() || text.find_first_of(",:()= \t\n") != std::string::npos)
    throw Error(node.place(where),
                fmt::format("`{}.{}` holds '{}', which is not a value that an option takes", type.name, option,
                            printable(text, 60)),
                "give one value without commas, colons and brackets");
  try {
    renderers::require_option_value(type, option, text);
  } catch (const Error& error) {
    throw Error(node.place(where), fmt::format("`{}.{}`: {}", type.name, option, error.wrong), error.advice);
  }
  out.setting = {type.name + "." + option, text, node.is_number() ? std::optional(node.as_number()) : std::nullopt};
  out.representation = type.name;
  out.option = option;
  return out;
}

TomlNode number_node(double number, bool whole, size_t line) {
  TomlNode node;
  node.line = line;
  node.type = whole ? TomlNode::Type::integer : TomlNode::Type::number;
  node.number = number;
  if (whole) node.integer = static_cast<int64_t>(std::llround(number));
  return node;
}

class AxesReader {
 public:
  AxesReader(std::string where, std::filesystem::path folder) : where_(std::move(where)), folder_(std::move(folder)) {}

  std::vector<Axis> run(const TomlNode& axes) {
    level("", axes);
    if (axes_.size() > kMostAxes)
      throw Error(axes.place(where_), fmt::format("{} axes", axes_.size()), fmt::format("give up to {}", kMostAxes));
    return std::move(axes_);
  }

 private:
  void level(const std::string& above, const TomlNode& table) {
    if (!table.is_table())
      throw Error(table.place(where_), fmt::format("`{}` is {}", above.empty() ? "axes" : above, table.type_name()),
                  "write it as a table: [axes]");
    for (const auto& [key, node] : table.table) {
      const std::string name = above.empty() ? key : above + "." + key;
      if (!above.empty() || !is_group(name) || !node.is_table())
        axis(name, node);
      else
        level(name, node);
    }
  }
  static bool is_group(const std::string& name) { return is_table_of_keys(name) || find_type(name) != nullptr; }

  void axis(const std::string& name, const TomlNode& node) {
    Axis made;
    made.name = name;
    made.place = node.place(where_);
    for (const Axis& other : axes_)
      if (other.name == name)
        throw Error(made.place, fmt::format("the axis `{}` is given twice", printable(name, 80)), "keep one of them");
    const Key* const key = find_key(name);
    if (is_table_of_keys(name) || (key != nullptr && key->table == "camera.key"))
      throw Error(made.place,
                  fmt::format("`{}` is {}", name, key == nullptr ? "a table of keys" : "of a camera's path"),
                  "vary it by named settings: [[axes.NAME]]");
    if (key != nullptr) {
      made.whole = key->type == KeyType::integer || key->type == KeyType::seed;
      values(made, node, [key, where = where_](const TomlNode& value) { return value_of_key(*key, value, where); });
    } else if (const size_t dot = name.find('.'); dot != std::string::npos && find_type(name.substr(0, dot))) {
      const renderers::RepresentationType& type = *find_type(name.substr(0, dot));
      const std::string option = known_option(type, name.substr(dot + 1), made.place);
      values(made, node, [&type, option, where = where_](const TomlNode& value) {
        return value_of_option(type, option, value, where);
      });
    } else if (node.is_list() && !node.list.empty() && node.list.front().is_table() && dot == std::string::npos) {
      named_settings(made, node);
    } else {
      unknown(name, made.place);
    }
    axes_.push_back(std::move(made));
  }

  std::string known_option(const renderers::RepresentationType& type, const std::string& option,
                           const std::string& place) const {
    std::vector<std::string> known;
    for (const renderers::OptionDoc& doc : renderers::option_docs(type)) known.push_back(doc.key);
    if (std::find(known.begin(), known.end(), option) != known.end()) return option;
    const std::string near = nearest_name(option, known);
    throw Error(place, fmt::format("{} has no option '{}'", type.name, printable(option, 60)),
                near.empty() ? "see `crowdbench info --representations`" : fmt::format("did you mean `{}`?", near));
  }

  [[noreturn]] void unknown(const std::string& name, const std::string& place) const {
    std::vector<std::string> known;
    for (const Key& key : scene::scenario_keys()) known.push_back(name_of(key));
    std::string near = nearest_name(name, known);
    for (const Key& key : scene::scenario_keys())
      if (key.name == name) near = name_of(key);
    for (const renderers::RepresentationType& type : renderers::representation_types())
      for (const renderers::OptionDoc& option : type.options)
        if (near.empty() && option.key == name) near = type.name + "." + name;
    throw Error(place, fmt::format("the axis `{}` is neither a key of a scenario nor an option", printable(name, 80)),
                near.empty() ? "named settings are written [[axes.NAME]]" : fmt::format("did you mean `{}`?", near));
  }

  template <typename Read>
  void values(Axis& made, const TomlNode& node, const Read& read) {
    if (node.is_table()) return range(made, node, read);
    if (!node.is_list() || node.list.empty() || node.list.size() > kMostValues)
      throw Error(made.place,
                  fmt::format("the axis `{}` {}", made.name,
                              node.is_list() ? fmt::format("has {} values", node.list.size())
                                             : fmt::format("is {}", node.type_name())),
                  "give a list of values, or { from = 1, to = 100, steps = 5 }");
    for (const TomlNode& value : node.list) {
      made.values.push_back(read(value));
      const std::string& text = made.values.back().setting.text;
      for (size_t i = 0; i + 1 < made.values.size(); ++i)
        if (made.values[i].setting.text == text)
          throw Error(value.place(where_), fmt::format("the axis `{}` has {} twice", made.name, printable(text, 60)),
                      "[points] `repetitions` measures all points several times");
    }
  }

  double number(const Axis& made, const TomlNode& table, const char* name) const {
    const TomlNode* const node = table.find(name);
    if (node == nullptr || !node->is_number() || !std::isfinite(node->as_number()))
      throw Error(
          node == nullptr ? made.place : node->place(where_),
          fmt::format("the range of `{}` {} `{}`", made.name, node == nullptr ? "lacks" : "has no number as", name),
          "write { from = 1, to = 100, steps = 5 }");
    return node->as_number();
  }

  template <typename Read>
  void range(Axis& made, const TomlNode& table, const Read& read) {
    for (const auto& [name, node] : table.table)
      if (name != "from" && name != "to" && name != "steps" && name != "scale")
        throw Error(node.place(where_), fmt::format("unknown key `{}` of a range", printable(name, 60)),
                    "a range has from, to, steps and scale");
    made.from = number(made, table, "from");
    made.to = number(made, table, "to");
    if (const TomlNode* const scale = table.find("scale")) {
      if (!scale->is_text() || (scale->text != "linear" && scale->text != "log"))
        throw Error(scale->place(where_), fmt::format("`scale` of `{}` is not known", made.name),
                    "choose \"linear\" or \"log\"");
      made.log = scale->text == "log";
    }
    if (!(made.from < made.to) || (made.log && made.from <= 0))
      throw Error(made.place, fmt::format("the range of `{}` goes from {} to {}", made.name, made.from, made.to),
                  made.log ? "a logarithmic one ascends from above 0" : "let it ascend");
    // The ends are checked here, what lies between them lies in the key's range too.
    read(number_node(made.from, made.whole, table.line));
    read(number_node(made.to, made.whole, table.line));
    const TomlNode* const steps = table.find("steps");
    if (steps == nullptr) {
      made.value_of = [read, whole = made.whole, line = table.line](double x) {
        return read(number_node(x, whole, line));
      };
      return;
    }
    if (!steps->is_integer() || steps->integer < 2 || steps->integer > static_cast<int64_t>(kMostValues))
      throw Error(steps->place(where_), fmt::format("`steps` of `{}` is not a number of values", made.name),
                  fmt::format("give 2 to {}", kMostValues));
    for (int64_t i = 0; i < steps->integer; ++i) {
      AxisValue value =
          read(number_node(between(made, static_cast<double>(i) / (steps->integer - 1)), made.whole, table.line));
      // Whole numbers may fall together at the low end of a logarithmic range.
      if (made.values.empty() || made.values.back().setting.text != value.setting.text)
        made.values.push_back(std::move(value));
    }
  }

  void named_settings(Axis& made, const TomlNode& list) {
    std::set<std::string> labels;
    for (const TomlNode& entry : list.list) {
      const TomlNode* const label = entry.is_table() ? entry.find("label") : nullptr;
      if (label == nullptr || !label->is_text() || label->text.empty() || label->text.size() > 100)
        throw Error(entry.place(where_), fmt::format("an entry of `{}` has no label", made.name),
                    "add label = \"...\": tables call it so");
      if (!labels.insert(label->text).second)
        throw Error(label->place(where_), fmt::format("the label '{}' is given twice", printable(label->text)),
                    "choose another");
      AxisValue value;
      value.setting = {made.name, label->text, std::nullopt};
      value.named = true;
      value.change = [entry, where = where_, folder = folder_](scene::Scenario& scenario) {
        scene::change_by_table(scenario, entry, where, folder, nullptr, "label");
      };
      scene::Scenario tried;
      value.change(tried);  // what is wrong with it is said now
      made.values.push_back(std::move(value));
    }
  }

 public:
  static double between(const Axis& axis, double share) {
    if (share <= 0) return axis.from;
    if (share >= 1) return axis.to;
    if (axis.log) return std::exp(std::log(axis.from) + share * (std::log(axis.to) - std::log(axis.from)));
    return axis.from + share * (axis.to - axis.from);
  }

 private:
  std::string where_;
  std::filesystem::path folder_;
  std::vector<Axis> axes_;
};

using Alternatives = std::vector<std::vector<AxisValue>>;

Alternatives drawn(const std::vector<Axis>& axes, const Sampling& sampling) {
  Alternatives all(sampling.count);
  size_t dimension = 0;
  for (const Axis& axis : axes) {
    if (!axis.sampled()) continue;
    for (size_t i = 0; i < sampling.count; ++i) {
      const double u = sampling.halton ? halton(sampling.seed, i, dimension) : random_unit(sampling.seed, i, dimension);
      all[i].push_back(axis.value_of(AxesReader::between(axis, u)));
    }
    ++dimension;
  }
  return all;
}

}  // namespace

std::vector<Axis> read_axes(const TomlNode& axes, const std::string& where, const std::filesystem::path& folder) {
  return AxesReader(where, folder).run(axes);
}

std::vector<AxisValue> read_listed(const TomlNode& point, const std::string& where, const std::filesystem::path& folder,
                                   const std::vector<Axis>& axes) {
  // Values by axis become axes of one value; a label is one of the axis' own.
  TomlNode ranges;
  std::vector<AxisValue> labelled;
  ranges.line = point.line;
  const std::function<TomlNode(const TomlNode&)> listed = [&](const TomlNode& node) {
    TomlNode out;
    out.line = node.line;
    if (node.is_table()) {
      for (const auto& [name, inner] : node.table) out.table.push_back({name, listed(inner)});
      return out;
    }
    out.type = TomlNode::Type::list;
    out.list = {node};
    return out;
  };
  for (const TomlNode::Entry& entry : point.table) {
    const std::string& name = entry.first;
    const TomlNode& node = entry.second;
    const auto axis = std::find_if(axes.begin(), axes.end(), [&](const Axis& a) { return a.name == name; });
    const bool named = axis != axes.end() && find_key(name) == nullptr;
    if (!named) {
      ranges.table.push_back({name, listed(node)});
      continue;
    }
    const auto value = std::find_if(axis->values.begin(), axis->values.end(),
                                    [&](const AxisValue& v) { return node.is_text() && v.setting.text == node.text; });
    if (value == axis->values.end())
      throw Error(node.place(where), fmt::format("`{}` has no such label", name), "choose one of its labels");
    labelled.push_back(*value);
  }
  for (Axis& axis : read_axes(ranges, where, folder)) labelled.push_back(std::move(axis.values.at(0)));
  return labelled;
}

std::vector<std::vector<AxisValue>> combine(const std::vector<Axis>& axes, const Sampling& sampling,
                                            const std::string& where) {
  std::vector<Alternatives> dimensions;
  bool sampled = false;
  size_t points = 1;
  for (const Axis& axis : axes) {
    if (axis.sampled() && std::exchange(sampled, true)) continue;
    points *= axis.sampled() ? sampling.count : axis.values.size();
    if (points > kMostPoints)
      throw Error(where, fmt::format("the axes span more than {} points", kMostPoints),
                  "give fewer values, or sample them: [points] sample = { method = \"halton\", count = 500 }");
    Alternatives here;
    for (const AxisValue& value : axis.values) here.push_back({value});
    dimensions.push_back(axis.sampled() ? drawn(axes, sampling) : std::move(here));
  }
  Alternatives all = {{}};
  for (const Alternatives& dimension : dimensions) {
    Alternatives next;
    next.reserve(all.size() * dimension.size());
    for (const auto& before : all)
      for (const auto& more : dimension) {
        next.push_back(before);
        next.back().insert(next.back().end(), more.begin(), more.end());
      }
    all = std::move(next);
  }
  return all;
}

double halton(uint64_t seed, size_t i, size_t dimension) {
  static constexpr std::array<unsigned, 32> kPrimes = {2,  3,  5,  7,   11,  13,  17,  19,  23,  29, 31,
                                                       37, 41, 43, 47,  53,  59,  61,  67,  71,  73, 79,
                                                       83, 89, 97, 101, 103, 107, 109, 113, 127, 131};
  const unsigned base = kPrimes.at(dimension);
  double value = 0;
  double digit = 1;
  for (uint64_t n = i + 1; n > 0; n /= base) {
    digit /= base;
    value += digit * static_cast<double>(n % base);
  }
  constexpr uint64_t kShift = 0x68616c74;
  value += random_unit(seed, dimension, kShift);
  return value - std::floor(value);
}

}  // namespace crowdbench::bench::sweep
