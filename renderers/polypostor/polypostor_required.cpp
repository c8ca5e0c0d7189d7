#include "renderers/polypostor/polypostor_required.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

namespace crowdbench::renderers {
namespace {

constexpr uint32_t kLayerBits = 11;  // PolypostorVertex::layer
constexpr uint16_t kLayerMask = (1U << kLayerBits) - 1;

// Texels of a page that one polygon reads, ends included.
struct Patch {
  int low_x = 0, low_y = 0, high_x = -1, high_y = -1;
  int source = 0;  // layer of the whole bake
  int layer = 0;   // of what is kept
  int area() const { return (high_x - low_x + 1) * (high_y - low_y + 1); }
};

// A set that is kept, with what each of its corners reads.
struct KeptSet {
  size_t set = 0;
  std::vector<size_t> patch_of_corner;
};

// The two texels that a filter mixes at a coordinate of 0 to 65535, along a side of `size` texels.
std::pair<int, int> filtered(uint16_t code, int size) {
  constexpr double kRounding = 1e-3;  // of a texel
  const double at = code / 65535.0 * size - 0.5;
  return {std::clamp(static_cast<int>(std::floor(at - kRounding)), 0, size - 1),
          std::clamp(static_cast<int>(std::floor(at + kRounding)) + 1, 0, size - 1)};
}

// The corners of a set: the first one's turn lies behind all positions of its frame.
size_t corner_count(const PolypostorBake& bake, const PolypostorSet& set) {
  return set.words == 0 ? 0 : bake.vertices[set.first_vertex].turn;
}

KeptSet keep_set(const PolypostorBake& bake, size_t index, std::vector<Patch>& patches) {
  KeptSet kept{index, {}};
  const PolypostorSet& set = bake.sets[index];
  const size_t corners = corner_count(bake, set);
  const size_t first_patch = patches.size();
  for (size_t k = 0; k < corners; ++k) {
    const PolypostorVertex& vertex = bake.vertices[set.first_vertex + k];
    const size_t sheet = first_patch + vertex.turn + k - corners;
    const auto [left, right] = filtered(vertex.u, bake.width);
    const auto [low, high] = filtered(vertex.v, bake.height);
    if (sheet == patches.size()) {
      patches.push_back({left, low, right, high, vertex.layer & kLayerMask, 0});
    } else {
      Patch& patch = patches[sheet];
      patch = {std::min(patch.low_x, left),
               std::min(patch.low_y, low),
               std::max(patch.high_x, right),
               std::max(patch.high_y, high),
               patch.source,
               0};
    }
    kept.patch_of_corner.push_back(sheet);
  }
  return kept;
}

// Gives every patch the first layer where its place is free or holds the same page. Returns the number of layers.
int assign_layers(std::vector<Patch>& patches, int width, int height) {
  constexpr int16_t kFree = -1;
  std::vector<size_t> order(patches.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return patches[a].area() > patches[b].area(); });
  std::vector<std::vector<int16_t>> layers;  // by texel: which source layer lies there
  for (const size_t i : order) {
    Patch& patch = patches[i];
    const auto source = static_cast<int16_t>(patch.source);
    const auto every_texel = [&](auto& layer, const auto& see) {
      for (int y = patch.low_y; y <= patch.high_y; ++y)
        for (int x = patch.low_x; x <= patch.high_x; ++x)
          if (!see(layer[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)])) return false;
      return true;
    };
    auto found = std::find_if(layers.begin(), layers.end(), [&](auto& layer) {
      return every_texel(layer, [&](int16_t holds) { return holds == kFree || holds == source; });
    });
    if (found == layers.end()) {
      layers.emplace_back(static_cast<size_t>(width) * static_cast<size_t>(height), kFree);
      found = layers.end() - 1;
    }
    every_texel(*found, [&](int16_t& holds) {
      holds = source;
      return true;
    });
    patch.layer = static_cast<int>(found - layers.begin());
  }
  return static_cast<int>(layers.size());
}

// One map of the kept pages.
std::vector<uint8_t> kept_texels(const PolypostorBake& whole, const std::vector<uint8_t>& map, size_t texel_bytes,
                                 const std::vector<Patch>& patches, int layers) {
  if (map.empty()) return {};
  const auto width = static_cast<size_t>(whole.width);
  const size_t page = width * static_cast<size_t>(whole.height);
  std::vector<uint8_t> out(page * static_cast<size_t>(layers) * texel_bytes);
  for (const Patch& patch : patches)
    for (int y = patch.low_y; y <= patch.high_y; ++y) {
      const size_t at = static_cast<size_t>(y) * width + static_cast<size_t>(patch.low_x);
      const auto from = static_cast<std::ptrdiff_t>((static_cast<size_t>(patch.source) * page + at) * texel_bytes);
      const auto to = static_cast<std::ptrdiff_t>((static_cast<size_t>(patch.layer) * page + at) * texel_bytes);
      std::copy_n(map.begin() + from, static_cast<size_t>(patch.high_x - patch.low_x + 1) * texel_bytes,
                  out.begin() + to);
    }
  return out;
}

}  // namespace

