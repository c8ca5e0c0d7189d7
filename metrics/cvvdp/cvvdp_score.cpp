// ColorVideoVDP as a score of the table.
#include <fmt/format.h>

#include <limits>
#include <memory>

#include "metrics/cvvdp/cvvdp.h"
#include "metrics/registry.h"

namespace crowdbench::metrics {
namespace {

constexpr std::string_view kNoPictures = "neither code values nor floats are given for both pictures";
constexpr std::string_view kNotLinear =
    "float pictures are light, which only a display with a linear colour space takes as it is (standard_hdr_linear)";

struct Colours {
  const Image8 *reference8 = nullptr, *test8 = nullptr;
  const Image16 *reference16 = nullptr, *test16 = nullptr;
  const ImageF *reference_f = nullptr, *test_f = nullptr;
  std::string reason;  // why there are none
};

// Code values go first: what is shown is the encoded picture. Floats are light in cd/m2, after the display's exposure.
Colours colours_of(const ScoreInput& input) {
  const Buffers& a = input.reference;
  const Buffers& b = input.test;
  Colours out;
  if (a.codes && b.codes) {
    out.reference8 = a.codes;
    out.test8 = b.codes;
    out.reason = cvvdp_obstacle(a.codes->width, a.codes->height);
  } else if (a.codes16 && b.codes16) {
    out.reference16 = a.codes16;
    out.test16 = b.codes16;
    out.reason = cvvdp_obstacle(a.codes16->width, a.codes16->height);
  } else if (a.linear && b.linear) {
    out.reference_f = a.linear;
    out.test_f = b.linear;
    const bool linear = input.display->colour_space.eotf == Eotf::linear;
    out.reason = linear ? cvvdp_obstacle(*a.linear, *b.linear) : std::string(kNotLinear);
  } else {
    out.reason = kNoPictures;
  }
  return out;
}

void take(Cvvdp& metric, const Colours& colours) {
  if (colours.reference8)
    metric.take(*colours.reference8, *colours.test8);
  else if (colours.reference16)
    metric.take(*colours.reference16, *colours.test16);
  else
    metric.take(*colours.reference_f, *colours.test_f);
}

ScoreResult result_of(const CvvdpResult& result) {
  constexpr std::array<const char*, 4> kParts = {"q_achromatic", "q_red_green", "q_violet_yellow", "q_transient"};
  ScoreResult out;
  out.value = result.jod;
  out.details = {{"q", result.q}};
  for (size_t c = 0; c < result.channel_q.size(); ++c) out.details.push_back({kParts.at(c), result.channel_q[c]});
  return out;
}

// Drawn red. There is no end to the scale; a pixel of 5 is seen at once, and few are lower.
constexpr double kWorstDrawn = 5;

ScoreMap map_of(const ImageF& jod) {
  ScoreMap out;
  out.values = Plane(jod.width, jod.height, 1);
  std::copy(jod.data.begin(), jod.data.end(), out.values.data.begin());
  out.equal = 10;
  out.worst = kWorstDrawn;
  out.open = true;
  out.unit = "JOD";
  return out;
}

// The pair's score; its map where a map or agents are asked for.
struct PairScore {
  std::string reason;
  CvvdpResult result;
  std::optional<ScoreMap> map;
};

const PairScore& pair_score(const ScoreInput& input, Shared& shared) {
  return shared.get<PairScore>([&] {
    PairScore out;
    const Colours colours = colours_of(input);
    out.reason = colours.reason;
    if (!out.reason.empty()) return out;
    CvvdpOptions options;
    if (input.maps || (given(input) & kNeedsIds) != 0)
      options.map = [&](size_t, CvvdpMap&& map) { out.map = map_of(map.jod); };
    Cvvdp metric(*input.display, options);
    take(metric, colours);
    out.result = metric.finish();
    return out;
  });
}

ScoreResult of_pictures(const ScoreInput& input, Shared& shared) {
  const PairScore& pair = pair_score(input, shared);
  if (!pair.reason.empty()) return absent(pair.reason);
  ScoreResult out = result_of(pair.result);
  if (input.maps) out.map = pair.map;
  return out;
}

std::optional<double> of_agent(const ScoreInput& input, Shared& shared, const AgentPixels& agent) {
  const PairScore& pair = pair_score(input, shared);
  if (!pair.map) return std::nullopt;
  return mean_over(pair.map->values, 0, 0, agent);
}

// A clip. Its map is that of the frame with the largest difference.
class ClipScore {
 public:
  void take(const ScoreInput& input) {
    if (!reason_.empty()) return;
    const Colours colours = colours_of(input);
    if (!colours.reason.empty())
      reason_ = fmt::format("frame {}: {}", metric_ ? metric_->frames() : 0, colours.reason);
    else if (metric_ && input.fps <= 0)
      reason_ = "the frame rate is not given";
    if (!reason_.empty()) return;
    if (!metric_) begin(input);
    metrics::take(*metric_, colours);
  }

  ScoreResult finish() {
    if (!reason_.empty()) return absent(reason_);
    if (!finished_) {
      const CvvdpResult result = metric_->finish();
      finished_ = result_of(result);
      for (const double q : result.frame_q) finished_->by_frame.push_back(cvvdp_jod(result.still ? result.q : q));
      if (worst_) finished_->map = map_of(worst_->jod);
    }
    return *finished_;
  }

 private:
  void begin(const ScoreInput& input) {
    CvvdpOptions options;
    options.fps = input.fps;
    options.padding = input.padding;
    if (input.maps)
      options.map = [this](size_t, CvvdpMap&& map) {
        if (!worst_ || map.q > worst_->q) worst_ = std::move(map);
      };
    metric_.emplace(*input.display, options);
  }

  std::optional<Cvvdp> metric_;
  std::optional<CvvdpMap> worst_;
  std::optional<ScoreResult> finished_;
  std::string reason_;
};

FrameScore over_time() {
  auto clip = std::make_shared<ClipScore>();
  return {[clip](const ScoreInput& input, Shared&) { clip->take(input); }, [clip] { return clip->finish(); }};
}

}  // namespace

extern const Score score_cvvdp = {
    .name = "cvvdp",
    .title = "ColorVideoVDP",
    .column = "CVVDP",
    .unit = "JOD",
    .direction = Direction::higher_is_better,
    .digits = 3,
    .least = -std::numeric_limits<double>::infinity(),
    .greatest = 10,
    .threshold = 9.5,
    .needs = kNeedsDisplay,
    .uses = kInTables,
    .computes =
        "visible differences by band of spatial frequency, opponent channel and (in a clip) time, pooled; 10 less "
        "their just-objectionable differences. Of an agent: the mean of the map over its pixels",
    .source = "Mantiuk et al. 2024, ColorVideoVDP 0.5.6",
    .absence =
        "a side is below 2 pixels, a value is not finite, float pictures on a display that is not linear, or a clip "
        "without its frame rate",
    .map_file = "cvvdp_map",
    .compute = of_pictures,
    .over_time = over_time,
    .by_agent = of_agent,
};

}  // namespace crowdbench::metrics
