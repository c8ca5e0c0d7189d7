// The axes of a plan and the combinations that they span.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bench/sweep/plan.h"
#include "scene/scenario/scenario_changes.h"

namespace crowdbench::bench::sweep {

// One value of an axis, and what it changes.
struct AxisValue {
  Setting setting;
  std::function<void(scene::Scenario&)> change;  // null where it is an option's
  std::string representation, option;            // of an option: the representation's name, and which option
  bool named = false;                            // settings by their label: keys that are axes themselves go above them
};

struct Axis {
  std::string name;
  std::string place;  // FILE:LINE
  std::vector<AxisValue> values;
  // Without values: drawn from the range of numbers by [points] `sample`.
  double from = 0, to = 0;
  bool log = false;
  bool whole = false;
  std::function<AxisValue(double)> value_of;

  bool sampled() const { return values.empty(); }
};

// Reads what a plan's [axes] holds. folder: of the plan. Throws Error.
std::vector<Axis> read_axes(const scene::TomlNode& axes, const std::string& where, const std::filesystem::path& folder);
// One entry of [[points.also]]: a value for each axis or scenario key that it names. Throws Error.
std::vector<AxisValue> read_listed(const scene::TomlNode& point, const std::string& where,
                                   const std::filesystem::path& folder, const std::vector<Axis>& axes);

struct Sampling {
  bool halton = true;
  size_t count = 0;
  uint64_t seed = 1;
};
// Every combination, the first axis slowest; sampled axes are drawn together, where the first of them stands. More than
// kMostPoints: throws Error naming `where`.
std::vector<std::vector<AxisValue>> combine(const std::vector<Axis>& axes, const Sampling& sampling,
                                            const std::string& where);

// The i-th of a sequence that fills [0, 1) evenly, in a dimension of its own (van der Corput in the dimension-th prime
// base, Halton 1960), shifted by what the seed gives modulo 1 (Cranley and Patterson 1976). dimension < 32.
double halton(uint64_t seed, size_t i, size_t dimension);

}  // namespace crowdbench::bench::sweep
