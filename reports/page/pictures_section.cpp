#include <fmt/format.h>

#include "reports/model/number_text.h"
#include "reports/model/scores.h"
#include "reports/page/blocks.h"
#include "reports/page/escape.h"
#include "reports/page/page_files.h"
#include "reports/page/sections.h"

namespace crowdbench::reports {
namespace {

Html figure(const PictureRow& picture, Html caption) {
  return figure_block(picture.width, picture.height, picture.png, picture.caption, std::move(caption));
}

// scores: empty for the reference itself.
Html caption(const SceneOnPage& page, const std::string& representation, bool reference, const std::string& scores) {
  std::vector<TemplateValues> text;
  if (!scores.empty()) text.push_back({{"text", scores}});
  return fill_template(
      page_file("crowd_caption.html"),
      {{"representation", page.mark(representation)}, {"is_reference", reference}, {"scores", std::move(text)}});
}

}  // namespace

Html pictures_section(const SceneOnPage& page) {
  const Scene& scene = page.scene;
  std::vector<Html> heroes;
  for (const PictureRow* picture : scene.pictures)
    if (picture->role == "hero") heroes.push_back(figure(*picture, Html{html_escape(picture->caption)}));
  if (heroes.empty() && scene.crowd_comparisons.empty()) return {};
  std::vector<TemplateValues> comparisons;
  for (const ComparisonRow* comparison : scene.crowd_comparisons) {
    const PictureRow* reference = scene.picture(*comparison, "reference");
    const PictureRow* test = scene.picture(*comparison, "test");
    const PictureRow* difference = scene.picture(*comparison, "difference");
    if (reference == nullptr || test == nullptr) continue;
    std::vector<Html> figures = {
        figure(*reference, caption(page, comparison->reference, true, "")),
        figure(*test, caption(page, comparison->representation, false, headline_scores(scene, *comparison)))};
    if (difference != nullptr)
      figures.push_back(
          figure(*difference, Html{"absolute difference: dark blue = equal, red = the largest possible error"}));
    comparisons.push_back({{"agents", agents_text(comparison->agents)},
                           {"occupancy", occupancy_title(comparison->requested_occupancy)},
                           {"figures", html_rows(std::move(figures))}});
  }
  if (heroes.empty() && comparisons.empty()) return {};
  std::vector<TemplateValues> hero_block;
  if (!heroes.empty()) hero_block.push_back({{"figures", html_rows(std::move(heroes))}});
  return fill_template(page_file("pictures.html"),
                       {{"heroes", std::move(hero_block)}, {"comparisons", std::move(comparisons)}});
}

}  // namespace crowdbench::reports
