#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "reports/charts/charts.h"
#include "reports/model/number_text.h"
#include "reports/model/scores.h"
#include "reports/page/blocks.h"
#include "reports/page/escape.h"
#include "reports/page/folded.h"
#include "reports/page/page_files.h"
#include "reports/page/sections.h"

namespace crowdbench::reports {
namespace {

using Rows = std::vector<TemplateValues>;

Rows titles(const std::vector<ScoreDoc>& scores) {
  Rows rows;
  for (const ScoreDoc& doc : scores) rows.push_back({{"title", heading(doc)}});
  return rows;
}

Rows agent_rows(const SceneOnPage& page, const AgentScoreTable& table) {
  Rows rows;
  for (const AgentScoreRow& row : table.rows) {
    Rows cells;
    for (const std::optional<ScoreCell>& cell : row.cells) {
      Rows score;
      if (cell) score.push_back({{"mean", cell->mean}, {"worst", cell->worst}});
      cells.push_back({{"score", std::move(score)}});
    }
    rows.push_back({{"representation", page.mark(row.representation)},
                    {"height", fmt::format("{:.0f}", row.height_px)},
                    {"views", row.views},
                    {"cells", std::move(cells)}});
  }
  return rows;
}

Rows scores_of(const Scene& scene, const ComparisonRow& comparison) {
  Rows rows;
  if (const std::string text = headline_scores(scene, comparison); !text.empty()) rows.push_back({{"text", text}});
  return rows;
}

// The colour bar of the differences, where they have none of their own.
Rows legend_of(const Scene& scene) {
  for (const PictureRow* picture : scene.pictures)
    if (picture->role == "legend")
      return {{{"legend", figure_block(picture->width, picture->height, picture->png, picture->caption, Html{})}}};
  return {};
}

// One group a representation and height, of the first view that has pictures: reference, test, difference. Small
// figures are enlarged so that their pixels can be seen.
Rows agent_pictures(const SceneOnPage& page) {
  const Scene& scene = page.scene;
  Rows groups;
  std::string direction;
  std::set<std::pair<std::string, double>> shown;
  for (const ComparisonRow* comparison : scene.agent_comparisons) {
    const PictureRow* reference = scene.picture(*comparison, "reference");
    const PictureRow* test = scene.picture(*comparison, "test");
    if (reference == nullptr || test == nullptr) continue;
    if (!shown.emplace(comparison->representation, comparison->height_px.value_or(0)).second) continue;
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
                      {"headline", scores_of(scene, *comparison)}});
    if (direction.empty())
      direction = fmt::format("Seen from {:.0f}° beside the front and {:.0f}° above.",
                              comparison->azimuth_deg.value_or(0), comparison->elevation_deg.value_or(0));
  }
  if (groups.empty()) return {};
  return {{{"direction", direction}, {"groups", std::move(groups)}, {"legends", legend_of(scene)}}};
}

Rows single_agents(SceneOnPage& page) {
  const Scene& scene = page.scene;
  if (scene.agent_comparisons.empty()) return {};
  std::vector<Html> charts;
  for (const ScoreDoc& doc : scene.scores) {
    if (!doc.charted) continue;
    if (const std::string specification = score_chart(scene, doc); !specification.empty())
      charts.push_back(page.chart(specification, heading(doc)));
  }
  const AgentScoreTable table = agent_score_table(scene);
  return {{{"charts", html_rows(std::move(charts))},
           {"scores", titles(table.columns)},
           {"rows", agent_rows(page, table)},
           {"by_height", agent_pictures(page)}}};
}

Rows crowds(const SceneOnPage& page) {
  if (page.scene.crowd_comparisons.empty()) return {};
  const std::vector<ScoreDoc> scores = scores_in(page.scene, page.scene.crowd_comparisons);
  Rows rows;
  for (const ComparisonRow* comparison : page.scene.crowd_comparisons) {
    Rows cells;
    for (const ScoreDoc& doc : scores) {
      const auto value = score_of(*comparison, doc.name);
      cells.push_back({{"score", value ? score_text(doc, *value) : "–"}});
    }
    rows.push_back({{"representation", page.mark(comparison->representation)},
                    {"agents", count_text(comparison->agents)},
                    {"occupancy", occupancy_text(comparison->requested_occupancy)},
                    {"cells", std::move(cells)}});
  }
  auto folded = folded_rows(rows.size());
  const bool unfold = !folded.empty();
  return {{{"scores", titles(scores)},
           {"folded", std::move(folded)},
           {"unfold", unfold},
           {"rows", std::move(rows)},
           {"stricter", !page.scene.agent_comparisons.empty()}}};
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