std::vector<uint8_t> needed_views(const PolypostorBake& bake, const ViewGrid& grid,
                                  const std::function<void(const std::function<void(const ViewSample&)>&)>& visit) {
  std::vector<uint8_t> needed(bake.clips.size() * bake.views);
  const glm::dvec3 centre(bake.centre[0], bake.centre[1], bake.centre[2]);
  visit([&](const ViewSample& seen) {
    const size_t first = static_cast<size_t>(seen.bank_clip) * bake.views;
    grid.visit_picks(glm::dvec3(seen.eye) - centre, false,
                     [&](int view, bool) { needed[first + static_cast<size_t>(view)] = 1; });
  });
  return needed;
}

PolypostorBake only_views(const PolypostorBake& whole, const std::vector<uint8_t>& needed) {
  const size_t a_level = whole.clips.size() * whole.views;
  assert(needed.size() == a_level);
  std::vector<Patch> patches;
  std::vector<KeptSet> sets;
  for (size_t s = 0; s < whole.sets.size(); ++s)
    if (needed[s % a_level] != 0 && whole.sets[s].words != 0) sets.push_back(keep_set(whole, s, patches));

  PolypostorBake out;
  out.centre = whole.centre;
  out.radius = whole.radius;
  out.texel = whole.texel;
  out.unit = whole.unit;
  out.unit_z = whole.unit_z;
  out.frames = whole.frames;
  out.views = whole.views;
  out.levels = whole.levels;
  out.ranges_by_frame = whole.ranges_by_frame;
  out.clips = whole.clips;
  out.width = whole.width;
  out.height = whole.height;
  out.layers = assign_layers(patches, whole.width, whole.height);
  out.albedo = kept_texels(whole, whole.albedo, 4, patches, out.layers);
  out.normals = kept_texels(whole, whole.normals, 2, patches, out.layers);
  out.materials = kept_texels(whole, whole.materials, 1, patches, out.layers);
  out.emission_peak = whole.emission_peak;
  out.emission = kept_texels(whole, whole.emission, 4, patches, out.layers);
  out.parts = whole.parts;
  out.parts_seen = whole.parts_seen;
  out.corners_seen = whole.corners_seen;
  out.outline_error = whole.outline_error;
  out.repaired = whole.repaired;

  // What views that were left out draw: nothing, in any frame.
  uint32_t most_frames = 1;
  for (const StoredClip& clip : whole.clips) most_frames = std::max(most_frames, clip.frames);
  out.ranges.resize(whole.ranges_by_frame != 0 ? most_frames : 1);
  out.sets.resize(whole.sets.size());
  std::map<uint32_t, std::pair<uint32_t, uint32_t>> moved;  // first word of the whole: first word and range of the kept
  for (const KeptSet& kept : sets) {
    const PolypostorSet& from = whole.sets[kept.set];
    PolypostorSet& to = out.sets[kept.set];
    to.words = from.words;
    const StoredClip& clip = whole.clips[kept.set / whole.views % whole.clips.size()];
    const auto [place, is_new] = moved.try_emplace(from.first_word, out.words.size(), out.ranges.size());
    std::tie(to.first_word, to.first_range) = place->second;
    if (is_new) {  // the levels of a tier share words and triangles
      const auto first = whole.words.begin() + from.first_word;
      out.words.insert(out.words.end(), first, first + static_cast<std::ptrdiff_t>(size_t{from.words} * clip.frames));
      for (uint32_t r = 0; r < (whole.ranges_by_frame != 0 ? clip.frames : 1); ++r) {
        const PolypostorRange& range = whole.ranges[from.first_range + r];
        const auto corners = whole.indices.begin() + range.first_index;
        out.ranges.push_back({static_cast<uint32_t>(out.indices.size()), range.indices});
        out.indices.insert(out.indices.end(), corners, corners + range.indices);
      }
    }
    to.first_vertex = static_cast<uint32_t>(out.vertices.size());
    for (size_t k = 0; k < kept.patch_of_corner.size(); ++k) {
      PolypostorVertex vertex = whole.vertices[from.first_vertex + k];
      const auto layer = static_cast<uint16_t>(patches[kept.patch_of_corner[k]].layer);
      vertex.layer = static_cast<uint16_t>((vertex.layer & ~kLayerMask) | layer);
      out.vertices.push_back(vertex);
    }
  }
  return out;
}

uint64_t view_count(const PolypostorBake& bake) {
  const auto a_level = static_cast<std::ptrdiff_t>(bake.clips.size() * bake.views);
  return static_cast<uint64_t>(std::count_if(bake.sets.begin(), bake.sets.begin() + a_level,
                                             [](const PolypostorSet& set) { return set.words != 0; }));
}

}  // namespace crowdbench::renderers
