// One frame of a crowd, scored agent by agent through the id buffers.
#pragma once
#include <optional>
#include <vector>

#include "metrics/ssim.h"

namespace crowdbench::metrics {

// Over the pixels that carry the agent's id in the reference or in the test (`union`).
struct AgentScore {
  uint32_t id = 0;  // as in the buffers: agent index + 1
  uint64_t pixels_ref = 0;
  uint64_t pixels_test = 0;
  uint64_t pixels_both = 0;
  double iou = 0;   // pixels_both / union; 1 = the same pixels
  double mae = 0;   // code values, as difference()
  double mse = 0;   // code values squared
  double psnr = 0;  // dB, +infinity when equal
  // Mean of the picture's SSIM map over the union; windows reach 5 pixels beyond it. Empty when no pixel of the union
  // is at least 5 pixels from the picture's edge.
  std::optional<double> ssim_union;
  // Mean absolute difference of linear depth over the pixels that carry the id in both, metres. Empty without depths or
  // without such pixels.
  std::optional<double> depth_mae;
};

struct Depths {
  const ImageF* reference = nullptr;  // one channel, eye-space metres, +infinity where empty
  const ImageF* test = nullptr;
};

// By ascending id; ids that are in neither buffer are left out, 0 is the background. Ids may be any 32-bit numbers.
// similarity: ssim() of the two pictures' luma, where the caller has it; computed otherwise. Throws Error when any two
// sizes differ.
std::vector<AgentScore> score_agents(const Image8& reference, const Image8& test, const ImageU32& reference_ids,
                                     const ImageU32& test_ids, const Depths& depths = {},
                                     const Ssim* similarity = nullptr);

}  // namespace crowdbench::metrics
