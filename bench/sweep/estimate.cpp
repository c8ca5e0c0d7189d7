#include "bench/sweep/estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/progress.h"
#include "core/short_numbers.h"
#include "core/statistics.h"

namespace crowdbench::bench::sweep {
namespace {

// Beside the timed rounds, seconds: solving and looking, a condition; baking, a representation at its first use. Rough.
constexpr double kConditionOverhead = 1.5;
constexpr double kBake = 5;
// What a frame of the mesh took on two cores of llvmpipe, seconds: by itself, an agent of some thousand triangles, a
// pixel. Others are taken to be no faster. Warm-ups settle after some rounds.
constexpr double kFrameSeconds = 0.003;
constexpr double kAgentSeconds = 0.0004;
constexpr double kPixelSeconds = 5e-8;
constexpr double kWarmUpRounds = 8;
// Bytes in the file, as measured: a run's text and the rows of a condition, a point with its ratios, a sample, a score.
constexpr double kFileBytes = 60'000;
constexpr double kConditionBytes = 5000;
constexpr double kPointBytes = 1600;
constexpr double kSampleBytes = 34;
constexpr double kScoreBytes = 40;
// Of a picture's three PNGs, bytes a pixel.
constexpr double kPictureBytes = 1.5;

// Each of the warm-up and the rounds ends at the time limit.
double timed_seconds_of(const Plan& plan, const Condition& condition) {
  if (!plan.measures.times) return 0;
  const scene::Scenario& scenario = condition.scenario;
  const double frame = kFrameSeconds + kAgentSeconds * scenario.crowd.agents +
                       kPixelSeconds * static_cast<double>(scenario.width) * scenario.height;
  const double round = frame * static_cast<double>(condition.points.size() + (plan.measures.aa ? 2 : 1));
  return std::min(plan.measures.time_limit_s, kWarmUpRounds * round) +
         std::min(plan.measures.time_limit_s, plan.measures.rounds * round);
}

double bytes_of(const Plan& plan, const Condition& condition) {
  const auto points = static_cast<double>(condition.points.size());
  const double drawn = points + 1;
  double bytes = kConditionBytes + drawn * kPointBytes;
  if (plan.measures.times) bytes += drawn * plan.measures.rounds * kSampleBytes;
  bytes += points * static_cast<double>(plan.measures.scores.size()) * kScoreBytes;
  if (plan.measures.pictures)
    bytes += points * kPictureBytes * static_cast<double>(condition.scenario.width) * condition.scenario.height;
  return bytes;
}

// Seconds that the conditions in the file took, each once.
std::vector<double> seconds_of(const StoreContents& contents) {
  std::vector<double> seconds;
  std::set<std::pair<uint32_t, uint32_t>> seen;
  for (const SweepPointRow& row : contents.sweep_points)
    if (seen.emplace(row.condition, row.repetition).second) seconds.push_back(row.seconds);
  return seconds;
}

}  // namespace

Estimate estimate(const Plan& plan, const Shard& shard, const std::filesystem::path& out) {
  Estimate result;
  result.repetitions = static_cast<size_t>(plan.repetitions);
  std::set<std::string> representations;
  double guessed = 0;
  for (size_t c = 0; c < plan.conditions.size(); ++c) {
    if (!shard.holds(c)) continue;
    ++result.conditions;
    guessed += timed_seconds_of(plan, plan.conditions[c]) + kConditionOverhead;
    result.points += plan.conditions[c].points.size() * result.repetitions;
    result.bytes += static_cast<uint64_t>(bytes_of(plan, plan.conditions[c])) * result.repetitions;
    for (const PlannedPoint& point : plan.conditions[c].points) representations.insert(point.representation);
  }
  result.bytes += static_cast<uint64_t>(kFileBytes);
  const size_t cells = result.conditions * result.repetitions;
  std::vector<double> before;
  std::error_code failed;
  if (is_finished(out, plan, shard)) {
    result.held = cells;
  } else if (std::filesystem::exists(partial_file(out), failed)) {
    before = seconds_of(read_store(partial_file(out), false, false));
    result.held = before.size();
  }
  const auto left = static_cast<double>(cells - std::min(cells, result.held));
  result.measured = !before.empty();
  if (result.measured)
    result.seconds = left * median(before);
  else if (left > 0)
    result.seconds =
        left * guessed / static_cast<double>(result.conditions) + kBake * static_cast<double>(representations.size());
  return result;
}

std::string dry_run_text(const Plan& plan, const Shard& shard, const Estimate& estimate) {
  std::string out;
  std::map<std::string, std::set<std::string>> values;
  for (const Condition& condition : plan.conditions)
    for (const PlannedPoint& point : condition.points)
      for (const Setting& setting : point.settings) values[setting.axis].insert(setting.text);
  std::map<std::string, std::map<std::string, std::string>> texts;
  for (const auto& [axis, of] : values) texts[axis] = short_numbers(of);
  for (size_t c = 0; c < plan.conditions.size(); ++c) {
    if (!shard.holds(c)) continue;
    for (const PlannedPoint& point : plan.conditions[c].points) {
      std::string settings;
      for (const Setting& setting : point.settings)
        if (setting.axis != "representation")
          settings += fmt::format("{} = {}, ", setting.axis, texts[setting.axis][setting.text]);
      out += fmt::format("condition {}: {}representation = {}\n", c + 1, settings, point.representation);
    }
  }
  out += fmt::format("{}: {} {} in {} {}", plan.name, estimate.points, estimate.points == 1 ? "point" : "points",
                     estimate.conditions, estimate.conditions == 1 ? "condition" : "conditions");
  if (estimate.repetitions > 1) out += fmt::format(", {} times each", estimate.repetitions);
  if (estimate.held > 0) out += fmt::format("; {} done already", estimate.held);
  const bool nothing = estimate.held >= estimate.conditions * estimate.repetitions;
  if (!nothing)
    out += fmt::format("; about {} {}", duration_text(estimate.seconds),
                       estimate.measured ? "left, as the ones before took" : "by a rough guess");
  const auto bytes = static_cast<double>(estimate.bytes);
  out += bytes < 1e6 ? fmt::format("; a file of about {:.0f} kB\n", bytes / 1e3)
                     : fmt::format("; a file of about {:.1f} MB\n", bytes / 1e6);
  return out;
}

}  // namespace crowdbench::bench::sweep
