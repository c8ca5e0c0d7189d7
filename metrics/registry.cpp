#include "metrics/registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "metrics/pseudocolour.h"

namespace crowdbench::metrics {

// One line a score; each is defined in the file of what it computes.
#define CROWDBENCH_SCORES(SCORE)  \
  SCORE(silhouette_iou)           \
  SCORE(boundary_px_mean)         \
  SCORE(boundary_px_p95)          \
  SCORE(silhouette_hausdorff_px)  \
  SCORE(silhouette_difference_px) \
  SCORE(holes)                    \
  SCORE(strays)                   \
  SCORE(ssim)                     \
  SCORE(ssim_union)               \
  SCORE(ms_ssim)                  \
  SCORE(flip)                     \
  SCORE(psnr)                     \
  SCORE(mae)                      \
  SCORE(mse)                      \
  SCORE(gmsd)                     \
  SCORE(depth_mae)                \
  SCORE(linear_mae)               \
  SCORE(linear_rms)               \
  SCORE(hdr_flip)                 \
  SCORE(cvvdp)                    \
  SCORE(flicker)

#define CROWDBENCH_DECLARE(name) extern const Score score_##name;
CROWDBENCH_SCORES(CROWDBENCH_DECLARE)
#define CROWDBENCH_ADDRESS(name) &score_##name,
namespace {
constexpr std::array kScores = {CROWDBENCH_SCORES(CROWDBENCH_ADDRESS)};

struct Need {
  Needs bit;
  const char* name;
  const char* missing;
};
constexpr Need kNeeds[] = {
    {kNeedsCodes, "code values", "float and 32-bit pictures have no 8-bit code values"},
    {kNeedsLinear, "floats", "the pictures have no linear values"},
    {kNeedsIds, "ids", "no agent ids are given"},
    {kNeedsDepth, "depth", "no depths are given"},
    {kNeedsRegion, "region", "no silhouettes are given"},
    {kNeedsFrames, "successive frames", "there are no successive frames"},
    {kNeedsDisplay, "display", "no display is given"},
};

ScoreResult without_nan(ScoreResult result) {
  if (!result.value || !std::isnan(*result.value)) return result;
  return absent_not_finite("a pixel is not a number");
}

std::string range_end(double value) {
  if (std::isinf(value)) return value > 0 ? "∞" : "-∞";
  return fmt::format("{:g}", value);
}

}  // namespace

std::string needs_text(Needs needs) {
  std::string text;
  for (const Need& need : kNeeds)
    if ((needs & need.bit) != 0) text += (text.empty() ? "" : ", ") + std::string(need.name);
  return text;
}

void look_at(const ChosenDisplay& chosen, ScoreInput& input) {
  input.display = &chosen.display;
  input.display_is_default = !chosen.given;
}

Needs given(const ScoreInput& input) {
  const Buffers& a = input.reference;
  const Buffers& b = input.test;
  Needs needs = 0;
  if ((a.codes && b.codes) || (a.codes16 && b.codes16)) needs |= kNeedsCodes;
  if (a.linear && b.linear) needs |= kNeedsLinear;
  if (a.ids && b.ids) needs |= kNeedsIds;
  if (a.depth && b.depth) needs |= kNeedsDepth;
  if (input.region) needs |= kNeedsRegion;
  if (input.display) needs |= kNeedsDisplay;
  return needs;
}

ScoreResult absent(std::string reason) {
  ScoreResult result;
  result.reason = std::move(reason);
  return result;
}

ScoreResult absent_not_finite(std::string reason) {
  ScoreResult result = absent(std::move(reason));
  result.not_finite = true;
  return result;
}

ScoreTable scores() { return kScores; }

const Score& ranking_score(ScoreTable table) {
  assert(!table.empty());
  const auto found = std::find_if(table.begin(), table.end(), [](const Score* s) { return (s->uses & kRanking) != 0; });
  return found == table.end() ? *table.front() : **found;
}

const Score* score_by_cause(ScoreTable table) {
  const auto found = std::find_if(table.begin(), table.end(), [](const Score* s) { return (s->uses & kByCause) != 0; });
  return found == table.end() ? nullptr : *found;
}

const Score* score_of_threshold(ScoreTable table) {
  const auto found = std::find_if(table.begin(), table.end(), [](const Score* s) { return s->threshold.has_value(); });
  return found == table.end() ? nullptr : *found;
}

double best_value(const Score& score) {
  return score.direction == Direction::higher_is_better ? score.greatest : score.least;
}

bool is_worse(const Score& score, double a, double b) {
  return score.direction == Direction::lower_is_better ? a > b : a < b;
}

std::string_view name_among_silhouettes(const Score& score) {
  constexpr std::string_view kPrefix = "silhouette_";
  return score.name.starts_with(kPrefix) ? score.name.substr(kPrefix.size()) : score.name;
}

std::vector<Scored> score_pictures(ScoreTable table, const ScoreInput& input, Shared& shared, Needs also) {
  const Needs here = given(input);
  std::vector<Scored> out;
  for (const Score* score : table) {
    if (!score->compute || (score->needs & ~(here | also)) != 0) continue;
    const Needs missing = score->needs & ~here;
    if (missing == 0) {
      out.push_back({score, without_nan(score->compute(input, shared))});
      continue;
    }
    const auto* need =
        std::find_if(std::begin(kNeeds), std::end(kNeeds), [&](const Need& n) { return (missing & n.bit) != 0; });
    out.push_back({score, absent(need->missing)});
  }
  return out;
}

std::vector<Scored> absent_scores(ScoreTable table, Needs needs, const std::string& reason) {
  std::vector<Scored> out;
  for (const Score* score : table)
    if (score->compute && (score->needs & ~needs) == 0) out.push_back({score, absent(reason)});
  return out;
}

ClipScores::ClipScores(ScoreTable table) : table_(table) {}

void ClipScores::take(const ScoreInput& frame) {
  if (frames_++ == 0)
    for (const Score* score : table_)
      if (score->over_time && (score->needs & ~(given(frame) | kNeedsFrames)) == 0)
        running_.emplace_back(score, score->over_time());
  Shared shared;
  for (const auto& [score, running] : running_) running.take(frame, shared);
}

std::vector<Scored> ClipScores::finish() const {
  std::vector<Scored> out;
  for (const auto& [score, running] : running_) out.push_back({score, without_nan(running.finish())});
  return out;
}

std::string value_text(const Score& score, const std::optional<double>& value) {
  if (!value) return "-";
  if (std::isinf(*value)) return *value > 0 ? "inf" : "-inf";
  return fmt::format("{:.{}f}", *value, score.digits);
}

namespace {

// "; pixels (5, 5) to (314, 234)" of a map that does not begin at the picture's corner.
std::string place_text(const ScoreMap& map) {
  if (map.left == 0 && map.top == 0) return {};
  return fmt::format("; pixels ({}, {}) to ({}, {})", map.left, map.top, map.left + map.values.width - 1,
                     map.top + map.values.height - 1);
}

// "; 1.2 % of pixels beyond the bar"
std::string beyond_text(const ScoreMap& map) {
  const bool rising = map.worst > map.equal;
  const auto beyond = std::count_if(map.values.data.begin(), map.values.data.end(),
                                    [&](double v) { return rising ? v > map.worst : v < map.worst; });
  if (beyond == 0) return {};
  const double share = 100 * static_cast<double>(beyond) / static_cast<double>(map.values.data.size());
  return fmt::format("; {:.2g} % of pixels beyond the bar", share);
}

Image8 painted(const ScoreMap& map, const std::string& caption, const ColourTable& table, bool bar) {
  Image8 levels(map.values.width, map.values.height, 1);
  for (size_t i = 0; i < levels.data.size(); ++i) {
    const double share = (map.values.data[i] - map.equal) / (map.worst - map.equal);
    levels.data[i] = static_cast<uint8_t>(std::isnan(share) ? 0 : std::lround(255 * std::clamp(share, 0.0, 1.0)));
  }
  const Image8 picture = pseudocolour(levels, table);
  if (!bar) return picture;
  const std::string words = caption + place_text(map) + beyond_text(map);
  return with_colour_bar(picture, words, {map.equal, map.worst, map.open}, table);
}

std::string in_unit(const std::string& unit) { return unit.empty() ? "no unit" : unit; }

}  // namespace

Image8 map_picture(const Score& score, const ScoreResult& result, MapColours colours) {
  assert(result.map);
  const ColourTable& table = colours == MapColours::error                   ? error_colours()
                             : colours == MapColours::magma                 ? magma_colours()
                             : colours == MapColours::viridis               ? viridis_colours()
                             : score.colours != nullptr /* own and plain */ ? score.colours()
                                                                            : error_colours();
  std::string caption = fmt::format("{} by pixel ({})", score.title, in_unit(result.map->unit));
  if (result.value)
    caption +=
        fmt::format("; score {}{}{}", value_text(score, result.value), score.unit.empty() ? "" : " ", score.unit);
  return painted(*result.map, caption, table, colours != MapColours::plain);
}

Image8 drawing_picture(const ScoreDrawing& drawing, MapColours colours) {
  return painted(drawing.map, fmt::format("{} ({})", drawing.title, in_unit(drawing.map.unit)), *drawing.colours,
                 colours != MapColours::plain);
}

std::optional<double> mean_over(const Plane& map, int left, int top, const AgentPixels& agent) {
  double sum = 0;
  uint64_t count = 0;
  for (const auto& [x, y] : agent.pixels) {
    const int u = x - left;
    const int v = y - top;
    if (u < 0 || v < 0 || u >= map.width || v >= map.height || std::isnan(*map.at(u, v))) continue;
    sum += *map.at(u, v);
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / static_cast<double>(count);
}

std::string scores_markdown(ScoreTable table) {
  std::string out =
      "| name | title | unit | better | range | over | needs | computes | does not exist | source |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Score* s : table)
    out += fmt::format("| `{}` | {} | {} | {} | {} to {} | {} | {} | {} | {} | {} |\n", s->name, s->title, s->unit,
                       s->direction == Direction::higher_is_better ? "higher" : "lower", range_end(s->least),
                       range_end(s->greatest), s->scope == Scope::region ? "region" : "picture", needs_text(s->needs),
                       s->computes, s->absence, s->source);
  return out +
         "\nOf a clip, a score over successive frames pools as its source says. Every other is the mean over the "
         "frames "
         "that have a finite value, and so is each of its further figures but `min`, the least of all frames, and "
         "`max`, the greatest. A frame that has no value is null in `by_frame`, and counts for nothing; but where a "
         "frame has none because pixels are not numbers or infinite, the clip has none either, and the reason says in "
         "how many frames and where the first is.\n";
}

}  // namespace crowdbench::metrics
