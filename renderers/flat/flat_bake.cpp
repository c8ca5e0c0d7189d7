// Based on: Tecchia and Chrysanthou 2000, "Real-time rendering of densely populated urban environments"; Tecchia,
// Loscos and Chrysanthou 2002, "Image-based crowd rendering" (views by frames, tiles trimmed to what they cover, one
// texel size); Dobbyn et al. 2005 (normal maps and material ids, lit at run time). Differs from the source: levels are
// separate pages instead of one mip chain, so that tiles may lie one texel apart at every level; alpha keeps the
// silhouette's area at every level; outlines are convex polygons instead of rectangles.
#include "renderers/flat/flat_bake.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/hash.h"
#include "core/parallel.h"
#include "renderers/bake/bake_cache.h"
#include "renderers/bake/bake_loader.h"
#include "renderers/bake/emission.h"
#include "renderers/flat/flat_motion.h"
#include "renderers/gl/objects.h"
#include "renderers/impostor/tiles/block_compression.h"
#include "renderers/impostor/tiles/outline.h"
#include "renderers/impostor/tiles/packing.h"
#include "scene/pose/hidden.h"

namespace crowdbench::renderers {
namespace {

constexpr uint32_t kBakeVersion = 13;  // raised whenever the same inputs give other bytes
constexpr int kFineLevels = 2;         // levels whose outlines have `corners` corners; the others are triangles

// Poses of the stored frames and half-way between each and the next of its clip.
struct Between {
  std::vector<std::vector<glm::vec3>> frames, half_way;  // by frame
  std::vector<size_t> before, after;                     // by frame: the frames next to it
  double range = 0;                                      // FlatBake's
};

struct Plan {
  StoredFrames frames;
  CaptureSphere sphere;
  double texel = 0;
  struct Captured {
    std::vector<CaptureTile> tiles;
    std::vector<size_t> index;  // into frames x views
  };
  Captured moving, still;
  std::vector<TileRect> bounds;   // frames x views; what holds a tile at level 0, captured or not
  std::vector<TilePlane> planes;  // frames x views
  std::vector<double> steps;      // metres: a frame's farthest vertex from where it is in the next
  size_t wanted = 0;              // of both kinds of tiles
  int slot_bits = 0;              // FlatBake's
  float emission_peak = 0;
  Between between;  // of a bake with motion
};

// frames: positions of the stored frames.
Between make_between(const scene::Character& character, const std::shared_ptr<const scene::PoseBank>& bank,
                     FrameCount count, const StoredFrames& stored, std::vector<std::vector<glm::vec3>> frames) {
  Between out;
  count.poses = 2;
  const StoredFrames finer = stored_frames(character, bank, count);
  for (size_t c = 0; c < stored.clips.size(); ++c) {
    const StoredClip& clip = stored.clips[c];
    const bool moves = finer.clips[c].frames > clip.frames;
    for (uint32_t f = 0; f < clip.frames; ++f) {
      const size_t half = finer.clips[c].first_frame + (moves ? 2 * f + 1 : f);
      out.half_way.push_back(scene::shown_positions(character.mesh, finer.palette(half)));
      out.before.push_back(clip.first_frame + (f + clip.frames - 1) % clip.frames);
      out.after.push_back(clip.first_frame + (f + 1) % clip.frames);
    }
  }
  out.frames = std::move(frames);
  out.range = 1e-6;
  for (size_t f = 0; f < out.frames.size(); ++f)
    out.range = std::max({out.range, largest_step(out.frames[f], out.half_way[f]),
                          largest_step(out.half_way[f], out.frames[out.after[f]])});
  return out;
}

std::vector<ViewBasis> view_bases(const ViewGrid& grid) {
  std::vector<ViewBasis> bases;
  for (int v = 0; v < grid.size(); ++v) bases.push_back(grid.basis(v));
  return bases;
}

Plan make_plan(const scene::Character& character, const std::shared_ptr<const scene::PoseBank>& bank,
               const FlatBakeOptions& options) {
  Plan plan;
  plan.emission_peak = emission_peak(character);
  if (options.compressed) {
    int largest = 0;
    for (const scene::Material& material : character.materials)
      largest = std::max(largest, std::min<int>(material.slot, 0x7f));
    plan.slot_bits = slot_bits(largest);
  }
  plan.frames = stored_frames(character, bank, options.frames);
  const std::vector<std::vector<glm::vec3>> positions = plan.frames.positions(character.mesh);
  plan.sphere = capture_sphere(character, positions);
  plan.texel = 2 * plan.sphere.radius / options.texels;

  plan.steps = pose_steps(plan.frames, positions);
  if (options.motion) plan.between = make_between(character, bank, options.frames, plan.frames, positions);

  const std::vector<ViewBasis> bases = view_bases(options.grid);
  const int half = (options.texels + 1) / 2;
  for (size_t f = 0; f < plan.frames.size(); ++f) {
    const StoredFrames::Pose& pose = plan.frames.poses[f];
    const SurfaceMoments moments = surface_moments(positions[f], character.mesh.indices);
    for (size_t v = 0; v < bases.size(); ++v) {
      plan.planes.push_back(options.fitted ? fit_plane(moments, plan.sphere.centre, bases[v]) : TilePlane{});
      const bool reachable = options.grid.reachable(static_cast<int>(v));
      TileRect rect;
      if (reachable)
        rect = options.trimmed ? tile_bounds(positions[f], plan.sphere.centre, bases[v], plan.texel)
                               : TileRect{-half, -half, 2 * half, 2 * half};
      plan.bounds.push_back(rect);
      const size_t index = f * bases.size() + v;
      if (!reachable) continue;
      const bool wanted = options.needed.empty() || options.needed[index] != 0;
      plan.wanted += wanted ? 1 : 0;
      Plan::Captured& captured = pose.moves ? plan.moving : plan.still;
      captured.tiles.push_back({pose.sample, bases[v], rect, wanted});
      captured.index.push_back(index);
    }
  }
  return plan;
}

// Where every tile of a level lies, needed or not: by what bounds it, so that a place depends on the options alone.
// Views of one elevation share layers, frames of one view lie beside each other.
// Based on: Tecchia, Loscos and Chrysanthou 2002 (textures split by elevation, so that only those in sight are loaded).
struct Layout {
  Packing packing;
  std::vector<int> layer;  // of the packing's, its place among those that are kept; -1: left out
  int layers = 0;
  int texel_bits = 64;  // of all maps
  uint64_t bytes() const {
    return static_cast<uint64_t>(packing.width) * static_cast<uint64_t>(packing.height) *
           static_cast<uint64_t>(layers) * static_cast<uint64_t>(texel_bits) / 8;
  }
};

bool holds_motion(const FlatBakeOptions& options, size_t level, size_t levels) {
  return options.motion && motion_level(level, levels) == level;
}

// Bits that one texel takes in all maps of a bake but those of motion.
int texel_bits(const FlatBakeOptions& options, const Plan& plan) {
  const bool glows = plan.emission_peak > 0;
  if (!options.compressed) return glows ? 96 : 64;
  const int block_bytes = kColourBlockBytes + kNormalBlockBytes + (options.depth ? kDepthBlockBytes : 0) +
                          (glows ? kEmissionBlockBytes : 0);
  return block_bytes * 8 / (kBlock * kBlock) + plan.slot_bits;
}

// Elevations that are stored together: the rows of a sphere, bands of 15 degrees of the others.
int elevation_group(const ViewGrid& grid, int view) {
  if (grid.kind == GridKind::sphere) return view / grid.azimuths;
  constexpr double kBand = 15 * 3.14159265358979323846 / 180;
  return static_cast<int>(std::floor(std::asin(std::clamp(grid.basis(view).to_eye.y, -1.0, 1.0)) / kBand));
}

Layout make_layout(const Plan& plan, const FlatBakeOptions& options, int level) {
  const auto views = static_cast<size_t>(options.grid.size());
  std::vector<size_t> order;  // view-major
  for (size_t v = 0; v < views; ++v)
    for (size_t f = 0; f < plan.frames.size(); ++f) order.push_back(f * views + v);
  std::vector<int> group_of_view;
  for (size_t v = 0; v < views; ++v) group_of_view.push_back(elevation_group(options.grid, static_cast<int>(v)));
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return group_of_view[a % views] < group_of_view[b % views]; });
  std::vector<PackSize> sizes;
  std::vector<int> groups;
  for (const size_t i : order) {
    const TileRect rect = level_rect(plan.bounds[i], level);
    PackSize size =
        rect.width == 0 ? PackSize{} : PackSize{rect.width + 2 * kTileGutter, rect.height + 2 * kTileGutter};
    if (options.compressed) size = {blocks(size.width) * kBlock, blocks(size.height) * kBlock};
    sizes.push_back(size);
    groups.push_back(group_of_view[i % views]);
  }
  // The page that wastes least; of equal ones the first. Small tiles lie one below the other: their rows are then
  // neighbours in memory, which software OpenGL fetches in a tenth less of a frame's time.
  int tallest = 4;
  int broadest = 4;
  for (const PackSize& s : sizes) {
    tallest = std::max(tallest, s.height);
    broadest = std::max(broadest, s.width);
  }
  constexpr int kColumn = 16;
  const int column = (broadest + kColumn - 1) / kColumn * kColumn;
  Packing best;
  std::pair<bool, uint64_t> least{true, std::numeric_limits<uint64_t>::max()};
  constexpr int kMostLayers = 1536;  // every driver's limit is 2048 at least; more are split over several arrays
  constexpr int kWidest = 1024;
  const bool small = level >= kFineLevels;
  const int narrowest = small ? column : 64;
  for (int width = narrowest; width <= std::max(kWidest, narrowest); width += narrowest) {
    if (small && !least.first) break;
    for (int shelves = 1; shelves == 1 || shelves * tallest <= kWidest; ++shelves) {
      Packing tried = pack_in_order(sizes, groups, width, shelves * tallest);
      const uint64_t area = static_cast<uint64_t>(tried.width) * static_cast<uint64_t>(tried.height) *
                            static_cast<uint64_t>(tried.layers);
      const std::pair found{tried.layers > kMostLayers, area};
      if (found >= least) continue;
      least = found;
      best = std::move(tried);
    }
  }
  Layout layout;
  layout.packing = best;
  layout.texel_bits = texel_bits(options, plan);
  if (holds_motion(options, static_cast<size_t>(level), static_cast<size_t>(tile_levels(options.texels))))
    layout.texel_bits += 32;
  layout.packing.places.assign(order.size(), {});
  std::vector<bool> kept(static_cast<size_t>(best.layers));
  for (size_t k = 0; k < order.size(); ++k) {
    layout.packing.places[order[k]] = best.places[k];
    if (best.places[k].layer >= 0 && (options.needed.empty() || options.needed[order[k]] != 0))
      kept[static_cast<size_t>(best.places[k].layer)] = true;
  }
  for (const bool keep : kept) layout.layer.push_back(keep ? layout.layers++ : -1);
  return layout;
}

