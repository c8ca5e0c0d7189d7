// How far scores agree about the same pictures: rank correlations over the comparisons of result files, and the
// pictures about whose order two scores disagree most. Pure functions of the rows.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/rank_correlation.h"
#include "metrics/registry.h"
#include "store/rows.h"

namespace crowdbench::bench {

// Two comparisons of one height that two scores put in opposite order.
struct Disagreement {
  size_t first = 0, second = 0;  // into the rows: the first score holds `first` for the better, the other `second`
  // How far apart each score puts them: the share of the rows of that height whose ranks lie between, [0, 1].
  double gap_a = 0, gap_b = 0;
};

struct ScorePair {
  size_t a = 0, b = 0;  // into ScoreAgreements::scores, a before b
  RankAgreement ranks;  // of "how good": +1 where both put all rows in one order, whichever end of a score is good
  std::optional<Disagreement> worst;  // where the smaller of both gaps is greatest; nothing: they never disagree
};

struct ScoreAgreements {
  std::vector<const metrics::Score*> scores;               // with values in at least two rows, in the table's order
  std::vector<const ComparisonRow*> rows;                  // that were looked at
  std::vector<std::vector<std::optional<double>>> values;  // by score and row
  std::vector<ScorePair> pairs;                            // every two scores
  size_t groups = 0;  // a character drawn by a representation: the bootstrap draws them whole
};

// Rows of kind "agent" that are of these scores; where a view was scored several times (the same representation,
// character, height, direction, clip, moment and display) its latest counts. The contents must outlive what comes back.
ScoreAgreements agreements_of(const StoreContents& contents, metrics::ScoreTable table, uint64_t seed);

const ScorePair& pair_of(const ScoreAgreements& all, size_t a, size_t b);  // in either order, a != b

// The pairs that disagree most, by the smaller gap; at most so many.
std::vector<const ScorePair*> worst_pairs(const ScoreAgreements& all, size_t most);

}  // namespace crowdbench::bench
