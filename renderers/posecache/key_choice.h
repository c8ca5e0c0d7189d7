// Which key poses a cache of a fixed size holds: those from which most agents can be blended.
//
// The key poses of a clip lie on a circle. An agent between two neighbours is a hit when the cache holds both. So key
// poses are the nodes of a graph, agents weigh its edges, and what is sought are the nodes with the heaviest edges
// between them: hard in general, but of circles it is solved exactly (choose_exact).
#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace crowdbench::renderers {

// The key poses of one clip: first, first + 1, ... of all those of the character. Interval k lies between key pose k
// and the next; the last one's next is the first. Of a single one the interval needs that one alone.
struct KeyCircle {
  uint32_t first = 0;
  uint32_t keys = 1;
  uint32_t next(uint32_t key) const { return key + 1 == first + keys ? first : key + 1; }
};

// Where an agent lies.
struct KeyPlace {
  uint32_t key = 0;  // the interval's first key pose
  float blend = 0;   // [0, 1] of the next
};
KeyPlace key_place(const KeyCircle& circle, float phase);

struct KeyDemand {
  std::vector<KeyCircle> circles;  // one after the other
  std::vector<uint32_t> agents;    // by interval
  // By key pose: whether it is there already. One that is not counts `fresh_cost` agents less.
  std::vector<uint8_t> cached;
  double fresh_cost = 0;
};

// By key pose: whether it is chosen.
using KeySet = std::vector<uint8_t>;

// Agents that are hits.
uint64_t hits_of(const KeyDemand& demand, const KeySet& set);
// What is sought: hits, less the cost of the chosen ones that are not cached.
double value_of(const KeyDemand& demand, const KeySet& set);

// At most `most` key poses. Equal demands give equal sets.
//   greedy:  again and again the key pose, or the two of an interval, that adds most value for each place it takes; of
//            equal ones the lowest.
//   popular: those beside which most agents lie, whether their neighbours are chosen or not.
//   exact:   a set of the largest value, by dynamic programming; time grows with key poses times `most`.
KeySet choose_greedy(const KeyDemand& demand, uint32_t most);
KeySet choose_popular(const KeyDemand& demand, uint32_t most);
KeySet choose_exact(const KeyDemand& demand, uint32_t most);

enum class KeyRule : uint8_t { greedy, popular, exact };
// All that somebody needs, where they fit and cost nothing; else by the rule.
KeySet choose_keys(const KeyDemand& demand, uint32_t most, KeyRule choice);

}  // namespace crowdbench::renderers