// place.layer: among those kept.
void copy_tile(const Tile& tile, const PackPlace& place, FlatLevel& level) {
  const auto row_bytes = static_cast<size_t>(tile.stride()) * 4;
  for (int row = 0; row < tile.rows(); ++row) {
    const size_t from = static_cast<size_t>(row) * row_bytes;
    const size_t to =
        4 *
        ((static_cast<size_t>(place.layer) * static_cast<size_t>(level.height) + static_cast<size_t>(place.y + row)) *
             static_cast<size_t>(level.width) +
         static_cast<size_t>(place.x));
    std::copy_n(tile.albedo.begin() + static_cast<std::ptrdiff_t>(from), row_bytes,
                level.albedo.begin() + static_cast<std::ptrdiff_t>(to));
    std::copy_n(tile.surface.begin() + static_cast<std::ptrdiff_t>(from), row_bytes,
                level.surface.begin() + static_cast<std::ptrdiff_t>(to));
    if (!tile.emission.empty())
      std::copy_n(tile.emission.begin() + static_cast<std::ptrdiff_t>(from), row_bytes,
                  level.emission.begin() + static_cast<std::ptrdiff_t>(to));
  }
}

void copy_motion(const Tile& tile, const std::vector<uint8_t>& motion, const PackPlace& place, FlatLevel& level) {
  const auto row_bytes = static_cast<std::ptrdiff_t>(tile.stride()) * 4;
  for (int row = 0; row < tile.rows(); ++row) {
    const auto to = static_cast<std::ptrdiff_t>(
        4 *
        ((static_cast<size_t>(place.layer) * static_cast<size_t>(level.height) + static_cast<size_t>(place.y + row)) *
             static_cast<size_t>(level.width) +
         static_cast<size_t>(place.x)));
    std::copy_n(motion.begin() + row * row_bytes, row_bytes, level.motion.begin() + to);
  }
}

