#include "studies/plan/compose.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>

#include "core/error.h"
#include "core/files.h"
#include "core/progress.h"
#include "metrics/registry.h"
#include "studies/stimuli/clip.h"
#include "studies/stimuli/proof.h"
#include "studies/stimuli/stack.h"

namespace crowdbench::studies {
namespace {

namespace fs = std::filesystem;

// What a browser may differ by in each channel: its own way to RGB; another colour matrix is farther off.
constexpr int kCheckTolerance = 24;

// Reads the next frame of a half; its absence is the disk's fault.
const Image8& next_frame(ClipReader& reader, ClipReader::Frame& frame, const fs::path& file) {
  if (!reader.next(frame)) throw Error(file.string(), "ends too early", "remove it, and export again");
  return frame.rgb;
}

struct Spot {
  int x = 0, y = 0;
  std::array<int, 3> rgb{};
};

// The mean of the 5 x 5 pixels around where all are about alike: what is compared is a colour and not an edge.
std::optional<Spot> flat_spot(const Image8& image, int x, int y) {
  constexpr int kReach = 2, kAlike = 10;
  const uint8_t* const middle = image.at(x, y);
  std::array<int, 3> sum{};
  for (int dy = -kReach; dy <= kReach; ++dy)
    for (int dx = -kReach; dx <= kReach; ++dx)
      for (size_t c = 0; c < 3; ++c) {
        const int value = image.at(x + dx, y + dy)[c];
        if (std::abs(value - middle[c]) > kAlike) return std::nullopt;
        sum[c] += value;
      }
  constexpr int kCount = (2 * kReach + 1) * (2 * kReach + 1);
  return Spot{x, y, {sum[0] / kCount, sum[1] / kCount, sum[2] / kCount}};
}

int distance(const Spot& a, const Spot& b) {
  int sum = 0;
  for (size_t c = 0; c < 3; ++c) sum += (a.rgb[c] - b.rgb[c]) * (a.rgb[c] - b.rgb[c]);
  return sum;
}

// Up to six places whose colours lie far from each other, as a check of what a browser shows: each next one is the
// farthest from those before.
std::vector<Spot> check_spots(const Image8& image) {
  constexpr int kNoNews = 12 * 12;  // squared: a colour that is there already
  std::vector<Spot> all;
  for (int y = 2; y + 2 < image.height; y += 2)
    for (int x = 2; x + 2 < image.width; x += 2)
      if (const auto spot = flat_spot(image, x, y)) all.push_back(*spot);
  std::vector<int> nearest(all.size(), 1 << 30);
  std::vector<Spot> chosen;
  while (!all.empty() && chosen.size() < 6) {
    const auto farthest = std::max_element(nearest.begin(), nearest.end());
    if (*farthest < kNoNews) break;
    chosen.push_back(all[static_cast<size_t>(farthest - nearest.begin())]);
    for (size_t i = 0; i < all.size(); ++i) nearest[i] = std::min(nearest[i], distance(all[i], chosen.back()));
  }
  return chosen;
}

Json check_frame_json(size_t index, const Image8& image) {
  Json colours = Json::array();
  for (const Spot& spot : check_spots(image)) colours.push_back({{"x", spot.x}, {"y", spot.y}, {"rgb", spot.rgb}});
  return {{"index", index}, {"tolerance", kCheckTolerance}, {"colours", std::move(colours)}};
}

// "avc1.F4001E": profile, constraints and level, as the file's own avcC box has them.
std::string avc_codec(const fs::path& file) {
  const std::vector<uint8_t> bytes = read_file(file);
  static constexpr std::array<uint8_t, 4> kBox = {'a', 'v', 'c', 'C'};
  const auto box = std::search(bytes.begin(), bytes.end(), kBox.begin(), kBox.end());
  if (bytes.end() - box < 8) throw Error(file.string(), "has no avcC box", "report this build of FFmpeg");
  return fmt::format("avc1.{:02X}{:02X}{:02X}", box[5], box[6], box[7]);
}

// "vp09.01.LL.08.03.01.01.01.00": profile 1, 8 bits, 4:4:4, BT.709, limited range; the least level whose picture size
// and rate hold the clip ("VP9 levels", webmproject.org).
std::string vp9_codec(int width, int height, int fps) {
  struct Level {
    int number;
    int64_t samples, rate;
  };
  static constexpr Level kLevels[] = {{10, 36864, 829440},        {11, 73728, 2764800},      {20, 122880, 4608000},
                                      {21, 245760, 9216000},      {30, 552960, 20736000},    {31, 983040, 36864000},
                                      {40, 2228224, 83558400},    {41, 2228224, 160432128},  {50, 8912896, 311951360},
                                      {51, 8912896, 588251136},   {52, 8912896, 1176502272}, {60, 35651584, 1176502272},
                                      {61, 35651584, 2353004544}, {62, 35651584, 4706009088}};
  const int64_t samples = int64_t{width} * height;
  int number = 62;
  for (const Level& level : kLevels)
    if (level.samples >= samples && level.rate >= samples * fps) {
      number = level.number;
      break;
    }
  return fmt::format("vp09.01.{}.08.03.01.01.01.00", number);
}

StackStyle style_of(const StudyPlan& plan) {
  StackStyle style;
  style.bar_height = plan.stimulus.bar_px;
  return style;
}

// Puts the raw frames into the writer and tells the recorder what is under test in each.
class Stacker {
 public:
  Stacker(const ComposeRequest& request, const StackStyle& style)
      : request_(request), style_(style), upper_(request.upper), lower_(request.lower) {
    if (!request.twin.empty()) twin_.emplace(request.twin);
  }

