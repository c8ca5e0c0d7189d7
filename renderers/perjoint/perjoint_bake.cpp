// Based on: Beacco, Spanlang, Andujar and Pelechano 2012. Differs from the source: README.md.
#include "renderers/perjoint/perjoint_bake.h"

#include <algorithm>

#include "core/error.h"
#include "core/hash.h"
#include "core/parallel.h"
#include "renderers/bake/bake_cache.h"
#include "renderers/bake/bake_loader.h"
#include "renderers/bake/emission.h"
#include "renderers/gl/context.h"
#include "renderers/impostor/tiles/outline.h"
#include "renderers/impostor/tiles/packing.h"
#include "renderers/impostor/tiles/plane.h"
#include "renderers/impostor/tiles/stored_frames.h"
#include "renderers/impostor/tiles/tile.h"
#include "renderers/impostor/tiles/tile_capture.h"
#include "renderers/perjoint/perjoint.shared.h"
#include "renderers/perjoint/perjoint_border.h"
#include "renderers/perjoint/perjoint_pieces.h"

namespace crowdbench::renderers {
namespace {

constexpr uint32_t kPerJointVersion = 2;  // raised whenever the same inputs give other bytes

struct PieceTiles {
  CaptureSphere sphere;
  std::vector<TileRect> bounds;  // by view, of the widest border, so that bytes do not depend on the clips
};

// What is known before anything is drawn.
struct PerJointPlan {
  RestPose rest;
  JointPieces pieces;
  double texel = 0;
  int levels = 1;
  std::vector<PieceTiles> tiles;
  Packing packing;  // level, piece, view
  float peak = 0;
};

PerJointPlan make_perjoint_plan(const scene::Character& character, const scene::PoseBank& bank,
                                const PerJointOptions& options) {
  PerJointPlan plan;
  plan.rest = rest_pose(character, bank);
  plan.pieces = find_joint_pieces(character, plan.rest, options.least);
  plan.texel = 2 * capture_sphere(character, {plan.rest.positions}).radius / options.texels;
  plan.levels = tile_levels(options.texels);
  plan.peak = emission_peak(character);
  const float widest = options.border > 0 ? options.border : kBorders.back();
  for (int p = 0; p < plan.pieces.count(); ++p) {
    const PieceSurface surface = cut_joint_piece(character.mesh, plan.pieces, p, widest);
    const std::vector<glm::vec3> positions = corner_positions(surface, plan.rest.positions);
    PieceTiles& tiles = plan.tiles.emplace_back();
    tiles.sphere = enclosing_sphere({positions});
    for (int v = 0; v < options.grid.size(); ++v)
      tiles.bounds.push_back(options.grid.reachable(v)
                                 ? tile_bounds(positions, tiles.sphere.centre, options.grid.basis(v), plan.texel)
                                 : TileRect{});
  }
  std::vector<PackSize> sizes;
  for (int level = 0; level < plan.levels; ++level)
    for (const PieceTiles& piece : plan.tiles)
      for (const TileRect& bounds : piece.bounds) {
        const TileRect rect = level_rect(bounds, level);
        sizes.push_back(rect.width == 0 ? PackSize{}
                                        : PackSize{rect.width + 2 * kTileGutter, rect.height + 2 * kTileGutter});
      }
  plan.packing = pack_tightly(sizes);
  return plan;
}

void check_budget(const PerJointPlan& plan, const PerJointOptions& options, const gl::Limits& limits,
                  const std::string& name, uint64_t budget) {
  const std::string where = "per-joint impostors of " + name;
  const Packing& pages = plan.packing;
  const uint64_t needed = static_cast<uint64_t>(pages.width) * static_cast<uint64_t>(pages.height) *
                          static_cast<uint64_t>(pages.layers) * (plan.peak > 0 ? 12 : 8);
  if (needed > budget) {
    const auto mib = [](uint64_t bytes) { return static_cast<double>(bytes) / (1 << 20); };
    constexpr int kLeastTexels = 16;
    const int fits = fitting_size(options.texels, kLeastTexels, needed, budget);
    throw Error(where,
                fmt::format("{} joints, {} views and {} texels need {:.0f} MiB, the budget is {:.0f}",
                            plan.pieces.count(), options.grid.size(), options.texels, mib(needed), mib(budget)),
                budget_advice(fits > 0 ? fmt::format("texels={}", fits) : std::string(),
                              "lower texels or views, or raise least", needed, budget));
  }
  if (pages.layers > limits.array_layers || std::max(pages.width, pages.height) > limits.texture_size)
    throw Error(where,
                fmt::format("{} pages of {} x {} texels are more than this driver's textures hold", pages.layers,
                            pages.width, pages.height),
                "lower texels or views");
}

void copy_joint_tile(const Tile& tile, const PackPlace& place, PerJointBake& bake) {
  const auto row_bytes = static_cast<size_t>(tile.stride()) * 4;
  for (int row = 0; row < tile.rows(); ++row) {
    const auto from = static_cast<std::ptrdiff_t>(static_cast<size_t>(row) * row_bytes);
    const auto to = static_cast<std::ptrdiff_t>(
        4 *
        ((static_cast<size_t>(place.layer) * static_cast<size_t>(bake.height) + static_cast<size_t>(place.y + row)) *
             static_cast<size_t>(bake.width) +
         static_cast<size_t>(place.x)));
    std::copy_n(tile.albedo.begin() + from, row_bytes, bake.albedo.begin() + to);
    std::copy_n(tile.surface.begin() + from, row_bytes, bake.surface.begin() + to);
    if (!tile.emission.empty()) std::copy_n(tile.emission.begin() + from, row_bytes, bake.emission.begin() + to);
  }
}

// One view of one piece, at all levels.
struct JointTile {
  std::vector<Tile> levels;
  std::vector<std::vector<glm::vec2>> outlines;
};

JointTile build_joint_tile(const TileRect& rect, const std::vector<CapturedTexel>& texels, int levels) {
  JointTile out;
  out.levels = build_tile_levels(rect, texels, levels);
  for (int level = 0; level < levels; ++level) {
    const int corners = level < CB_PERJOINT_FEW_FROM ? CB_PERJOINT_CORNERS : CB_PERJOINT_FEW;
    out.outlines.push_back(tile_outline(out.levels[static_cast<size_t>(level)], corners));
    out.outlines.back().resize(CB_PERJOINT_CORNERS, out.outlines.back().back());
  }
  return out;
}

void place_joint_tile(const PerJointPlan& plan, const JointTile& built, const TilePlane& plane, size_t piece,
                      size_t view, PerJointBake& bake) {
  for (size_t level = 0; level < built.levels.size(); ++level) {
    const Tile& tile = built.levels[level];
    const size_t index = (level * bake.pieces + piece) * bake.views + view;
    if (tile.rect.width == 0) continue;
    const PackPlace& place = plan.packing.places[index];
    copy_joint_tile(tile, place, bake);
    bake.tiles[2 * index] = {static_cast<float>(place.x + kTileGutter - tile.rect.x),
                             static_cast<float>(place.y + kTileGutter - tile.rect.y), static_cast<float>(place.layer),
                             static_cast<float>(tile.coverage)};
    bake.tiles[2 * index + 1] = {static_cast<float>(plane.slope_x), static_cast<float>(plane.slope_y),
                                 static_cast<float>(plane.height), static_cast<float>(tile.rect.width)};
    for (size_t k = 0; k < CB_PERJOINT_CORNERS; ++k)
      bake.outlines[index * CB_PERJOINT_CORNERS + k] = {built.outlines[level][k].x, built.outlines[level][k].y};
  }
}

// The views of one piece, captured and put on their pages.
void bake_piece(gl::Context& context, const scene::Character& character, const PerJointPlan& plan,
                const PerJointOptions& options, size_t piece, const std::function<void(size_t)>& done,
                PerJointBake& bake) {
  const PieceSurface surface =
      cut_joint_piece(character.mesh, plan.pieces, static_cast<int>(piece), bake.borders[piece]);
  const PieceTiles& tiles = plan.tiles[piece];
  if (surface.indices.empty() || tiles.sphere.radius <= 0) return;
  const auto alone = std::make_shared<const scene::Character>(piece_character(character, plan.rest, surface));
  const auto still = std::make_shared<const scene::PoseBank>(scene::PoseBank::exact(*alone, -1, 0));
  const SurfaceMoments moments = surface_moments(alone->mesh.positions, alone->mesh.indices);
  std::vector<CaptureTile> wanted;
  for (size_t v = 0; v < tiles.bounds.size(); ++v)
    wanted.push_back({still->sample(0, 0), options.grid.basis(static_cast<int>(v)), tiles.bounds[v]});
  TileCapture capture(
      context, alone, still,
      {.centre = tiles.sphere.centre, .texel = plan.texel, .range = tiles.sphere.radius, .peak = plan.peak});
  capture.capture(wanted, [&](std::span<const size_t> page, std::span<const std::vector<CapturedTexel>> texels) {
    std::vector<JointTile> built(page.size());
    parallel_for(page.size(), options.threads,
                 [&](size_t k) { built[k] = build_joint_tile(wanted[page[k]].rect, texels[k], plan.levels); });
    for (size_t k = 0; k < page.size(); ++k)
      place_joint_tile(plan, built[k], fit_plane(moments, tiles.sphere.centre, wanted[page[k]].basis), piece, page[k],
                       bake);
    done(page.size());
  });
}

PerJointBake empty_bake(const PerJointPlan& plan, const PerJointOptions& options) {
  PerJointBake bake;
  bake.texel = static_cast<float>(plan.texel);
  bake.pieces = static_cast<uint32_t>(plan.pieces.count());
  bake.views = static_cast<uint32_t>(options.grid.size());
  bake.levels = static_cast<uint32_t>(plan.levels);
  bake.emission_peak = plan.peak;
  for (size_t p = 0; p < bake.pieces; ++p) {
    const int joint = plan.pieces.joint[p];
    bake.joints.push_back(static_cast<uint32_t>(joint));
    for (const glm::vec4& row : plan.rest.inverse[static_cast<size_t>(joint)].rows)
      bake.inverse.push_back({row.x, row.y, row.z, row.w});
    const CaptureSphere& sphere = plan.tiles[p].sphere;
    bake.centres.push_back({static_cast<float>(sphere.centre.x), static_cast<float>(sphere.centre.y),
                            static_cast<float>(sphere.centre.z), static_cast<float>(sphere.radius)});
  }
  const size_t tiles = size_t{bake.levels} * bake.pieces * bake.views;
  bake.tiles.assign(2 * tiles, {});
  bake.outlines.assign(CB_PERJOINT_CORNERS * tiles, {});
  bake.width = plan.packing.width;
  bake.height = plan.packing.height;
  bake.layers = plan.packing.layers;
  const size_t texels =
      static_cast<size_t>(bake.width) * static_cast<size_t>(bake.height) * static_cast<size_t>(bake.layers);
  bake.albedo.assign(4 * texels, 0);
  bake.surface.assign(4 * texels, 0);
  if (plan.peak > 0) bake.emission.assign(4 * texels, 0);
  return bake;
}

}  // namespace

std::string perjoint_cache_key(const scene::Character& character, const scene::PoseBank& bank,
                               const PerJointOptions& options, const std::string& gl_renderer,
                               const std::string& gl_version) {
  Sha256 hash;
  hash.text("perjoint").value(kPerJointVersion).text(character.content_hash).text(gl_renderer).text(gl_version);
  hash.text(options.grid.text()).value(options.grid.el_min);
  hash.value(options.texels).value(options.least).value(options.border);
  hash_poses(hash, bank, {});
  for (const scene::BankClip& clip : bank.clips()) hash.value(clip.samples);
  return hash.hex();
}

PerJointBake bake_perjoint(gl::Context& context, const std::shared_ptr<const scene::Character>& character,
                           const scene::PoseBank& bank, const PerJointOptions& options, uint64_t budget,
                           const std::function<void(size_t, size_t)>& progress) {
  const PerJointPlan plan = make_perjoint_plan(*character, bank, options);
  check_budget(plan, options, context.limits(), character->name, budget);
  PerJointBake bake = empty_bake(plan, options);
  if (options.border > 0) {
    bake.borders.assign(bake.pieces, options.border);
  } else {
    const BorderChoice choice = choose_borders(*character, bank, plan.rest, plan.pieces, options.grid, options.threads);
    bake.borders = choice.borders;
    bake.torn = {static_cast<float>(choice.holes), static_cast<float>(choice.strays),
                 static_cast<float>(choice.holes_cut), static_cast<float>(choice.strays_cut)};
  }
  size_t done = 0;
  const size_t all = size_t{bake.pieces} * bake.views;
  for (size_t p = 0; p < bake.pieces; ++p) {
    const auto tell = [&](size_t more) {
      done += more;
      if (progress) progress(std::min(done, all), all);
    };
    bake_piece(context, *character, plan, options, p, tell, bake);
  }
  return bake;
}

std::vector<uint8_t> serialise(const PerJointBake& bake) {
  ByteWriter out;
  out.reserve(bake.texture_bytes() + (size_t{1} << 20));
  out.value(bake.texel);
  for (const uint32_t n : {bake.pieces, bake.views, bake.levels}) out.value(n);
  out.values(bake.joints);
  out.values(bake.inverse);
  out.values(bake.centres);
  out.values(bake.borders);
  out.value(bake.torn);
  out.values(bake.tiles);
  out.values(bake.outlines);
  for (const int n : {bake.width, bake.height, bake.layers}) out.value(n);
  out.value(bake.emission_peak);
  out.values(bake.albedo);
  out.values(bake.surface);
  out.values(bake.emission);
  return out.bytes();
}

std::optional<PerJointBake> deserialise_perjoint(std::span<const uint8_t> bytes) {
  ByteReader in(bytes);
  PerJointBake bake;
  bake.texel = in.value<float>();
  for (uint32_t* n : {&bake.pieces, &bake.views, &bake.levels}) *n = in.value<uint32_t>();
  bake.joints = in.values<uint32_t>();
  bake.inverse = in.values<std::array<float, 4>>();
  bake.centres = in.values<std::array<float, 4>>();
  bake.borders = in.values<float>();
  bake.torn = in.value<std::array<float, 4>>();
  bake.tiles = in.values<std::array<float, 4>>();
  bake.outlines = in.values<std::array<float, 2>>();
  for (int* n : {&bake.width, &bake.height, &bake.layers}) *n = in.value<int>();
  bake.emission_peak = in.value<float>();
  bake.albedo = in.values<uint8_t>();
  bake.surface = in.values<uint8_t>();
  bake.emission = in.values<uint8_t>();
  const uint64_t tiles = uint64_t{bake.levels} * bake.pieces * bake.views;
  const uint64_t pieces = bake.pieces;
  if (!in.ok() || !in.at_end() || bake.width < 0 || bake.height < 0 || bake.layers < 0) return std::nullopt;
  const uint64_t texels =
      static_cast<uint64_t>(bake.width) * static_cast<uint64_t>(bake.height) * static_cast<uint64_t>(bake.layers);
  if (bake.joints.size() != pieces || bake.inverse.size() != 3 * pieces || bake.centres.size() != pieces ||
      bake.borders.size() != pieces || bake.tiles.size() != 2 * tiles ||
      bake.outlines.size() != CB_PERJOINT_CORNERS * tiles || bake.albedo.size() != 4 * texels ||
      bake.surface.size() != 4 * texels || bake.emission.size() != (bake.emission_peak > 0 ? 4 * texels : 0))
    return std::nullopt;
  return bake;
}

}  // namespace crowdbench::renderers