// The same of a compressed tile, whose place is a multiple of four.
void copy_blocks(const CompressedTile& tile, const PackPlace& place, int slot_bits, FlatLevel& level) {
  const auto pitch = static_cast<size_t>(level.width / kBlock);
  const auto copy = [&](const std::vector<uint8_t>& from, size_t block_bytes, std::vector<uint8_t>& to) {
    const size_t row_bytes = static_cast<size_t>(tile.blocks_x) * block_bytes;
    for (int row = 0; row < tile.blocks_y; ++row) {
      const size_t first = static_cast<size_t>(place.layer) * static_cast<size_t>(level.height / kBlock) +
                           static_cast<size_t>(place.y / kBlock + row);
      std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(static_cast<size_t>(row) * row_bytes), row_bytes,
                  to.begin() + static_cast<std::ptrdiff_t>((first * pitch + static_cast<size_t>(place.x / kBlock)) *
                                                           block_bytes));
    }
  };
  copy(tile.albedo, kColourBlockBytes, level.albedo);
  copy(tile.normal, kNormalBlockBytes, level.normal);
  if (!level.depth.empty()) copy(tile.depth, kDepthBlockBytes, level.depth);
  if (!tile.emission.empty()) copy(tile.emission, kEmissionBlockBytes, level.emission);
  const int texels = 8 / slot_bits;  // a byte
  const int row_texels = tile.blocks_x * kBlock;
  for (int row = 0; row < tile.blocks_y * kBlock; ++row) {
    const uint8_t* from = &tile.slots[static_cast<size_t>(row) * static_cast<size_t>(row_texels)];
    uint8_t* to = &level.slots[(static_cast<size_t>(place.layer) * static_cast<size_t>(level.height) +
                                static_cast<size_t>(place.y + row)) *
                                   static_cast<size_t>(level.width / texels) +
                               static_cast<size_t>(place.x / texels)];
    for (int x = 0; x < row_texels; x += texels) *to++ = texels == 1 ? from[x] : pack_slots(from[x], from[x + 1]);
  }
}