  void run(ClipWriter& writer, ProofRecorder& recorder) {
    const size_t frames = request_.plan.frames();
    const bool on_top = request_.stimulus.test_on_top.value_or(true);
    // The other half is the reference of the same crowd where both halves show one.
    const bool other_is_reference = request_.twin == (on_top ? request_.lower : request_.upper);
    Progress progress("stacking " + request_.stimulus.id, frames);
    for (size_t f = 0; f < frames; ++f) {
      const Image8& upper = next_frame(upper_, upper_frame_, request_.upper);
      const Image8& lower = next_frame(lower_, lower_frame_, request_.lower);
      equal = equal && upper == lower;
      if (twin_)
        recorder.expect(on_top ? upper : lower, next_frame(*twin_, twin_frame_, request_.twin), on_top,
                        other_is_reference);
      else
        recorder.expect_nothing();
      const Image8 stack = stack_vertically(upper, lower, style_);
      if (f == frames / 2) check_frame = check_frame_json(f, stack);
      writer.add(stack);
      progress.advance();
    }
  }

  bool equal = true;
  Json check_frame;

 private:
  const ComposeRequest& request_;
  StackStyle style_;
  ClipReader upper_, lower_;
  std::optional<ClipReader> twin_;
  ClipReader::Frame upper_frame_, lower_frame_, twin_frame_;
};

[[noreturn]] void refuse_clip(const ComposeRequest& request, const Clip& clip, const ProofRecorder& recorder) {
  const StudyCondition& condition = request.plan.conditions[request.stimulus.condition];
  const ClipFile& file = clip.files.back();
  const std::string why = recorder.refusal();
  throw Error(request.plan.where,
              fmt::format("{}: {} even at rate factor {}: {}", condition.name, file.codec, file.crf.value_or(0),
                          why.empty() ? fmt::format("decoded frame {} is at {:.2f} dB", file.error.worst_frame,
                                                    file.error.psnr_worst_frame)
                                      : why),
              why.empty() ? "lower [stimulus] `least_psnr`" : "show the figures larger, or another level");
}

Json source_json(const ClipFile& file, const Clip& clip) {
  const bool webm = file.codec == "vp9";
  return {{"src", "clips/" + file.path.filename().string()},
          {"type", fmt::format("video/{}; codecs=\"{}\"", webm ? "webm" : "mp4",
                               webm ? vp9_codec(clip.width, clip.height, clip.fps) : avc_codec(file.path))},
          {"sha256", file.sha256}};
}

// The worst pixel of a map, in the picture.
std::optional<std::pair<int, int>> worst_pixel(const metrics::ScoreMap& map) {
  std::optional<std::pair<int, int>> worst;
  double most = -1;
  for (int y = 0; y < map.values.height; ++y)
    for (int x = 0; x < map.values.width; ++x) {
      const double off = std::abs(*map.values.at(x, y) - map.equal);
      if (!(off > most)) continue;
      most = off;
      worst = {map.left + x, map.top + y};
    }
  return worst;
}

struct ScoreSum {
  const metrics::Score* score = nullptr;
  double sum = 0;
  size_t count = 0;
  double worst = 0;
  size_t worst_frame = 0;
  std::optional<std::pair<int, int>> place;

