// Based on: S. P. Lloyd, "Least squares quantization in PCM" (1982), on sorted values, where a cluster is a run.
#include "renderers/pseudo/pose_choice.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace crowdbench::renderers {
namespace {

constexpr int kIterations = 32;  // of Lloyd's at most; a frame's phases take about ten

// Phases in ascending order from the end of the circle's largest gap on, unrolled: the circle's last ones follow the
// first by adding 1.
struct Unrolled {
  std::vector<uint32_t> agents;  // in that order
  std::vector<double> phases;
  std::vector<double> sums;  // sums[i] of phases[0 .. i - 1]
  // How many lie before a phase.
  size_t before(double phase) const {
    return static_cast<size_t>(std::lower_bound(phases.begin(), phases.end(), phase) - phases.begin());
  }
  double mean(size_t first, size_t end) const { return (sums[end] - sums[first]) / static_cast<double>(end - first); }
};

Unrolled unroll(std::span<const float> phases) {
  Unrolled out;
  const size_t n = phases.size();
  out.agents.resize(n);
  std::iota(out.agents.begin(), out.agents.end(), 0U);
  std::stable_sort(out.agents.begin(), out.agents.end(), [&](uint32_t a, uint32_t b) { return phases[a] < phases[b]; });
  size_t start = 0;
  double largest = 0;
  for (size_t i = 0; i < n; ++i) {
    const double before = i == 0 ? static_cast<double>(phases[out.agents[n - 1]]) - 1 : phases[out.agents[i - 1]];
    const double gap = phases[out.agents[i]] - before;
    if (gap > largest) {
      largest = gap;
      start = i;
    }
  }
  std::rotate(out.agents.begin(), out.agents.begin() + static_cast<ptrdiff_t>(start), out.agents.end());
  out.sums.push_back(0);
  for (size_t i = 0; i < n; ++i) {
    out.phases.push_back(static_cast<double>(phases[out.agents[i]]) + (i + start >= n ? 1 : 0));
    out.sums.push_back(out.sums.back() + out.phases.back());
  }
  return out;
}

// Where runs of one phase begin, and the end.
std::vector<size_t> runs_of_one_phase(const Unrolled& all) {
  std::vector<size_t> runs;
  for (size_t i = 0; i < all.phases.size(); ++i)
    if (i == 0 || all.phases[i] != all.phases[i - 1]) runs.push_back(i);
  runs.push_back(all.phases.size());
  return runs;
}

// Each agent to the nearest mean, until none changes.
std::vector<size_t> improved(const Unrolled& all, std::vector<size_t> runs) {
  const size_t n = all.phases.size();
  for (int i = 0; i < kIterations; ++i) {
    std::vector<size_t> next = {0};
    for (size_t k = 0; k + 2 < runs.size(); ++k) {
      const double border = 0.5 * (all.mean(runs[k], runs[k + 1]) + all.mean(runs[k + 1], runs[k + 2]));
      const size_t at = all.before(border);
      if (at > next.back()) next.push_back(at);
    }
    if (next.back() < n) next.push_back(n);
    if (next == runs) break;
    runs = std::move(next);
  }
  return runs;
}

double squared_error(const Unrolled& all, const std::vector<size_t>& runs) {
  double sum = 0;
  for (size_t k = 0; k + 1 < runs.size(); ++k) {
    const double mean = all.mean(runs[k], runs[k + 1]);
    for (size_t i = runs[k]; i < runs[k + 1]; ++i) sum += (all.phases[i] - mean) * (all.phases[i] - mean);
  }
  return sum;
}

// Runs of clusters: the better of those that begin with as many agents in each and with as wide a range in each.
std::vector<size_t> runs_of_clusters(const Unrolled& all, uint32_t poses) {
  const size_t n = all.phases.size();
  std::vector<size_t> counts = {0};
  std::vector<size_t> widths = {0};
  const double range = all.phases.back() - all.phases.front();
  for (uint32_t k = 1; k < poses; ++k) {
    counts.push_back(n * k / poses);
    const size_t at = all.before(all.phases.front() + range * k / poses);
    if (at > widths.back() && at < n) widths.push_back(at);
  }
  counts.push_back(n);
  widths.push_back(n);
  const std::vector<size_t> a = improved(all, counts);
  const std::vector<size_t> b = improved(all, widths);
  return squared_error(all, b) < squared_error(all, a) ? b : a;
}

}  // namespace

double nearest_even_phase(double phase, uint32_t poses) {
  const double count = poses;
  return std::fmod(std::floor(phase * count + 0.5), count) / count;
}

PoseChoice even_poses(std::span<const float> phases, uint32_t poses) {
  PoseChoice out;
  std::vector<uint32_t> place(poses, ~0U);  // of a phase in `out`
  for (const float phase : phases) {
    const double shown = nearest_even_phase(phase, poses);
    uint32_t& at = place[static_cast<size_t>(std::lround(shown * poses))];
    if (at == ~0U) {
      at = static_cast<uint32_t>(out.phases.size());
      out.phases.push_back(shown);
    }
    out.of.push_back(at);
  }
  return out;
}

PoseChoice clustered_poses(std::span<const float> phases, uint32_t poses) {
  PoseChoice out;
  if (phases.empty()) return out;
  const Unrolled all = unroll(phases);
  std::vector<size_t> runs = runs_of_one_phase(all);
  if (runs.size() - 1 > poses) runs = runs_of_clusters(all, poses);
  out.of.resize(phases.size());
  for (size_t k = 0; k + 1 < runs.size(); ++k) {
    // One phase is its own mean to the bit.
    const bool one = all.phases[runs[k]] == all.phases[runs[k + 1] - 1];
    const double mean = one ? all.phases[runs[k]] : all.mean(runs[k], runs[k + 1]);
    for (size_t i = runs[k]; i < runs[k + 1]; ++i) out.of[all.agents[i]] = static_cast<uint32_t>(out.phases.size());
    out.phases.push_back(mean - std::floor(mean));
  }
  return out;
}

}  // namespace crowdbench::renderers