// What one tile becomes at every level.
struct Built {
  std::vector<Tile> levels;
  std::vector<CompressedTile> compressed;  // in place of the levels' texels
  std::vector<std::vector<glm::vec2>> outlines;
  std::vector<std::vector<uint8_t>> motion;  // of the levels that hold it, others empty; gutters included
};

// A tile whose alpha is that of `tile` and of what is shown half-way to the frames before and after: what an outline
// must hold. Texels next to those shown there count, too, since only centres are known to be covered.
Tile swept_tile(const Tile& tile, const std::array<ShownSurface, 2>& half_way) {
  Tile out;
  int x0 = tile.rect.x;
  int y0 = tile.rect.y;
  int x1 = x0 + tile.rect.width;
  int y1 = y0 + tile.rect.height;
  for (const ShownSurface& shown : half_way) {
    if (shown.rect.width == 0) continue;
    x0 = std::min(x0, shown.rect.x - 1);
    y0 = std::min(y0, shown.rect.y - 1);
    x1 = std::max(x1, shown.rect.x + shown.rect.width + 1);
    y1 = std::max(y1, shown.rect.y + shown.rect.height + 1);
  }
  out.rect = {x0, y0, x1 - x0, y1 - y0};
  out.albedo.assign(static_cast<size_t>(out.stride()) * static_cast<size_t>(out.rows()) * 4, 0);
  const auto alpha = [](auto& of, int x, int y) -> auto& {
    return of.albedo[4 * (static_cast<size_t>(y - of.rect.y + kTileGutter) * static_cast<size_t>(of.stride()) +
                          static_cast<size_t>(x - of.rect.x + kTileGutter)) +
                     3];
  };
  for (int y = tile.rect.y; y < tile.rect.y + tile.rect.height; ++y)
    for (int x = tile.rect.x; x < tile.rect.x + tile.rect.width; ++x) alpha(out, x, y) = alpha(tile, x, y);
  for (const ShownSurface& shown : half_way)
    for (int y = shown.rect.y; y < shown.rect.y + shown.rect.height; ++y)
      for (int x = shown.rect.x; x < shown.rect.x + shown.rect.width; ++x) {
        if (!shown.covers(x, y)) continue;
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) alpha(out, x + dx, y + dy) = 255;
      }
  return out;
}

// What of the motion a tile is built with: nothing where the bake has none.
struct TileMotion {
  const Between* between = nullptr;
  const std::vector<uint32_t>* indices = nullptr;
  size_t frame = 0;
  MotionLattice lattice;  // of level 0
};

