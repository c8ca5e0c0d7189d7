// The rows of a result file that may be compared with each other, put in order. Pure functions of the store's rows.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "reports/model/score_doc.h"
#include "store/store.h"

namespace crowdbench::reports {

// Rows of one scenario, character and picture size, measured by one revision on one renderer and processor; pointers
// are into the StoreContents, which must outlive this. Scenarios that differ in the number of agents and in the
// occupancy alone are one, as of a sweep over both: rows know these themselves. Where a key was measured again only its
// latest row counts.
struct Scene {
  const RunRow* run = nullptr;  // the latest
  std::string source;           // the file, where the rows are of several (StoreContents::sources); else empty
  std::string likeness;         // the scenario without number of agents and occupancy: equal where others show the same
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
  std::vector<ScoreDoc> scores;  // of the names that its comparisons have; those that nobody described come last

  // Takes the row; one of the same point (of a ratio also kind and metric) takes the place of an earlier one.
  void take(const MeasurementRow& row);
  void take(const RatioRow& row);
  // nullptr when there is none.
  const MeasurementRow* find(const std::string& representation, uint32_t agent_count, double occupancy) const;
  // kind: "speed" (how many times as fast as the reference) or "floor"; metric: "cpu", "wall", "gpu".
  const RatioRow* ratio(const std::string& kind, const std::string& representation, uint32_t agent_count,
                        double occupancy, const std::string& metric) const;
  const PictureRow* picture(const ComparisonRow& comparison, const std::string& role) const;

 private:
  using Point = std::tuple<std::string, uint32_t, double>;  // representation, agents, occupancy
  std::map<Point, size_t> row_places_;                      // of `rows`
  std::map<std::tuple<Point, std::string, std::string>, const RatioRow*> latest_ratios_;  // and kind, metric
};

// The occupancies that a page draws curves over agents of: all of a few; of more those with at least two timed crowds,
// kMostCurves of them from end to end. Empty where there are more and each was timed with one crowd alone.
std::vector<double> shown_occupancies(const Scene& scene);
inline constexpr size_t kMostCurves = 6;

// A scenario's text without the lines that say how many agents there are and how much they cover.
std::string without_crowd_size(const std::string& scenario);

// Where points of many crowds and occupancies were timed, each with few others (a sweep of samples), scenarios that
// differ in these alone stay apart beyond so many pairs of both.
inline constexpr size_t kPairsInAScene = 10'000;
// scores: what is known of scores, in the order in which they are shown.
std::vector<Scene> scenes_of(const StoreContents& contents, const std::vector<ScoreDoc>& scores = {});

// Runs that compared single agents and timed nothing, one scene a run and character: without rows and size. timed:
// scenes_of() of the same contents.
std::vector<Scene> scenes_of_agents(const StoreContents& contents, const std::vector<Scene>& timed,
                                    const std::vector<ScoreDoc>& scores = {});

// The time that ratios and charts are made of on this machine: the run's headline metric.
const std::optional<TimeSummary>& time_of(const MeasurementRow& row, const std::string& metric);
std::string metric_title(const std::string& metric);  // "process CPU time", "wall-clock time", "GPU time"

// Whether the row carries a time that counts: curves, crossings and figures are made of these alone.
bool is_timed(const MeasurementRow& row);

}  // namespace crowdbench::reports
