// Numbers that are none, infinite or hardly there, at every door: refused by name, or taken and finite.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bench/stability/fixture.h"
#include "bench/stability/odd_gltf.h"
#include "bench/sweep/plan.h"
#include "core/error.h"
#include "renderers/representation.h"
#include "scene/scenario/parse_scenario.h"
#include "scene/scenario/scenario_keys.h"
#include "store/store.h"
#include "studies/analysis/answers.h"
#include "studies/analysis/table.h"
#include "studies/plan/plan.h"

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

// `text` with each of its numbers in turn replaced: where it begins, and what stands there then. Strings, comments and
// names are left alone.
struct Replaced {
  std::string text, line, value;
};
std::vector<Replaced> with_no_numbers(const std::string& text) {
  std::vector<Replaced> out;
  bool quoted = false;
  bool comment = false;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\n') comment = false;
    if (text[i] == '#' && !quoted) comment = true;
    if (text[i] == '"' && !comment) quoted = !quoted;
    const bool begins = std::isdigit(static_cast<unsigned char>(text[i])) != 0 && i > 0 &&
                        std::string_view(" [,=").find(text[i - 1]) != std::string_view::npos;
    if (quoted || comment || !begins) continue;
    const size_t end = text.find_first_not_of("0123456789.", i);
    const size_t line = text.rfind('\n', i) + 1;
    for (const char* value : kNoNumbers)
      out.push_back(
          {text.substr(0, i) + value + text.substr(end), text.substr(line, text.find('\n', i) - line), value});
    i = end - 1;
  }
  return out;
}

// REFERENCE and IMPOSTOR in a plan stand for the reference and the default impostor.
std::string with_names(std::string plan) {
  for (const auto& [stand_in, name] :
       {std::pair<std::string, std::string>{"REFERENCE", renderers::reference_spec().name},
        {"IMPOSTOR", renderers::default_impostor().name}})
    for (size_t at = plan.find(stand_in); at != std::string::npos; at = plan.find(stand_in))
      plan.replace(at, stand_in.size(), name);
  return plan;
}

template <typename Parse>
void count_plan(Doors& doors, const std::string& template_text, const Parse& parse) {
  const std::string plan = with_names(template_text);
  const std::string as_it_is = refusal_of([&] { parse(plan); });
  doors.count(as_it_is.empty(), "the plan as it is", "taken", as_it_is);
  for (const Replaced& with : with_no_numbers(plan)) {
    const std::string refusal = refusal_of([&] { parse(with.text); });
    doors.count(refusal.find("plan.toml:") == 0, fmt::format("{} in `{}`", with.value, with.line),
                "refused, by the plan's line", refusal.empty() ? "taken" : refusal);
  }
}

Found plan_doors(Fixture&) {
  Doors doors;
  count_plan(doors, R"(
[scenario]
width = 640
[axes]
crowd.agents = { from = 10, to = 2000, scale = "log" }
occupancy = [0.15, 0.9]
camera.fov_y_deg = { from = 20, to = 80, steps = 3 }
representation = ["REFERENCE", "IMPOSTOR"]
IMPOSTOR.texels = [64, 128]
[points]
sample = { method = "halton", count = 4, seed = 1 }
repetitions = 1
[measure]
rounds = 24
time_limit_s = 10
bake_budget_mib = 512
together = 16
[[table]]
rows = "occupancy"
value = "agents_at_ms"
at = 33.3
)",
             [](const std::string& text) { sweep::parse_plan(text, "plan.toml", "."); });
  count_plan(doors, R"(
name = "doors"
title = "Two crowds"
[question]
ask = "better"
task = "forced-choice"
[scenario]
width = 640
supersample = 3
crowd.agents = 60
camera.eye = [0.0, 5.0, 22.0]
[conditions]
reference = "REFERENCE"
test = "IMPOSTOR"
[factors]
height_px = [24, 48]
[stimulus]
seconds = 8
seeds = "independent"
crowds = 6
largest_px = 120
[method]
repeats = 2
blocks = 2
[catch]
identical = 2
broken = 4
[participants]
planned = 36
[exclude]
catch_least = 0.75
[analysis]
margin = 0.1
alpha = 0.05
power = 0.8
)",
             [](const std::string& text) { studies::parse_study_plan(text, "plan.toml", "."); });
  return doors.end();
}

// Tables of answers: every column that holds a number, with one trial beside it that is as it should be.
Found answer_door(Fixture&) {
  Doors doors;
  const auto read = [](const std::string& column, const std::string& value) {
    const bool counted = column == "yes" || column == "total";
    std::string header = counted ? "participant,yes,total" : "participant,answer";
    std::string row = counted ? (column == "yes" ? "p1," + value + ",9" : "p1,3," + value) : "p1,yes";
    if (!counted) {
      header += "," + column;
      row += "," + value;
    }
    const studies::Table table = studies::parse_table(header + "\n" + row + "\n", "answers.csv");
    studies::Answers answers;
    studies::add_answers(answers, table, studies::columns_by_name(table));
  };
  for (const std::string column : {"level", "rt", "hidden", "frames_dropped", "pixels_per_degree",
                                   "pixels_per_degree_se", "css_px_per_clip_px", "yes", "total"}) {
    for (const char* value : kNoNumbers) {
      const std::string refusal = refusal_of([&] { read(column, value); });
      const bool named = refusal.find("answers.csv:2") == 0 && refusal.find(column) != std::string::npos;
      doors.count(named, fmt::format("{} = {}", column, value), "refused, by line and column",
                  refusal.empty() ? "taken" : refusal);
    }
    const std::string refusal = refusal_of([&] { read(column, "9"); });
    doors.count(refusal.empty(), column + " = 9", "taken", refusal);
  }
  for (const char* value : {"5e-324", "1e-310", "-1e-320"}) {
    const std::string refusal = refusal_of([&] { read("level", value); });
    doors.count(refusal.find("answers.csv:2") == 0, fmt::format("level = {}", value), "refused: levels begin at 1e-15",
                refusal.empty() ? "taken" : refusal);
  }
  return doors.end();
}

// A result file keeps what is infinite, and what is no number as absent: SQL knows none.
Found store_door(Fixture&) {
  Doors doors;
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / fmt::format("crowdbench-doors-{}.sqlite", getpid());
  std::filesystem::remove(file);
  const std::vector<double> given = {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                                     std::numeric_limits<double>::denorm_min(),
                                     std::numeric_limits<double>::quiet_NaN()};
  {
    StoreWriter writer(file);
    RunRow run;
    run.command = "stability";
    run.headline = "cpu";
    StabilityCaseRow row;
    row.run = writer.write(run);
    row.name = row.group = "numbers";
    for (const double value : given) {
      row.measured = value;
      writer.write(row);
    }
  }
  const StoreContents read = read_store(file);
  std::filesystem::remove(file);
  for (size_t i = 0; i < given.size(); ++i) {
    const std::optional<double> back = i < read.stability_cases.size() ? read.stability_cases[i].measured : -1.0;
    doors.count(std::isnan(given[i]) ? !back : back == given[i], fmt::format("{}", given[i]),
                std::isnan(given[i]) ? "absent" : "kept", back ? fmt::format("{}", *back) : "absent");
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
  add("numbers_plans", "every number of a sweep's plan and of a study's as nan, inf and 1e400", true, plan_doors);
  add("numbers_answers", "every number of a table of answers likewise, and levels below the least normal double", true,
      answer_door);
  add("numbers_store", "a result file given infinity, the least subnormal and NaN: kept, and absent", true, store_door);
}

}  // namespace crowdbench::bench
