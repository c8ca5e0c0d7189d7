// Based on: Kavan, Dobbyn, Collins, Zara and O'Sullivan 2008, "Polypostors: 2D polygonal impostors for 3D crowds" (an
// image a body part and view, deformed by a polygon whose corners follow the part's contour). Differs from the source:
// parts are found from the skeleton; the key frame is the one whose image looks best in all frames; each part has a
// depth plane; far away fewer parts with fewer corners are drawn; colours and normals apart, lit at run time.
#include "renderers/polypostor/polypostor_bake.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/hash.h"
#include "core/parallel.h"
#include "renderers/bake/bake_cache.h"
#include "renderers/bake/bake_loader.h"
#include "renderers/polypostor/polypostor_images.h"
#include "renderers/polypostor/polypostor_order.h"
#include "renderers/polypostor/polypostor_plan.h"
#include "renderers/polypostor/polypostor_view.h"

namespace crowdbench::renderers {
namespace {

constexpr uint32_t kBakeVersion = 27;  // raised whenever the same inputs give other bytes

uint32_t pack_position(const glm::dvec2& p, double z, double quantum, double unit_z) {
  const auto code = [](double v, double zero, double most) {
    return static_cast<uint32_t>(std::clamp(std::round(v + zero), 0.0, most));
  };
  return code(p.x / quantum, 2048, 4095) | code(p.y / quantum, 2048, 4095) << 12U | code(z / unit_z, 128, 255) << 24U;
}

uint32_t pack_turn(const glm::dvec2& turn) {
  const auto code = [](double v) {
    return static_cast<uint32_t>(static_cast<uint16_t>(static_cast<int16_t>(std::lround(v * 32767))));
  };
  return code(turn.x) | code(turn.y) << 16U;
}

size_t corners_of(const ViewParts& view) {
  size_t corners = 0;
  for (const auto& sheets : view.sheets)
    for (const Sheet& sheet : sheets) corners += sheet.fit.polygon.size();
  return corners;
}

// Every pose's block of words.
void store_words(const PolypostorPlan& plan, const ViewParts& view, PolypostorBake& bake) {
  for (size_t f = 0; f < plan.frames.clips[view.clip].frames; ++f) {
    for (const auto& sheets : view.sheets)
      for (const Sheet& sheet : sheets)
        for (const glm::dvec2& p : sheet.fit.poses[f]) {
          const glm::dvec3 corner = on_plane(plan, sheet.planes[f], p);
          bake.words.push_back(pack_position(corner, corner.z, plan.quantum, static_cast<double>(bake.unit_z)));
        }
    for (const auto& sheets : view.sheets)
      for (const Sheet& sheet : sheets) bake.words.push_back(pack_turn(sheet.fit.turns[f]));
  }
}

// The triangles of the sheets that are shown: in each frame, or once for all.
void store_triangles(const PolypostorPlan& plan, const ViewParts& view, PolypostorBake& bake) {
  const size_t frames = plan.frames.clips[view.clip].frames;
  for (size_t f = 0; f < (bake.ranges_by_frame != 0 ? frames : 1); ++f) {
    PolypostorRange range{static_cast<uint32_t>(bake.indices.size()), 0};
    size_t base = 0;
    for (const auto& sheets : view.sheets) {
      const size_t shown = sheets.empty() ? 0 : sheet_for(sheets, f, frames);
      for (size_t s = 0; s < sheets.size(); ++s) {
        if (s == shown)
          for (const Triangle& t : sheets[s].fit.triangles)
            for (const uint16_t corner : t) bake.indices.push_back(static_cast<uint16_t>(base + corner));
        base += sheets[s].fit.polygon.size();
      }
    }
    range.indices = static_cast<uint32_t>(bake.indices.size()) - range.first_index;
    bake.ranges.push_back(range);
  }
}

// Where the corners lie on the pages at one level.
void store_vertices(const ViewParts& view, uint32_t level, uint32_t first_level, std::span<const Tile> tiles,
                    std::span<const PackPlace> places, PolypostorBake& bake) {
  const size_t corners = corners_of(view);
  size_t corner = 0;
  size_t sheet_index = 0;
  for (size_t part = 0; part < view.sheets.size(); ++part)
    for (const Sheet& sheet : view.sheets[part]) {
      const size_t tile = sheet.first_tile + level - first_level;
      const PackPlace& place = places[tile];
      const TileRect& rect = tiles[tile].rect;
      for (const glm::dvec2& p : sheet.fit.polygon) {
        const glm::dvec2 at =
            p / std::exp2(static_cast<double>(level)) + glm::dvec2(place.x - rect.x, place.y - rect.y);
        const auto code = [](double v) {
          return static_cast<uint16_t>(std::clamp(std::round(v * 65535), 0.0, 65535.0));
        };
        bake.vertices.push_back({code(at.x / bake.width), code(at.y / bake.height),
                                 static_cast<uint16_t>(std::max(place.layer, 0) | static_cast<int>(part) << 11),
                                 static_cast<uint16_t>(corners + sheet_index - corner)});
        ++corner;
      }
      ++sheet_index;
    }
}

void store_view(const PolypostorPlan& plan, const ViewParts& view, std::span<const Tile> tiles,
                std::span<const PackPlace> places, PolypostorBake& bake) {
  const PolypostorTier& tier = plan.tiers[view.tier];
  PolypostorSet set;
  set.first_word = static_cast<uint32_t>(bake.words.size());
  set.words = static_cast<uint32_t>(corners_of(view));
  for (const auto& sheets : view.sheets) set.words += static_cast<uint32_t>(sheets.size());
  set.first_range = static_cast<uint32_t>(bake.ranges.size());
  store_words(plan, view, bake);
  store_triangles(plan, view, bake);
  for (uint32_t l = tier.first_level; l < tier.first_level + tier.levels; ++l) {
    set.first_vertex = static_cast<uint32_t>(bake.vertices.size());
    store_vertices(view, l, tier.first_level, tiles, places, bake);
    bake.sets[(l * bake.clips.size() + view.clip) * bake.views + view.view] = set;
  }
}

// Texels that hold a part in a view.
TileRect part_bounds(const PolypostorPlan& plan, const std::vector<glm::vec3>& positions,
                     const std::vector<uint32_t>& corners, const ViewBasis& basis) {
  glm::dvec2 low(INFINITY);
  glm::dvec2 high(-INFINITY);
  for (const uint32_t v : corners) {
    const glm::dvec3 d = (glm::dvec3(positions[v]) - plan.sphere.centre) / plan.texel;
    const glm::dvec2 p(glm::dot(d, basis.right), glm::dot(d, basis.up));
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  if (corners.empty()) return {};
  const glm::ivec2 first(glm::floor(low));
  const glm::ivec2 size = glm::ivec2(glm::ceil(high)) - first;
  return {first.x, first.y, size.x, size.y};
}

// The figures that are for people: of the fine polygons.
void summarise(const PolypostorPlan& plan, std::span<const ViewParts> views, PolypostorBake& bake) {
  double seen = 0;
  double corners = 0;
  double errors = 0;
  double fine_views = 0;
  double poses = 0;
  for (const ViewParts& view : views) {
    if (view.tier != 0) continue;
    ++fine_views;
    for (size_t f = 0; f < view.areas.size(); ++f) {
      if (view.areas[f] <= 0) continue;
      double torn = 0;
      for (const auto& sheets : view.sheets)
        if (!sheets.empty()) torn += sheets[sheet_for(sheets, f, view.areas.size())].torn[f];
      bake.torn += 1000 * torn / view.areas[f];
      bake.torn_most = std::max(bake.torn_most, 1000 * torn / view.areas[f]);
      ++poses;
    }
    for (const auto& sheets : view.sheets)
      for (const Sheet& sheet : sheets) {
        ++seen;
        corners += static_cast<double>(sheet.fit.polygon.size());
        for (const double e : sheet.fit.errors) errors += e / static_cast<double>(sheet.fit.errors.size());
        bake.repaired += static_cast<double>(sheet.fit.repaired);
      }
  }
  bake.parts = static_cast<double>(plan.tiers[0].corners.size());
  bake.parts_seen = seen / fine_views;
  bake.corners_seen = corners / std::max(seen, 1.0);
  bake.outline_error = errors / std::max(seen, 1.0);
  bake.torn /= std::max(poses, 1.0);
}

}  // namespace

std::string polypostor_cache_key(const scene::Character& character, const scene::PoseBank& bank,
                                 const PolypostorBakeOptions& options, const std::string& gl_renderer,
                                 const std::string& gl_version) {
  Sha256 hash;
  hash.text("polypostor").value(kBakeVersion).text(character.content_hash).text(gl_renderer).text(gl_version);
  hash.text(options.grid.text()).value(options.grid.el_min).text(options.cuts);
  hash.value(options.texels).value(options.corners).value(options.key);
  hash_poses(hash, bank, options.frames);
  return hash.hex();
}

ViewSampling sample_polypostors(const scene::Character& character, const std::shared_ptr<const scene::PoseBank>& bank,
                                const PolypostorBakeOptions& options) {
  const PolypostorPlan plan = plan_polypostors(character, bank, options);
  ViewSampling out;
  out.grid = options.grid;
  const StoredFrames frames = stored_frames(character, bank, options.frames);
  out.frames = most_frames(frames);
  out.texel = plan.texel;
  out.centre = plan.sphere.centre;
  out.lies = ViewLies::by_part;
  set_pose_steps(out, pose_steps(frames, frames.positions(character.mesh)));
  double bytes = 0;
  for (const PolypostorTier& tier : plan.tiers)
    for (int v = 0; v < options.grid.size(); ++v) {
      if (!options.grid.reachable(v)) continue;
      const ViewBasis basis = options.grid.basis(v);
      for (const auto& corners : tier.corners)
        for (const StoredClip& clip : plan.frames.clips)
          for (uint32_t f = clip.first_frame; f < clip.first_frame + clip.frames; ++f) {
            const TileRect rect = part_bounds(plan, tier.positions[f], corners, basis);
            bytes += static_cast<double>(image_bytes(plan, tier, rect.width, rect.height)) / clip.frames;
          }
    }
  // As many keys as it takes were two of a part on the mannequin and three on characters with capes and jackets.
  const double keys = options.key == KeyChoice::enough ? 2.5 : options.key == KeyChoice::two_keys ? 2 : 1;
  out.texture_bytes = static_cast<uint64_t>(bytes * keys);
  return out;
}

PolypostorBake bake_polypostor(gl::Context& context, const std::shared_ptr<const scene::Character>& character,
                               const std::shared_ptr<const scene::PoseBank>& bank, const PolypostorBakeOptions& options,
                               uint64_t budget, const std::function<void(size_t, size_t)>& progress) {
  const PolypostorPlan plan = plan_polypostors(*character, bank, options);
  const auto grid_views = static_cast<size_t>(options.grid.size());
  const size_t clips = plan.frames.clips.size();
  std::vector<ViewParts> views;
  for (size_t t = 0; t < plan.tiers.size(); ++t)
    for (size_t c = 0; c < clips; ++c)
      for (size_t v = 0; v < grid_views; ++v) views.push_back({t, c, v, {}, {}});
  const size_t image_steps = views.size() / 4;  // images take about a fifth of the time
  const size_t total = views.size() + image_steps + 1;
  const auto advance = [&](size_t done) {
    if (progress) progress(done, total);
  };

  parallel_for(
      views.size(), options.threads,
      [&](size_t i) {
        ViewParts& view = views[i];
        if (options.grid.reachable(static_cast<int>(view.view)))
          fit_view(plan, options.grid.basis(static_cast<int>(view.view)), options.key, view);
      },
      advance);

  if (const uint64_t bytes = image_bytes(plan, views); bytes > budget) {
    constexpr int kLeastTexels = 16;
    constexpr double kSafe = 0.95;  // gutters do not shrink as images do
    const int texels =
        fitting_size(options.texels, kLeastTexels, bytes, static_cast<uint64_t>(kSafe * static_cast<double>(budget)));
    throw Error(fmt::format("polypostor bake of {}", character->name),
                fmt::format("{} clip{}, {} views and {} texels need about {:.1f} MiB, the budget is {:.0f}", clips,
                            clips == 1 ? "" : "s", grid_views, options.texels, static_cast<double>(bytes) / (1 << 20),
                            static_cast<double>(budget) / (1 << 20)),
                budget_advice(texels == 0 ? "" : fmt::format("texels={}", texels),
                              "lower texels or views, use fewer clips or characters", bytes, budget));
  }
  const std::vector<Tile> tiles = capture_images(context, plan, options.grid, views, options.threads, [&](double done) {
    advance(views.size() + static_cast<size_t>(done * static_cast<double>(image_steps)));
  });

  PolypostorBake bake;
  bake.centre = {static_cast<float>(plan.sphere.centre.x), static_cast<float>(plan.sphere.centre.y),
                 static_cast<float>(plan.sphere.centre.z)};
  bake.radius = static_cast<float>(plan.sphere.radius);
  bake.texel = static_cast<float>(plan.texel);
  bake.unit = static_cast<float>(plan.quantum * plan.texel);
  bake.unit_z = static_cast<float>(depth_unit(plan));
  bake.frames = static_cast<uint32_t>(plan.frames.size());
  bake.views = static_cast<uint32_t>(grid_views);
  bake.levels = plan.tiers.back().first_level + plan.tiers.back().levels;
  bake.ranges_by_frame = options.key == KeyChoice::two_keys || options.key == KeyChoice::enough ? 1 : 0;
  bake.clips = plan.frames.clips;
  bake.emission_peak = plan.emission_peak;
  const std::vector<PackPlace> places = pack_images(tiles, bake);
  bake.sets.resize(bake.levels * clips * grid_views);
  for (const ViewParts& view : views) store_view(plan, view, tiles, places, bake);
  summarise(plan, views, bake);
  advance(total);
  return bake;
}

std::vector<uint8_t> serialise(const PolypostorBake& bake) {
  ByteWriter out;
  out.reserve(bake.texture_bytes() + (size_t{1} << 20));
  out.value(bake.centre);
  for (const float v : {bake.radius, bake.texel, bake.unit, bake.unit_z}) out.value(v);
  for (const uint32_t v : {bake.frames, bake.views, bake.levels, bake.ranges_by_frame}) out.value(v);
  for (const int v : {bake.width, bake.height, bake.layers}) out.value(v);
  for (const double v :
       {bake.parts, bake.parts_seen, bake.corners_seen, bake.outline_error, bake.repaired, bake.torn, bake.torn_most})
    out.value(v);
  out.values(bake.clips);
  out.values(bake.albedo);
  out.values(bake.normals);
  out.values(bake.materials);
  out.value(bake.emission_peak);
  if (bake.emission_peak > 0) out.values(bake.emission);
  out.values(bake.sets);
  out.values(bake.ranges);
  out.values(bake.indices);
  out.values(bake.vertices);
  out.values(bake.words);
  return out.bytes();
}

std::optional<PolypostorBake> deserialise_polypostor(std::span<const uint8_t> bytes) {
  ByteReader in(bytes);
  PolypostorBake bake;
  bake.centre = in.value<std::array<float, 3>>();
  for (float* v : {&bake.radius, &bake.texel, &bake.unit, &bake.unit_z}) *v = in.value<float>();
  for (uint32_t* v : {&bake.frames, &bake.views, &bake.levels, &bake.ranges_by_frame}) *v = in.value<uint32_t>();
  for (int* v : {&bake.width, &bake.height, &bake.layers}) *v = in.value<int>();
  for (double* v : {&bake.parts, &bake.parts_seen, &bake.corners_seen, &bake.outline_error, &bake.repaired, &bake.torn,
                    &bake.torn_most})
    *v = in.value<double>();
  bake.clips = in.values<StoredClip>();
  bake.albedo = in.values<uint8_t>();
  bake.normals = in.values<uint8_t>();
  bake.materials = in.values<uint8_t>();
  bake.emission_peak = in.value<float>();
  if (bake.emission_peak > 0) bake.emission = in.values<uint8_t>();
  bake.sets = in.values<PolypostorSet>();
  bake.ranges = in.values<PolypostorRange>();
  bake.indices = in.values<uint16_t>();
  bake.vertices = in.values<PolypostorVertex>();
  bake.words = in.values<uint32_t>();
  if (!in.ok() || !in.at_end() || bake.width < 0 || bake.height < 0 || bake.layers < 0 || bake.clips.empty())
    return std::nullopt;
  const uint64_t texels =
      static_cast<uint64_t>(bake.width) * static_cast<uint64_t>(bake.height) * static_cast<uint64_t>(bake.layers);
  if (bake.albedo.size() != 4 * texels || bake.normals.size() != 2 * texels || bake.materials.size() != texels ||
      bake.emission.size() != (bake.emission_peak > 0 ? 4 * texels : 0) ||
      bake.sets.size() != uint64_t{bake.levels} * bake.clips.size() * bake.views)
    return std::nullopt;
  // What the GPU will follow must lead nowhere else.
  for (size_t i = 0; i < bake.sets.size(); ++i) {
    const PolypostorSet& set = bake.sets[i];
    const StoredClip& clip = bake.clips[i / bake.views % bake.clips.size()];
    const uint64_t ranges = bake.ranges_by_frame != 0 ? clip.frames : 1;
    if (clip.frames == 0 || uint64_t{clip.first_frame} + clip.frames > bake.frames ||
        set.first_word + uint64_t{set.words} * clip.frames > bake.words.size() ||
        set.first_range + ranges > bake.ranges.size() || set.first_vertex > bake.vertices.size())
      return std::nullopt;
    for (uint64_t r = set.first_range; r < set.first_range + ranges; ++r) {
      const PolypostorRange& range = bake.ranges[r];
      if (uint64_t{range.first_index} + range.indices > bake.indices.size()) return std::nullopt;
      for (uint32_t k = range.first_index; k < range.first_index + range.indices; ++k) {
        const uint64_t vertex = set.first_vertex + uint64_t{bake.indices[k]};
        if (vertex >= bake.vertices.size() || bake.indices[k] + uint64_t{bake.vertices[vertex].turn} >= set.words)
          return std::nullopt;
      }
    }
  }
  return bake;
}

}  // namespace crowdbench::renderers
