#include "reports/model/number_text.h"
#include "reports/page/page_files.h"
#include "reports/page/sections.h"

namespace crowdbench::reports {

Html untimed_section(const SceneOnPage& page) {
  std::vector<TemplateValues> rows;
  for (const MeasurementRow* row : page.scene.rows)
    if (row->status != Status::valid)
      rows.push_back({{"representation", page.mark(row->key.representation)},
                      {"agents", count_text(row->key.agents)},
                      {"occupancy", occupancy_text(row->key.requested_occupancy)},
                      {"status", status_name(row->status)},
                      {"reason", row->reason}});
  if (rows.empty()) return {};
  return fill_template(page_file("untimed.html"), {{"rows", std::move(rows)}});
}

}  // namespace crowdbench::reports
