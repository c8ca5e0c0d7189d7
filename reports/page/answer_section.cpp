#include "reports/model/answer.h"
#include "reports/page/page_files.h"
#include "reports/page/sections.h"

namespace crowdbench::reports {

Html answer_section(const Scene& scene) {
  std::vector<TemplateValues> paragraphs;
  for (const std::string& paragraph : answer(scene)) paragraphs.push_back({{"text", paragraph}});
  if (paragraphs.empty()) return {};
  std::vector<TemplateValues> shown;
  for (const Tile& tile : tiles(scene)) shown.push_back({{"figure", tile.figure}, {"meaning", tile.meaning}});
  std::vector<TemplateValues> notices;
  if (const auto notice = void_notice(scene)) notices.push_back({{"notice", *notice}});
  return fill_template(
      page_file("answer.html"),
      {{"tiles", std::move(shown)}, {"void", std::move(notices)}, {"paragraphs", std::move(paragraphs)}});
}

}  // namespace crowdbench::reports
