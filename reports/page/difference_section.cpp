#include <fmt/format.h>

#include <algorithm>

#include "reports/charts/charts.h"
#include "reports/model/number_text.h"
#include "reports/model/scores.h"
#include "reports/page/blocks.h"
#include "reports/page/escape.h"
#include "reports/page/page_files.h"
#include "reports/page/sections.h"

namespace crowdbench::reports {
namespace {

using Rows = std::vector<TemplateValues>;

// The scores of one agent and of a whole crowd that the tables show, in their order.
const std::vector<std::string> kAgentScores = {"silhouette_iou", "boundary_px_mean", "boundary_px_p95",
                                               "ssim",           "ssim_union",       "psnr"};
const std::vector<std::string> kCrowdScores = {"ssim", "psnr", "mae", "silhouette_iou"};

Rows titles(const std::vector<std::string>& scores) {
  Rows rows;
  for (const std::string& name : scores) rows.push_back({{"title", score_style(name).title}});
  return rows;
}

Rows agent_rows(const SceneOnPage& page) {
  std::vector<std::vector<ScoreByHeight>> columns;
  for (const std::string& name : kAgentScores) columns.push_back(scores_by_height(page.scene, name));
  Rows rows;
  for (const ScoreByHeight& row : columns.front()) {
    Rows cells;
    for (size_t c = 0; c < columns.size(); ++c) {
      const std::string& name = kAgentScores[c];
      Rows score;
      for (const ScoreByHeight& cell : columns[c])
        if (cell.representation == row.representation && cell.height_px == row.height_px)
          score.push_back(
              {{"mean", score_text(name, cell.mean)},
               {"worst", score_text(name, score_style(name).worst_is_greatest ? cell.greatest : cell.least)}});
      cells.push_back({{"score", std::move(score)}});
    }
    rows.push_back({{"representation", page.mark(row.representation)},
                    {"height", fmt::format("{:.0f}", row.height_px)},
                    {"views", row.views},
                    {"cells", std::move(cells)}});
  }
  return rows;
}

Html scores_caption(const ComparisonRow& comparison) {
  std::string html;
  if (const auto iou = score_of(comparison, "silhouette_iou"))
    html += "<br>silhouette IoU " + score_text("silhouette_iou", *iou);
  if (const auto ssim = score_of(comparison, "ssim")) html += ", SSIM " + score_text("ssim", *ssim);
  return {html};
}

// One group a height: reference, test, difference. Small figures are enlarged so that their pixels can be seen.
Rows agent_pictures(const SceneOnPage& page) {
  const Scene& scene = page.scene;
  Rows groups;
  std::string direction;
  for (const ComparisonRow* comparison : scene.agent_comparisons) {
    const PictureRow* reference = scene.picture(*comparison, "reference");
    const PictureRow* test = scene.picture(*comparison, "test");
    if (reference == nullptr || test == nullptr) continue;
    const int scale = std::clamp(180 / std::max(1, reference->height), 1, 4);
    Rows pictures;
    for (const PictureRow* picture : {reference, test, scene.picture(*comparison, "difference")})
      if (picture != nullptr)
        pictures.push_back({{"width", picture->width * scale},
                            {"height", picture->height * scale},
                            {"alt", picture->caption},
                            {"png", base64(picture->png)}});
    Rows enlarged;
    if (scale > 1) enlarged.push_back({{"factor", scale}});
    groups.push_back({{"pictures", std::move(pictures)},
                      {"pixels", fmt::format("{:.0f}", comparison->height_px.value_or(0))},
                      {"enlarged", std::move(enlarged)},
                      {"reference", comparison->reference},
                      {"representation", comparison->representation},
                      {"scores", scores_caption(*comparison)}});
    if (direction.empty())
      direction = fmt::format("Seen from {:.0f}° beside the front and {:.0f}° above.",
                              comparison->azimuth_deg.value_or(0), comparison->elevation_deg.value_or(0));
  }
  if (groups.empty()) return {};
  return {{{"direction", direction}, {"groups", std::move(groups)}}};
}

Rows single_agents(SceneOnPage& page) {
  const Scene& scene = page.scene;
  if (scene.agent_comparisons.empty()) return {};
  std::vector<Html> charts;
  const auto chart = [&](const char* score, const char* axis, const char* title) {
    if (const std::string specification = score_chart(scene, score, axis); !specification.empty())
      charts.push_back(page.chart(specification, title));
  };
  chart("silhouette_iou", "silhouette overlap (IoU)", "Silhouette");
  chart("ssim_union", "SSIM over the figure", "Structure within the figure");
  return {{{"charts", html_rows(std::move(charts))},
           {"scores", titles(kAgentScores)},
           {"rows", agent_rows(page)},
           {"by_height", agent_pictures(page)}}};
}

Rows crowds(const SceneOnPage& page) {
  if (page.scene.crowd_comparisons.empty()) return {};
  Rows rows;
  for (const ComparisonRow* comparison : page.scene.crowd_comparisons) {
    Rows cells;
    for (const std::string& name : kCrowdScores) {
      const auto value = score_of(*comparison, name);
      cells.push_back({{"score", value ? score_text(name, *value) : "–"}});
    }
    rows.push_back({{"representation", page.mark(comparison->representation)},
                    {"agents", count_text(comparison->agents)},
                    {"occupancy", occupancy_text(comparison->requested_occupancy)},
                    {"cells", std::move(cells)}});
  }
  return {{{"scores", titles(kCrowdScores)}, {"rows", std::move(rows)}}};
}

}  // namespace

Html difference_section(SceneOnPage& page) {
  const Scene& scene = page.scene;
  if (scene.crowd_comparisons.empty() && scene.agent_comparisons.empty()) return {};
  return fill_template(
      page_file("difference.html"),
      {{"reference", scene.reference}, {"single_agents", single_agents(page)}, {"crowds", crowds(page)}});
}

}  // namespace crowdbench::reports
