#include <fmt/format.h>

#include "reports/model/answer.h"
#include "reports/model/number_text.h"
#include "reports/page/page_files.h"
#include "reports/page/sections.h"

namespace crowdbench::reports {

Html floors_section(const SceneOnPage& page, const FloorTexts& floors) {
  const Scene& scene = page.scene;
  std::vector<TemplateValues> rows;
  for (const std::string& name : scene.representations)
    for (const double occupancy : scene.occupancies)
      for (const uint32_t agents : scene.agents)
        if (const RatioRow* ratio = scene.ratio("floor", name, agents, occupancy, scene.run->headline))
          rows.push_back({{"representation", page.mark(name)},
                          {"agents", count_text(agents)},
                          {"occupancy", occupancy_text(occupancy)},
                          {"poor", name == scene.reference && ratio->ratio > kReferenceFloorBound},
                          {"factor", factor_text(ratio->ratio)},
                          {"low", factor_text(ratio->low)},
                          {"high", factor_text(ratio->high)}});
  if (rows.empty()) return {};
  return fill_template(page_file("floors.html"), {{"floors", floors_text(scene, floors)},
                                                  {"reference", scene.reference},
                                                  {"bound", fmt::format("{}", kReferenceFloorBound)},
                                                  {"rows", std::move(rows)}});
}

}  // namespace crowdbench::reports
