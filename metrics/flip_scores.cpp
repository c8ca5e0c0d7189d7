#include <fmt/format.h>

#include <algorithm>

#include "metrics/flip.h"
#include "metrics/hdr_flip.h"
#include "metrics/intermediates.h"

namespace crowdbench::metrics {
namespace {

struct FlipOfCodes {
  ImageF map;
};
struct HdrFlipOfFloats {
  HdrFlip of;
};

constexpr std::string_view kTooFewPixels = "less than one pixel of the display is in a degree";
constexpr std::string_view kNoExposure =
    "the reference's median luminance is 0, the exposures would start above where they stop, or a pixel is not finite";

// The display that somebody chose; nullptr: FLIP's own default.
const Display* display_of(const ScoreInput& input) { return input.display_is_default ? nullptr : input.display; }

FlipSettings settings_of(const ScoreInput& input) {
  FlipSettings settings;
  if (const Display* display = display_of(input)) settings.pixels_per_degree = display->pixels_per_degree;
  return settings;
}

std::string conditions_of(const ScoreInput& input) {
  return fmt::format("{:.4f} pixels/degree{}", settings_of(input).pixels_per_degree,
                     display_of(input) ? "" : ", FLIP's own default");
}

bool too_few_pixels(const ScoreInput& input) { return settings_of(input).pixels_per_degree < 1; }

const ImageF& flip_of_codes(const ScoreInput& input, Shared& shared) {
  return shared
      .get<FlipOfCodes>([&] {
        const FlipSettings settings = settings_of(input);
        return FlipOfCodes{input.reference.codes && input.test.codes
                               ? flip_map(*input.reference.codes, *input.test.codes, settings)
                               : flip_map(*input.reference.codes16, *input.test.codes16, settings)};
      })
      .map;
}

const HdrFlip& hdr_flip_of(const ScoreInput& input, Shared& shared) {
  return shared
      .get<HdrFlipOfFloats>([&] {
        HdrFlipSettings settings;
        settings.flip = settings_of(input);
        return HdrFlipOfFloats{hdr_flip(*input.reference.linear, *input.test.linear, settings)};
      })
      .of;
}

ScoreMap map_of(const ImageF& errors) {
  ScoreMap map;
  map.values = Plane(errors.width, errors.height, 1);
  std::copy(errors.data.begin(), errors.data.end(), map.values.data.begin());
  return map;
}

ScoreResult result_of(const ImageF& errors, const ScoreInput& input) {
  const FlipPooled pooled = flip_pooled(errors);
  ScoreResult result;
  result.conditions = conditions_of(input);
  result.value = pooled.mean;
  result.pooled = {
      {"mean", pooled.mean}, {"weighted_median", pooled.weighted_median}, {"q1", pooled.q1},
      {"q3", pooled.q3},     {"min", pooled.min, OverFrames::least},      {"max", pooled.max, OverFrames::greatest}};
  if (input.maps) result.map = map_of(errors);
  return result;
}

std::optional<double> mean_of_agent(const ImageF& errors, const AgentPixels& agent) {
  double sum = 0;
  for (const auto& [x, y] : agent.pixels) sum += *errors.at(x, y);
  return sum / static_cast<double>(agent.pixels.size());
}

// The exposure at which each pixel's error is greatest.
ScoreDrawing exposures_of(const HdrFlip& errors) {
  ScoreDrawing out{"hdr_flip_exposures", "exposure of the greatest FLIP", map_of(errors.exposure), &viridis_colours()};
  const ExposureRange& range = errors.range;
  for (double& place : out.map.values.data) place = range.start + place * (range.stop - range.start);
  out.map.equal = range.start;
  // One exposure twice is still a range to colour.
  out.map.worst = range.stop > range.start ? range.stop : range.start + 1;
  out.map.unit = "stops";
  return out;
}

ScoreResult flip(const ScoreInput& input, Shared& shared) {
  if (too_few_pixels(input)) return absent(std::string(kTooFewPixels));
  return result_of(flip_of_codes(input, shared), input);
}

ScoreResult hdr_flip_score(const ScoreInput& input, Shared& shared) {
  if (too_few_pixels(input)) return absent(std::string(kTooFewPixels));
  if (const std::string& reason = not_finite_reason(input, shared); !reason.empty()) return absent_not_finite(reason);
  const HdrFlip& errors = hdr_flip_of(input, shared);
  if (!errors.range.reason.empty()) return absent(errors.range.reason);
  ScoreResult result = result_of(errors.map, input);
  result.conditions += fmt::format(", tone mapped by ACES, {} exposures of {:.4f} to {:.4f}", errors.range.exposures,
                                   errors.range.start, errors.range.stop);
  result.details = {{"start_exposure", errors.range.start},
                    {"stop_exposure", errors.range.stop},
                    {"exposures", static_cast<double>(errors.range.exposures)}};
  if (input.maps) result.drawings.push_back(exposures_of(errors));
  return result;
}

}  // namespace

extern const Score score_flip = {
    .name = "flip",
    .title = "FLIP",
    .column = "FLIP",
    .unit = "",
    .direction = Direction::lower_is_better,
    .digits = 4,
    .least = 0,
    .greatest = 1,
    .needs = kNeedsCodes,
    .uses = kInTables | kHeadline,
    .computes =
        "mean over pixels of what is seen when one flips between the pictures, at the display's pixels per "
        "degree (67.02 where none is given)",
    .source = "Andersson et al. 2020",
    .absence = kTooFewPixels,
    .map_file = "flip_map",
    .compute = flip,
    .by_agent = [](const ScoreInput& input, Shared& shared, const AgentPixels& agent) -> std::optional<double> {
      if (too_few_pixels(input)) return std::nullopt;
      return mean_of_agent(flip_of_codes(input, shared), agent);
    },
    .colours = magma_colours,
};

extern const Score score_hdr_flip = {
    .name = "hdr_flip",
    .title = "HDR-FLIP",
    .column = "HDR-FLIP",
    .unit = "",
    .direction = Direction::lower_is_better,
    .digits = 4,
    .least = 0,
    .greatest = 1,
    .needs = kNeedsLinear,
    .computes =
        "mean over pixels of the greatest flip of all exposures, tone mapped by ACES, from where the "
        "reference's greatest luminance is bright to where its median is",
    .source = "Andersson et al. 2021",
    .absence = kNoExposure,
    .map_file = "hdr_flip_map",
    .compute = hdr_flip_score,
    .by_agent = [](const ScoreInput& input, Shared& shared, const AgentPixels& agent) -> std::optional<double> {
      if (too_few_pixels(input) || !not_finite_reason(input, shared).empty()) return std::nullopt;
      const HdrFlip& errors = hdr_flip_of(input, shared);
      if (!errors.range.reason.empty()) return std::nullopt;
      return mean_of_agent(errors.map, agent);
    },
    .colours = magma_colours,
};

}  // namespace crowdbench::metrics
