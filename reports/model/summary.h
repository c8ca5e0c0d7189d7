// What a result file says, put in order: the rows that may be compared with each other, the curves, where they cross,
// and the sentence that answers the question. Pure functions of the store's rows.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "store/store.h"

namespace crowdbench::reports {

// Rows of one scenario, character and picture size, measured by one revision on one renderer; pointers are into the
// StoreContents, which must outlive this. Where a key was measured again only its latest row counts.
struct Scene {
  const RunRow* run = nullptr;  // the latest
  std::string character;
  int width = 0, height = 0;
  std::string reference;                     // "mesh"
  std::vector<std::string> representations;  // the reference first, the others in the order in which they were measured
  std::vector<double> occupancies;           // requested, ascending
  std::vector<uint32_t> agents;              // ascending
  std::vector<const MeasurementRow*> rows;
  std::vector<const RatioRow*> ratios;
  std::vector<const ComparisonRow*> crowd_comparisons;
  std::vector<const ComparisonRow*> agent_comparisons;
  std::vector<const PictureRow*> pictures;

  // nullptr when there is none.
  const MeasurementRow* find(const std::string& representation, uint32_t agent_count, double occupancy) const;
  // kind: "speed" (how many times as fast as the reference) or "floor"; metric: "cpu", "wall", "gpu".
  const RatioRow* ratio(const std::string& kind, const std::string& representation, uint32_t agent_count,
                        double occupancy, const std::string& metric) const;
  const PictureRow* picture(const ComparisonRow& comparison, const std::string& role) const;
};
std::vector<Scene> scenes_of(const StoreContents& contents);

// The time that ratios and charts are made of on this machine: the run's headline metric.
const std::optional<TimeSummary>& time_of(const MeasurementRow& row, const std::string& metric);
std::string metric_title(const std::string& metric);  // "process CPU time", "wall-clock time", "GPU time"

// Whether the row carries a time that counts: curves, crossings and figures are made of these alone.
bool is_timed(const MeasurementRow& row);

// Where two curves of time against agents cross, by log-log interpolation between measured points.
struct CrossoverLine {
  double occupancy = 0;
  std::string first, second;
  std::optional<double> agents;  // std::nullopt: they do not cross within the range that both cover
  std::string cheaper_below;     // with a crossing; else empty
  std::string cheaper_beyond;    // without a crossing: the cheaper one everywhere
  uint32_t from = 0, to = 0;     // the range of agents that both cover
  double time_ns = 0;            // at the crossing
};
// Every pair of representations at every occupancy; pairs with fewer than two common points are left out.
std::vector<CrossoverLine> crossovers_of(const Scene& scene, const std::string& metric);

// Mean, least and greatest of one score over the agent comparisons of a representation at one height in pixels.
struct ScoreByHeight {
  std::string representation;
  double height_px = 0;
  double mean = 0, least = 0, greatest = 0;
  size_t views = 0;
};
std::vector<ScoreByHeight> scores_by_height(const Scene& scene, const std::string& score);

std::optional<double> score_of(const ComparisonRow& comparison, const std::string& name);

// The answer at a glance: a figure and what it is, in the order of reading; of the first representation that is not the
// reference.
struct Tile {
  std::string figure;
  std::string meaning;
};
std::vector<Tile> tiles(const Scene& scene);

// The answer, in a few paragraphs without markup: what it costs, from where on it pays, what it gets wrong.
std::vector<std::string> answer(const Scene& scene);

// Every figure of speed is a ratio to the reference, which is held to its own floor: above this many times the floor,
// figures are void. The worst point's line of text; std::nullopt when none is above, or none was measured.
constexpr double kReferenceFloorBound = 1.4;
std::optional<std::string> void_notice(const Scene& scene);

// "1,000", "12.3 ms", "4.2 MiB", "15 %", "12.5x": for people.
std::string count_text(uint64_t count);
std::string time_text(double nanoseconds);
std::string bytes_text(uint64_t bytes);
std::string percent_text(double fraction);
std::string factor_text(double factor);

}  // namespace crowdbench::reports