// One level's motion map, where it holds one, and the tile that its outline is to be made of.
Tile add_motion(const TileMotion& motion, const Tile& tile, int level, bool holds, Built& built) {
  const Between& between = *motion.between;
  MotionLattice lattice = motion.lattice;
  lattice.texel *= std::exp2(level);
  const size_t before = between.before[motion.frame];
  const size_t after = between.after[motion.frame];
  built.motion.emplace_back();
  if (holds)
    built.motion.back() = motion_texels(
        {between.frames[motion.frame], between.half_way[motion.frame], between.frames[after], *motion.indices}, lattice,
        {tile.rect.x - kTileGutter, tile.rect.y - kTileGutter, tile.stride(), tile.rows()}, between.range);
  return swept_tile(tile, {shown_surface(between.half_way[before], *motion.indices, lattice),
                           shown_surface(between.half_way[motion.frame], *motion.indices, lattice)});
}

int corners_of(const FlatBakeOptions& options, int level) {
  return !options.trimmed ? 4 : level < kFineLevels ? options.corners : 3;
}

Built build(const TileRect& rect, const std::vector<CapturedTexel>& texels, const FlatBakeOptions& options, int levels,
            const TileMotion& motion) {
  Built built;
  built.levels = build_tile_levels(rect, texels, levels, options.trimmed);
  for (int level = 0; level < levels; ++level) {
    const Tile& tile = built.levels[static_cast<size_t>(level)];
    const int corners = corners_of(options, level);
    const bool moves = motion.between != nullptr && tile.rect.width > 0;
    const bool holds = holds_motion(options, static_cast<size_t>(level), static_cast<size_t>(levels));
    const Tile swept = moves ? add_motion(motion, tile, level, holds, built) : Tile{};
    const Tile& drawn = moves ? swept : tile;
    built.outlines.push_back(
        !options.trimmed ? rectangle_strip(glm::vec2(tile.rect.x, tile.rect.y),
                                           glm::vec2(tile.rect.x + tile.rect.width, tile.rect.y + tile.rect.height))
        : corners == 3   ? tile_triangle(drawn)
                         : tile_outline(drawn, corners));
  }
  if (options.compressed)
    for (Tile& tile : built.levels) {
      built.compressed.push_back(compress(tile));
      tile.albedo = tile.surface = tile.emission = {};
    }
  return built;
}

FlatLevel pack_level(std::vector<Built>& built, const std::vector<TilePlane>& planes, const Layout& layout,
                     const FlatBakeOptions& options, int slot_bits, bool glows, size_t level) {
  FlatLevel out;
  out.width = layout.packing.width;
  out.height = layout.packing.height;
  out.layers = layout.layers;
  const size_t texels =
      static_cast<size_t>(out.width) * static_cast<size_t>(out.height) * static_cast<size_t>(out.layers);
  if (slot_bits == 0) {
    out.albedo.assign(texels * 4, 0);
    out.surface.assign(texels * 4, 0);
    if (glows) out.emission.assign(texels * 4, 0);
  } else {
    const size_t all_blocks = texels / (kBlock * kBlock);
    out.albedo.assign(all_blocks * kColourBlockBytes, 0);
    out.normal.assign(all_blocks * kNormalBlockBytes, 0);
    if (options.depth) out.depth.assign(all_blocks * kDepthBlockBytes, 0);
    if (glows) out.emission.assign(all_blocks * kEmissionBlockBytes, 0);
    out.slots.assign(texels * static_cast<size_t>(slot_bits) / 8, 0);
  }
  if (holds_motion(options, level, static_cast<size_t>(tile_levels(options.texels)))) out.motion.assign(texels * 4, 0);
  for (const Built& b : built)
    if (!b.outlines.empty()) out.corners = static_cast<int>(b.outlines[level].size());
  for (size_t i = 0; i < built.size(); ++i) {
    if (built[i].levels.empty() || built[i].levels[level].rect.width == 0) {
      out.tiles.push_back({});
      out.outlines.insert(out.outlines.end(), static_cast<size_t>(out.corners), {0.0F, 0.0F});
      continue;
    }
    Tile& tile = built[i].levels[level];
    PackPlace place = layout.packing.places[i];
    place.layer = layout.layer[static_cast<size_t>(place.layer)];
    if (slot_bits == 0)
      copy_tile(tile, place, out);
    else
      copy_blocks(built[i].compressed[level], place, slot_bits, out);
    if (!out.motion.empty()) copy_motion(tile, built[i].motion[level], place, out);
    out.tiles.push_back({static_cast<float>(place.x + kTileGutter - tile.rect.x),
                         static_cast<float>(place.y + kTileGutter - tile.rect.y), static_cast<float>(place.layer),
                         static_cast<float>(tile.coverage), static_cast<float>(planes[i].slope_x),
                         static_cast<float>(planes[i].slope_y), static_cast<float>(planes[i].height), 0.0F,
                         static_cast<float>(tile.rect.x), static_cast<float>(tile.rect.y),
                         static_cast<float>(tile.rect.x + tile.rect.width),
                         static_cast<float>(tile.rect.y + tile.rect.height)});
    const auto& outline = built[i].outlines[level];
    for (const glm::vec2& p : outline) out.outlines.push_back({p.x, p.y});
    tile = {};  // its texels live on the page now
    if (!built[i].motion.empty()) built[i].motion[level] = {};
    if (slot_bits > 0) built[i].compressed[level] = {};
  }
  return out;
}

}  // namespace

