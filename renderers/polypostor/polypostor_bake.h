// The bake of polypostors: for each clip and view the parts' key images, packed into pages, and the polygons that move
// them through the clip's frames.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderers/impostor/tiles/stored_frames.h"
#include "renderers/impostor/views/view_grid.h"
#include "renderers/impostor/views/view_sampling.h"
#include "scene/character/character.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench::gl {
class Context;
}

namespace crowdbench::renderers {

// enough: the one that is most visible, and further ones while what is shown is torn.
enum class KeyChoice : uint8_t { first, most_visible, two_keys, enough };

struct PolypostorBakeOptions {
  ViewGrid grid;
  FrameCount frames;
  int texels = 128;  // across the enclosing sphere: the texel size is its diameter over this
  int corners = 8;   // of a part's polygon, 4..32
  KeyChoice key = KeyChoice::enough;
  std::string cuts = "auto";  // cut_parts
  unsigned threads = 0;       // 0: as many as there are cores, 8 at most; the bytes do not depend on it
};

// One corner of a part's polygon at one level.
struct PolypostorVertex {
  uint16_t u = 0, v = 0;  // of 65535, on the page
  uint16_t layer = 0;     // in the low 11 bits; above, the part
  uint16_t turn = 0;      // words from this corner's position to its part's turn
};
inline constexpr int kPolypostorParts = 32;  // of one character, at most

// One view of one clip at one level. A frame's block of words: a position a corner (x, y in 12 bits each, z in 8; units
// and zeros in the bake), then cos and sin of each part's turn in the plane (two signed normalised 16-bit numbers).
struct PolypostorSet {
  uint32_t first_word = 0;  // of the first frame's block
  uint32_t words = 0;       // a block
  uint32_t first_range = 0;
  uint32_t first_vertex = 0;
};
struct PolypostorRange {
  uint32_t first_index = 0;
  uint32_t indices = 0;
};

struct PolypostorBake {
  std::array<float, 3> centre{};  // of the enclosing sphere, model space, metres
  float radius = 0;               // metres
  float texel = 0;                // metres, of level 0
  float unit = 0;                 // metres, of x and y; zero is at 2048
  float unit_z = 0;               // metres towards the eye, of z; zero is at 128
  uint32_t frames = 0;            // of all clips
  uint32_t views = 0;
  uint32_t levels = 0;
  uint32_t ranges_by_frame = 0;  // 1: a set has a range for each frame (two keys); 0: one for all
  std::vector<StoredClip> clips;
  int width = 0, height = 0, layers = 0;  // of the pages; row 0 lowest
  // renderers/impostor/tiles/tile.h: albedo RGBA8; x and y of the normal RG8; material id R8.
  std::vector<uint8_t> albedo, normals, materials;
  float emission_peak = 0;          // linear light, of all materials (renderers/bake/emission.h)
  std::vector<uint8_t> emission;    // RGBA8; empty where the peak is 0
  std::vector<PolypostorSet> sets;  // levels x clips x views
  std::vector<PolypostorRange> ranges;
  std::vector<uint16_t> indices;  // triangles, from the set's first vertex
  std::vector<PolypostorVertex> vertices;
  std::vector<uint32_t> words;
  // Of the fine polygons, for people: parts; parts seen in a view and their corners, means; the mean distance in texels
  // between moved outlines and the frames' own; frames of parts whose polygon had to be made more alike to its key.
  double parts = 0, parts_seen = 0, corners_seen = 0, outline_error = 0, repaired = 0;
  // How torn outlines are (torn_area), per mille of the silhouette: the mean over views and poses, and the most of any.
  double torn = 0, torn_most = 0;
  uint64_t texture_bytes() const { return albedo.size() + normals.size() + materials.size() + emission.size(); }
};

std::string polypostor_cache_key(const scene::Character& character, const scene::PoseBank& bank,
                                 const PolypostorBakeOptions& options, const std::string& gl_renderer,
                                 const std::string& gl_version);

// Bakes every clip of the bank; clips of a single sample are baked as that one pose. Throws Error: no extent, more than
// kPolypostorParts parts, textures of more than `budget` bytes.
PolypostorBake bake_polypostor(gl::Context& context, const std::shared_ptr<const scene::Character>& character,
                               const std::shared_ptr<const scene::PoseBank>& bank, const PolypostorBakeOptions& options,
                               uint64_t budget, const std::function<void(size_t done, size_t total)>& progress = {});

// What such a bake would sample, without making it: texture bytes by the bounds of each part in a view, mean over the
// frames (which of them is kept is known only once polygons are fitted).
ViewSampling sample_polypostors(const scene::Character& character, const std::shared_ptr<const scene::PoseBank>& bank,
                                const PolypostorBakeOptions& options);

std::vector<uint8_t> serialise(const PolypostorBake& bake);
// std::nullopt when the bytes are not a sound bake.
std::optional<PolypostorBake> deserialise_polypostor(std::span<const uint8_t> bytes);

}  // namespace crowdbench::renderers
