#include "bench/commands/study_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "core/error.h"
#include "reports/page/study_page.h"
#include "studies/analysis/analysis_output.h"
#include "studies/analysis/analysis_text.h"
#include "studies/analysis/psychometric.h"
#include "studies/analysis/text_numbers.h"

namespace crowdbench::bench {
namespace {

using namespace studies;
using reports::StudyPoint;

constexpr int kLinePoints = 120;

reports::StudyChart chart_of(Topic topic) {
  switch (topic) {
    case Topic::shares: return reports::StudyChart::shares;
    case Topic::curves: return reports::StudyChart::curves;
    case Topic::ranking: return reports::StudyChart::ranking;
    case Topic::prediction: return reports::StudyChart::prediction;
    default: return reports::StudyChart::none;
  }
}

reports::StudySection section_of(const Section& s) {
  reports::StudySection out{s.heading, s.lead, s.note, s.list, {}, chart_of(s.topic)};
  if (s.table) out.table = {s.table->columns, s.table->words, s.table->rows};
  return out;
}

// Answers by level, as the curve is fitted to them: the rule for ties is one of sums, and alike trials are not of it.
std::vector<Level> levels_of(const Analysis& a, const TaskResult& t, const CurveResult& c) {
  std::map<double, Answer> sums;
  for (const Answer& row : a.answers.rows) {
    const std::string task = row.task ? a.answers.tasks[*row.task] : "";
    const std::string condition = row.condition ? a.answers.conditions[*row.condition] : "";
    if (!row.level || row.item_a || task != t.name || condition != c.condition || !row.signal.value_or(true)) continue;
    Answer& sum = sums[*row.level];
    sum.yes += row.yes;
    sum.ties += row.ties;
    sum.no += row.no;
  }
  std::vector<Level> out;
  for (const auto& [x, sum] : sums) {
    const Decided d = decided(sum.yes, sum.ties, sum.no, a.settings.ties);
    if (d.of > 0) out.push_back({x, d.yes, d.of});
  }
  return out;
}

reports::StudyCurve curve_of(const Analysis& a, const TaskResult& t, const CurveResult& c) {
  reports::StudyCurve out;
  out.name = text::named(c.condition);
  out.level = a.settings.curve.level;
  const std::vector<Level> levels = levels_of(a, t, c);
  for (const Level& level : levels) {
    const Interval exact = clopper_pearson(level.yes, level.of, a.settings.confidence);
    out.points.push_back(
        {level.x, static_cast<double>(level.yes) / static_cast<double>(level.of), exact.low, exact.high});
  }
  if (c.fit.state != CurveState::fitted && c.fit.state != CurveState::step) return out;
  out.threshold = c.fit.threshold;
  if (const auto interval = threshold_interval(c)) {
    out.threshold_low = interval->low;
    out.threshold_high = interval->high;
  }
  const double from = levels.front().x;
  const double to = levels.back().x;
  for (int i = 0; i <= kLinePoints; ++i) {
    const double x = from + (to - from) * i / kLinePoints;
    out.line.push_back(
        {x, psi(a.settings.curve.curve, a.settings.curve.falling, c.fit.at, x), std::nullopt, std::nullopt});
  }
  return out;
}

std::vector<StudyPoint> ranking_of(const RankingResult& r) {
  std::vector<StudyPoint> out;
  const std::vector<double>& q = r.jod_with_prior.q;
  for (size_t i = 0; i < q.size(); ++i) {
    StudyPoint point{text::named(r.items[i]), q[i], std::nullopt, std::nullopt, fmt::format("{:+.2f} JOD", q[i])};
    if (r.intervals && !r.intervals->q.empty()) {
      point.low = r.intervals->q[i].low;
      point.high = r.intervals->q[i].high;
      point.text += fmt::format(", {:+.2f} to {:+.2f}", *point.low, *point.high);
    }
    out.push_back(std::move(point));
  }
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.value > b.value; });
  return out;
}

std::vector<StudyPoint> prediction_of(const ScorePredictions& p) {
  std::vector<StudyPoint> out;
  for (const ScorePrediction& s : p.scores) {
    if (s.state != PredictionState::fitted) continue;
    StudyPoint point{text::named(s.score), s.auc, std::nullopt, std::nullopt, fmt::format("{:.3f}", s.auc)};
    if (s.auc_interval) {
      point.low = s.auc_interval->low;
      point.high = s.auc_interval->high;
      point.text += fmt::format(", {:.3f} to {:.3f}", *point.low, *point.high);
    }
    out.push_back(std::move(point));
  }
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.value > b.value; });
  return out;
}

reports::StudyTask task_of(const Analysis& a, const TaskResult& t, const TaskText& text) {
  reports::StudyTask out;
  out.name = text.name;
  out.axis = axis_title(a.settings.axis);
  out.verdicts = text.verdicts;
  for (const Section& section : text.sections) out.sections.push_back(section_of(section));
  for (const ConditionResult& c : t.conditions)
    out.shares.push_back(
        {text::named(c.name), static_cast<double>(c.yes), static_cast<double>(c.ties), static_cast<double>(c.no)});
  for (const CurveResult& c : t.curves) out.curves.push_back(curve_of(a, t, c));
  if (t.ranking) out.ranking = ranking_of(*t.ranking);
  if (t.prediction) out.prediction = prediction_of(*t.prediction);
  return out;
}

std::vector<std::string> standing_sentences(const StudyReport& report) {
  std::vector<std::string> out;
  if (!report.standing) return out;
  if (report.standing->standing != Standing::planned) out.push_back(standing_title(report.standing->standing) + ".");
  out.insert(out.end(), report.standing->sentences.begin(), report.standing->sentences.end());
  return out;
}

}  // namespace

Json study_report_json(const StudyReport& report) {
  Json out = analysis_json(report.analysis);
  out["plan"] = Json();
  if (report.standing)
    out["plan"] = {{"standing", standing_title(report.standing->standing)}, {"sentences", report.standing->sentences}};
  return out;
}

std::string study_report_markdown(const StudyReport& report) {
  return analysis_markdown(report.analysis, standing_sentences(report));
}

std::string study_report_plain(const StudyReport& report) {
  return analysis_plain(report.analysis, standing_sentences(report));
}

std::string study_report_page(const StudyReport& report) {
  const AnalysisText text = analysis_text(report.analysis);
  reports::StudyPageModel model;
  model.source = printable(fmt::format("{}", fmt::join(report.analysis.sources, ", ")), 200);
  if (report.standing) {
    model.planned = report.standing->standing == Standing::planned;
    model.standing_title = standing_title(report.standing->standing);
    model.standing = report.standing->sentences;
  }
  model.title = "What " + text.who + " answered";
  model.lead = text.lead;
  for (size_t i = 0; i < text.tasks.size(); ++i)
    model.tasks.push_back(task_of(report.analysis, report.analysis.tasks[i], text.tasks[i]));
  return reports::study_page(model);
}

}  // namespace crowdbench::bench
