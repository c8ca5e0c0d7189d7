// Differs from a score of two pictures: what is scored is a change. |(T[t] - T[t-1]) - (H[t] - T[t-1])| is |T[t] -
// H[t]|; a difference of two magnitudes of change (`pop_excess`) can be 0 or below where a switch is plain to see,
// because the switch may happen to hide motion.
#include "metrics/popping.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "metrics/cvvdp/cvvdp.h"
#include "metrics/flip.h"
#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

// Places in kPopScores.
enum Place : uint8_t { kCvvdpStay, kFlip, kLuma, kCvvdp, kExcess, kFlipExcess };

constexpr std::array<PopScore, 6> kPopScores = {{
    {"pop_cvvdp_stay", "ColorVideoVDP across the switch, frame t staying for a quarter of a second", "CVVDP", "JOD",
     Direction::higher_is_better, 3, 10,
     "ColorVideoVDP (a clip at the frame rate, at the display) over the box: T[t-1], then T[t] for 1/4 s, against "
     "T[t-1], then H[t] for 1/4 s: what has switched stays so, and the metric's memory is as long"},
    {"pop_flip", "FLIP of the switch", "FLIP", "", Direction::lower_is_better, 4, 0,
     "mean over the agent's pixels of FLIP between the frame with the switch and the frame without"},
    {"pop_luma", "luma of the switch", "luma", "code values", Direction::lower_is_better, 2, 0,
     "mean over the agent's pixels of |(T[t] - T[t-1]) - (H[t] - T[t-1])|, BT.601 luma; 0..255"},
    {"pop_cvvdp", "ColorVideoVDP of the two frames alone", "2 frames", "JOD", Direction::higher_is_better, 4, 10,
     "ColorVideoVDP of the clip of T[t-1] and T[t] against the clip of T[t-1] and H[t]; near 10 throughout, for it "
     "ends "
     "with the switch"},
    {"pop_excess", "change of luma beyond the motion's", "excess", "code values", Direction::lower_is_better, 2, 0,
     "mean over the agent's pixels of |T[t] - T[t-1]| - |H[t] - T[t-1]|, BT.601 luma; -255..255; may be 0 though the "
     "switch is seen"},
    {"pop_flip_excess", "FLIP beyond the motion's", "FLIP exc.", "", Direction::lower_is_better, 4, 0,
     "mean over the agent's pixels of FLIP from T[t-1] to T[t] less FLIP from T[t-1] to H[t]; -1..1"},
}};

double mean_of(const ImageF& map, const Mask& mask) {
  double sum = 0;
  uint64_t count = 0;
  for (size_t i = 0; i < map.data.size(); ++i)
    if (mask.data[i] != 0) {
      sum += static_cast<double>(map.data[i]);
      ++count;
    }
  return sum / static_cast<double>(count);
}

Mask mask_of_id(const ImageU32& shown, const ImageU32& held, uint32_t id) {
  Mask mask(shown.width, shown.height, 1);
  for (size_t i = 0; i < mask.data.size(); ++i) mask.data[i] = shown.data[i] == id || held.data[i] == id ? 255 : 0;
  return mask;
}

// The box's pixels.
struct Cut {
  Image8 before, shown, held;
  Mask mask;
};

void score_luma(const Cut& cut, Pop& pop) {
  const Plane before = luma601(cut.before);
  const Plane shown = luma601(cut.shown);
  const Plane held = luma601(cut.held);
  double apart = 0;
  double excess = 0;
  for (size_t i = 0; i < before.data.size(); ++i) {
    if (cut.mask.data[i] == 0) continue;
    const double with = shown.data[i] - before.data[i];
    const double without = held.data[i] - before.data[i];
    apart += std::abs(with - without);
    excess += std::abs(with) - std::abs(without);
  }
  pop.values[kLuma] = apart / static_cast<double>(pop.pixels);
  pop.values[kExcess] = excess / static_cast<double>(pop.pixels);
}