  void take(const metrics::ScoreResult& result, size_t frame) {
    if (!result.value || !std::isfinite(*result.value)) return;
    if (count == 0 || metrics::is_worse(*score, *result.value, worst)) {
      worst = *result.value;
      worst_frame = frame;
      place = result.map ? worst_pixel(*result.map) : std::nullopt;
    }
    sum += *result.value;
    ++count;
  }
  Json json() const {
    return {{"score", score->name},
            {"unit", score->unit},
            {"frames", count},
            {"mean", sum / static_cast<double>(count)},
            {"worst", worst},
            {"worst_frame", worst_frame},
            {"x", place ? Json(place->first) : Json()},
            {"y", place ? Json(place->second) : Json()}};
  }
};

std::vector<const metrics::Score*> scores_of_stimuli() {
  std::vector<const metrics::Score*> out;
  for (const metrics::Score* const score : metrics::scores())
    if ((score->uses & (metrics::kInTables | metrics::kHeadline)) != 0 && score->compute != nullptr)
      out.push_back(score);
  return out;
}

}  // namespace

Composed compose_stimulus(const ComposeRequest& request) {
  const StudyPlan& plan = request.plan;
  const scene::Scenario& scenario = plan.conditions[request.stimulus.condition].scenario;
  const StackStyle style = style_of(plan);
  const StackSize size = stack_size(scenario.width, scenario.height, style);
  ProofRecorder recorder(size.width, scenario.height, style, plan.stimulus.artefact_share);
  ClipSettings settings;
  settings.fps = plan.stimulus.fps;
  settings.least_psnr = plan.stimulus.least_psnr;
  settings.webm = request.webm;
  settings.check = recorder.check();
  std::vector<ClipProof> proofs;  // one an attempt
  settings.check.missing_db = [&proofs, &recorder, missing = settings.check.missing_db] {
    const double db = missing();
    proofs.push_back(recorder.proof());
    return db;
  };
  ClipWriter writer(request.out / "page" / "clips" / (request.stimulus.id + ".mp4"), size.width, size.height, settings);
  Stacker stacker(request, style);
  stacker.run(writer, recorder);
  const Clip clip = writer.finish();
  if (!clip.accurate) refuse_clip(request, clip, recorder);

  Composed out;
  Json sources = Json::array();
  for (const ClipFile& file : clip.files) {
    out.files.push_back({"page/clips/" + file.path.filename().string(), file.sha256});
    sources.push_back(source_json(file, clip));
  }
  out.facts["files"] = std::move(sources);
  out.facts["check_frame"] = stacker.check_frame;
  out.facts["equal"] = stacker.equal;
  out.facts["proof"] = Json::object();
  for (size_t i = 0; i < proofs.size(); ++i) out.facts["proof"][clip.attempts[i].codec] = proof_json(proofs[i]);
  out.facts["video"] = clip_json(clip);
  return out;
}

Json score_halves(const fs::path& test, const fs::path& reference, size_t every,
                  const metrics::ChosenDisplay& display) {
  const std::vector<const metrics::Score*> scores = scores_of_stimuli();
  std::vector<ScoreSum> sums(scores.size());
  for (size_t i = 0; i < scores.size(); ++i) sums[i].score = scores[i];
  ClipReader of_test(test);
  ClipReader of_reference(reference);
  ClipReader::Frame a;
  ClipReader::Frame b;
  for (size_t f = 0; of_test.next(a) && of_reference.next(b); ++f) {
    if (f % every != 0) continue;
    throw_if_interrupted();
    metrics::ScoreInput input;
    input.test.codes = &a.rgb;
    input.reference.codes = &b.rgb;
    input.maps = true;
    metrics::look_at(display, input);
    metrics::Shared shared;
    for (const metrics::Scored& scored : metrics::score_pictures(scores, input, shared))
      for (ScoreSum& sum : sums)
        if (sum.score == scored.score) sum.take(scored.result, f);
  }
  Json out = Json::array();
  for (const ScoreSum& sum : sums)
    if (sum.count > 0) out.push_back(sum.json());
  return out;
}

}  // namespace crowdbench::studies
