#include "renderers/dynamic/tile_atlas.h"

#include <algorithm>
#include <array>
#include <limits>

namespace crowdbench::renderers {
namespace {

constexpr std::array<int, 13> kCellSizes = {8, 12, 16, 24, 32, 48, 64, 96, 128, 170, 256, 384, 512};
constexpr uint64_t kNobody = ~uint64_t{0};

// 0: larger than any.
int cell_size(int texels) {
  const auto* const found = std::lower_bound(kCellSizes.begin(), kCellSizes.end(), texels);
  return found == kCellSizes.end() ? 0 : *found;
}

}  // namespace

TileAtlas::Place TileAtlas::place(const Tile& tile) const {
  const Page& page = pages_[tile.page];
  const auto across = static_cast<uint32_t>(kSide / page.cell.x);
  return {tile.page,
          {static_cast<int>(tile.cell % across) * page.cell.x, static_cast<int>(tile.cell / across) * page.cell.y},
          page.cell};
}

std::optional<TileAtlas::Tile> TileAtlas::free_cell(const glm::ivec2& cell) {
  std::optional<uint32_t> empty;
  for (uint32_t p = 0; p < pages_.size(); ++p) {
    Page& page = pages_[p];
    if (page.used == 0 && !empty) empty = p;
    if (page.used == 0 || page.cell != cell || page.used == page.tiles.size()) continue;
    const auto at = std::find(page.tiles.begin(), page.tiles.end(), kNobody);
    return Tile{p, static_cast<uint32_t>(at - page.tiles.begin())};
  }
  if (!empty) return std::nullopt;
  Page& page = pages_[*empty];
  page.cell = cell;
  page.tiles.assign(static_cast<size_t>(kSide / cell.x) * static_cast<size_t>(kSide / cell.y), kNobody);
  return Tile{*empty, 0};
}

std::optional<TileAtlas::Tile> TileAtlas::oldest_cell(const glm::ivec2& cell, uint64_t now) {
  const Tile* oldest = nullptr;
  for (const Page& page : pages_) {
    if (page.used == 0 || page.cell != cell) continue;
    for (const uint64_t id : page.tiles) {
      const Tile& tile = tiles_.at(id);
      if (tile.used != now && (oldest == nullptr || tile.used < oldest->used)) oldest = &tile;
    }
  }
  if (oldest == nullptr) return std::nullopt;
  const Tile out = *oldest;
  tiles_.erase(pages_[out.page].tiles[out.cell]);
  pages_[out.page].tiles[out.cell] = kNobody;
  --pages_[out.page].used;
  return out;
}

bool TileAtlas::empty_oldest_page(uint64_t now) {
  size_t best = pages_.size();
  uint64_t best_used = now;
  for (size_t p = 0; p < pages_.size(); ++p) {
    uint64_t latest = 0;
    for (const uint64_t id : pages_[p].tiles)
      if (id != kNobody) latest = std::max(latest, tiles_.at(id).used);
    if (latest < best_used) {
      best = p;
      best_used = latest;
    }
  }
  if (best == pages_.size()) return false;
  const std::vector<uint64_t> gone = pages_[best].tiles;
  for (const uint64_t id : gone)
    if (id != kNobody) give_up(id);
  return true;
}

std::optional<TileAtlas::Place> TileAtlas::take(uint64_t tile, const glm::ivec2& size, uint64_t now) {
  const glm::ivec2 cell(cell_size(size.x), cell_size(size.y));
  if (cell.x == 0 || cell.y == 0) {
    give_up(tile);
    return std::nullopt;
  }
  if (const auto known = find(tile)) {
    if (known->size == cell) {
      use(tile, now);
      return known;
    }
    give_up(tile);
  }
  std::optional<Tile> found = free_cell(cell);
  if (!found) found = oldest_cell(cell, now);
  if (!found && empty_oldest_page(now)) found = free_cell(cell);
  if (!found) return std::nullopt;
  found->used = now;
  pages_[found->page].tiles[found->cell] = tile;
  ++pages_[found->page].used;
  tiles_[tile] = *found;
  return place(*found);
}

void TileAtlas::use(uint64_t tile, uint64_t now) { tiles_.at(tile).used = now; }

std::optional<TileAtlas::Place> TileAtlas::find(uint64_t tile) const {
  const auto found = tiles_.find(tile);
  if (found == tiles_.end()) return std::nullopt;
  return place(found->second);
}

void TileAtlas::give_up(uint64_t tile) {
  const auto found = tiles_.find(tile);
  if (found == tiles_.end()) return;
  Page& page = pages_[found->second.page];
  page.tiles[found->second.cell] = kNobody;
  if (--page.used == 0) page.tiles.clear();
  tiles_.erase(found);
}

void TileAtlas::clear() {
  tiles_.clear();
  for (Page& page : pages_) page = {};
}

}  // namespace crowdbench::renderers
