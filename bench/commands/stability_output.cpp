#include "bench/commands/stability_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/image_io.h"
#include "core/version.h"
#include "reports/exports/markdown_cell.h"
#include "reports/page/stability_page.h"

namespace crowdbench::bench {
namespace {

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::string figure(double value) { return std::isnan(value) ? "nothing" : fmt::format("{:.3g}", value); }

Json row_json(const StabilityRow& row) {
  const Found& found = row.found;
  return {{"case", row.asked.name},
          {"representation", row.representation.empty() ? Json(nullptr) : Json(row.representation)},
          {"measured", number_or_null(found.measured)},
          {"bound", number_or_null(found.bound)},
          {"unit", row.asked.unit},
          {"pass", row.pass()},
          {"group", row.asked.group},
          {"asked", row.asked.asked},
          {"bound_from", row.asked.bound_from},
          {"bound_seen", row.asked.bound_seen},
          {"place", found.place},
          {"values", {{"expected", found.expected}, {"got", found.got}}},
          {"note", found.note},
          {"error", row.error},
          {"seconds", row.seconds}};
}

// How near to its bound a row comes: above 1 it fails; rows that were not measured are the worst.
double strain(const StabilityRow& row) {
  if (!row.error.empty() || std::isnan(row.found.measured)) return INFINITY;
  if (row.found.bound > 0) return row.found.measured / row.found.bound;
  return row.found.measured > 0 ? INFINITY : 0;
}

}  // namespace

size_t failed(const StabilityReport& report) {
  return static_cast<size_t>(
      std::count_if(report.rows.begin(), report.rows.end(), [](const StabilityRow& row) { return !row.pass(); }));
}

Json stability_json(const StabilityReport& report) {
  Json cases = Json::array();
  for (const StabilityRow& row : report.rows) cases.push_back(row_json(row));
  return {{"renderer", report.renderer}, {"small", report.small}, {"failed", failed(report)}, {"cases", cases}};
}

std::vector<StabilityCaseRow> stability_rows(const StabilityReport& report, int64_t run) {
  const auto finite = [](double value) { return std::isfinite(value) ? std::optional(value) : std::nullopt; };
  std::vector<StabilityCaseRow> rows;
  for (const StabilityRow& row : report.rows) {
    const Found& found = row.found;
    StabilityCaseRow& out = rows.emplace_back();
    out.run = run;
    out.name = row.asked.name;
    out.group = row.asked.group;
    if (!row.representation.empty()) out.representation = row.representation;
    out.measured = finite(found.measured);
    out.bound = finite(found.bound);
    out.unit = row.asked.unit;
    out.pass = row.pass();
    out.bound_seen = row.asked.bound_seen;
    out.small = report.small;
    out.place = found.place;
    out.expected = found.expected;
    out.got = found.got;
    out.note = found.note;
    out.error = row.error;
  }
  return rows;
}

std::string stability_text(const StabilityReport& report) {
  size_t name = 22;
  size_t unit = 16;
  for (const StabilityRow& row : report.rows) {
    name = std::max(name, row.asked.name.size());
    unit = std::max(unit, row.asked.unit.size());
  }
  std::string out = fmt::format("{:<{}} {:<26} {:>10} {:>10} {:<{}}\n", "case", name, "representation", "measured",
                                "bound", "unit", unit);
  for (const StabilityRow& row : report.rows) {
    const Found& found = row.found;
    out += fmt::format("{:<{}} {:<26} {:>10} {:>10} {:<{}} {}\n", row.asked.name, name, row.representation,
                       figure(found.measured), figure(found.bound), row.asked.unit, unit, row.pass() ? "" : "FAILS");
    if (row.pass()) continue;
    if (!row.error.empty()) out += fmt::format("    {}\n", row.error);
    if (!found.place.empty()) out += fmt::format("    {}: {}, should be {}\n", found.place, found.got, found.expected);
    if (!found.note.empty()) out += fmt::format("    {}\n", found.note);
    out += fmt::format("    asked: {}; bound: {}\n", row.asked.asked, row.asked.bound_from);
  }
  const size_t bad = failed(report);
  out += bad == 0 ? fmt::format("all {} rows hold\n", report.rows.size())
                  : fmt::format("{} of {} rows FAIL\n", bad, report.rows.size());
  return out;
}

std::string stability_markdown(const StabilityReport& report) {
  std::string out =
      "| case | what is asked | measured at worst | bound | unit | of |\n"
      "|---|---|---|---|---|---|\n";
  std::vector<const StabilityRow*> worst;  // in the order of the cases
  for (const StabilityRow& row : report.rows) {
    const auto same = std::find_if(worst.begin(), worst.end(),
                                   [&](const StabilityRow* other) { return other->asked.name == row.asked.name; });
    if (same == worst.end())
      worst.push_back(&row);
    else if (strain(row) > strain(**same))
      *same = &row;
  }
  for (const StabilityRow* row : worst)
    out += fmt::format("| `{}` | {} | {}{} | {} | {} | {} |\n", row->asked.name,
                       reports::markdown_cell(std::string(row->asked.asked)), figure(row->found.measured),
                       row->pass() ? "" : " **fails**", figure(row->found.bound), row->asked.unit,
                       row->representation.empty() ? "" : "`" + reports::markdown_cell(row->representation) + "`");
  return out;
}

std::string stability_page_of(const StabilityReport& report) {
  std::vector<reports::StabilityPageRow> rows;
  for (const StabilityRow& row : report.rows) {
    const Found& found = row.found;
    reports::StabilityPageRow shown;
    shown.name = row.asked.name;
    shown.representation = row.representation;
    shown.asked = row.asked.asked;
    shown.measured = figure(found.measured);
    shown.bound = figure(found.bound);
    shown.unit = row.asked.unit;
    shown.bound_from = row.asked.bound_from;
    shown.place = found.place;
    shown.expected = found.expected;
    shown.got = found.got;
    shown.note = row.error.empty() ? found.note : row.error;
    shown.pass = row.pass();
    shown.bound_seen = row.asked.bound_seen;
    if (!found.before.empty()) {
      shown.before = encode_png(found.before);
      shown.after = encode_png(found.after);
      shown.width = found.before.width;
      shown.height = found.before.height;
    }
    rows.push_back(std::move(shown));
  }
  return reports::stability_page(rows, report.renderer, fmt::format("crowdbench {}", version()));
}

std::string stability_list(const std::vector<StabilityCase>& cases) {
  std::string out;
  std::string_view group;
  for (const StabilityCase& one : cases) {
    if (one.group != group) out += fmt::format("{}:\n", group = one.group);
    out += fmt::format("  {:<22} {}\n  {:<22} in {}; bound: {}\n", one.name, one.asked, "", one.unit, one.bound_from);
  }
  return out;
}

}  // namespace crowdbench::bench
