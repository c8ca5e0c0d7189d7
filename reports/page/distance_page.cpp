#include "reports/page/distance_page.h"

#include <utility>

#include "reports/page/page_files.h"
#include "reports/page/page_frame.h"

namespace crowdbench::reports {

std::string distance_page(const DistancePage& page) {
  int last_chart = 0;
  Html content =
      fill_template(page_file("distance_page.html"), {{"scene", page.scene},
                                                      {"reference", page.reference},
                                                      {"counts", page.counts},
                                                      {"renderer", page.renderer},
                                                      {"display", page.display},
                                                      {"section", distance_section(page.scores, last_chart)}});
  return page_frame("Difference over distance", std::move(content), "");
}

}  // namespace crowdbench::reports
