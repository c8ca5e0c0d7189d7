// A plan of a sweep: which conditions are measured, what is drawn in each, and what is looked at. One TOML file, whose
// whole form is in bench/sweep/README.md (a test reads it).
//
// A point is one representation at one place of the grid. Points whose scenarios are equal but for what is drawn make a
// condition: they are drawn in the same rounds, beside the reference and its A/A twin; a shard holds whole
// conditions. A point's key is a hash of all that decides what it shows, the contents of the characters' files among
// it, so that a comment or another order of the axes changes no key; a plan's hash is one over its points in order.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "metrics/registry.h"
#include "renderers/representation.h"
#include "scene/scenario/scenario.h"

namespace crowdbench::bench::sweep {

inline constexpr size_t kMostPoints = 100'000;

// The value that a point has on an axis, as tables and rows say it.
struct Setting {
  std::string axis;
  std::string text;
  std::optional<double> number;  // where it is one
};

struct PlannedPoint {
  renderers::Spec spec;
  std::string representation;     // its canonical text
  std::vector<Setting> settings;  // in the order of the axes; an option's only where the representation has it
};

struct Condition {
  scene::Scenario scenario;  // its representation is the reference
  std::string scenario_text, scenario_hash;
  std::vector<PlannedPoint> points;  // by their canonical text unique
  std::string character_files;       // CharacterFiles::fingerprint
};

struct Measures {
  renderers::Spec reference;
  bool times = true;
  bool aa = true;
  int rounds = 24;
  double time_limit_s = 10;  // of timing a condition, from kLeastRounds on
  std::vector<const metrics::Score*> scores;
  bool pictures = false;
  size_t together = 16;  // points in a condition, at most: all of them are on the GPU at once
  uint64_t bake_budget = uint64_t{512} << 20;
};
inline constexpr int kLeastRounds = 10;

// One table of the end: values of a measure by an axis, or two.
struct TableRequest {
  std::string title;
  std::string rows, columns;  // axes, or "representation"; columns may be empty
  std::string value;          // a measure (sweep_table.h)
  std::optional<double> at;   // of the measures that have one: milliseconds
  std::string place;          // FILE:LINE
};

struct Plan {
  std::string name, look_for, text;
  std::filesystem::path folder;  // that the characters' paths are relative to
  std::vector<std::string> axes;
  std::vector<Condition> conditions;
  int repetitions = 1;
  Measures measures;
  std::vector<TableRequest> tables;
  std::string hash;

  size_t points() const;  // of all conditions and repetitions
  // The point's identity, 16 hexadecimal digits.
  std::string key(const Condition& condition, const PlannedPoint& point, int repetition) const;
};

// Throws Error naming file and line.
Plan read_plan(const std::filesystem::path& file);
// where: the plan's name in errors; folder: what its paths are relative to.
Plan parse_plan(const std::string& toml, const std::string& where, const std::filesystem::path& folder);

}  // namespace crowdbench::bench::sweep
