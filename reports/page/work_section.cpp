#include <optional>

#include "reports/model/number_text.h"
#include "reports/page/page_files.h"
#include "reports/page/sections.h"

namespace crowdbench::reports {

Html work_section(const SceneOnPage& page) {
  const Scene& scene = page.scene;
  const auto count = [](const std::optional<uint64_t>& value) { return value ? count_text(*value) : "–"; };
  std::vector<TemplateValues> rows;
  for (const double occupancy : scene.occupancies)
    for (const uint32_t agents : scene.agents)
      for (const std::string& name : scene.representations) {
        const MeasurementRow* row = scene.find(name, agents, occupancy);
        if (row == nullptr || !is_timed(*row)) continue;
        rows.push_back({{"representation", page.mark(name)},
                        {"agents", count_text(agents)},
                        {"occupancy", occupancy_text(occupancy)},
                        {"triangles", count(row->triangles_per_agent)},
                        {"vertices", count(row->vertices_shaded)},
                        {"primitives", count(row->primitives)},
                        {"fragments", count(row->fragments)},
                        {"samples", count(row->samples_passed)},
                        {"covered", count(row->covered_px)}});
      }
  if (rows.empty()) return {};
  return fill_template(page_file("work.html"), {{"rows", std::move(rows)}});
}

}  // namespace crowdbench::reports
