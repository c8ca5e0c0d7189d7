#include "reports/page/distance_page.h"

#include <utility>

#include "reports/page/page_files.h"
#include "reports/page/page_frame.h"

namespace crowdbench::reports {

std::string distance_page(const DistancePage& page) {
  std::vector<TemplateValues> cause_rows;
  for (const auto& [representation, words] : page.causes)
    cause_rows.push_back({{"representation", representation}, {"words", words}});
  std::vector<TemplateValues> causes;
  if (!cause_rows.empty()) causes.push_back({{"rows", std::move(cause_rows)}});
  int last_chart = 0;
  Html content =
      fill_template(page_file("distance_page.html"), {{"scene", page.scene},
                                                      {"reference", page.reference},
                                                      {"counts", page.counts},
                                                      {"renderer", page.renderer},
                                                      {"display", page.display},
                                                      {"causes", std::move(causes)},
                                                      {"section", distance_section(page.scores, last_chart)}});
  return page_frame("Difference over distance", std::move(content), "");
}

}  // namespace crowdbench::reports
