// Every point of a file of many scenes as a row, where no reader could take in a section for each.
#pragma once
#include <vector>

#include "reports/model/scene.h"
#include "reports/page/html_template.h"

namespace crowdbench::reports {

// A page tells of so many scenes in full; of more, of the first ones, and every point of all in one table.
inline constexpr size_t kScenesInFull = 12;

// scenes: of scenes_of(contents). Empty where all of them are told in full.
Html points_section(const StoreContents& contents, const std::vector<Scene>& scenes);

// The points of a sweep that were not drawn, and why. Empty where all were.
Html undrawn_section(const StoreContents& contents);

}  // namespace crowdbench::reports
