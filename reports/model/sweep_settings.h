// What the points of a sweep's plan were set to, in words, and which of them were not drawn. Pure functions of the
// store's rows.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "reports/model/scene.h"
#include "store/store.h"

namespace crowdbench::reports {

// The settings of all points of some contents. Numbers are written as short as tells the values of an axis apart.
class SweepSettings {
 public:
  explicit SweepSettings(const StoreContents& contents);

  // "seed = 1, crowd.agents = 40": a point's values by axis, but for the representation. Empty where the row's settings
  // are not an object of texts.
  std::string of_point(const SweepPointRow& row) const;
  // What all points of a scene were set to alike; empty where no sweep made it.
  std::string of_scene(const Scene& scene) const;

 private:
  using Values = std::vector<std::pair<std::string, std::string>>;  // by axis, in the plan's order
  static Values values_of(const SweepPointRow& row);
  std::string text_of(const Values& values) const;

  std::map<std::string, std::map<std::string, std::string>> texts_;  // by axis and value what stands for it
  std::map<int64_t, Values> by_measurement_;
};

// Points of a sweep that have neither time nor score, for one reason.
struct UndrawnPoints {
  std::string state, reason;  // of SweepPointRow
  size_t count = 0;
  std::vector<std::string> some;  // "relief:map=32, who = missing": the first ones, at most kUndrawnNamed
};
inline constexpr size_t kUndrawnNamed = 5;
// By reason, in the order in which they come.
std::vector<UndrawnPoints> undrawn_points(const StoreContents& contents);

}  // namespace crowdbench::reports
