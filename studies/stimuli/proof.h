// The proof that a stimulus shows what it is for: what decoding changes where the difference under test is, and whether
// anything of one half reaches the other.
//
// The artefact's pixels are those where the raw half under test and the same crowd drawn by the reference differ by
// more than kArtefactCodes in a channel. Over them, and over all three channels,
//   artefact_rms  is the root mean square of (test - reference),
//   decoded_rms   that of (decoded - raw),
// and a clip is refused where decoded_rms > share * artefact_rms. A video may lie 40 dB from its frames as a whole and
// yet lose what a few pixels show.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/image.h"
#include "core/json.h"
#include "studies/stimuli/clip.h"
#include "studies/stimuli/stack.h"

namespace crowdbench::studies {

inline constexpr int kArtefactCodes = 8;   // of 255: below, dithering and rounding differ
inline constexpr int kBarDeviation = 12;   // of 255: how far the middle of the bar may lie from its colour
inline constexpr double kEdgeRatio = 2.0;  // error in the rows beside the bar over that of all others, at most
inline constexpr int kEdgeRows = 8;        // those rows, on either side

struct ClipProof {
  uint64_t artefact_pixels = 0;  // over all frames; 0: nothing under test is seen
  double artefact_rms = 0;       // code values
  double decoded_rms = 0;        // code values, at the artefact's pixels
  double whole_rms = 0;          // code values, over both halves
  double edge_rms = 0;           // code values, over the kEdgeRows rows on either side of the bar
  int bar_deviation = 0;         // largest difference from the bar's colour, in the middle half of its rows
  size_t worst_frame = 0;        // where decoded_rms of one frame is largest
};
// "artefact_pixels", ..., "share": decoded_rms / artefact_rms, null where there is no artefact.
Json proof_json(const ClipProof& proof);

class ProofRecorder {
 public:
  // half_height: rows of one half. share: see above.
  ProofRecorder(int width, int half_height, const StackStyle& style, double share);
  ~ProofRecorder();
  ProofRecorder(const ProofRecorder&) = delete;
  ProofRecorder& operator=(const ProofRecorder&) = delete;

  // The next raw frame's test half and its crowd by the reference, RGB or RGBA, and where they stand: the half under
  // test at the top (or the bottom), and whether the other half is `reference` itself, so that its pixels count too.
  void expect(const Image8& test, const Image8& reference, bool test_on_top, bool other_is_reference);
  // The next raw frame has nothing under test.
  void expect_nothing();
  // For ClipSettings::check; the recorder must outlive the writer.
  ClipCheck check();
  // Of the encoding that was checked last.
  const ClipProof& proof() const;
  // Why that encoding is refused; empty where it is not.
  std::string refusal() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace crowdbench::studies