uint64_t FlatBake::texture_bytes() const {
  uint64_t bytes = 0;
  for (const FlatLevel& l : levels) bytes += l.texture_bytes();
  return bytes;
}

FlatForecast forecast_flat(const scene::Character& character, const std::shared_ptr<const scene::PoseBank>& bank,
                           const FlatBakeOptions& options) {
  const Plan plan = make_plan(character, bank, options);
  FlatForecast out;
  ViewSampling& sampling = out.sampling;
  sampling.grid = options.grid;
  sampling.frames = most_frames(plan.frames);
  sampling.texel = plan.texel;
  sampling.centre = plan.sphere.centre;
  sampling.lies = options.fitted ? ViewLies::nearest : ViewLies::across;
  for (int level = 0; level < tile_levels(options.texels); ++level)
    sampling.texture_bytes += make_layout(plan, options, level).bytes();
  set_pose_steps(sampling, plan.steps);
  out.tiles = plan.wanted;
  return out;
}

namespace {

// The option that a budget holds, as budget_advice takes it.
std::string fitting_texels(const scene::Character& character, const std::shared_ptr<const scene::PoseBank>& bank,
                           FlatBakeOptions options, uint64_t needed, uint64_t budget) {
  constexpr int kLeastTexels = 16;
  constexpr int kTries = 8;
  options.texels = fitting_size(options.texels, kLeastTexels, needed, budget);
  for (int i = 0; i < kTries && options.texels >= kLeastTexels; ++i) {
    if (forecast_flat(character, bank, options).sampling.texture_bytes <= budget)
      return fmt::format("texels={}", options.texels);
    options.texels -= 1 + options.texels / 20;  // gutters and the packing's leftovers do not shrink as tiles do
  }
  return {};
}

}  // namespace

NominalFrame nominal_frame(const ViewGrid& grid, int texels) {
  int views = 0;
  for (int v = 0; v < grid.size(); ++v) views += grid.reachable(v) ? 1 : 0;
  NominalFrame out;
  const auto holds = [&](int side) { return (side / texels) * (side / texels) >= views; };
  for (out.side = 1; !holds(out.side);) out.side *= 2;
  out.bytes = gl::texture_bytes(GL_RGBA8, out.side, out.side) + gl::texture_bytes(GL_RGB8, out.side, out.side);
  out.compressed_bytes = gl::texture_bytes(GL_COMPRESSED_RGBA_S3TC_DXT5_EXT, out.side, out.side) +
                         gl::texture_bytes(GL_COMPRESSED_RGB_S3TC_DXT1_EXT, out.side, out.side);
  return out;
}

std::vector<uint8_t> needed_tiles(const scene::Character& character, const std::shared_ptr<const scene::PoseBank>& bank,
                                  const FlatBakeOptions& options, const ShownTiles& shown,
                                  const std::function<void(const std::function<void(const ViewSample&)>&)>& visit) {
  const Plan plan = make_plan(character, bank, options);
  const auto views = static_cast<size_t>(options.grid.size());
  std::vector<uint8_t> needed(plan.frames.size() * views);
  visit([&](const ViewSample& seen) {
    const StoredClip& clip = plan.frames.clips[static_cast<size_t>(seen.bank_clip)];
    constexpr double kNearPhase = 1e-4;  // what single precision leaves open
    options.grid.visit_picks(glm::dvec3(seen.eye) - plan.sphere.centre, shown.blend, [&](int view, bool mirrored) {
      for (const double off : {-kNearPhase, kNearPhase}) {
        const double at = (static_cast<double>(seen.phase) + off) * clip.frames;
        const auto mark = [&](double whole) {
          auto step = static_cast<uint32_t>(std::max(0.0, whole));
          step = (step + (mirrored ? clip.frames / 2 : 0)) % clip.frames;
          needed[(clip.first_frame + step) * views + static_cast<size_t>(view)] = 1;
        };
        if (!shown.both_frames) {
          mark(std::floor(at + 0.5));
          continue;
        }
        mark(std::floor(at) + (at < 0 ? clip.frames : 0));
        mark(std::floor(at) + 1);
      }
    });
  });
  return needed;
}

