#include "renderers/bake/bake_loader.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <set>
#include <utility>

#include "core/error.h"
#include "core/hash.h"
#include "core/progress.h"

namespace crowdbench::renderers {

BakeInfo bake_info_of(std::span<const BakeRecord> records) {
  BakeInfo info;
  info.cached = !records.empty();
  Sha256 keys;
  for (const BakeRecord& r : records) {
    info.cached = info.cached && r.cached;
    info.made_seconds += r.made_seconds;
    keys.text(r.cache_key);
  }
  info.cache_key = records.size() == 1 ? records[0].cache_key : keys.hex();
  return info;
}

uint64_t disk_bytes_of(std::span<const BakeRecord> records) {
  uint64_t bytes = 0;
  for (const BakeRecord& r : records) bytes += r.disk_bytes;
  return bytes;
}

std::string budget_advice(const std::string& fits, const std::string& otherwise, uint64_t needed, uint64_t left) {
  constexpr uint64_t kMiB = uint64_t{1} << 20;
  return fmt::format("{}{}, or raise --bake-budget by {} MiB", fits.empty() ? "" : fits + " would fit: ", otherwise,
                     (needed - left + kMiB - 1) / kMiB);
}

int fitting_size(int size, int least, uint64_t needed, uint64_t left) {
  const auto fits = static_cast<int>(size * std::sqrt(static_cast<double>(left) / static_cast<double>(needed)));
  return fits < least ? 0 : fits;
}

BakeLoader::BakeLoader(const BakePolicy& policy, BakeMessages messages)
    : policy_(policy), messages_(std::move(messages)), cache_(bake_folder(), policy.use_cache), left_(policy.budget) {}

void warn_of_bake(const std::string& what, const std::string& text) {
  static std::mutex mutex;
  static std::set<std::string> said;
  const std::scoped_lock lock(mutex);
  if (text.empty() || !said.insert(what + text).second) return;
  fmt::print(stderr, "crowdbench: warning: {}: {}\n", what, text);
}

std::optional<StoredBake> BakeLoader::stored(const std::string& key) const {
  if (policy_.rebake) return std::nullopt;
  return cache_.load(messages_.kind, key);
}

BakeProgress bake_progress(const BakePolicy& policy, const std::string& label) {
  if (!policy.progress) return [](size_t, size_t) { throw_if_interrupted(); };
  struct Shown {
    std::optional<Progress> line;
    size_t done = 0;
  };
  const auto shown = std::make_shared<Shown>();
  return [shown, label](size_t done, size_t total) {
    throw_if_interrupted();
    if (!shown->line) shown->line.emplace(label, total);
    shown->line->advance(done - std::min(shown->done, done));
    shown->done = std::max(shown->done, done);
  };
}

BakeProgress bake_progress(const BakePolicy& policy, const std::string& what, const std::string& character) {
  return bake_progress(policy, fmt::format("baking {} of {}", what, printable(character)));
}

void BakeLoader::take(const std::string& character, BakeRecord record, uint64_t texture_bytes) {
  if (texture_bytes > left_)
    throw Error(fmt::format("{} bake of {}", messages_.kind, character),
                fmt::format("{:.0f} MiB of {} are more than what is left of the budget, {:.0f}",
                            static_cast<double>(texture_bytes) / (1 << 20), messages_.stored,
                            static_cast<double>(left_) / (1 << 20)),
                messages_.advice);
  left_ -= texture_bytes;
  record.disk_bytes = cache_.enabled() ? cache_.disk_bytes(messages_.kind, record.cache_key) : 0;
  records_.push_back(std::move(record));
}

}  // namespace crowdbench::renderers
