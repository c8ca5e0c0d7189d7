#include "bench/commands/level_output.h"

#include <fmt/format.h>

#include "core/error.h"

namespace crowdbench::bench {
namespace {

constexpr double kMillimetres = 1000;

Json json_of(const std::optional<renderers::LevelInfo::Other>& other) {
  if (!other) return nullptr;
  return {{"triangles", other->triangles},
          {"stated_m", other->stated},
          {"max_m", other->error.max},
          {"rms_m", other->error.rms}};
}

}  // namespace

std::string level_text(const renderers::LevelInfo& level, double figure_px) {
  std::string text = fmt::format(
      "{}: {} of {} triangles; error {:.1f} mm at most ({:.2f} px of {:g}), {:.1f} mm rms, both ways, over {} pose{}, "
      "most "
      "in '{}'",
      printable(level.character), level.triangles, level.of_triangles, level.error.max * kMillimetres,
      level.pixels(figure_px), figure_px, level.error.rms * kMillimetres, level.error.poses,
      level.error.poses == 1 ? "" : "s", printable(level.worst_clip.empty() ? "(unnamed)" : level.worst_clip));
  if (const auto& other = level.meshoptimizer)
    text += fmt::format("; meshoptimizer: {} triangles, states {:.1f} mm, has {:.1f} mm at most, {:.1f} mm rms",
                        other->triangles, other->stated * kMillimetres, other->error.max * kMillimetres,
                        other->error.rms * kMillimetres);
  return text;
}

Json levels_json(std::span<const renderers::LevelInfo> levels, double figure_px) {
  Json out = Json::array();
  for (const renderers::LevelInfo& level : levels)
    out.push_back({{"character", level.character},
                   {"triangles", level.triangles},
                   {"of_triangles", level.of_triangles},
                   {"max_m", level.error.max},
                   {"rms_m", level.error.rms},
                   {"figure_px", figure_px},
                   {"max_px", level.pixels(figure_px)},
                   {"poses", level.error.poses},
                   {"worst_clip", level.worst_clip},
                   {"worst_phase", level.error.phase},
                   {"meshoptimizer", json_of(level.meshoptimizer)},
                   {"note", level.note.empty() ? Json(nullptr) : Json(level.note)}});
  return out;
}

}  // namespace crowdbench::bench
