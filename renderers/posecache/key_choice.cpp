// Based on: W. Lister, R. G. Laycock and A. M. Day, "A key-pose caching system for rendering an animated crowd in
// real-time" (2010), whose abstract names the problem, its hardness and a greedy algorithm. The rules here are this
// project's: README.md.
#include "renderers/posecache/key_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace crowdbench::renderers {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();

double cost_of(const KeyDemand& demand, uint32_t key) { return demand.cached[key] ? 0 : demand.fresh_cost; }

// Neighbours on the circles, and what adding a key pose to a set gains.
class Greedy {
 public:
  explicit Greedy(const KeyDemand& demand) : demand_(demand), set_(demand.agents.size(), 0) {
    for (const KeyCircle& circle : demand.circles)
      for (uint32_t key = circle.first; key < circle.first + circle.keys; ++key) next_.push_back(circle.next(key));
    before_.resize(next_.size());
    for (uint32_t key = 0; key < next_.size(); ++key) before_[next_[key]] = key;
  }

  KeySet choose(uint32_t most) {
    for (uint32_t left = most; left > 0;) {
      Move best;
      for (uint32_t key = 0; key < set_.size(); ++key) {
        if (set_[key]) continue;
        consider(best, {key, key, gain(key), 1});
        const uint32_t other = next_[key];
        if (left < 2 || other == key || set_[other]) continue;
        double both = gain(key);
        set_[key] = 1;
        both += gain(other);
        set_[key] = 0;
        consider(best, {key, other, both, 2});
      }
      if (!(best.gain > 0)) break;
      set_[best.a] = set_[best.b] = 1;
      left -= best.places;
    }
    return set_;
  }

 private:
  struct Move {
    uint32_t a = 0, b = 0;
    double gain = 0;
    uint32_t places = 1;
  };
  static void consider(Move& best, const Move& move) {
    if (move.gain * best.places > best.gain * move.places) best = move;
  }
  double gain(uint32_t key) const {
    double agents = 0;
    if (next_[key] == key || set_[next_[key]]) agents += demand_.agents[key];
    const uint32_t before = before_[key];
    if (before != key && set_[before]) agents += demand_.agents[before];
    return agents - cost_of(demand_, key);
  }

  const KeyDemand& demand_;
  KeySet set_;
  std::vector<uint32_t> next_, before_;
};

// The best sets of one circle, by how many key poses they have.
class CircleSets {
 public:
  CircleSets(const KeyDemand& demand, const KeyCircle& circle, uint32_t most)
      : demand_(demand), circle_(circle), most_(std::min(most, circle.keys)) {
    solve(0);
    solve(1);
  }
  uint32_t most() const { return most_; }
  double value(uint32_t count) const { return std::max(ends_[0][count].value, ends_[1][count].value); }
  void mark(uint32_t count, KeySet& set) const {
    const size_t first = ends_[1][count].value > ends_[0][count].value ? 1 : 0;
    size_t chosen = ends_[first][count].chosen;
    for (uint32_t i = circle_.keys; i-- > 0;) {
      set[circle_.first + i] = static_cast<uint8_t>(chosen);
      const size_t before = from_[first][place(i, chosen, count)];
      count -= static_cast<uint32_t>(chosen);
      chosen = before;
    }
  }

 private:
  struct End {
    double value = kNever;
    size_t chosen = 0;  // of the last key pose
  };
  size_t place(uint32_t i, size_t chosen, uint32_t count) const {
    return (static_cast<size_t>(i) * 2 + chosen) * (most_ + 1) + count;
  }
  double own(uint32_t i, size_t chosen) const { return chosen ? -cost_of(demand_, circle_.first + i) : 0; }
  double between(uint32_t i, bool both) const { return both ? demand_.agents[circle_.first + i] : 0; }

  // With the first key pose chosen or not, so that the circle can be closed at the end.
  void solve(size_t first) {
    const size_t width = most_ + 1;
    std::vector<double> now(2 * width, kNever);
    from_[first].assign(2 * width * circle_.keys, 0);
    if (first <= most_) now[first * width + first] = own(0, first);
    for (uint32_t i = 1; i < circle_.keys; ++i) {
      std::vector<double> then(2 * width, kNever);
      for (size_t chosen = 0; chosen < 2; ++chosen)
        for (uint32_t count = static_cast<uint32_t>(chosen); count <= most_; ++count)
          for (size_t before = 0; before < 2; ++before) {
            const double value =
                now[before * width + count - chosen] + between(i - 1, before && chosen) + own(i, chosen);
            if (!(value > then[chosen * width + count])) continue;
            then[chosen * width + count] = value;
            from_[first][place(i, chosen, count)] = static_cast<uint8_t>(before);
          }
      now = std::move(then);
    }
    ends_[first].resize(width);
    for (uint32_t count = 0; count <= most_; ++count)
      for (size_t chosen = 0; chosen < 2; ++chosen) {
        const double value = now[chosen * width + count] + between(circle_.keys - 1, first && chosen);
        if (value > ends_[first][count].value) ends_[first][count] = {value, chosen};
      }
  }