std::string flat_cache_key(const scene::Character& character, const scene::PoseBank& bank,
                           const FlatBakeOptions& options, const std::string& gl_renderer,
                           const std::string& gl_version) {
  Sha256 hash;
  hash.text("flat").value(kBakeVersion).text(character.content_hash).text(gl_renderer).text(gl_version);
  hash.text(options.grid.text()).value(options.grid.el_min);
  hash.value(options.texels).value(options.trimmed).value(options.corners).value(options.fitted);
  hash.value(options.compressed).value(options.compressed && options.depth).value(options.motion);
  hash.value(options.needed.size()).bytes(options.needed.data(), options.needed.size());
  hash_poses(hash, bank, options.frames);
  return hash.hex();
}

FlatBake bake_flat(gl::Context& context, const std::shared_ptr<const scene::Character>& character,
                   const std::shared_ptr<const scene::PoseBank>& bank, const FlatBakeOptions& options, uint64_t budget,
                   const std::function<void(size_t, size_t)>& progress) {
  const Plan plan = make_plan(*character, bank, options);
  const int levels = tile_levels(options.texels);
  std::vector<Layout> layouts;
  uint64_t needed = 0;
  for (int level = 0; level < levels; ++level) {
    layouts.push_back(make_layout(plan, options, level));
    needed += layouts.back().bytes();
  }
  if (needed > budget) {
    const auto mib = [](uint64_t bytes) { return static_cast<double>(bytes) / (1 << 20); };
    throw Error(fmt::format("{} bake of {}", options.drawn_by, character->name),
                fmt::format("{} clip{}, {} frames, {} views and {} texels need {:.0f} MiB, the budget is {:.0f}",
                            plan.frames.clips.size(), plan.frames.clips.size() == 1 ? "" : "s", plan.frames.size(),
                            options.grid.size(), options.texels, mib(needed), mib(budget)),
                budget_advice(fitting_texels(*character, bank, options, needed, budget),
                              "lower texels, frames or views, use fewer clips or characters", needed, budget));
  }

  FlatBake bake;
  bake.centre = {static_cast<float>(plan.sphere.centre.x), static_cast<float>(plan.sphere.centre.y),
                 static_cast<float>(plan.sphere.centre.z)};
  bake.radius = static_cast<float>(plan.sphere.radius);
  bake.texel = static_cast<float>(plan.texel);
  bake.frames = static_cast<uint32_t>(plan.frames.size());
  bake.views = static_cast<uint32_t>(options.grid.size());
  bake.clips = plan.frames.clips;
  bake.slot_bits = plan.slot_bits;
  bake.emission_peak = plan.emission_peak;
  bake.motion_range = static_cast<float>(plan.between.range);

  std::vector<Built> built(plan.frames.size() * bake.views);
  size_t done = 0;
  for (const bool moves : {true, false}) {
    const Plan::Captured& captured = moves ? plan.moving : plan.still;
    if (captured.tiles.empty()) continue;
    TileCapture capture(context, character, plan.frames.bank(moves),
                        {.centre = glm::dvec3(bake.centre[0], bake.centre[1], bake.centre[2]),
                         .texel = bake.texel,
                         .range = bake.radius,
                         .peak = bake.emission_peak});
    capture.capture(captured.tiles,
                    [&](std::span<const size_t> page, std::span<const std::vector<CapturedTexel>> texels) {
                      // Tiles do not depend on each other, so the bytes do not depend on the number of threads.
                      parallel_for(page.size(), options.threads, [&](size_t i) {
                        const CaptureTile& tile = captured.tiles[page[i]];
                        const size_t index = captured.index[page[i]];
                        const TileMotion motion{options.motion ? &plan.between : nullptr,
                                                &character->mesh.indices,
                                                index / bake.views,
                                                {plan.sphere.centre, tile.basis, plan.texel}};
                        built[index] = build(tile.rect, texels[i], options, levels, motion);
                      });
                      done += page.size();
                      if (progress) progress(done, plan.wanted);
                    });
  }
  for (int level = 0; level < levels; ++level)
    bake.levels.push_back(pack_level(built, plan.planes, layouts[static_cast<size_t>(level)], options, plan.slot_bits,
                                     plan.emission_peak > 0, static_cast<size_t>(level)));
  return bake;
}

