#include "reports/model/scores.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace crowdbench::reports {

std::optional<double> score_of(const ComparisonRow& comparison, const std::string& name) {
  for (const ScoreRow& score : comparison.scores)
    if (score.name == name) return score.value;
  return std::nullopt;
}

std::vector<ScoreByHeight> scores_by_height(const Scene& scene, const std::string& score) {
  std::vector<ScoreByHeight> all;
  for (const std::string& representation : scene.representations) {
    std::map<double, std::vector<double>> values;
    for (const ComparisonRow* row : scene.agent_comparisons) {
      if (row->representation != representation || !row->height_px) continue;
      const std::optional<double> value = score_of(*row, score);
      if (value && std::isfinite(*value)) values[*row->height_px].push_back(*value);
    }
    for (const auto& [height, list] : values) {
      double sum = 0;
      for (const double value : list) sum += value;
      const auto [least, greatest] = std::minmax_element(list.begin(), list.end());
      all.push_back({representation, height, sum / static_cast<double>(list.size()), *least, *greatest, list.size()});
    }
  }
  return all;
}

ScoreStyle score_style(std::string_view name) {
  if (name == "silhouette_iou") return {"Silhouette IoU"};
  if (name == "boundary_px_mean") return {"Boundary off by, px", 2, true};
  if (name == "boundary_px_p95") return {"95th percentile, px", 2, true};
  if (name == "ssim") return {"SSIM"};
  if (name == "ssim_union") return {"SSIM in the figure"};
  if (name == "psnr") return {"PSNR, dB", 1};
  if (name == "mae") return {"Mean absolute error, code values", 2, true};
  return {std::string(name)};
}

std::string score_text(std::string_view name, double value) {
  return std::isinf(value) ? "\u221e" : fmt::format("{:.{}f}", value, score_style(name).digits);
}

}  // namespace crowdbench::reports
