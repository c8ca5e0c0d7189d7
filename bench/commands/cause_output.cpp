#include "bench/commands/cause_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "bench/commands/score_json.h"

namespace crowdbench::bench {
namespace {

using metrics::CauseDoc;
using metrics::CauseErrors;
using metrics::CauseRow;

Json name_or_null(const std::optional<metrics::Cause>& cause) {
  return cause ? Json(metrics::doc_of(*cause).name) : Json(nullptr);
}

const metrics::AgentChange* change_of(std::span<const metrics::AgentChange> changes, uint32_t id) {
  const auto found = std::find_if(changes.begin(), changes.end(), [&](const auto& change) { return change.id == id; });
  return found == changes.end() ? nullptr : &*found;
}

// Shifts are known to a hundredth of a pixel at best.
double thousandths(double pixels) { return std::round(1000 * pixels) / 1000; }

void put_change(Json& row, const CauseErrors& errors, const metrics::AgentChange& change) {
  row["displaced_px"] = {thousandths(change.dx), thousandths(change.dy)};
  row["told_px"] = thousandths(change.told_px);
  row["recoloured"] = change.recoloured;
  row["displaced_m"] = json_number(change.farther);
  row["surface_m"] = json_number(change.surface_farther);
  row["thickness_m"] = change.surface_farther ? Json(change.thickness) : Json(nullptr);
  row["card"] = change.surface_farther ? Json(change.card) : Json(nullptr);
  row["late"] = errors.available(metrics::Cause::pose) ? Json(change.posed) : Json(nullptr);
  row["changed_places_with"] = Json::array();
  for (const uint32_t other : change.changed_places_with) row["changed_places_with"].push_back(other);
}

std::string change_text(const metrics::AgentChange& change) {
  std::string text;
  if (change.posed) text += "; in the pose of --pose-ref";
  if (change.dx != 0 || change.dy != 0)
    text += fmt::format("; displaced by {:.3g} pixels {} and {:.3g} {}", std::abs(change.dx),
                        change.dx < 0 ? "left" : "right", std::abs(change.dy), change.dy < 0 ? "up" : "down");
  const auto far = [](double metres) {
    return fmt::format("{:.3g} m {}", std::abs(metres), metres > 0 ? "farther" : "nearer");
  };
  if (change.farther && std::abs(*change.farther) > metrics::kSurfaceTolerance)
    text += "; " + far(*change.farther);
  else if (!change.farther && change.surface_farther && std::abs(*change.surface_farther) > change.thickness)
    text += "; the surface that is drawn for it " + far(*change.surface_farther);
  if (change.recoloured) text += "; recoloured";
  if (change.card) text += "; drawn on a card";
  for (const uint32_t other : change.changed_places_with) text += fmt::format("; now behind {}", other);
  constexpr double kWorthSaying = 0.5;  // pixels
  if (change.told_px >= kWorthSaying) {
    const bool moved = change.dx != 0 || change.dy != 0;
    text += fmt::format("; its outline is {}wrong by as much as a shift by {:.2g} pixels makes it{}",
                        moved ? "then still " : "", change.told_px,
                        moved ? "" : ", of which no displacement explains half: one of about that size cannot be told");
  }
  return text;
}

}  // namespace

Json cause_row_json(const CauseErrors& errors, const CauseRow& row) {
  Json squared = Json::object();
  for (const CauseDoc& doc : metrics::causes())
    squared[std::string(doc.name)] = errors.available(doc.cause) ? Json(row.amount(doc.cause)) : Json(nullptr);
  return {{"squared", squared},
          {"residue", row.residue},
          {"total", row.total},
          {"pixels", row.pixels},
          {"largest", name_or_null(row.largest())}};
}

Json causes_json(const CauseErrors& errors, std::span<const metrics::AgentChange> changes, bool agents) {
  Json out = cause_row_json(errors, errors.whole);
  out["order"] = Json::array();
  out["reasons"] = Json::object();
  for (const CauseDoc& doc : metrics::causes()) {
    out["order"].push_back(std::string(doc.name));
    if (!errors.available(doc.cause))
      out["reasons"][std::string(doc.name)] = errors.reasons[static_cast<size_t>(doc.cause)];
  }
  if (!agents) return out;
  out["agents"] = Json::array();
  for (const CauseRow& agent : errors.agents) {
    Json row = {{"id", agent.id}};
    row.update(cause_row_json(errors, agent));
    if (const metrics::AgentChange* change = change_of(changes, agent.id)) put_change(row, errors, *change);
    out["agents"].push_back(std::move(row));
  }
  return out;
}

Json cause_ranges_json(std::span<const CauseRange> ranges) {
  Json out = Json::array();
  for (const CauseRange& range : ranges) {
    Json shares = Json::object();
    for (const CauseDoc& doc : metrics::causes())
      shares[std::string(doc.name)] = range.shares[static_cast<size_t>(doc.cause)];
    Json one = {{"from_px", range.from},
                {"below_px", json_number(range.below)},
                {"units", range.units},
                {"total", range.total},
                {"shares", shares},
                {"residue", range.residue},
                {"dominant", name_or_null(range.dominant)}};
    one["interval"] = range.dominant ? Json({range.share.low, range.share.high}) : Json(nullptr);
    out.push_back(std::move(one));
  }
  return out;
}

std::string cause_shares_text(const CauseRow& row) {
  if (row.total == 0) return "no error";
  const auto percent = [&](int64_t amount) {
    return 100 * static_cast<double>(amount) / static_cast<double>(row.total);
  };
  std::string text;
  for (const CauseDoc& doc : metrics::causes())
    if (const int64_t amount = row.amount(doc.cause); amount != 0)
      text += fmt::format("{}{} {:.1f} %", text.empty() ? "" : ", ", doc.name, percent(amount));
  return text + fmt::format("{}residue {:.1f} %", text.empty() ? "" : "; ", percent(row.residue));
}

void print_untold(const CauseErrors& errors) {
  std::map<std::string, std::string> untold;  // causes by reason
  for (const CauseDoc& doc : metrics::causes())
    if (!errors.available(doc.cause)) {
      std::string& names = untold[errors.reasons[static_cast<size_t>(doc.cause)]];
      names += fmt::format("{}{}", names.empty() ? "" : ", ", doc.name);
    }
  for (const auto& [reason, names] : untold) fmt::print("  not available: {}: {}\n", names, reason);
}

void print_causes(const CauseErrors& errors, std::span<const metrics::AgentChange> changes) {
  fmt::print("squared error by cause, {} in all: {}\n", errors.whole.total, cause_shares_text(errors.whole));
  for (const CauseRow& agent : errors.agents) {
    if (agent.total == 0) continue;
    const metrics::AgentChange* change = change_of(changes, agent.id);
    fmt::print("  agent id {}, {}: {}{}\n", agent.id, agent.total, cause_shares_text(agent),
               change ? change_text(*change) : "");
  }
  print_untold(errors);
}

}  // namespace crowdbench::bench
