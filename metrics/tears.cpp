#include "metrics/tears.h"

#include <algorithm>
#include <limits>
#include <string>

#include "metrics/intermediates.h"
#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

// Whether a pixel and all of its neighbours in the picture are of the mask, or none is.
bool all_alike(const Mask& mask, int x, int y, bool covered) {
  for (int j = std::max(y - 1, 0); j <= std::min(y + 1, mask.height - 1); ++j)
    for (int i = std::max(x - 1, 0); i <= std::min(x + 1, mask.width - 1); ++i)
      if ((*mask.at(i, j) != 0) != covered) return false;
  return true;
}

constexpr std::string_view kNoSilhouette = "nothing is drawn in the reference";

// Of one input.
struct Torn {
  std::optional<Tears> of;
};

ScoreResult torn(const ScoreInput& input, Shared& shared, double Tears::*member) {
  const Torn& found = shared.get<Torn>([&] {
    const SilhouettePair& pair = silhouettes(input, shared);
    return Torn{tears(pair.reference, pair.test)};
  });
  if (!found.of) return absent(std::string(kNoSilhouette));
  ScoreResult result;
  result.value = (*found.of).*member;
  return result;
}

std::optional<double> torn_of_agent(const ScoreInput& input, const AgentPixels& agent, double Tears::*member) {
  const SilhouettePair pair = masks_of_agent(input, agent);
  const std::optional<Tears> found = tears(pair.reference, pair.test);
  return found ? std::optional((*found).*member) : std::nullopt;
}

}  // namespace

std::optional<Tears> tears(const Mask& reference, const Mask& test) {
  require_same_size(reference, test);
  size_t pixels = 0;
  size_t holes = 0;
  size_t strays = 0;
  for (int y = 0; y < reference.height; ++y)
    for (int x = 0; x < reference.width; ++x) {
      const bool inside = *reference.at(x, y) != 0;
      const bool drawn = *test.at(x, y) != 0;
      pixels += inside ? 1 : 0;
      if (inside == drawn || !all_alike(reference, x, y, inside)) continue;
      ++(inside ? holes : strays);
    }
  if (pixels == 0) return std::nullopt;
  const double per_mille = 1000.0 / static_cast<double>(pixels);
  return Tears{static_cast<double>(holes) * per_mille, static_cast<double>(strays) * per_mille};
}

extern const Score score_holes = {
    .name = "holes",
    .title = "holes",
    .column = "holes",
    .unit = "‰",
    .direction = Direction::lower_is_better,
    .digits = 2,
    .least = 0,
    .greatest = 1000,
    .needs = kNeedsIds,
    .uses = kInTables | kCharted,
    .computes =
        "pixels left empty although the reference covers them and their eight neighbours, per mille of its silhouette",
    .source = "",
    .absence = kNoSilhouette,
    .compute = [](const ScoreInput& input, Shared& shared) { return torn(input, shared, &Tears::holes); },
    .by_agent = [](const ScoreInput& input, Shared&,
                   const AgentPixels& agent) { return torn_of_agent(input, agent, &Tears::holes); },
};

extern const Score score_strays = {
    .name = "strays",
    .title = "strays",
    .column = "strays",
    .unit = "‰",
    .direction = Direction::lower_is_better,
    .digits = 2,
    .least = 0,
    .greatest = std::numeric_limits<double>::infinity(),
    .needs = kNeedsIds,
    .uses = kInTables | kCharted,
    .computes =
        "pixels drawn although the reference covers neither them nor a neighbour of the eight, per mille of its "
        "silhouette",
    .source = "",
    .absence = kNoSilhouette,
    .compute = [](const ScoreInput& input, Shared& shared) { return torn(input, shared, &Tears::strays); },
    .by_agent = [](const ScoreInput& input, Shared&,
                   const AgentPixels& agent) { return torn_of_agent(input, agent, &Tears::strays); },
};

}  // namespace crowdbench::metrics