void score_flip(const Cut& cut, const PopView& view, Pop& pop) {
  FlipSettings settings{.threads = view.threads};
  if (view.display && !view.display_is_default) settings.pixels_per_degree = view.display->pixels_per_degree;
  if (settings.pixels_per_degree < 1) return;
  const auto flip = [&](const Image8& a, const Image8& b) { return mean_of(flip_map(a, b, settings), cut.mask); };
  pop.values[kFlip] = flip(cut.held, cut.shown);
  pop.values[kFlipExcess] = flip(cut.before, cut.shown) - flip(cut.before, cut.held);
}

// frames: how many T[t] and H[t] are shown for.
double cvvdp_across(const Cut& cut, const PopView& view, int frames) {
  Cvvdp metric(*view.display, {.fps = view.fps, .threads = view.threads});
  metric.take(cut.before, cut.before);
  for (int f = 0; f < frames; ++f) metric.take(cut.held, cut.shown);
  return metric.finish().jod;
}

void score_cvvdp(const Cut& cut, const PopView& view, Pop& pop) {
  if (!view.display || !cvvdp_obstacle(cut.shown.width, cut.shown.height).empty()) return;
  constexpr double kStay = 0.25;  // seconds: ColorVideoVDP's temporal filters
  pop.values[kCvvdpStay] = cvvdp_across(cut, view, std::max(1, static_cast<int>(std::lround(kStay * view.fps))));
  pop.values[kCvvdp] = cvvdp_across(cut, view, 1);
}

}  // namespace

std::span<const PopScore> pop_scores() { return kPopScores; }

bool is_worse(const PopScore& score, double a, double b) {
  return score.direction == Direction::lower_is_better ? a > b : a < b;
}

std::string value_text(const PopScore& score, const std::optional<double>& value) {
  return value ? fmt::format("{:.{}f}", *value, score.digits) : "-";
}

int pop_margin(const PopView& view) {
  constexpr int kLeast = 32;
  const double degree = view.display ? view.display->pixels_per_degree : 0;
  return std::max(kLeast, static_cast<int>(std::ceil(degree / 2)));
}

std::optional<Pop> score_pop(const PopFrames& frames, uint32_t id, const PopView& view) {
  require_same_size(*frames.before, *frames.shown);
  require_same_size(*frames.before, *frames.held);
  require_same_size(*frames.before, *frames.shown_ids);
  require_same_size(*frames.before, *frames.held_ids);
  const Mask mask = mask_of_id(*frames.shown_ids, *frames.held_ids, id);
  const std::optional<Box> box = crop_box(mask, mask, pop_margin(view));
  if (!box) return std::nullopt;
  Pop pop;
  pop.box = *box;
  pop.pixels = static_cast<uint64_t>(std::count(mask.data.begin(), mask.data.end(), uint8_t{255}));
  pop.values.resize(kPopScores.size());
  const Cut cut{crop(*frames.before, *box), crop(*frames.shown, *box), crop(*frames.held, *box), crop(mask, *box)};
  score_luma(cut, pop);
  score_flip(cut, view, pop);
  score_cvvdp(cut, view, pop);
  return pop;
}

std::string pop_scores_markdown() {
  std::string out =
      "\nOf a switch (`crowdbench popping`): T[t-1] and T[t] are the frames as drawn, H[t] is frame t without the "
      "switch.\n\n| name | unit | without a switch | what is computed |\n|---|---|---|---|\n";
  for (const PopScore& score : kPopScores) {
    std::string computes(score.computes);
    for (size_t at = 0; (at = computes.find('|', at)) != std::string::npos; at += 2) computes.insert(at, 1, '\\');
    out += fmt::format("| `{}` | {} | {:g} | {} |\n", score.name, score.unit, score.equal, computes);
  }
  return out;
}

}  // namespace crowdbench::metrics
