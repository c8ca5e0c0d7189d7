#include "reports/page/lead_section.h"

#include "reports/page/page_files.h"

namespace crowdbench::reports {

Html lead_section(const Lead& lead) {
  std::vector<TemplateValues> rows;
  for (const LeadRow& row : lead.rows)
    rows.push_back({{"character", row.character},
                    {"representation", row.representation},
                    {"score", row.score},
                    {"from", row.from},
                    {"cost", row.cost}});
  std::vector<TemplateValues> table;
  if (!rows.empty()) table.push_back({{"rows", std::move(rows)}, {"basis", lead.basis}});
  std::vector<TemplateValues> silent;
  if (!lead.silent.empty()) silent.push_back({{"text", lead.silent}});
  return fill_template(page_file("lead.html"), {{"table", std::move(table)}, {"silent", std::move(silent)}});
}

}  // namespace crowdbench::reports
