#include "bench/experiments/score_agreement.h"

#include <algorithm>
#include <cassert>
#include <map>
#include <tuple>

#include "core/parallel.h"
#include "core/progress.h"

namespace crowdbench::bench {
namespace {

using Values = std::vector<std::optional<double>>;

std::vector<const ComparisonRow*> latest_rows(const StoreContents& contents) {
  std::map<std::tuple<std::string, std::string, double, double, double, std::string, double, std::string>, size_t>
      places;
  std::vector<const ComparisonRow*> rows;
  for (const ComparisonRow& row : contents.comparisons) {
    if (row.kind != "agent") continue;
    const auto [place, fresh] =
        places.try_emplace({row.representation, row.character, row.height_px.value_or(0), row.azimuth_deg.value_or(0),
                            row.elevation_deg.value_or(0), row.clip, row.time.value_or(0), row.display.value_or("")},
                           rows.size());
    if (fresh)
      rows.push_back(&row);
    else
      rows[place->second] = &row;
  }
  return rows;
}

Values values_of(const std::vector<const ComparisonRow*>& rows, const metrics::Score& score) {
  Values values(rows.size());
  for (size_t i = 0; i < rows.size(); ++i)
    for (const ScoreRow& one : rows[i]->scores)
      if (one.name == score.name) values[i] = one.value;
  return values;
}

// Greater is better, whatever the score's direction.
double goodness(const metrics::Score& score, double value) {
  return score.direction == metrics::Direction::higher_is_better ? value : -value;
}

// A number for each character drawn by a representation.
std::vector<uint32_t> groups_of(const std::vector<const ComparisonRow*>& rows) {
  std::map<std::pair<std::string, std::string>, uint32_t> numbers;
  std::vector<uint32_t> groups;
  for (const ComparisonRow* row : rows)
    groups.push_back(numbers.try_emplace({row->character, row->representation}, static_cast<uint32_t>(numbers.size()))
                         .first->second);
  return groups;
}

// Rows that have both scores.
struct Shared {
  std::vector<size_t> rows;
  std::vector<double> a, b;
  std::vector<uint32_t> groups;
};

Shared shared_of(const ScoreAgreements& all, size_t a, size_t b, const std::vector<uint32_t>& groups) {
  Shared out;
  for (size_t i = 0; i < all.rows.size(); ++i) {
    if (!all.values[a][i] || !all.values[b][i]) continue;
    out.rows.push_back(i);
    out.a.push_back(goodness(*all.scores[a], *all.values[a][i]));
    out.b.push_back(goodness(*all.scores[b], *all.values[b][i]));
    out.groups.push_back(groups[i]);
  }
  return out;
}

// Of the rows of one height: places into `shared`.
void look_for_worst(const Shared& shared, const std::vector<size_t>& places, std::optional<Disagreement>& worst) {
  std::vector<double> a;
  std::vector<double> b;
  for (const size_t p : places) {
    a.push_back(shared.a[p]);
    b.push_back(shared.b[p]);
  }
  const std::vector<double> rank_a = ranks_of(a);
  const std::vector<double> rank_b = ranks_of(b);
  const auto span = static_cast<double>(std::max<size_t>(places.size(), 2) - 1);
  for (size_t i = 0; i < places.size(); ++i)
    for (size_t j = 0; j < places.size(); ++j) {
      const double gap_a = (rank_a[i] - rank_a[j]) / span;
      const double gap_b = (rank_b[j] - rank_b[i]) / span;
      if (gap_a <= 0 || gap_b <= 0) continue;
      if (worst && std::min(gap_a, gap_b) <= std::min(worst->gap_a, worst->gap_b)) continue;
      worst = Disagreement{shared.rows[places[i]], shared.rows[places[j]], gap_a, gap_b};
    }
}

std::optional<Disagreement> worst_of(const ScoreAgreements& all, const Shared& shared) {
  std::map<double, std::vector<size_t>> by_height;
  for (size_t p = 0; p < shared.rows.size(); ++p)
    by_height[all.rows[shared.rows[p]]->height_px.value_or(0)].push_back(p);
  std::optional<Disagreement> worst;
  for (const auto& [height, places] : by_height) look_for_worst(shared, places, worst);
  return worst;
}

double smaller_gap(const ScorePair& pair) { return pair.worst ? std::min(pair.worst->gap_a, pair.worst->gap_b) : 0; }

}  // namespace

ScoreAgreements agreements_of(const StoreContents& contents, metrics::ScoreTable table, uint64_t seed) {
  ScoreAgreements all;
  all.rows = latest_rows(contents);
  for (const metrics::Score* score : table) {
    Values values = values_of(all.rows, *score);
    if (std::count_if(values.begin(), values.end(), [](const auto& v) { return v.has_value(); }) < 2) continue;
    all.scores.push_back(score);
    all.values.push_back(std::move(values));
  }
  const std::vector<uint32_t> groups = groups_of(all.rows);
  all.groups = groups.empty() ? 0 : *std::max_element(groups.begin(), groups.end()) + size_t{1};
  for (size_t a = 0; a < all.scores.size(); ++a)
    for (size_t b = a + 1; b < all.scores.size(); ++b) all.pairs.push_back({a, b, {}, {}});
  Progress progress("correlating", all.pairs.size());
  const auto correlate = [&](size_t p) {
    throw_if_interrupted();
    ScorePair& pair = all.pairs[p];
    const Shared shared = shared_of(all, pair.a, pair.b, groups);
    pair.ranks = rank_agreement(shared.a, shared.b, shared.groups, seed);
    pair.worst = worst_of(all, shared);
  };
  parallel_for(all.pairs.size(), 0, correlate, [&](size_t done) { progress.set_done(done); });
  return all;
}

const ScorePair& pair_of(const ScoreAgreements& all, size_t a, size_t b) {
  const auto found = std::find_if(all.pairs.begin(), all.pairs.end(), [&](const ScorePair& pair) {
    return pair.a == std::min(a, b) && pair.b == std::max(a, b);
  });
  assert(found != all.pairs.end());
  return *found;
}

std::vector<const ScorePair*> worst_pairs(const ScoreAgreements& all, size_t most) {
  std::vector<const ScorePair*> out;
  for (const ScorePair& pair : all.pairs)
    if (pair.worst) out.push_back(&pair);
  std::stable_sort(out.begin(), out.end(),
                   [](const ScorePair* x, const ScorePair* y) { return smaller_gap(*x) > smaller_gap(*y); });
  if (out.size() > most) out.resize(most);
  return out;
}

}  // namespace crowdbench::bench
