// Shards of a plan put together.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "store/store.h"

namespace crowdbench::bench::sweep {

struct MergeRequest {
  std::filesystem::path out;
  std::vector<std::filesystem::path> shards;
  bool mixed = false;          // of different programs or drivers too
  bool allow_missing = false;  // shards, or conditions of them
};
struct MergeOutcome {
  StoreContents contents;            // as written, without samples and pictures
  std::vector<std::string> remarks;  // what is missing or mixed, where that was allowed
};

// Not every shard is there, or not every condition of one: more data is needed.
struct MissingShards {
  std::string what;
};

// Writes one file with the rows of all shards, conditions in the order of the plan, so that it holds the same whatever
// number of shards they come from; a file that is there is replaced. Times stay with the run that they are of: nothing
// is computed across shards. Throws Error: shards of different plans or cut differently, one twice, of different
// programs or drivers (unless `mixed`), not a shard; and MissingShards (unless `allow_missing`).
MergeOutcome merge_shards(const MergeRequest& request);

}  // namespace crowdbench::bench::sweep