std::vector<uint8_t> serialise(const FlatBake& bake) {
  ByteWriter out;
  out.reserve(bake.texture_bytes() + (size_t{1} << 20));
  out.value(bake.centre);
  out.value(bake.radius);
  out.value(bake.texel);
  out.value(bake.frames);
  out.value(bake.views);
  out.value(bake.slot_bits);
  out.value(bake.emission_peak);
  out.value(bake.motion_range);
  out.values(bake.clips);
  out.value(static_cast<uint32_t>(bake.levels.size()));
  for (const FlatLevel& l : bake.levels) {
    out.value(l.width);
    out.value(l.height);
    out.value(l.layers);
    out.value(l.corners);
    out.values(l.tiles);
    out.values(l.outlines);
    out.values(l.albedo);
    out.values(l.surface);
    out.values(l.normal);
    out.values(l.depth);
    out.values(l.slots);
    if (bake.emission_peak > 0) out.values(l.emission);
    if (bake.motion_range > 0) out.values(l.motion);
  }
  return out.bytes();
}

std::optional<FlatBake> deserialise_flat(std::span<const uint8_t> bytes) {
  ByteReader in(bytes);
  FlatBake bake;
  bake.centre = in.value<std::array<float, 3>>();
  bake.radius = in.value<float>();
  bake.texel = in.value<float>();
  bake.frames = in.value<uint32_t>();
  bake.views = in.value<uint32_t>();
  bake.slot_bits = in.value<int>();
  bake.emission_peak = in.value<float>();
  bake.motion_range = in.value<float>();
  if (bake.slot_bits != 0 && bake.slot_bits != 4 && bake.slot_bits != 8) return std::nullopt;
  bake.clips = in.values<StoredClip>();
  const auto levels = in.value<uint32_t>();
  const uint64_t tiles = uint64_t{bake.frames} * bake.views;
  for (uint32_t i = 0; i < levels && in.ok(); ++i) {
    FlatLevel l;
    l.width = in.value<int>();
    l.height = in.value<int>();
    l.layers = in.value<int>();
    l.corners = in.value<int>();
    l.tiles = in.values<FlatTile>();
    l.outlines = in.values<std::array<float, 2>>();
    l.albedo = in.values<uint8_t>();
    l.surface = in.values<uint8_t>();
    l.normal = in.values<uint8_t>();
    l.depth = in.values<uint8_t>();
    l.slots = in.values<uint8_t>();
    if (bake.emission_peak > 0) l.emission = in.values<uint8_t>();
    if (bake.motion_range > 0) l.motion = in.values<uint8_t>();
    const auto texels =
        static_cast<uint64_t>(l.width) * static_cast<uint64_t>(l.height) * static_cast<uint64_t>(l.layers);
    if (l.width < 0 || l.height < 0 || l.layers < 0 || l.corners < 3 || l.corners > 16 || l.tiles.size() != tiles ||
        l.outlines.size() != tiles * static_cast<uint64_t>(l.corners))
      return std::nullopt;
    const auto bits = static_cast<uint64_t>(bake.slot_bits);
    const bool fits = bits == 0 ? l.albedo.size() == texels * 4 && l.surface.size() == texels * 4 && l.normal.empty() &&
                                      l.depth.empty() && l.slots.empty()
                                : l.width % kBlock == 0 && l.height % kBlock == 0 && l.albedo.size() == texels &&
                                      l.surface.empty() && l.normal.size() == texels &&
                                      (l.depth.empty() || l.depth.size() == texels / 2) &&
                                      l.slots.size() == texels * bits / 8;
    const uint64_t emission_bytes = bake.emission_peak <= 0 ? 0 : bits == 0 ? texels * 4 : texels / 2;
    const bool moves = bake.motion_range > 0 && motion_level(i, levels) == i;
    if (!fits || l.emission.size() != emission_bytes || l.motion.size() != (moves ? texels * 4 : 0))
      return std::nullopt;
    bake.levels.push_back(std::move(l));
  }
  for (const StoredClip& c : bake.clips)
    if (c.frames == 0 || uint64_t{c.first_frame} + c.frames > bake.frames) return std::nullopt;
  if (!in.ok() || !in.at_end() || bake.levels.empty()) return std::nullopt;
  return bake;
}

}  // namespace crowdbench::renderers
