#include "reports/model/score_doc.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace crowdbench::reports {

ScoreDoc doc_of(const std::vector<ScoreDoc>& docs, std::string_view name) {
  const auto find = [&](std::string_view wanted) {
    return std::find_if(docs.begin(), docs.end(), [&](const ScoreDoc& doc) { return doc.name == wanted; });
  };
  if (const auto doc = find(name); doc != docs.end()) return *doc;
  const size_t point = name.find('.');
  if (const auto doc = find(name.substr(0, point)); point != std::string_view::npos && doc != docs.end()) {
    ScoreDoc pooled = *doc;
    pooled.name = name;
    pooled.title += fmt::format(", {}", name.substr(point + 1));
    pooled.headline = pooled.charted = pooled.ranking = false;
    return pooled;
  }
  ScoreDoc unknown;
  unknown.name = unknown.title = name;
  return unknown;
}

std::string heading(const ScoreDoc& doc) {
  std::string text = doc.title;
  if (text == doc.name && doc.computes.empty()) return text;  // not described: a name, no words
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return doc.unit.empty() ? text : text + ", " + doc.unit;
}

std::string score_text(const ScoreDoc& doc, double value) {
  if (std::isinf(value)) return value > 0 ? "∞" : "-∞";
  return fmt::format("{:.{}f}", value, doc.digits);
}

std::string best_text(const ScoreDoc& doc) {
  if (!doc.best) return {};
  return std::isinf(*doc.best) ? std::string(", ∞ is equal") : fmt::format(", {:g} is equal", *doc.best);
}

}  // namespace crowdbench::reports
