#include "studies/stimuli/proof.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>

namespace crowdbench::studies {
namespace {

double root_mean_square(uint64_t squared, uint64_t pixels) {
  return pixels == 0 ? 0.0 : std::sqrt(static_cast<double>(squared) / (3.0 * static_cast<double>(pixels)));
}

uint64_t squared_difference(const uint8_t* a, const uint8_t* b) {
  uint64_t sum = 0;
  for (int c = 0; c < 3; ++c) sum += static_cast<uint64_t>((a[c] - b[c]) * (a[c] - b[c]));
  return sum;
}

// Decibels by which `found` must fall to reach `wanted`.
double decibels_above(double found, double wanted) { return found <= wanted ? 0 : 20 * std::log10(found / wanted); }

}  // namespace

struct ProofRecorder::State {
  int width = 0, half = 0;
  StackStyle style;
  double share = 0;
  std::vector<std::vector<uint32_t>> artefact;  // by frame: pixels of the stack
  uint64_t artefact_squared = 0, artefact_pixels = 0;
  // Of the encoding in hand.
  ClipProof proof;
  uint64_t decoded_squared = 0, whole_squared = 0, edge_squared = 0;
  uint64_t whole_pixels = 0, edge_pixels = 0;
  double worst = -1;

  void begin() {
    proof = {};
    decoded_squared = whole_squared = edge_squared = whole_pixels = edge_pixels = 0;
    worst = -1;
  }

  void take_artefact(size_t frame, const std::vector<uint8_t>& raw, const std::vector<uint8_t>& decoded) {
    uint64_t squared = 0;
    for (const uint32_t pixel : artefact[frame])
      squared += squared_difference(&raw[size_t{pixel} * 3], &decoded[size_t{pixel} * 3]);
    decoded_squared += squared;
    const double here = root_mean_square(squared, artefact[frame].size());
    if (here > worst) {
      worst = here;
      proof.worst_frame = frame;
    }
  }

  void take_row(int y, const uint8_t* raw, const uint8_t* decoded) {
    const int bar_end = half + style.bar_height;
    if (y >= half && y < bar_end) {
      const int margin = style.bar_height / 4;
      if (y < half + margin || y >= bar_end - margin) return;
      for (int x = 0; x < width; ++x)
        for (size_t c = 0; c < 3; ++c)
          proof.bar_deviation = std::max(proof.bar_deviation,
                                         std::abs(int{decoded[static_cast<size_t>(x) * 3 + c]} - style.bar_colour[c]));
      return;
    }
    uint64_t squared = 0;
    for (int x = 0; x < width; ++x) squared += squared_difference(raw + x * 3, decoded + x * 3);
    const bool edge = y >= half - kEdgeRows && y < bar_end + kEdgeRows;
    (edge ? edge_squared : whole_squared) += squared;
    (edge ? edge_pixels : whole_pixels) += static_cast<uint64_t>(width);
  }

  void end() {
    proof.artefact_pixels = artefact_pixels;
    proof.artefact_rms = root_mean_square(artefact_squared, artefact_pixels);
    proof.decoded_rms = root_mean_square(decoded_squared, artefact_pixels);
    proof.edge_rms = root_mean_square(edge_squared, edge_pixels);
    proof.whole_rms = root_mean_square(whole_squared + edge_squared, whole_pixels + edge_pixels);
  }

  double missing() const {
    const double rest = root_mean_square(whole_squared, whole_pixels);
    return std::max({artefact_pixels > 0 ? decibels_above(proof.decoded_rms, share * proof.artefact_rms) : 0.0,
                     decibels_above(proof.bar_deviation, kBarDeviation),
                     // Below half a code value a ratio of errors says nothing.
                     decibels_above(proof.edge_rms, std::max(kEdgeRatio * rest, 0.5))});
  }
};

ProofRecorder::ProofRecorder(int width, int half_height, const StackStyle& style, double share)
    : state_(std::make_unique<State>()) {
  state_->width = width;
  state_->half = half_height;
  state_->style = style;
  state_->share = share;
}

ProofRecorder::~ProofRecorder() = default;

void ProofRecorder::expect(const Image8& test, const Image8& reference, bool test_on_top, bool other_is_reference) {
  State& s = *state_;
  assert(test.width == reference.width && test.height == reference.height && test.height == s.half);
  std::vector<uint32_t> pixels;
  const int lower = s.half + s.style.bar_height;
  for (int y = 0; y < test.height; ++y)
    for (int x = 0; x < test.width; ++x) {
      const uint8_t* const a = test.at(x, y);
      const uint8_t* const b = reference.at(x, y);
      if (std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])}) <= kArtefactCodes) continue;
      const auto add = [&](int first_row) {
        pixels.push_back(static_cast<uint32_t>((first_row + y) * s.width + x));
        s.artefact_squared += squared_difference(a, b);
      };
      add(test_on_top ? 0 : lower);
      if (other_is_reference) add(test_on_top ? lower : 0);
    }
  s.artefact_pixels += pixels.size();
  s.artefact.push_back(std::move(pixels));
}

void ProofRecorder::expect_nothing() { state_->artefact.emplace_back(); }

ClipCheck ProofRecorder::check() {
  State* const s = state_.get();
  return {[s](size_t frame, const std::vector<uint8_t>& raw, const std::vector<uint8_t>& decoded) {
            assert(frame < s->artefact.size());
            if (frame == 0) s->begin();
            s->take_artefact(frame, raw, decoded);
            const size_t row = static_cast<size_t>(s->width) * 3;
            for (int y = 0; y < 2 * s->half + s->style.bar_height; ++y)
              s->take_row(y, &raw[static_cast<size_t>(y) * row], &decoded[static_cast<size_t>(y) * row]);
          },
          [s] {
            s->end();
            return s->missing();
          }};
}

const ClipProof& ProofRecorder::proof() const { return state_->proof; }

std::string ProofRecorder::refusal() const {
  const State& s = *state_;
  if (s.missing() <= 0) return {};
  const ClipProof& p = s.proof;
  if (s.artefact_pixels > 0 && p.decoded_rms > s.share * p.artefact_rms)
    return fmt::format(
        "decoding changes the {} pixels under test by {:.2f} code values, more than {:g} of the {:.2f} that are tested",
        p.artefact_pixels, p.decoded_rms, s.share, p.artefact_rms);
  if (p.bar_deviation > kBarDeviation)
    return fmt::format("the bar's middle is {} code values from its colour: one half bleeds into it", p.bar_deviation);
  return fmt::format("the rows beside the bar are {:.2f} code values off, more than {:g} times the others", p.edge_rms,
                     kEdgeRatio);
}

Json proof_json(const ClipProof& proof) {
  return {{"artefact_pixels", proof.artefact_pixels},
          {"artefact_rms", proof.artefact_rms},
          {"decoded_rms", proof.decoded_rms},
          {"share", proof.artefact_pixels == 0 ? Json() : Json(proof.decoded_rms / proof.artefact_rms)},
          {"worst_frame", proof.worst_frame},
          {"whole_rms", proof.whole_rms},
          {"edge_rms", proof.edge_rms},
          {"bar_deviation", proof.bar_deviation}};
}

}  // namespace crowdbench::studies
