// The bakes of a cast: from the cache where they are there, else made and kept there, all within one budget.
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "renderers/bake/bake_cache.h"
#include "renderers/bake/bake_progress.h"
#include "renderers/representation.h"

namespace crowdbench::renderers {

// What became of one character's bake.
struct BakeRecord {
  std::string cache_key;
  bool cached = false;      // it came from the cache
  uint64_t disk_bytes = 0;  // of the cache entry, 0 when not cached
  double made_seconds = 0;  // what making it took, in this run or in the one that stored it
};
// BakeInfo but for the seconds of this run and the facts.
BakeInfo bake_info_of(std::span<const BakeRecord> records);
uint64_t disk_bytes_of(std::span<const BakeRecord> records);

// What helps a bake of `needed` bytes where `left` are left. fits: the option that would fit, as "texels=64"; empty
// where none does. otherwise: what else there is to lower.
std::string budget_advice(const std::string& fits, const std::string& otherwise, uint64_t needed, uint64_t left);
// Of a bake whose bytes grow with the square of a size from `least` on: about the largest that fits; 0: none.
int fitting_size(int size, int least, uint64_t needed, uint64_t left);

// A warning about a bake of `what`, on stderr, once a process; nothing where the text is empty.
void warn_of_bake(const std::string& what, const std::string& text);

// A line on stderr from the first call on, "LABEL: 12/306, 8 s left", where the policy asks for it. Throws Interrupted
// after Ctrl-C in any case. Of its copies the last ends the line.
BakeProgress bake_progress(const BakePolicy& policy, const std::string& label);
// With the label "baking WHAT of CHARACTER".
BakeProgress bake_progress(const BakePolicy& policy, const std::string& what, const std::string& character);

class BakeLoader {
 public:
  struct BakeMessages {
    std::string kind;    // of the cache's entries, and of errors: "flat"
    std::string what;    // on the progress line: "flat impostors"
    std::string stored;  // what the budget pays for: "tiles"
    std::string advice;  // to whoever lacks budget
  };
  BakeLoader(const BakePolicy& policy, BakeMessages messages);

  // One character's bake. deserialise: std::nullopt when the bytes are no sound bake; make(budget, progress): bakes;
  // serialise(bake) and bake.texture_bytes() are the bake's own. Throws Error when its textures are more than what is
  // left of the budget, and what `make` throws; make's progress throws Interrupted after Ctrl-C.
  template <typename Bake>
  Bake load(const std::string& character, const std::string& key,
            const std::function<std::optional<Bake>(std::span<const uint8_t>)>& deserialise,
            const std::function<Bake(uint64_t budget, const BakeProgress& progress)>& make) {
    std::optional<Bake> bake;
    BakeRecord record{.cache_key = key};
    if (const auto kept = stored(key)) {
      bake = deserialise(kept->payload);
      record.made_seconds = kept->made_seconds;
    }
    record.cached = bake.has_value();
    if (!bake) {
      const auto start = std::chrono::steady_clock::now();
      bake = make(left_, bake_progress(policy_, messages_.what, character));
      record.made_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      cache_.store(messages_.kind, key, serialise(*bake), record.made_seconds);
    }
    take(character, std::move(record), bake->texture_bytes());
    return std::move(*bake);
  }
  void warn(const std::string& text) const { warn_of_bake(messages_.what, text); }
  // One a bake loaded.
  const std::vector<BakeRecord>& records() const { return records_; }

 private:
  std::optional<StoredBake> stored(const std::string& key) const;
  void take(const std::string& character, BakeRecord record, uint64_t texture_bytes);

  BakePolicy policy_;
  BakeMessages messages_;
  BakeCache cache_;
  uint64_t left_;
  std::vector<BakeRecord> records_;
};

}  // namespace crowdbench::renderers
