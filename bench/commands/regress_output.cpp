#include "bench/commands/regress_output.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "core/error.h"
#include "core/files.h"
#include "core/image_io.h"
#include "core/png.h"
#include "metrics/pseudocolour.h"
#include "reports/exports/markdown_cell.h"
#include "reports/page/escape.h"

namespace crowdbench::bench {
namespace {

// Calls visit(number, kind, title, point) for every point, times first.
template <typename Visit>
void for_each_point(const RegressReport& report, const Visit& visit) {
  size_t number = 0;
  for (const TimePoint& point : report.times) visit(++number, "time", point.what, point);
  for (const ScorePoint& point : report.scores) visit(++number, "score", point.score + ": " + point.what, point);
  for (const PicturePoint& point : report.pictures) visit(++number, "picture", point.role + ": " + point.what, point);
}

std::string percent(double fraction) { return fmt::format("{:+.1f} %", 100 * fraction); }

std::string ending(const RegressReport& report) {
  const auto counted = [&](Verdict verdict) {
    return fmt::format("{} {}", count(report, verdict), verdict_name(verdict));
  };
  const std::string counts =
      fmt::format("{}, {}, {}, {}, {}", counted(Verdict::worse), counted(Verdict::unclear), counted(Verdict::better),
                  counted(Verdict::indistinct), counted(Verdict::same));
  switch (exit_status(report)) {
    case 0: return "PASS: " + counts;
    case 1: return "REGRESSION: " + counts;
    default: break;
  }
  const bool nothing = report.times.empty() && report.scores.empty() && report.pictures.empty();
  return "NOT ENOUGH DATA: " + (nothing ? std::string("the files have no point in common") : counts) +
         (report.only_baseline.empty() ? "" : fmt::format("; {} of the baseline missing", report.only_baseline.size()));
}

const char* correction_name(Correction correction) {
  switch (correction) {
    case Correction::holm: return "Holm";
    case Correction::benjamini_hochberg: return "Benjamini-Hochberg";
    case Correction::none: break;
  }
  return "none";
}

std::string method(const RegressReport& report) {
  const RegressLimits& limits = report.limits;
  return fmt::format(
      "Ratios to the reference of the same rounds (the reference: to its own floor), a value a run. Slower: a rank "
      "test "
      "says that the ratio grew by more than {:.2g} % (or than what a control shows without any change), level {:g}, "
      "correction over "
      "all points: {}. Unclear: a slow-down of {:.3g} % is not excluded. Not distinguishable: one of that "
      "size is, but the 95 % interval reaches beyond {:.2g} %. A slow-down of the reference makes all others "
      "faster; it shows in the reference's own line.",
      100 * limits.least_effect, limits.level, correction_name(limits.correction), 100 * limits.detect,
      100 * limits.least_effect);
}

std::string drift_text(const RegressReport& report) {
  if (!report.drift) return {};
  return fmt::format("Drift control, the reference's own time: {} to {} (95 %)", percent(report.drift->low),
                     percent(report.drift->high));
}

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
Json optional_json(const std::optional<double>& value) { return value ? number_or_null(*value) : Json(nullptr); }

Json point_json(const RegressPoint& point) {
  return {{"scenario", point.scenario},
          {"point", point.what},
          {"verdict", verdict_name(point.verdict)},
          {"reason", point.reason}};
}

Json time_json(const TimePoint& point) {
  Json json = point_json(point);
  json.update({{"representation", point.key.representation},
               {"character", point.key.character},
               {"agents", point.key.agents},
               {"width_px", point.key.width},
               {"height_px", point.key.height},
               {"requested_occupancy", point.key.requested_occupancy},
               {"yardstick", point.yardstick},
               {"metric", point.metric},
               {"unit", point.unit},
               {"values", {{"baseline", point.baseline_values}, {"current", point.current_values}}},
               {"runs", {{"baseline", point.baseline_runs}, {"current", point.current_runs}}},
               {"judged", point.judged},
               {"runs_needed", point.verdict == Verdict::unclear ? Json(point.runs_needed) : Json(nullptr)},
               {"baseline", point.baseline},
               {"current", point.current},
               {"change", point.change},
               {"interval", point.judged ? Json::array({point.interval.low, point.interval.high}) : Json(nullptr)},
               {"least_effect", point.least_effect},
               {"p_slower", point.p_slower},
               {"p_slower_adjusted", point.adjusted_slower},
               {"p_faster", point.p_faster},
               {"p_faster_adjusted", point.adjusted_faster},
               {"detectable", number_or_null(point.detectable)}});
  return json;
}

std::string explanation(const TimePoint& point) {
  if (!point.judged)
    return fmt::format("  time over that of {}, {} time: {:.4g}, was {:.4g}\n", point.yardstick, point.metric,
                       point.current, point.baseline);
  return fmt::format(
      "  time over that of {}, {} time: {:.4g}, was {:.4g}\n  change {} [{}, {}]\n  p of slower than {:.2g} % is "
      "{:.3g}, corrected {:.3g}; of faster {:.3g}, corrected {:.3g}\n  {} {} against {} of the baseline; slow-downs "
      "under {:.2g} % would be missed (80 % power, one point alone)\n",
      point.yardstick, point.metric, point.current, point.baseline, percent(point.change), percent(point.interval.low),
      percent(point.interval.high), 100 * point.least_effect, point.p_slower, point.adjusted_slower, point.p_faster,
      point.adjusted_faster, point.current_values, point.unit, point.baseline_values, 100 * point.detectable);
}
std::string explanation(const ScorePoint& point) {
  const auto text = [](const std::optional<double>& value) { return value ? fmt::format("{:.6g}", *value) : "absent"; };
  return fmt::format("  {}: {}, was {}; may get worse by {:.3g}\n", point.score, text(point.current),
                     text(point.baseline), point.tolerance);
}
std::string explanation(const PicturePoint& point) {
  return fmt::format("  {:.4g} % of the pixels differ beyond the limit, by {} levels at most\n", 100 * point.share,
                     point.largest);
}

std::string write_pictures(const PicturePoint& point, size_t number, const std::filesystem::path& folder) {
  const Image8 before = decode_png(point.baseline->png, "BASELINE");
  const Image8 after = decode_png(point.current->png, "CURRENT");
  std::string text;
  const auto write = [&](const char* name, const Image8& image) {
    const std::filesystem::path file = folder / fmt::format("{}_{}_{}.png", number, point.role, name);
    write_png(file, image);
    text += "  " + file.string() + "\n";
  };
  write("baseline", before);
  write("current", after);
  if (before.width == after.width && before.height == after.height)
    write("difference", metrics::with_colour_bar(metrics::pseudocolour(metrics::error_levels(before, after)),
                                                 "mean absolute difference, code values"));
  return text;
}

// Whether a picture shows what the point is about.
bool shows(const PicturePoint& picture, const RegressPoint& point) {
  const std::string of = point.what.substr(0, point.what.find(", "));
  return picture.what == point.what || picture.what.starts_with(of + " against ");
}

}  // namespace

std::string regress_text(const RegressReport& report) {
  std::string out;
  size_t same = 0;
  for_each_point(report, [&]<typename Point>(size_t number, const char* kind, const std::string& title,
                                             const Point& point) {
    if (!std::is_same_v<Point, TimePoint> && point.verdict == Verdict::same) {
      ++same;
      return;
    }
    out += fmt::format("{:>4} {:<19} {:<8} {}: {}\n", number, verdict_name(point.verdict), kind, title, point.reason);
  });
  if (same > 0) out += fmt::format("{:>13} scores and pictures are the same\n", same);
  for (const std::string& point : report.only_baseline) out += "  missing in CURRENT: " + point + "\n";
  for (const std::string& point : report.only_current) out += "  only in CURRENT: " + point + "\n";
  if (const std::string drift = drift_text(report); !drift.empty()) out += drift + "\n";
  return out + ending(report) + "\n";
}

std::string regress_markdown(const RegressReport& report) {
  std::string out = fmt::format("## {}\n\n{}\n\n", ending(report), method(report));
  if (const std::string drift = drift_text(report); !drift.empty()) out += drift + ".\n\n";
  out += "| # | verdict | point | | |\n|--:|---|---|---|---|\n";
  for_each_point(
      report, [&]<typename Point>(size_t number, const char* kind, const std::string& title, const Point& point) {
        if (!std::is_same_v<Point, TimePoint> && point.verdict == Verdict::same) return;
        const char* strong = point.verdict == Verdict::worse ? "**" : "";
        out += fmt::format("| {} | {}{}{} | {} | {} | {} |\n", number, strong, verdict_name(point.verdict), strong,
                           reports::markdown_cell(title), kind, reports::markdown_cell(point.reason));
      });
  for (const std::string& point : report.only_baseline) out += "\nMissing: " + reports::markdown_cell(point) + "\n";
  for (const std::string& point : report.only_current) out += "\nNew: " + reports::markdown_cell(point) + "\n";
  return out;
}

std::string regress_junit(const RegressReport& report) {
  const size_t points = report.times.size() + report.scores.size() + report.pictures.size();
  std::string out = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n  <testsuite name=\"crowdbench regress\" "
      "tests=\"{}\" failures=\"{}\" errors=\"0\" skipped=\"{}\">\n",
      points + report.only_baseline.size(), count(report, Verdict::worse),
      count(report, Verdict::unclear) + report.only_baseline.size());
  const auto add = [&](const std::string& kind, const std::string& title, Verdict verdict, const std::string& reason) {
    out += fmt::format("    <testcase classname=\"{}\" name=\"{}\"", kind, reports::html_escape(title));
    const std::string why = reports::html_escape(reason);
    if (verdict == Verdict::worse)
      out += fmt::format("><failure message=\"{}\"/></testcase>\n", why);
    else if (verdict == Verdict::unclear)
      out += fmt::format("><skipped message=\"{}\"/></testcase>\n", why);
    else
      out += "/>\n";
  };
  for_each_point(report, [&](size_t, const char* kind, const std::string& title, const auto& point) {
    add(kind, point.scenario.empty() ? title : point.scenario + ": " + title, point.verdict, point.reason);
  });
  for (const std::string& point : report.only_baseline) add("missing", point, Verdict::unclear, "missing in CURRENT");
  return out + "  </testsuite>\n</testsuites>\n";
}

