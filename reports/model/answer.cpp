#include "reports/model/answer.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <set>

#include "reports/model/crossovers.h"
#include "reports/model/equal_levels.h"
#include "reports/model/number_text.h"
#include "reports/model/scores.h"

namespace crowdbench::reports {
namespace {

std::string view_text(const Scene& scene, double occupancy) {
  return occupancy > 0
             ? fmt::format("covering {} of a {} \u00d7 {} picture", percent_text(occupancy), scene.width, scene.height)
             : fmt::format("in a {} \u00d7 {} picture", scene.width, scene.height);
}

// The speed of the largest crowd that both were timed with.
const RatioRow* largest_ratio(const Scene& scene, const std::string& name, double occupancy) {
  for (auto agents = scene.agents.rbegin(); agents != scene.agents.rend(); ++agents) {
    const MeasurementRow* row = scene.find(name, *agents, occupancy);
    if (row == nullptr || !is_timed(*row)) continue;
    const RatioRow* ratio = scene.ratio("speed", name, *agents, occupancy, scene.run->headline);
    if (ratio != nullptr) return ratio;
  }
  return nullptr;
}

// One size says enough in a summary: the one nearest 64 pixels.
const ScoreByHeight* nearest_height(const std::vector<ScoreByHeight>& scores, const std::string& name) {
  const ScoreByHeight* nearest = nullptr;
  const auto distance = [](const ScoreByHeight& score) { return std::abs(std::log(score.height_px / 64)); };
  for (const ScoreByHeight& score : scores)
    if (score.representation == name && (nearest == nullptr || distance(score) < distance(*nearest))) nearest = &score;
  return nearest;
}

// The headline scores of single agents of one height, the first of them saying which; empty without any.
std::string difference_text(const Scene& scene, const std::string& name) {
  std::string text;
  std::optional<double> height;
  for (const ScoreDoc& doc : scene.scores) {
    if (!doc.headline) continue;
    const auto values = scores_by_height(scene, doc.name);
    const ScoreByHeight* shown = nearest_height(values, name);
    if (shown == nullptr || (height && shown->height_px != *height)) continue;
    if (!height)
      text = fmt::format("Seen {:.0f} pixels tall in {} views, {} has against {}, on average,", shown->height_px,
                         shown->views, name, scene.reference);
    text += fmt::format("{} {} {} ({} in the worst view{})", height ? ";" : "", doc.title, score_text(doc, shown->mean),
                        score_text(doc, worst_of(doc, *shown)), best_text(doc));
    height = shown->height_px;
  }
  return text.empty() ? text : text + ".";
}

// What the reference of a ratio is drawn with: " of 27,048 triangles"; empty where that was not kept.
std::string triangles_text(const Scene& scene, const RatioRow& ratio) {
  const MeasurementRow* row = scene.find(scene.reference, ratio.of.agents, ratio.of.requested_occupancy);
  if (row == nullptr || !row->triangles_per_agent) return {};
  return fmt::format(" of {} triangles", count_text(*row->triangles_per_agent));
}

struct LevelRatio {
  std::string level;
  double times_as_fast = 0;
};
// Of a representation against the levels of detail that were timed in the same rounds, by the ratios of both to the
// reference.
std::vector<LevelRatio> ratios_to_levels(const Scene& scene, const RatioRow& row) {
  std::vector<LevelRatio> out;
  for (const std::string& level : scene.representations) {
    if (!is_level(scene, level) || level == row.of.representation) continue;
    const RatioRow* own = scene.ratio("speed", level, row.of.agents, row.of.requested_occupancy, scene.run->headline);
    if (own != nullptr && own->ratio > 0) out.push_back({level, row.ratio / own->ratio});
  }
  return out;
}

// The level as wrong and the one as dear; levels that were asked for by name too, and every level where the two are
// not known.
std::string levels_text(const Scene& scene, const RatioRow& row) {
  if (is_level(scene, row.of.representation)) return {};
  const std::vector<LevelRatio> ratios = ratios_to_levels(scene, row);
  if (ratios.empty()) return fmt::format(" No level of detail of {} was timed beside it.", scene.reference);
  std::string text;
  const auto beside = levels_beside(scene, row.of.representation, row.of.requested_occupancy);
  if (beside) text += equal_levels_text(beside->table, beside->row, scene.reference);
  for (const LevelRatio& r : ratios) {
    if (beside && is_ruler(scene, r.level)) continue;
    const bool faster = r.times_as_fast >= 1;
    text += fmt::format(" It is {} times as {} as {}, a level of detail of {}.",
                        factor_text(faster ? r.times_as_fast : 1 / r.times_as_fast), faster ? "fast" : "slow", r.level,
                        scene.reference);
  }
  return text;
}

// The same in a tile.
std::string levels_clause(const Scene& scene, const RatioRow& row) {
  const auto beside = levels_beside(scene, row.of.representation, row.of.requested_occupancy);
  std::string text = beside ? "; " + equal_levels_clause(beside->row) : "";
  for (const LevelRatio& r : ratios_to_levels(scene, row))
    if (!beside || !is_ruler(scene, r.level))
      text += fmt::format("; {}× that of {}", factor_text(r.times_as_fast), r.level);
  return text;
}

}  // namespace

std::vector<std::string> answer(const Scene& scene) {
  std::vector<std::string> paragraphs;
  const std::string& metric = scene.run->headline;
  const auto lines = crossovers_of(scene, metric);
  for (const std::string& name : subjects_of(scene)) {
    for (const double occupancy : scene.occupancies) {
      const RatioRow* best = largest_ratio(scene, name, occupancy);
      if (best == nullptr) continue;
      const bool faster = best->ratio >= 1;
      std::string text =
          fmt::format("With {} {}, {} is {} times as {} as {}{} (95 % interval {} to {}, {} interleaved pairs).",
                      agents_text(best->of.agents), view_text(scene, occupancy), name,
                      factor_text(faster ? best->ratio : 1 / best->ratio), faster ? "fast" : "slow", scene.reference,
                      triangles_text(scene, *best), factor_text(faster ? best->low : 1 / best->high),
                      factor_text(faster ? best->high : 1 / best->low), best->pairs);
      text += levels_text(scene, *best);
      for (const CrossoverLine& line : lines) {
        if (line.occupancy != occupancy || line.first != scene.reference || line.second != name) continue;
        text += " Against " + scene.reference + ": " + crossover_text(line) + ".";
      }
      paragraphs.push_back(text);
    }
    if (const std::string text = difference_text(scene, name); !text.empty()) paragraphs.push_back(text);
  }
  return paragraphs;
}

std::optional<std::string> void_notice(const Scene& scene) {
  const RatioRow* worst = nullptr;
  for (const RatioRow* row : scene.ratios)
    if (row->kind == "floor" && row->of.representation == scene.reference && row->metric == scene.run->headline &&
        (worst == nullptr || row->ratio > worst->ratio))
      worst = row;
  if (worst == nullptr || worst->ratio <= kReferenceFloorBound) return std::nullopt;
  return fmt::format(
      "Figures of speed are void: {} took up to {} times its own floor (the same draw with the work removed), more "
      "than {}.",
      scene.reference, factor_text(worst->ratio), kReferenceFloorBound);
}

std::string floors_text(const Scene& scene, const FloorTexts& floors) {
  std::string text = "The floor of a representation is the same draw with the work removed.";
  std::set<std::string> met;
  for (const std::string& representation : scene.representations) {
    const auto floor = floors.find(representation.substr(0, representation.find_first_of(":(")));
    if (floor != floors.end() && met.insert(floor->first).second)
      text += fmt::format(" That of {} is {}.", floor->first, floor->second);
  }
  return text;
}

std::vector<Tile> tiles(const Scene& scene) {
  std::vector<Tile> all;
  const std::vector<std::string> subjects = subjects_of(scene);
  if (subjects.empty() || scene.occupancies.empty()) return all;
  const std::string& name = subjects.front();
  const std::string& metric = scene.run->headline;
  const double occupancy = scene.occupancies.front();
  const std::string at = occupancy > 0 ? " at " + percent_text(occupancy) + " occupancy" : std::string();
  if (const RatioRow* ratio = largest_ratio(scene, name, occupancy); ratio != nullptr) {
    all.push_back({factor_text(ratio->ratio) + "×",
                   fmt::format("the speed of {} over that of {}{}, with {}{}{}{}", name, scene.reference,
                               triangles_text(scene, *ratio), agents_text(ratio->of.agents), at,
                               levels_clause(scene, *ratio), void_notice(scene) ? " (void, see below)" : "")});
  }
  for (const CrossoverLine& line : crossovers_of(scene, metric))
    if (line.occupancy == occupancy && line.first == scene.reference && line.second == name && line.agents) {
      all.push_back({agents_text(static_cast<uint64_t>(std::llround(*line.agents))),
                     fmt::format("from there on {} is the cheaper one{} (95 % interval {} to {})", line.cheaper_beyond,
                                 at, count_text(static_cast<uint64_t>(std::llround(line.agents_low))),
                                 agents_text(static_cast<uint64_t>(std::llround(line.agents_high))))});
      break;
    }
  for (const ScoreDoc& doc : scene.scores) {
    if (!doc.headline) continue;
    const auto values = scores_by_height(scene, doc.name);
    const ScoreByHeight* nearest = nearest_height(values, name);
    if (nearest == nullptr) continue;
    all.push_back({score_text(doc, nearest->mean), fmt::format("{}{}{}, {:.0f} pixels tall (mean of {} views{})",
                                                               doc.title, doc.unit.empty() ? "" : ", ", doc.unit,
                                                               nearest->height_px, nearest->views, best_text(doc))});
    break;
  }
  for (const MeasurementRow* row : scene.rows)
    if (row->key.representation == name && row->texture_bytes && row->buffer_bytes) {
      all.push_back({bytes_text(*row->texture_bytes + *row->buffer_bytes), "of textures and buffers on the GPU"});
      break;
    }
  return all;
}

}  // namespace crowdbench::reports
