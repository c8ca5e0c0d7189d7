// Based on: Williams, "Experimental designs balanced for the estimation of residual effects of treatments" (1949); the
// circle method of tournaments.
#include "studies/analysis/designs.h"

#include <algorithm>

namespace crowdbench::studies {

std::vector<std::vector<uint32_t>> williams_design(uint32_t n) {
  // Steps of 1, 2, 3, ... to and fro: every difference occurs once.
  std::vector<uint32_t> zigzag;
  for (uint32_t i = 0; i < n; ++i) zigzag.push_back(i % 2 == 1 ? (i + 1) / 2 : (n - i / 2) % n);
  std::vector<std::vector<uint32_t>> rows;
  for (uint32_t add = 0; add < n; ++add) {
    rows.push_back(zigzag);
    for (uint32_t& condition : rows.back()) condition = (condition + add) % n;
  }
  if (n % 2 == 0 || n == 1) return rows;
  // Of odd n differences d and n - d are both of one kind in these; the reversed rows hold the other.
  for (uint32_t i = 0; i < n; ++i) rows.emplace_back(rows[i].rbegin(), rows[i].rend());
  return rows;
}

std::vector<Pairs> round_robin(uint32_t n) {
  // All but the last on a circle that turns by one each round; for odd n the last is nobody.
  const uint32_t circle = n % 2 == 0 ? n - 1 : n;
  std::vector<Pairs> rounds(circle);
  for (uint32_t round = 0; round < circle; ++round) {
    for (uint32_t k = 1; 2 * k < circle + 1; ++k)
      rounds[round].emplace_back((round + k) % circle, (round + circle - k) % circle);
    if (n % 2 == 0) {
      rounds[round].emplace_back(round, n - 1);
      if (round % 2 == 1) std::swap(rounds[round].back().first, rounds[round].back().second);
    }
  }
  return rounds;
}

}  // namespace crowdbench::studies
