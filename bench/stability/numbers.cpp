// Numbers that are none, infinite or hardly there, at every door: refused by name, or taken and finite.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "bench/stability/fixture.h"
#include "bench/stability/odd_gltf.h"
#include "core/error.h"
#include "scene/scenario/parse_scenario.h"
#include "scene/scenario/scenario_keys.h"

namespace crowdbench::bench {
namespace {

constexpr std::array<const char*, 5> kNoNumbers = {"nan", "-nan", "inf", "-inf", "1e400"};

// Counts what went another way than it should.
struct Doors {
  Found found;
  int tried = 0;
  Doors() { found.measured = 0; }
  void count(bool right, const std::string& place, const std::string& expected, const std::string& got) {
    ++tried;
    if (right) return;
    if (found.measured == 0) {
      found.place = place;
      found.expected = expected;
      found.got = got;
    }
    found.measured += 1;
  }
  Found end() {
    found.note = fmt::format("{} values tried", tried);
    return found;
  }
};

// What the fault says, or nothing where it was taken.
template <typename Try>
std::string refusal_of(const Try& attempt) {
  try {
    attempt();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

std::string with_key(const scene::Key& key, const std::string& value) {
  std::string text;
  if (!key.table.empty()) {
    const auto& tables = scene::scenario_tables();
    const auto table =
        std::find_if(tables.begin(), tables.end(), [&](const scene::KeyTable& t) { return t.name == key.table; });
    const bool list = table != tables.end() && table->list;
    text = fmt::format("{}{}{}\n", list ? "[[" : "[", key.table, list ? "]]" : "]");
  }
  return text + fmt::format("{} = {}\n", key.name, value);
}

Found scenario_door(Fixture&) {
  Doors doors;
  for (const scene::Key& key : scene::scenario_keys()) {
    const bool vector = key.type == scene::KeyType::vector;
    const bool number = key.type == scene::KeyType::number || key.type == scene::KeyType::integer ||
                        key.type == scene::KeyType::seed || vector;
    if (!number) continue;
    for (const char* value : kNoNumbers) {
      const std::string text = with_key(key, vector ? fmt::format("[0, {}, 1]", value) : value);
      const std::string refusal = refusal_of([&] { scene::parse_scenario(text, "scenario.toml"); });
      const bool named = refusal.find(key.name) != std::string::npos || refusal.find("scenario.toml:") == 0;
      doors.count(named, fmt::format("{}.{} = {}", key.table, key.name, value), "refused, by name and line",
                  refusal.empty() ? "taken" : refusal);
    }
  }
  return doors.end();
}

// Numbers below the least normal double are numbers: taken where the range begins at or below them.
Found subnormal_door(Fixture&) {
  Doors doors;
  for (const scene::Key& key : scene::scenario_keys()) {
    if (key.type != scene::KeyType::number) continue;
    for (const char* value : {"5e-324", "1e-320", "-5e-324"}) {
      const double given = std::strtod(value, nullptr);
      std::optional<double> read;
      const std::string refusal = refusal_of([&] {
        const scene::Scenario scenario = scene::parse_scenario(with_key(key, value), "scenario.toml");
        const scene::KeyValue back = key.get(scenario, 0);
        if (std::holds_alternative<double>(back)) read = std::get<double>(back);
      });
      const bool in_range = given >= key.low && given <= key.high;
      const bool right = refusal.empty() ? in_range && read && std::isfinite(*read) : !in_range || !read;
      doors.count(right, fmt::format("{}.{} = {}", key.table, key.name, value),
                  in_range ? "taken, and finite" : "refused",
                  refusal.empty() ? fmt::format("{}", read.value_or(NAN)) : refusal);
    }
  }
  return doors.end();
}

// Options of representations that hold a number, by what their documentation says.
Found option_door(Fixture& fixture) {
  Doors doors;
  for (const renderers::RepresentationType& type : renderers::representation_types())
    for (const renderers::OptionDoc& option : renderers::option_docs(type)) {
      if (option.values.find("..") == std::string::npos) continue;
      for (const char* value : kNoNumbers) {
        const std::string base = renderers::example_spec(type);
        const std::string refusal = refusal_of([&] {
          renderers::Spec spec = renderers::parse_spec(base);
          std::erase_if(spec.options, [&](const auto& given) { return given.first == option.key; });
          spec.options.emplace_back(option.key, value);
          renderers::make_representation({.context = fixture.context(), .cast = fixture.walker(), .progress = false},
                                         spec);
        });
        doors.count(refusal.find(option.key) != std::string::npos,
                    fmt::format("{}:{}={}", type.name, option.key, value), "refused, by name",
                    refusal.empty() ? "taken" : refusal);
      }
    }
  return doors.end();
}

// A small character with one thing wrong or odd in its bytes.
Found gltf_door(Fixture&) {
  Doors doors;
  for (const OddGltf& odd : odd_gltfs()) {
    scene::Character loaded;
    const std::string refusal = refusal_of([&] { loaded = scene::load_character(odd.bytes, "odd.glb", {}); });
    if (odd.refused) {
      doors.count(refusal.find("odd.glb") == 0, odd.name, "refused, by the file's name",
                  refusal.empty() ? "taken" : refusal);
      continue;
    }
    bool sane = refusal.empty();
    for (const glm::vec4& weight : loaded.mesh.weights)
      sane = sane && std::abs(weight.x + weight.y + weight.z + weight.w - 1) < 1e-6F;
    for (const glm::vec3& p : loaded.mesh.positions)
      sane = sane && std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
    for (const glm::vec3& n : loaded.mesh.normals) sane = sane && std::abs(glm::length(n) - 1) < 1e-3F;
    doors.count(sane, odd.name, "taken: weights that sum to 1, finite places, unit normals",
                refusal.empty() ? "other weights, places or normals" : refusal);
  }
  return doors.end();
}

}  // namespace

void add_number_cases(std::vector<StabilityCase>& cases) {
  const auto add = [&](std::string_view name, std::string_view asked, bool small, Found (*measure)(Fixture&)) {
    cases.push_back({.name = name,
                     .group = "numbers",
                     .asked = asked,
                     .unit = "wrong answers",
                     .bound_from = "what is not a number is refused in one line that names it; what is one is kept",
                     .once = true,
                     .small = small,
                     .measure = measure});
  };
  add("numbers_scenario", "every number of a scenario file as nan, inf and 1e400", true, scenario_door);
  add("numbers_subnormal", "every number of a scenario file below the least normal double", true, subnormal_door);
  add("numbers_options", "every number among the representations' options, likewise", true, option_door);
  add("numbers_gltf",
      "a glTF with weights that sum to 0, 0.1 and 2, are negative, NaN or infinite; with joints and indices out of "
      "range; places and times that are not numbers; no normals, no skin",
      true, gltf_door);
}

}  // namespace crowdbench::bench
