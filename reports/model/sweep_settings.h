// What the points of a sweep's plan were set to, in words, and which of them were not drawn. Pure functions of the
// store's rows.
#pragma once
#include <string>
#include <vector>

#include "reports/model/scene.h"
#include "store/store.h"

namespace crowdbench::reports {

// "seed = 1, crowd.agents = 40": a point's values by axis, but for the representation. Empty where the row's settings
// are not an object of texts.
std::string settings_text(const SweepPointRow& row);
// What all points of a scene were set to alike; empty where no sweep made it.
std::string settings_of_scene(const StoreContents& contents, const Scene& scene);

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
