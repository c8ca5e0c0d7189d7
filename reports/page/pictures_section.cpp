#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "core/error.h"
#include "core/image_io.h"
#include "reports/model/amplified.h"
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

// Whether no larger crowd of the same representation and occupancy is shown.
bool is_largest(const Scene& scene, const ComparisonRow& comparison) {
  return std::none_of(scene.crowd_comparisons.begin(), scene.crowd_comparisons.end(), [&](const ComparisonRow* other) {
    return other->representation == comparison.representation &&
           other->requested_occupancy == comparison.requested_occupancy && other->agents > comparison.agents &&
           scene.picture(*other, "test") != nullptr;
  });
}

std::vector<TemplateValues> more_block(std::vector<Html> comparisons) {
  if (comparisons.empty()) return {};
  const std::string count = count_text(comparisons.size());
  return {{{"count", count}, {"comparisons", html_rows(std::move(comparisons))}}};
}

// Where a map from nothing to the largest possible error would be all dark. Nothing of bytes that are no picture.
std::optional<Html> amplified_figure(const PictureRow& reference, const PictureRow& test) {
  try {
    const auto made = amplified_difference(decode_png(reference.png, "picture"), decode_png(test.png, "picture"));
    if (!made) return std::nullopt;
    const std::string caption =
        fmt::format("difference × {}: each channel’s difference in code values, {} at most, times {}; black = equal",
                    made->factor, made->largest, made->factor);
    return fill_template(page_file("amplified.html"),
                         {{"factor", made->factor},
                          {"figure", figure_block(test.width, test.height, encode_png(made->picture), caption,
                                                  Html{html_escape(caption)})}});
  } catch (const Error&) {
    return std::nullopt;
  }
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
  std::vector<Html> comparisons;
  std::vector<Html> smaller;  // crowds, of which the page shows larger ones
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
    if (auto amplified = amplified_figure(*reference, *test)) figures.push_back(std::move(*amplified));
    auto& group = is_largest(scene, *comparison) ? comparisons : smaller;
    group.push_back(
        fill_template(page_file("comparison.html"), {{"representation", comparison->representation},
                                                     {"agents", agents_text(comparison->agents)},
                                                     {"occupancy", occupancy_title(comparison->requested_occupancy)},
                                                     {"figures", html_rows(std::move(figures))}}));
  }
  if (heroes.empty() && comparisons.empty()) return {};
  std::vector<TemplateValues> hero_block;
  if (!heroes.empty()) hero_block.push_back({{"figures", html_rows(std::move(heroes))}});
  return fill_template(page_file("pictures.html"), {{"heroes", std::move(hero_block)},
                                                    {"comparisons", html_rows(std::move(comparisons))},
                                                    {"smaller", more_block(std::move(smaller))}});
}

}  // namespace crowdbench::reports
