#include "reports/model/pareto.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reports/model/scores.h"

namespace crowdbench::reports {
namespace {

// How many were timed there.
size_t timed_at(const Scene& scene, uint32_t agents, double occupancy) {
  size_t count = 0;
  for (const std::string& name : scene.representations) {
    const MeasurementRow* row = scene.find(name, agents, occupancy);
    if (row != nullptr && is_timed(*row)) ++count;
  }
  return count;
}

// The error of every representation by the scene's first headline score: of single agents at the height nearest to 64
// pixels where there are any, else of the crowd.
void put_errors(const Scene& scene, ParetoFront& front) {
  for (const ScoreDoc& doc : scene.scores) {
    if (!doc.headline) continue;
    std::vector<ScoreByHeight> all = scores_by_height(scene, doc.name);
    if (!all.empty()) {
      const auto distance = [](const ScoreByHeight& one) { return std::abs(std::log(one.height_px / 64)); };
      const double height = std::min_element(all.begin(), all.end(), [&](const auto& a, const auto& b) {
                              return distance(a) < distance(b);
                            })->height_px;
      for (const ScoreByHeight& one : all)
        for (ParetoEntry& entry : front.entries)
          if (one.height_px == height && one.representation == entry.representation) {
            entry.error = one.mean;
            front.scored_over = fmt::format("single agents {:.0f} pixels tall, mean of {} views", height, one.views);
          }
    } else {
      for (const ComparisonRow* row : scene.crowd_comparisons)
        for (ParetoEntry& entry : front.entries)
          if (row->representation == entry.representation && row->agents == front.agents &&
              row->requested_occupancy == front.occupancy)
            entry.error = score_of(*row, doc.name);
      front.scored_over = "the crowd";
    }
    for (ParetoEntry& entry : front.entries)
      if (entry.representation == scene.reference && doc.best) entry.error = doc.best;
    if (std::any_of(front.entries.begin(), front.entries.end(),
                    [&](const ParetoEntry& entry) { return entry.error && entry.representation != scene.reference; })) {
      front.score = doc;
      return;
    }
    for (ParetoEntry& entry : front.entries) entry.error.reset();
  }
  front.scored_over.clear();
}

bool no_worse(const ScoreDoc& doc, const std::optional<double>& a, const std::optional<double>& b) {
  // Where some were scored, one that was not neither beats nor is beaten; where none was, time and bytes decide.
  if (!a || !b) return doc.name.empty();
  return doc.higher_is_better ? *a >= *b : *a <= *b;
}

void put_beaten(ParetoFront& front) {
  for (ParetoEntry& entry : front.entries)
    for (const ParetoEntry& other : front.entries) {
      if (&other == &entry || !(other.high < entry.low) || !entry.beaten_by.empty()) continue;
      if (!other.bytes || !entry.bytes || *other.bytes > *entry.bytes) continue;
      if (no_worse(front.score, other.error, entry.error)) entry.beaten_by = other.representation;
    }
}

}  // namespace

std::vector<ParetoFront> pareto_fronts(const Scene& scene) {
  std::vector<ParetoFront> out;
  for (const double occupancy : scene.occupancies) {
    ParetoFront front;
    front.occupancy = occupancy;
    size_t most = 1;
    for (const uint32_t agents : scene.agents)
      if (const size_t count = timed_at(scene, agents, occupancy); count > 1 && count >= most) {
        most = count;
        front.agents = agents;
      }
    if (front.agents == 0) continue;
    for (const std::string& name : scene.representations) {
      const MeasurementRow* row = scene.find(name, front.agents, occupancy);
      if (row == nullptr || !is_timed(*row)) continue;
      ParetoEntry entry;
      entry.representation = name;
      if (row->texture_bytes && row->buffer_bytes) entry.bytes = *row->texture_bytes + *row->buffer_bytes;
      if (name != scene.reference) {
        const RatioRow* ratio = scene.ratio("speed", name, front.agents, occupancy, scene.run->headline);
        if (ratio == nullptr || !(ratio->low > 0)) continue;
        entry.time = 1 / ratio->ratio;
        entry.low = 1 / ratio->high;
        entry.high = 1 / ratio->low;
      }
      front.entries.push_back(entry);
    }
    if (front.entries.size() < 2) continue;
    put_errors(scene, front);
    put_beaten(front);
    out.push_back(std::move(front));
  }
  return out;
}

}  // namespace crowdbench::reports
