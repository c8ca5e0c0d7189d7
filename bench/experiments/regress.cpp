#include "bench/experiments/regress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <tuple>

#include "bench/experiments/point_name.h"
#include "bench/experiments/regress_times.h"
#include "core/error.h"
#include "core/image_io.h"
#include "core/png.h"

namespace crowdbench::bench {
namespace {

// What two comparisons of the same views have in common.
using ViewKey = std::tuple<std::string, std::string, std::string, std::string, std::string, uint32_t, double, uint64_t,
                           double, double, double, std::string, double, uint32_t>;
struct View {
  std::string scenario;
  const ComparisonRow* row = nullptr;
  std::map<std::string, const PictureRow*> pictures;  // by role
};
using Views = std::map<ViewKey, View>;

ViewKey key_of(const RunRow& run, const ComparisonRow& row) {
  return {run.scenario_hash,
          row.kind,
          row.representation,
          row.reference,
          row.character,
          row.agents,
          row.requested_occupancy,
          row.tick,
          row.height_px.value_or(0),
          row.azimuth_deg.value_or(0),
          row.elevation_deg.value_or(0),
          row.clip,
          row.time.value_or(0),
          row.agent.value_or(0)};
}

std::string name_of(const ComparisonRow& row) {
  std::string name = fmt::format("{} against {}, {}", row.representation, row.reference, row.character);
  if (row.kind == "agent")
    return name + fmt::format(", {:g} px, azimuth {:g}, elevation {:g}, {} at {:.3g} s", row.height_px.value_or(0),
                              row.azimuth_deg.value_or(0), row.elevation_deg.value_or(0), row.clip,
                              row.time.value_or(0));
  name += fmt::format(", {}, {}", agents_text(row.agents), view_name(row.requested_occupancy));
  return row.agent ? name + fmt::format(", agent {}", *row.agent) : name;
}

Views views_of(std::span<const StoreContents> side) {
  Views views;
  for (const StoreContents& contents : side) {
    std::map<int64_t, const RunRow*> runs;
    for (const RunRow& run : contents.runs) runs[run.id] = &run;
    std::map<int64_t, ViewKey> keys;
    for (const ComparisonRow& row : contents.comparisons) {
      const auto run = runs.find(row.run);
      if (run == runs.end()) continue;
      keys[row.id] = key_of(*run->second, row);
      views[keys[row.id]] = {run->second->scenario_name, &row, {}};
    }
    for (const PictureRow& picture : contents.pictures)
      if (picture.comparison && keys.contains(*picture.comparison))
        views[keys[*picture.comparison]].pictures[picture.role] = &picture;
  }
  return views;
}

const ScoreRow* find_score(const ComparisonRow& row, const std::string& name) {
  for (const ScoreRow& score : row.scores)
    if (score.name == name) return &score;
  return nullptr;
}

// How far a score may get worse: what was asked for by name, else a share of its distance from what equal pictures
// score (of its value where that is infinite), and never less than half of its last digit.
double tolerance_of(const metrics::Score& score, double baseline, const RegressLimits& limits) {
  const auto named = limits.score_tolerances.find(std::string(score.name));
  if (named != limits.score_tolerances.end()) return named->second;
  const double equal = score.direction == metrics::Direction::higher_is_better ? score.greatest : score.least;
  const double distance = std::isfinite(equal) ? std::abs(baseline - equal) : std::abs(baseline);
  return std::max(0.5 * std::pow(10.0, -score.digits), limits.score_share * distance);
}

void judge_score(ScorePoint& point, const metrics::Score& score, const RegressLimits& limits) {
  if (!point.baseline) {
    point.verdict = point.current ? Verdict::better : Verdict::same;
    point.reason = point.current ? "has a value now" : "has no value in either";
    return;
  }
  if (!point.current) {
    point.verdict = Verdict::worse;
    point.reason = "has no value any more";
    return;
  }
  if (*point.baseline == *point.current) {
    point.reason = "equal";
    return;
  }
  const double sign = score.direction == metrics::Direction::higher_is_better ? -1 : 1;
  const double worse_by = sign * (*point.current - *point.baseline);
  point.tolerance = std::isfinite(*point.baseline) ? tolerance_of(score, *point.baseline, limits) : 0;
  if (worse_by > point.tolerance)
    point.verdict = Verdict::worse;
  else if (-worse_by > point.tolerance)
    point.verdict = Verdict::better;
  point.reason = fmt::format("{:.{}f} was {:.{}f}, tolerance {:.2g}", *point.current, score.digits, *point.baseline,
                             score.digits, point.tolerance);
}

void compare_scores(RegressReport& report, const View& before, const View& after, metrics::ScoreTable table) {
  for (const metrics::Score* score : table) {
    const std::string name(score->name);
    const ScoreRow* a = find_score(*before.row, name);
    const ScoreRow* b = find_score(*after.row, name);
    if (a == nullptr || b == nullptr) continue;
    ScorePoint point;
    point.scenario = after.scenario;
    point.what = name_of(*after.row);
    point.score = name;
    point.baseline = a->value;
    point.current = b->value;
    judge_score(point, *score, report.limits);
    report.scores.push_back(std::move(point));
  }
}

void measure_pictures(PicturePoint& point, const RegressLimits& limits) {
  const Image8 a = decode_png(point.baseline->png, "BASELINE");
  const Image8 b = decode_png(point.current->png, "CURRENT");
  if (a.width != b.width || a.height != b.height || a.channels != b.channels) {
    point.share = 1;
    point.largest = 255;
    point.verdict = Verdict::worse;
    point.reason = fmt::format("{}x{} pixels, was {}x{}", b.width, b.height, a.width, a.height);
    return;
  }
  size_t differ = 0;
  const auto channels = static_cast<size_t>(a.channels);
  for (size_t pixel = 0; pixel < a.pixels(); ++pixel) {
    int most = 0;
    for (size_t c = 0; c < channels; ++c)
      most = std::max(most, std::abs(int{a.data[pixel * channels + c]} - int{b.data[pixel * channels + c]}));
    point.largest = std::max(point.largest, most);
    differ += most > limits.picture_levels ? 1 : 0;
  }
  point.share = static_cast<double>(differ) / static_cast<double>(a.pixels());
  point.verdict = point.share > limits.picture_share ? Verdict::worse : Verdict::same;
  point.reason = point.largest == 0 ? std::string("equal")
                                    : fmt::format("{:.3g} % of the pixels differ by more than {} levels, {} at most",
                                                  100 * point.share, limits.picture_levels, point.largest);
}

void compare_pictures(RegressReport& report, const View& before, const View& after) {
  for (const auto& [role, picture] : after.pictures) {
    const auto old = before.pictures.find(role);
    if (role == "difference" || old == before.pictures.end()) continue;
    PicturePoint point;
    point.scenario = after.scenario;
    point.what = name_of(*after.row);
    point.role = role;
    point.baseline = old->second;
    point.current = picture;
    measure_pictures(point, report.limits);
    report.pictures.push_back(std::move(point));
  }
}

// Runs that measured times or scores: what draws, and which clock counts.
void require_alike(std::span<const StoreContents> baseline, std::span<const StoreContents> current) {
  const RunRow* first = nullptr;
  for (const auto& [side, name] : {std::pair{baseline, "BASELINE"}, std::pair{current, "CURRENT"}})
    for (const StoreContents& contents : side)
      for (const RunRow& run : contents.runs) {
        if (first == nullptr) first = &run;
        if (run.gl_renderer != first->gl_renderer || run.headline != first->headline)
          throw Error(name,
                      fmt::format("was drawn by {} and judged by {} time, other runs by {} and {} time",
                                  run.gl_renderer, run.headline, first->gl_renderer, first->headline),
                      "compare files of one device: keep a baseline for each");
      }
}

template <typename Key, typename Value, typename Name>
void list_unpaired(const std::map<Key, Value>& of, const std::map<Key, Value>& in, std::vector<std::string>& names,
                   const Name& name) {
  for (const auto& [key, value] : of)
    if (!in.contains(key)) names.push_back(name(key, value));
}

}  // namespace

const char* verdict_name(Verdict verdict) {
  switch (verdict) {
    case Verdict::same: return "same";
    case Verdict::indistinct: return "not distinguishable";
    case Verdict::better: return "better";
    case Verdict::worse: return "worse";
    case Verdict::unclear: return "unclear";
  }
  return "unclear";
}

size_t count(const RegressReport& report, Verdict verdict) {
  const auto in = [verdict](const auto& points) {
    return static_cast<size_t>(
        std::count_if(points.begin(), points.end(), [verdict](const auto& point) { return point.verdict == verdict; }));
  };
  return in(report.times) + in(report.scores) + in(report.pictures);
}

int exit_status(const RegressReport& report) {
  if (count(report, Verdict::worse) > 0) return 1;
  const bool nothing = report.times.empty() && report.scores.empty() && report.pictures.empty();
  return nothing || count(report, Verdict::unclear) > 0 || !report.only_baseline.empty() ? 3 : 0;
}

RegressReport regress(std::span<const StoreContents> baseline, std::span<const StoreContents> current,
                      const RegressLimits& limits, metrics::ScoreTable table) {
  require_alike(baseline, current);
  RegressReport report;
  report.limits = limits;
  const TimesByKey times_before = times_of(baseline);
  const TimesByKey times_after = times_of(current);
  for (const auto& [key, series] : times_after)
    if (const auto before = times_before.find(key); before != times_before.end())
      report.times.push_back(compare_times(key, before->second, series, limits));
  judge_times(report.times, limits);
  const Views views_before = views_of(baseline);
  const Views views_after = views_of(current);
  for (const auto& [key, view] : views_after)
    if (const auto before = views_before.find(key); before != views_before.end()) {
      compare_scores(report, before->second, view, table);
      compare_pictures(report, before->second, view);
    }
  const auto time_name = [](const TimeKey& key, const TimeSeries&) {
    return fmt::format("time of {}, {}, {}", key.key.representation, agents_text(key.key.agents),
                       view_name(key.key.requested_occupancy));
  };
  const auto view_name_of = [](const ViewKey&, const View& view) { return "scores of " + name_of(*view.row); };
  list_unpaired(times_before, times_after, report.only_baseline, time_name);
  list_unpaired(times_after, times_before, report.only_current, time_name);
  list_unpaired(views_before, views_after, report.only_baseline, view_name_of);
  list_unpaired(views_after, views_before, report.only_current, view_name_of);
  return report;
}

}  // namespace crowdbench::bench
