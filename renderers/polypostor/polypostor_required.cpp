#include "renderers/polypostor/polypostor_required.h"

#include <algorithm>
#include <cassert>
#include <map>
#include <tuple>
#include <utility>

namespace crowdbench::renderers {
namespace {

constexpr uint16_t kLayerMask = (1U << 11U) - 1;  // PolypostorVertex::layer

// The corners of a set: the first one's turn lies behind all positions of its frame.
size_t corner_count(const PolypostorBake& bake, const PolypostorSet& set) {
  return set.words == 0 ? 0 : bake.vertices[set.first_vertex].turn;
}

// The pages of one map that are kept, in their order. place: of every page, -1 where it is left out.
std::vector<uint8_t> kept_pages(const std::vector<uint8_t>& map, const std::vector<int>& place) {
  std::vector<uint8_t> out;
  const size_t page = map.size() / std::max<size_t>(place.size(), 1);
  for (size_t i = 0; i < place.size(); ++i) {
    const auto first = map.begin() + static_cast<std::ptrdiff_t>(i * page);
    if (place[i] >= 0) out.insert(out.end(), first, first + static_cast<std::ptrdiff_t>(page));
  }
  return out;
}

// The bake without sets, with the pages that have a place.
PolypostorBake pages_of(const PolypostorBake& whole, const std::vector<int>& place, int layers) {
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
  out.layers = layers;
  out.albedo = kept_pages(whole.albedo, place);
  out.normals = kept_pages(whole.normals, place);
  out.materials = kept_pages(whole.materials, place);
  out.emission_peak = whole.emission_peak;
  out.emission = kept_pages(whole.emission, place);
  out.parts = whole.parts;
  out.parts_seen = whole.parts_seen;
  out.corners_seen = whole.corners_seen;
  out.outline_error = whole.outline_error;
  out.repaired = whole.repaired;
  out.torn = whole.torn;
  out.torn_most = whole.torn_most;
  return out;
}

// First word of the whole -> first word and first range of what is kept: the levels of a tier share words and
// triangles.
using KeptWords = std::map<uint32_t, std::pair<uint32_t, uint32_t>>;

// Set `s` of the whole with its words, triangles and corners, at the ends of what `out` has. place: of every page.
void keep_set(const PolypostorBake& whole, size_t s, const std::vector<int>& place, KeptWords& words,
              PolypostorBake& out) {
  const PolypostorSet& from = whole.sets[s];
  PolypostorSet& to = out.sets[s];
  to.words = from.words;
  const StoredClip& clip = whole.clips[s / whole.views % whole.clips.size()];
  const auto [known, is_new] = words.try_emplace(from.first_word, out.words.size(), out.ranges.size());
  std::tie(to.first_word, to.first_range) = known->second;
  if (is_new) {
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
  for (size_t k = 0; k < corner_count(whole, from); ++k) {
    PolypostorVertex vertex = whole.vertices[from.first_vertex + k];
    const int layer = place[vertex.layer & kLayerMask];
    vertex.layer = static_cast<uint16_t>((vertex.layer & ~kLayerMask) | layer);
    out.vertices.push_back(vertex);
  }
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
  std::vector<size_t> sets;
  std::vector<int> place(static_cast<size_t>(whole.layers), -1);
  for (size_t s = 0; s < whole.sets.size(); ++s) {
    const PolypostorSet& set = whole.sets[s];
    if (needed[s % a_level] == 0 || set.words == 0) continue;
    sets.push_back(s);
    for (size_t k = 0; k < corner_count(whole, set); ++k)
      place[whole.vertices[set.first_vertex + k].layer & kLayerMask] = 0;
  }
  int layers = 0;
  for (int& at : place)
    if (at >= 0) at = layers++;

  PolypostorBake out = pages_of(whole, place, layers);
  // What views that were left out draw: nothing, in any frame.
  uint32_t most_frames = 1;
  for (const StoredClip& clip : whole.clips) most_frames = std::max(most_frames, clip.frames);
  out.ranges.resize(whole.ranges_by_frame != 0 ? most_frames : 1);
  out.sets.resize(whole.sets.size());
  KeptWords words;
  for (const size_t s : sets) keep_set(whole, s, place, words, out);
  return out;
}

uint64_t gpu_bytes(const PolypostorBake& bake) {
  const auto bytes = [](const auto& values) { return uint64_t{values.size()} * sizeof(values[0]); };
  return bake.texture_bytes() + bytes(bake.sets) + bytes(bake.ranges) + bytes(bake.indices) + bytes(bake.vertices) +
         bytes(bake.words);
}

uint64_t view_count(const PolypostorBake& bake) {
  const auto a_level = static_cast<std::ptrdiff_t>(bake.clips.size() * bake.views);
  return static_cast<uint64_t>(std::count_if(bake.sets.begin(), bake.sets.begin() + a_level,
                                             [](const PolypostorSet& set) { return set.words != 0; }));
}

}  // namespace crowdbench::renderers
