#include "renderers/polypostor/polypostor_images.h"

#include <algorithm>

#include "core/parallel.h"
#include "renderers/impostor/tiles/tile_capture.h"

namespace crowdbench::renderers {
namespace {

constexpr uint64_t kTexelBytes = 7;
constexpr uint64_t kEmissionBytes = 4;  // more, of a character that glows

// The character with the triangles of one part only, drawn from both sides.
std::shared_ptr<const scene::Character> only_part(const scene::Character& character,
                                                  const std::vector<uint32_t>& triangles) {
  auto part = std::make_shared<scene::Character>(character);
  for (scene::Material& material : part->materials) material.double_sided = true;
  scene::Mesh& mesh = part->mesh;
  mesh.indices.clear();
  size_t next = 0;
  for (scene::Primitive& primitive : mesh.primitives) {
    const uint32_t end = (primitive.first_index + primitive.index_count) / 3;
    const auto first = static_cast<uint32_t>(mesh.indices.size());
    // Triangles are ascending, and so are the primitives' ranges.
    while (next < triangles.size() && triangles[next] < end) {
      for (uint32_t k = 0; k < 3; ++k) mesh.indices.push_back(character.mesh.indices[3 * triangles[next] + k]);
      ++next;
    }
    primitive.first_index = first;
    primitive.index_count = static_cast<uint32_t>(mesh.indices.size()) - first;
  }
  return part;
}

// Copies a tile with the gutters of the sides asked for. Neighbours share one gutter between them, filled by whoever
// comes last; a tile's own texels are written after all gutters.
void copy_tile(const Tile& tile, const PackPlace& place, bool gutters, PolypostorBake& bake) {
  for (int row = 0; row < tile.rows(); ++row)
    for (int column = 0; column < tile.stride(); ++column) {
      const bool own = column >= kTileGutter && row >= kTileGutter && column < tile.stride() - kTileGutter &&
                       row < tile.rows() - kTileGutter;
      const int x = place.x + column - kTileGutter;
      const int y = place.y + row - kTileGutter;
      if (own == gutters || x < 0 || y < 0) continue;
      const size_t from = static_cast<size_t>(row) * static_cast<size_t>(tile.stride()) + static_cast<size_t>(column);
      const size_t to = (static_cast<size_t>(place.layer) * static_cast<size_t>(bake.height) + static_cast<size_t>(y)) *
                            static_cast<size_t>(bake.width) +
                        static_cast<size_t>(x);
      std::copy_n(&tile.albedo[4 * from], 4, &bake.albedo[4 * to]);
      std::copy_n(&tile.surface[4 * from], 2, &bake.normals[2 * to]);
      bake.materials[to] = tile.surface[4 * from + 2];
      if (bake.emission.empty()) continue;
      if (tile.emission.empty())
        std::fill_n(&bake.emission[4 * to], 4, uint8_t{0});
      else
        std::copy_n(&tile.emission[4 * from], 4, &bake.emission[4 * to]);
    }
}

}  // namespace

uint64_t image_bytes(const PolypostorPlan& plan, const PolypostorTier& tier, int width, int height) {
  uint64_t texels = 0;
  for (uint32_t l = tier.first_level; l < tier.first_level + tier.levels; ++l) {
    const auto side = [&](int v) { return static_cast<uint64_t>((v >> l) + 1 + kTileGutter); };
    texels += side(width) * side(height);
  }
  return texels * (kTexelBytes + (plan.emission_peak > 0 ? kEmissionBytes : 0));
}

uint64_t image_bytes(const PolypostorPlan& plan, std::span<const ViewParts> views) {
  uint64_t bytes = 0;
  for (const ViewParts& view : views)
    for (const auto& sheets : view.sheets)
      for (const Sheet& sheet : sheets)
        bytes += image_bytes(plan, plan.tiers[view.tier], sheet.rect.width, sheet.rect.height);
  return bytes;
}

std::vector<Tile> capture_images(gl::Context& context, const PolypostorPlan& plan, const ViewGrid& grid,
                                 std::span<ViewParts> views, unsigned threads,
                                 const std::function<void(double done)>& progress) {
  size_t count = 0;
  for (ViewParts& view : views)
    for (auto& sheets : view.sheets)
      for (Sheet& sheet : sheets) {
        sheet.first_tile = count;
        count += plan.tiers[view.tier].levels;
      }
  std::vector<Tile> tiles(count);
  for (size_t t = 0; t < plan.tiers.size(); ++t) {
    const PolypostorTier& tier = plan.tiers[t];
    const auto& triangles = tier.cut.triangles;
    for (size_t part = 0; part < triangles.size(); ++part) {
      for (const bool moves : {true, false}) {
        std::vector<CaptureTile> wanted;
        std::vector<size_t> to;
        for (const ViewParts& view : views) {
          const size_t first_frame = plan.frames.clips[view.clip].first_frame;
          if (view.tier != t || view.sheets.empty() || plan.frames.poses[first_frame].moves != moves) continue;
          for (const Sheet& sheet : view.sheets[part]) {
            wanted.push_back({plan.frames.poses[first_frame + sheet.fit.key].sample,
                              grid.basis(static_cast<int>(view.view)), sheet.rect});
            to.push_back(sheet.first_tile);
          }
        }
        if (wanted.empty()) continue;
        TileCapture capture(context, only_part(*tier.cut.character, triangles[part]), plan.frames.bank(moves),
                            {.centre = plan.sphere.centre,
                             .texel = plan.texel,
                             .range = plan.sphere.radius,
                             .eye = plan.eye * plan.texel,
                             .peak = plan.emission_peak});
        capture.capture(wanted, [&](std::span<const size_t> page, std::span<const std::vector<CapturedTexel>> images) {
          parallel_for(page.size(), threads, [&](size_t k) {
            std::vector<Tile> levels = build_tile_levels(wanted[page[k]].rect, images[k],
                                                         static_cast<int>(tier.first_level + tier.levels), false);
            for (uint32_t l = 0; l < tier.levels; ++l) tiles[to[page[k]] + l] = std::move(levels[tier.first_level + l]);
          });
          progress((static_cast<double>(t) + static_cast<double>(part) / static_cast<double>(triangles.size())) /
                   static_cast<double>(plan.tiers.size()));
        });
      }
    }
  }
  return tiles;
}

std::vector<PackPlace> pack_images(std::span<const Tile> tiles, PolypostorBake& bake) {
  std::vector<PackSize> sizes;
  for (const Tile& tile : tiles)
    sizes.push_back(tile.rect.width == 0 ? PackSize{}
                                         : PackSize{tile.stride() - kTileGutter, tile.rows() - kTileGutter});
  Packing packing = pack_tightly(sizes);
  bake.width = packing.width;
  bake.height = packing.height;
  bake.layers = packing.layers;
  const size_t texels =
      static_cast<size_t>(bake.width) * static_cast<size_t>(bake.height) * static_cast<size_t>(bake.layers);
  bake.albedo.assign(4 * texels, 0);
  bake.normals.assign(2 * texels, 0);
  bake.materials.assign(texels, 0);
  if (bake.emission_peak > 0) bake.emission.assign(4 * texels, 0);
  for (const bool gutters : {true, false})
    for (size_t i = 0; i < tiles.size(); ++i)
      if (packing.places[i].layer >= 0) copy_tile(tiles[i], packing.places[i], gutters, bake);
  return std::move(packing.places);
}

}  // namespace crowdbench::renderers
