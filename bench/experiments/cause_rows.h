// Error by cause and switches as rows of the result store.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "bench/experiments/cause_words.h"
#include "bench/experiments/popping.h"
#include "store/rows.h"

namespace crowdbench::bench {

// What is compared with what.
struct CauseSubject {
  std::string representation, reference, character;
};
// unit: "view" or "agent", as cause_words() has it. Causes without a share in a range are left out of its shares.
std::vector<CauseRangeRow> cause_rows(int64_t run, const CauseSubject& subject, std::span<const CauseRange> ranges,
                                      const std::string& unit);

// Of one representation, the most visible switch first. display: where it is looked at, for people.
std::vector<PopRow> pop_rows(int64_t run, const std::string& representation, const std::string& character,
                             const std::string& display, const PoppingResult& result);

}  // namespace crowdbench::bench
