// Places for tiles on pages of a fixed number: which are free, and whose is given up when none is.
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <unordered_map>
#include <vector>

namespace crowdbench::renderers {

// A page holds cells of one size, which it has while it holds any tile. Cells are as wide and as high as the next of
// kCellSizes that holds the tile.
class TileAtlas {
 public:
  static constexpr int kSide = 512;  // texels of a page
  TileAtlas(uint32_t pages) : pages_(pages) {}

  struct Place {
    uint32_t page = 0;
    glm::ivec2 corner{0};  // texels
    glm::ivec2 size{0};    // of the cell, texels
    bool operator==(const Place&) const = default;
  };
  // A cell for a tile, which loses the one that it had unless that is as large. Where none is free, the place of the
  // tile of such a cell that was not used for longest, and else a page, all of whose tiles are not in use; tiles used
  // at `now` are never given up. nullopt where there is none, or where a side is larger than a page.
  std::optional<Place> take(uint64_t tile, const glm::ivec2& size, uint64_t now);
  // Says that a tile is used.
  void use(uint64_t tile, uint64_t now);
  std::optional<Place> find(uint64_t tile) const;
  void give_up(uint64_t tile);
  void clear();
  size_t tiles() const { return tiles_.size(); }

 private:
  struct Page {
    glm::ivec2 cell{0};           // size; 0: empty
    std::vector<uint64_t> tiles;  // by cell; kNobody
    size_t used = 0;              // cells
  };
  struct Tile {
    uint32_t page = 0;
    uint32_t cell = 0;
    uint64_t used = 0;
  };
  Place place(const Tile& tile) const;
  std::optional<Tile> free_cell(const glm::ivec2& cell);
  std::optional<Tile> oldest_cell(const glm::ivec2& cell, uint64_t now);
  bool empty_oldest_page(uint64_t now);

  std::vector<Page> pages_;
  std::unordered_map<uint64_t, Tile> tiles_;
};

}  // namespace crowdbench::renderers
