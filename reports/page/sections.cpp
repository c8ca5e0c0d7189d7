#include "reports/page/sections.h"

#include <algorithm>

#include "reports/charts/charts.h"
#include "reports/model/number_text.h"
#include "reports/page/blocks.h"
#include "reports/page/page_files.h"

namespace crowdbench::reports {

SceneOnPage::SceneOnPage(const Scene& shown, int& last_chart)
    : scene(shown), colours_(representation_colours(shown.representations.size())), last_chart_(last_chart) {}

Html SceneOnPage::mark(const std::string& representation) const {
  const auto& names = scene.representations;
  const auto place = std::find(names.begin(), names.end(), representation);
  const std::string colour = place == names.end() ? "#9aa5b1" : colours_[static_cast<size_t>(place - names.begin())];
  return fill_template(page_file("mark.html"), {{"colour", colour}, {"representation", representation}});
}

Html SceneOnPage::chart(const std::string& specification, const std::string& title) {
  return chart_block(specification, title, ++last_chart_);
}

std::string occupancy_title(double occupancy) {
  return occupancy > 0 ? percent_text(occupancy) + " of the picture covered" : "the scenario's own camera";
}

}  // namespace crowdbench::reports