Json regress_json(const RegressReport& report) {
  Json times = Json::array();
  for (const TimePoint& point : report.times) times.push_back(time_json(point));
  Json scores = Json::array();
  for (const ScorePoint& point : report.scores) {
    Json json = point_json(point);
    json.update({{"score", point.score},
                 {"baseline", optional_json(point.baseline)},
                 {"current", optional_json(point.current)},
                 {"tolerance", point.tolerance}});
    scores.push_back(std::move(json));
  }
  Json pictures = Json::array();
  for (const PicturePoint& point : report.pictures) {
    Json json = point_json(point);
    json.update({{"role", point.role}, {"share", point.share}, {"largest", point.largest}});
    pictures.push_back(std::move(json));
  }
  Json all = {{"verdict", exit_status(report) == 0   ? "pass"
                          : exit_status(report) == 1 ? "regression"
                                                     : "not enough data"},
              {"level", report.limits.level},
              {"least_effect", report.limits.least_effect},
              {"detect", report.limits.detect},
              {"correction", correction_name(report.limits.correction)}};
  all["drift"] = report.drift ? Json::array({report.drift->low, report.drift->high}) : Json(nullptr);
  all["times"] = times;
  all["scores"] = scores;
  all["pictures"] = pictures;
  all["only_baseline"] = report.only_baseline;
  all["only_current"] = report.only_current;
  return all;
}

std::string regress_explanation(const RegressReport& report, const std::string& point,
                                const std::filesystem::path& folder) {
  size_t wanted = 0;
  const auto [end, error] = std::from_chars(point.data(), point.data() + point.size(), wanted);
  const bool by_number = error == std::errc() && end == point.data() + point.size();
  std::string out;
  for_each_point(report, [&](size_t number, const char* kind, const std::string& title, const auto& one) {
    if (by_number ? number != wanted : title.find(point) == std::string::npos) return;
    out += fmt::format("{} {} {} ({}): {}\n{}", number, verdict_name(one.verdict), title, kind, one.reason,
                       explanation(one));
    if (folder.empty()) return;
    for (const PicturePoint& picture : report.pictures)
      if (shows(picture, one)) out += write_pictures(picture, number, folder);
  });
  if (out.empty())
    throw Error("--explain", fmt::format("no point is '{}'", point), "give a point's number in the table, or its text");
  return out + method(report) + "\n";
}

}  // namespace crowdbench::bench
