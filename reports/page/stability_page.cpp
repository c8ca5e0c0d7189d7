#include "reports/page/stability_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "reports/page/blocks.h"
#include "reports/page/escape.h"
#include "reports/page/page_files.h"
#include "reports/page/page_frame.h"

namespace crowdbench::reports {
namespace {

std::vector<TemplateValues> pictures(const StabilityPageRow& row) {
  std::vector<Html> blocks;
  const auto add = [&](const std::vector<uint8_t>& png, const std::string& caption) {
    if (!png.empty()) blocks.push_back(figure_block(row.width, row.height, png, caption, Html{html_escape(caption)}));
  };
  add(row.before, "as it should be");
  add(row.after, "as it is");
  return html_rows(std::move(blocks));
}

TemplateValues values_of(const StabilityPageRow& row) {
  return {{"name", row.name},
          {"representation", row.representation},
          {"asked", row.asked},
          {"measured", row.measured},
          {"bound", row.bound},
          {"unit", row.unit},
          {"bound_from", row.bound_from},
          {"seen", row.bound_seen},
          {"place", row.place},
          {"note", row.note}};
}

}  // namespace

std::string stability_page(const std::vector<StabilityPageRow>& rows, const std::string& renderer,
                           const std::string& program) {
  std::vector<TemplateValues> all;
  std::vector<TemplateValues> failing;
  for (const StabilityPageRow& row : rows) {
    TemplateValues values = values_of(row);
    values["verdict"] = row.pass ? "holds" : "FAILS";
    all.push_back(std::move(values));
    if (row.pass) continue;
    TemplateValues fault = values_of(row);
    fault["expected"] = row.expected;
    fault["got"] = row.got;
    fault["pictures"] = pictures(row);
    failing.push_back(std::move(fault));
  }
  const size_t bad = failing.size();
  Html content = fill_template(page_file("stability_page.html"), {{"renderer", renderer},
                                                                  {"program", program},
                                                                  {"rows", all.size()},
                                                                  {"bad", bad},
                                                                  {"failing", std::move(failing)},
                                                                  {"all", std::move(all)}});
  return page_frame("What holds at the extremes", std::move(content), "");
}

}  // namespace crowdbench::reports