  const KeyDemand& demand_;
  KeyCircle circle_;
  uint32_t most_;
  std::vector<End> ends_[2];      // by whether the first key pose is chosen; by count
  std::vector<uint8_t> from_[2];  // whether the key pose before is
};

}  // namespace

KeyPlace key_place(const KeyCircle& circle, float phase) {
  const float at = phase * static_cast<float>(circle.keys);
  const auto key = std::min(static_cast<uint32_t>(std::max(at, 0.0F)), circle.keys - 1);
  return {circle.first + key, std::clamp(at - static_cast<float>(key), 0.0F, 1.0F)};
}

uint64_t hits_of(const KeyDemand& demand, const KeySet& set) {
  uint64_t hits = 0;
  for (const KeyCircle& circle : demand.circles)
    for (uint32_t key = circle.first; key < circle.first + circle.keys; ++key)
      if (set[key] && set[circle.next(key)]) hits += demand.agents[key];
  return hits;
}

double value_of(const KeyDemand& demand, const KeySet& set) {
  auto value = static_cast<double>(hits_of(demand, set));
  for (uint32_t key = 0; key < set.size(); ++key)
    if (set[key]) value -= cost_of(demand, key);
  return value;
}

KeySet choose_greedy(const KeyDemand& demand, uint32_t most) { return Greedy(demand).choose(most); }

KeySet choose_popular(const KeyDemand& demand, uint32_t most) {
  std::vector<double> beside(demand.agents.size(), 0);
  for (const KeyCircle& circle : demand.circles)
    for (uint32_t key = circle.first; key < circle.first + circle.keys; ++key) {
      beside[key] += demand.agents[key];
      if (circle.next(key) != key) beside[circle.next(key)] += demand.agents[key];
    }
  for (uint32_t key = 0; key < beside.size(); ++key) beside[key] -= cost_of(demand, key);
  std::vector<uint32_t> order(beside.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return beside[a] > beside[b]; });
  KeySet set(beside.size(), 0);
  for (size_t i = 0; i < order.size() && i < most && beside[order[i]] > 0; ++i) set[order[i]] = 1;
  return set;
}

KeySet choose_exact(const KeyDemand& demand, uint32_t most) {
  most = std::min<uint32_t>(most, static_cast<uint32_t>(demand.agents.size()));
  std::vector<CircleSets> circles;
  std::vector<double> best(most + 1, kNever);  // of the circles so far, by how many key poses they have
  std::vector<std::vector<uint32_t>> shares;   // by circle and count: how many of them are its own
  best[0] = 0;
  for (const KeyCircle& circle : demand.circles) {
    const CircleSets& sets = circles.emplace_back(demand, circle, most);
    std::vector<double> then(most + 1, kNever);
    std::vector<uint32_t>& share = shares.emplace_back(most + 1, 0);
    for (uint32_t count = 0; count <= most; ++count)
      for (uint32_t own = 0; own <= std::min(count, sets.most()); ++own)
        if (const double value = best[count - own] + sets.value(own); value > then[count]) {
          then[count] = value;
          share[count] = own;
        }
    best = std::move(then);
  }
  auto count = static_cast<uint32_t>(std::max_element(best.begin(), best.end()) - best.begin());
  KeySet set(demand.agents.size(), 0);
  for (size_t c = circles.size(); c-- > 0;) {
    circles[c].mark(shares[c][count], set);
    count -= shares[c][count];
  }
  return set;
}

KeySet choose_keys(const KeyDemand& demand, uint32_t most, KeyRule choice) {
  if (demand.fresh_cost == 0) {
    KeySet needed(demand.agents.size(), 0);
    for (const KeyCircle& circle : demand.circles)
      for (uint32_t key = circle.first; key < circle.first + circle.keys; ++key)
        if (demand.agents[key] > 0) needed[key] = needed[circle.next(key)] = 1;
    if (std::accumulate(needed.begin(), needed.end(), 0U) <= most) return needed;
  }
  switch (choice) {
    case KeyRule::popular: return choose_popular(demand, most);
    case KeyRule::exact: return choose_exact(demand, most);
    case KeyRule::greedy: break;
  }
  return choose_greedy(demand, most);
}

}  // namespace crowdbench::renderers
