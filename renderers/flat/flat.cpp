#include "renderers/flat/flat.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <tuple>

#include "core/error.h"
#include "renderers/bake/bake_loader.h"
#include "renderers/bake/emission.h"
#include "renderers/flat/flat.shared.h"
#include "renderers/flat/flat_bake.h"
#include "renderers/frame/frame_resources.h"
#include "renderers/gl/objects.h"
#include "renderers/gl/per_sample.h"
#include "renderers/gl/program.h"
#include "renderers/impostor/tiles/level_order.h"
#include "renderers/impostor/tiles/tile_textures.h"
#include "renderers/impostor/views/view_options.h"
#include "renderers/shaders/bindings.shared.h"

namespace crowdbench::renderers {
namespace {

// `Table` of flat_table.glsl, std140.
struct LevelTable {
  glm::vec4 centre;
  glm::ivec4 grid;
  glm::vec4 span;
  glm::vec4 scale;
  glm::uvec4 first;
  glm::uvec4 layers;
  glm::vec4 motion;
  glm::uvec4 clips[CB_FLAT_CLIPS];
};

// BC3, which is no part of OpenGL, and BC1 as sRGB.
constexpr const char* kS3tc = "GL_EXT_texture_compression_s3tc";
constexpr const char* kSrgb = "GL_EXT_texture_sRGB";

// Agents drawn by one call: bounds the index buffer.
constexpr uint32_t kBatch = 8192;

struct CharacterTiles {
  // Some layers of a level: as many as an array texture may have.
  struct Array {
    gl::Buffer table;
    gl::Texture albedo, surface;
    gl::Texture slots, depth;  // of compressed tiles; depth where it was baked
    gl::Texture emission;      // of a character that glows
    gl::Texture motion;        // of a bake with motion
    uint64_t texture_bytes() const {
      return albedo.bytes() + surface.bytes() + slots.bytes() + depth.bytes() + emission.bytes() + motion.bytes();
    }
  };
  struct Level {
    std::vector<Array> arrays;
    int corners = 4;
  };
  std::vector<Level> levels;
  gl::Buffer tiles, outlines, axes;
  gl::Texture tile_texels, outline_texels, view_texels;
  glm::vec3 centre{0.0F};
  double texel = 0;
  int slot_bits = 0;
  bool glows = false;
  uint64_t tiles_baked = 0;
  uint32_t frames = 0, views = 0;
  std::vector<StoredClip> clips;
  double covered = 0, drawn = 0;  // texels of level 0 over all tiles: silhouettes, and the outlines around them
};

// Texels that the strip of corners from `first` on covers.
double strip_area(const FlatLevel& level, size_t first) {
  double area = 0;
  for (size_t i = first; i + 2 < first + static_cast<size_t>(level.corners); ++i) {
    const auto& [a, b, c] = std::tie(level.outlines[i], level.outlines[i + 1], level.outlines[i + 2]);
    area += 0.5 * std::abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
  }
  return area;
}

LevelTable make_table(const FlatBake& bake, const ViewGrid& grid, size_t l) {
  LevelTable table{};
  table.centre = {bake.centre[0], bake.centre[1], bake.centre[2], bake.radius};
  const ViewGridUniforms uniforms = view_grid_uniforms(grid);
  table.grid = uniforms.grid;
  table.span = uniforms.span;
  const FlatLevel& level = bake.levels[l];
  table.scale = {static_cast<float>(bake.texel * std::exp2(static_cast<double>(l))),
                 1.0F / static_cast<float>(std::max(level.width, 1)),
                 1.0F / static_cast<float>(std::max(level.height, 1)), static_cast<float>(l)};
  const size_t motion = motion_level(l, bake.levels.size());
  table.first = {0U, 0U, bake.views, 0U};
  for (size_t finer = 0; finer < motion; ++finer) {
    const auto tiles = static_cast<uint32_t>(bake.levels[finer].tiles.size());
    table.first.w += tiles;
    if (finer >= l) continue;
    table.first.x += tiles;
    table.first.y += static_cast<uint32_t>(bake.levels[finer].outlines.size());
  }
  table.motion = {bake.motion_range / table.scale.x, motion > l ? 0.5F : 1.0F, 0.0F, 0.0F};
  for (size_t c = 0; c < bake.clips.size(); ++c)
    table.clips[c] = {bake.clips[c].first_frame, bake.clips[c].frames, 0U, 0U};
  return table;
}

// Layers of one array texture of a level's largest map: the driver's limit (or a lower one), and less than 2 GiB.
int layers_at_once(const gl::Context& context, const FlatLevel& level, int most_layers) {
  constexpr uint64_t kMostBytes = (uint64_t{1} << 31) - 1;
  const uint64_t layer_bytes =
      std::max<uint64_t>(level.albedo.size() / static_cast<uint64_t>(std::max(level.layers, 1)), 1);
  const int limit = std::min(context.limits().array_layers, 1 << CB_FLAT_LAYER_BITS);
  return static_cast<int>(
      std::min<uint64_t>(most_layers > 0 ? std::min(limit, most_layers) : limit, kMostBytes / layer_bytes));
}

// FlatTile::spread of a level of RGBA8 texels.
float spread_of(const FlatBake& bake, const FlatLevel& level, size_t l, const FlatTile& tile) {
  const double metres = bake.texel * std::exp2(static_cast<double>(l));
  double most = 0;
  for (int y = static_cast<int>(tile.low_y); y < static_cast<int>(tile.high_y); ++y)
    for (int x = static_cast<int>(tile.low_x); x < static_cast<int>(tile.high_x); ++x) {
      const auto row = static_cast<size_t>(tile.layer) * static_cast<size_t>(level.height) +
                       static_cast<size_t>(y + static_cast<int>(tile.offset_y));
      const size_t at =
          4 * (row * static_cast<size_t>(level.width) + static_cast<size_t>(x + static_cast<int>(tile.offset_x)));
      if (level.albedo[at + 3] < 128) continue;
      const double height = decode_signed(level.surface[at + 3]) * static_cast<double>(bake.radius);
      const double plane =
          (static_cast<double>(tile.slope_x) * (x + 0.5) + static_cast<double>(tile.slope_y) * (y + 0.5)) * metres +
          static_cast<double>(tile.height);
      most = std::max(most, std::abs(height - plane));
    }
  return static_cast<float>(most);
}

CharacterTiles upload(gl::Context& context, const FlatBake& bake, const ViewGrid& grid, int most_layers, bool sliced) {
  CharacterTiles out;
  out.centre = {bake.centre[0], bake.centre[1], bake.centre[2]};
  out.texel = bake.texel;
  out.clips = bake.clips;
  out.slot_bits = bake.slot_bits;
  out.glows = bake.emission_peak > 0;
  out.frames = bake.frames;
  out.views = bake.views;
  const FlatLevel& finest = bake.levels[0];
  for (const FlatTile& t : finest.tiles) {
    out.tiles_baked += t.covered > 0 ? 1 : 0;
    out.covered += t.covered;
  }
  for (size_t i = 0; i < finest.outlines.size(); i += static_cast<size_t>(finest.corners))
    out.drawn += strip_area(finest, i);
  out.axes = gl::Buffer(context, view_axes(grid));
  out.view_texels = gl::Texture::make_buffer(context, GL_RGBA32F, out.axes);
  std::vector<FlatTile> tiles;
  std::vector<std::array<float, 2>> outlines;
  for (size_t i = 0; i < bake.levels.size(); ++i) {
    const FlatLevel& level = bake.levels[i];
    for (const FlatTile& tile : level.tiles) {
      tiles.push_back(tile);
      if (sliced) tiles.back().spread = spread_of(bake, level, i, tile);
    }
    outlines.insert(outlines.end(), level.outlines.begin(), level.outlines.end());
    CharacterTiles::Level& l = out.levels.emplace_back();
    l.corners = level.corners;
    const int step = layers_at_once(context, level, most_layers);
    LevelTable table = make_table(bake, grid, i);
    for (int first = 0; first < level.layers; first += step) {
      const int count = std::min(step, level.layers - first);
      table.layers = {first, count, std::bit_cast<uint32_t>(bake.emission_peak), 0};
      const auto make = [&](unsigned stored, unsigned format, int width, const std::vector<uint8_t>& texels) {
        const size_t layer_bytes = texels.size() / static_cast<size_t>(level.layers);
        return upload_layers(context, stored, format, width, level.height, count,
                             std::span(texels).subspan(static_cast<size_t>(first) * layer_bytes,
                                                       static_cast<size_t>(count) * layer_bytes));
      };
      CharacterTiles::Array& array = l.arrays.emplace_back();
      array.table = gl::Buffer(context, sizeof table, &table);
      if (out.glows)
        array.emission = make(bake.slot_bits == 0 ? GL_SRGB8_ALPHA8 : GL_COMPRESSED_SRGB_S3TC_DXT1_EXT, GL_RGBA,
                              level.width, level.emission);
      if (!level.motion.empty()) array.motion = make(GL_RGBA8, GL_RGBA, level.width, level.motion);
      if (bake.slot_bits == 0) {
        array.albedo = make(GL_RGBA8, GL_RGBA, level.width, level.albedo);
        array.surface = make(GL_RGBA8, GL_RGBA, level.width, level.surface);
        continue;
      }
      array.albedo = make(GL_COMPRESSED_RGBA_S3TC_DXT5_EXT, 0, level.width, level.albedo);
      array.surface = make(GL_COMPRESSED_RG_RGTC2, 0, level.width, level.normal);
      array.slots = make(GL_R8UI, GL_RED_INTEGER, level.width * bake.slot_bits / 8, level.slots);
      if (!level.depth.empty()) array.depth = make(GL_COMPRESSED_RED_RGTC1, 0, level.width, level.depth);
    }
  }
  out.tiles = gl::Buffer(context, tiles);
  out.tile_texels = gl::Texture::make_buffer(context, GL_RGBA32F, out.tiles);
  out.outlines = gl::Buffer(context, outlines);
  out.outline_texels = gl::Texture::make_buffer(context, GL_RG32F, out.outlines);
  return out;
}

// What is shown between stored frames, in the order of the option's values; CB_BETWEEN of flat_between.glsl.
enum class FramesBetween : uint8_t { nearest, blend, move, move_blend };

// How the tiles are drawn; the bake does not depend on it.
struct DrawOptions {
  bool nailboard = false;
  bool blend = false;  // of three views
  bool floor = false;
  bool list = false;  // one fetch a fragment, not lit
  int parallax = 0;   // steps of the reprojection by stored depths
  int layers = 0;     // of one array texture, at most; 0: the driver's limit
  FramesBetween between = FramesBetween::nearest;
  int slices = 0;  // parallel polygons of the finest level; 0: one, and no intervals
  double overlap = 0;
  // Half as many of each coarser level, whose texels are as large as the intervals that twice as many would have.
  int slices_at(size_t level) const { return slices == 0 ? 0 : std::max(slices >> level, 1); }
};

void check_limits(const gl::Context& context, const FlatBake& bake, const std::string& what_bake,
                  const DrawOptions& draw) {
  const gl::Limits& limits = context.limits();
  const auto refuse = [&](const std::string& what) {
    throw Error(what_bake, what, "lower texels, frames or views, or use fewer clips");
  };
  uint64_t corners = 0;
  for (const FlatLevel& level : bake.levels) {
    corners += level.outlines.size();
    if (std::max(level.width, level.height) > limits.texture_size)
      refuse(fmt::format("a page of {} x {} texels is larger than this driver's {} a side", level.width, level.height,
                         limits.texture_size));
    // A fragment of these reads several tiles of any layers.
    const char* several = draw.blend                               ? "blend=3 needs"
                          : draw.between != FramesBetween::nearest ? "the frames between need"
                                                                   : nullptr;
    if (const int most = layers_at_once(context, level, draw.layers); several != nullptr && level.layers > most)
      refuse(fmt::format("{} layers are more than the {} of one array texture, which {} them in", level.layers, most,
                         several));
  }
  if (corners > static_cast<uint64_t>(limits.texel_buffer))
    refuse(fmt::format("{} tiles need too large a table", uint64_t{bake.frames} * bake.views));
}

class FlatRepresentation : public Representation {
 public:
  FlatRepresentation(const MakeContext& make, FlatBakeOptions options, const DrawOptions& draw)
      : context_(make.context),
        draw_(draw),
        grid_(options.grid),
        nominal_(nominal_frame(options.grid, options.texels)) {
    const auto start = std::chrono::steady_clock::now();
    const bool any_glows =
        std::ranges::any_of(make.cast.characters, [](const auto& character) { return emission_peak(*character) > 0; });
    const char* lacking = !context_.has_extension(kS3tc)                ? kS3tc
                          : any_glows && !context_.has_extension(kSrgb) ? kSrgb
                                                                        : nullptr;
    if (options.compressed && lacking != nullptr) {
      // One line a process, however many of these are made. RGTC is part of OpenGL 3.0.
      static std::atomic<bool> said = false;
      if (!said.exchange(true))
        fmt::print(stderr, "crowdbench: warning: this driver lacks {}: flat impostors use RGBA8, not blocks\n",
                   lacking);
      options.compressed = false;
    }
    BakeLoader loader(make.policy(),
                      {"flat", options.drawn_by + " impostors", "tiles",
                       "lower texels, frames or views, use fewer clips or characters, or raise --bake-budget"});
    for (size_t c = 0; c < make.cast.characters.size(); ++c) {
      const auto& character = make.cast.characters[c];
      const auto& bank = make.cast.banks[c];
      if (bank->clips().size() > CB_FLAT_CLIPS)
        throw Error(fmt::format("{} bake of {}", options.drawn_by, character->name),
                    fmt::format("{} clips; {} is the most", bank->clips().size(), CB_FLAT_CLIPS), "use fewer clips");
      if (make.required_by) {
        options.needed.clear();
        const FlatForecast whole = forecast_flat(*character, bank, options);
        whole_bytes_ += whole.sampling.texture_bytes;
        whole_tiles_ += whole.tiles;
        options.needed = needed_tiles(*character, bank, options, {draw_.blend, draw_.between != FramesBetween::nearest},
                                      [&](const auto& see) { make.required_by(c, see); });
      }
      loader.warn(coarse_frames_text(*character, *bank, options.frames));
      const std::string key = flat_cache_key(*character, *bank, options, context_.renderer(), context_.version());
      const FlatBake bake = loader.load<FlatBake>(
          character->name, key, deserialise_flat, [&](uint64_t left, const BakeProgress& progress) {
            return bake_flat(context_, character, bank, options, left, progress);
          });
      check_limits(context_, bake, fmt::format("{} bake of {}", options.drawn_by, character->name), draw_);
      characters_.push_back(upload(context_, bake, options.grid, draw_.layers, draw_.slices > 0));
    }
    records_ = loader.records();
    filtered_ = page_sampler(context_, GL_LINEAR);
    nearest_ = page_sampler(context_, GL_NEAREST);
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  void draw(const scene::Frame& frame, const FrameResources& resources, const AgentLists& agents,
            const Pass& pass) override {
    const gl::PerSampleScope by_sample(pass.samples);
    for (const unsigned unit : kFiltered) filtered_.bind(unit);
    for (const unsigned unit : kNearest) nearest_.bind(unit);
    for (size_t c = 0; c < characters_.size(); ++c) {
      if (agents[c].empty()) continue;
      const CharacterTiles& tiles = characters_[c];
      order_.sort(frame, frame.agents[c], agents[c], tiles.centre, tiles.texel, static_cast<int>(tiles.levels.size()));
      tiles.tile_texels.bind(CB_TEXTURE_TILES);
      tiles.outline_texels.bind(CB_TEXTURE_OUTLINES);
      tiles.view_texels.bind(CB_TEXTURE_VIEWS);
      for (size_t l = 0; l < tiles.levels.size(); ++l) {
        const CharacterTiles::Level& level = tiles.levels[l];
        if (level.arrays.empty()) continue;
        resources.draw_listed(c, order_.at_level(static_cast<int>(l)), [&](uint32_t n) {
          const int slices = draw_.slices_at(l);
          const gl::Program& used = program(pass, level.corners, tiles.slot_bits, tiles.glows, slices);
          used.use();
          if (slices > 0) used.set(CB_LOCATION_OVERLAP, static_cast<float>(draw_.overlap));
          // Every array is offered all agents and shows those whose tile it holds; nearly all bakes have one.
          for (const CharacterTiles::Array& array : level.arrays) {
            array.table.bind(GL_UNIFORM_BUFFER, CB_UNIFORM_TABLE);
            array.albedo.bind(CB_FLAT_TEXTURE_ALBEDO);
            array.surface.bind(CB_FLAT_TEXTURE_SURFACE);
            if (array.slots) array.slots.bind(CB_FLAT_TEXTURE_SLOTS);
            if (array.depth) array.depth.bind(CB_FLAT_TEXTURE_DEPTH);
            if (array.emission) array.emission.bind(CB_FLAT_TEXTURE_EMISSION);
            if (const auto& moved_by = tiles.levels[motion_level(l, tiles.levels.size())].arrays;
                !moved_by.empty() && moved_by[0].motion)
              moved_by[0].motion.bind(CB_FLAT_TEXTURE_MOTION);
            draw_polygons(draw_.blend ? 4 : level.corners, n * static_cast<uint32_t>(std::max(slices, 1)));
          }
        });
      }
    }
    for (const unsigned unit : kFiltered) glBindSampler(unit, 0);
    for (const unsigned unit : kNearest) glBindSampler(unit, 0);
  }

  Footprint footprint() const override {
    Footprint out;
    for (const CharacterTiles& c : characters_) {
      for (const CharacterTiles::Level& l : c.levels)
        for (const CharacterTiles::Array& array : l.arrays) {
          out.texture_bytes += array.texture_bytes();
          out.buffer_bytes += array.table.size();
        }
      out.buffer_bytes += c.tiles.size() + c.outlines.size() + c.axes.size();
    }
    out.disk_bytes = disk_bytes_of(records_);
    for (const auto& [corners, polygons] : polygons_) out.buffer_bytes += polygons.indices.size();
    out.upload_bytes_per_frame = order_.agents() * sizeof(uint32_t);
    return out;
  }

  BakeInfo bake_info() const override {
    BakeInfo info = bake_info_of(records_);
    info.seconds = seconds_;
    double tiles = 0;
    double covered = 0;
    double drawn = 0;
    double emission = 0;
    double frames = 0;
    for (const CharacterTiles& c : characters_) {
      tiles += static_cast<double>(c.tiles_baked);
      frames += c.frames;
      covered += c.covered;
      drawn += c.drawn;
      for (const CharacterTiles::Level& l : c.levels)
        for (const CharacterTiles::Array& array : l.arrays) emission += static_cast<double>(array.emission.bytes());
    }
    if (!characters_.empty()) {
      info.facts = {{"views", characters_[0].views},
                    {"frames", frames},
                    {"tiles", tiles},
                    {"levels", static_cast<double>(characters_[0].levels.size())},
                    {"texel_mm", characters_[0].texel * 1000},
                    {"compressed", characters_[0].slot_bits > 0 ? 1.0 : 0.0},
                    {"emission_bytes", emission},
                    {"drawn_over_covered", covered > 0 ? drawn / covered : 0.0}};
      for (auto& fact : view_error_facts(grid_)) info.facts.push_back(std::move(fact));
    }
    info.facts.emplace_back("nominal_page", nominal_.side);
    info.facts.emplace_back("nominal_frame_bytes", static_cast<double>(nominal_.bytes));
    info.facts.emplace_back("nominal_frame_compressed_bytes", static_cast<double>(nominal_.compressed_bytes));
    if (whole_tiles_ > 0)
      info.kept.push_back(
          {"tiles", static_cast<uint64_t>(tiles), whole_tiles_, footprint().texture_bytes, whole_bytes_});
    return info;
  }

  uint64_t triangles(size_t character) const override {
    const auto& levels = characters_[character].levels;
    const auto polygons = static_cast<uint64_t>(std::max(draw_.slices, 1));
    return levels.empty() ? 0 : polygons * (static_cast<uint64_t>(levels[0].corners) - 2);
  }

  double texel_metres(size_t character) const override { return characters_[character].texel; }
  bool shows_texels() const override { return true; }

  // As flat.vert picks it.
  double shown_phase(size_t character, int bank_clip, double phase) const override {
    if (draw_.between != FramesBetween::nearest) return phase;
    const auto frames = static_cast<float>(characters_[character].clips[static_cast<size_t>(bank_clip)].frames);
    const float step = std::floor(static_cast<float>(phase) * frames + 0.5F);
    return step >= frames ? 0.0 : static_cast<double>(step / frames);
  }

 private:
  static constexpr unsigned kFiltered[] = {CB_FLAT_TEXTURE_ALBEDO, CB_FLAT_TEXTURE_EMISSION};
  // Units that are read without filtering.
  static constexpr unsigned kNearest[] = {CB_FLAT_TEXTURE_SURFACE, CB_FLAT_TEXTURE_SLOTS, CB_FLAT_TEXTURE_DEPTH,
                                          CB_FLAT_TEXTURE_MOTION};

  struct Variant {
    bool ids, touched, texels, dithered;
    int corners;
    int slot_bits;
    bool glows;
    int slices;
    auto operator<=>(const Variant&) const = default;
  };
  struct Polygons {
    gl::Buffer indices;
    gl::VertexArray vertex_array;
  };

  void draw_polygons(int corners, uint32_t agents) {
    Polygons& polygons = polygons_[corners];
    const uint32_t batch = std::min(agents, kBatch);
    const uint32_t per_agent = 3 * (static_cast<uint32_t>(corners) - 2);
    if (polygons.indices.size() < size_t{batch} * per_agent * sizeof(uint32_t)) {
      const uint32_t room = std::min(std::bit_ceil(batch), kBatch);
      std::vector<uint32_t> indices;
      indices.reserve(size_t{room} * per_agent);
      for (uint32_t a = 0; a < room; ++a)
        for (uint32_t t = 0; t + 2 < static_cast<uint32_t>(corners); ++t)
          for (uint32_t k = 0; k < 3; ++k) indices.push_back(a * static_cast<uint32_t>(corners) + t + k);
      polygons.indices = gl::Buffer(context_, indices);
      polygons.vertex_array = gl::VertexArray(context_);
      glVertexArrayElementBuffer(polygons.vertex_array.name(), polygons.indices.name());
    }
    polygons.vertex_array.bind();
    for (uint32_t first = 0; first < agents; first += kBatch) {
      const uint32_t n = std::min(kBatch, agents - first);
      glDrawElementsBaseVertex(GL_TRIANGLES, static_cast<GLsizei>(n * per_agent), GL_UNSIGNED_INT, nullptr,
                               static_cast<GLint>(first * static_cast<uint32_t>(corners)));
    }
  }

  const gl::Program& program(const Pass& pass, int corners, int slot_bits, bool glows, int slices) {
    const Variant v{pass.ids, pass.touched, pass.texels, pass.dithered, corners, slot_bits, glows, slices};
    auto found = programs_.find(v);
    if (found == programs_.end()) {
      gl::Defines defines = {{"CB_CORNERS", std::to_string(corners)},
                             {"CB_PARALLAX", std::to_string(draw_.parallax)},
                             {"CB_BETWEEN", std::to_string(static_cast<int>(draw_.between))}};
      if (slot_bits > 0) defines.emplace_back("CB_SLOT_BITS", std::to_string(slot_bits));
      if (glows) defines.emplace_back("CB_EMISSIVE", "");
      if (slices > 0) defines.emplace_back("CB_SLICES", std::to_string(slices));
      if (v.ids) defines.emplace_back("CB_IDS", "");
      if (v.touched) defines.emplace_back("CB_TOUCHED", "");
      if (draw_.nailboard) defines.emplace_back("CB_NAILBOARD", "");
      if (v.texels) defines.emplace_back("CB_TEXELS", "");
      if (v.dithered) defines.emplace_back("CB_DITHER", "");
      if (draw_.floor) defines.emplace_back("CB_FLOOR", "");
      if (draw_.list && !v.texels) defines.emplace_back("CB_LIST", "");
      found =
          programs_
              .emplace(v,
                       draw_.blend
                           ? gl::Program(context_, {"renderers/flat/blend.vert", "renderers/flat/blend.frag"}, defines)
                           : gl::Program(context_, {"renderers/flat/flat.vert", "renderers/flat/flat.frag"}, defines))
              .first;
    }
    return found->second;
  }

  gl::Context& context_;
  DrawOptions draw_;
  ViewGrid grid_;
  NominalFrame nominal_;
  double seconds_ = 0;
  std::vector<BakeRecord> records_;
  uint64_t whole_bytes_ = 0, whole_tiles_ = 0;  // of the bakes of which only the required part was made
  std::vector<CharacterTiles> characters_;
  gl::Sampler filtered_, nearest_;
  std::map<Variant, gl::Program> programs_;
  std::map<int, Polygons> polygons_;  // by corners
  // Of the frame being drawn.
  LevelOrder order_;
};

FramesBetween read_between(const OptionReader& reader) {
  return static_cast<FramesBetween>(reader.choice("frames_between", {"nearest", "blend", "move", "move_blend"}));
}

}  // namespace

std::unique_ptr<Representation> make_flat_slices(const MakeContext& make, const FlatBakeOptions& options,
                                                 const FlatSlices& slices) {
  const DrawOptions draw{.floor = slices.floor, .slices = slices.most, .overlap = slices.overlap};
  return std::make_unique<FlatRepresentation>(make, options, draw);
}

FlatBakeOptions flat_bake_options(const Spec& spec) {
  const OptionReader reader(flat_type, spec);
  FlatBakeOptions options;
  options.grid = read_view_grid(reader);
  options.frames = read_frame_count(reader);
  options.texels = static_cast<int>(reader.integer("texels", 16, 1024));
  options.trimmed = reader.choice("quad", {"trimmed", "square"}) == 0;
  options.fitted = reader.choice("plane", {"fitted", "facing"}) == 0;
  options.corners = static_cast<int>(reader.integer("corners", 4, 8));
  options.compressed = reader.choice("compress", {"none", "bc"}) == 1;
  options.depth = reader.choice("depth", {"flat", "nailboard"}) == 1 || reader.integer("parallax", 0, 8) > 0;
  options.motion = read_between(reader) >= FramesBetween::move;
  return options;
}

const RepresentationType flat_type = {
    .name = "flat",
    .summary = "flat impostors: one textured polygon an agent, its tile picked by view and clip frame, lit at run time",
    .options =
        {views_option(),
         el_min_option(),
         frames_option("stored frames a clip"),
         fps_option(),
         {"texels", "16..1024", "128", "texels across the captured width, the diameter of the character's sphere"},
         {"quad", "trimmed|square", "trimmed", "what is drawn: the outline of each tile, or the whole captured square"},
         {"plane", "fitted|facing", "fitted",
          "where a tile's polygon lies: on the plane nearest to its stored depths, or across the view through "
          "the centre"},
         {"corners", "4..8", "8", "of the outlines of large tiles; small ones are triangles"},
         {"compress", "none|bc", "none", "RGBA8 texels, or blocks made offline: BC3, BC5, BC4 and packed ids"},
         {"depth", "flat|nailboard", "flat",
          "the polygon's own, or every texel's stored depth (bodies interpenetrate)"},
         {"blend", "1|3", "1", "views: the nearest, or the three around the direction, averaged by nearness"},
         {"parallax", "0..8", "0",
          "steps by which every view's stored depths move what it shows to where the eye sees it; 3 is enough"},
         {"frames_between", "nearest|blend|move|move_blend", "nearest",
          "between two stored frames: the nearer one; both, averaged by nearness; the nearer, its surface moved to "
          "where it is at the moment; or both, moved and averaged"},
         {"layers", "0..4096", "0",
          "of one array texture, at most; 0: the driver's limit. More are split over several"},
         {"shade", "lit|list", "lit",
          "lit as the mesh is, or a bare list of polygons: one fetch, the stored colour as it is"}},
    .make = [](const MakeContext& context, const Spec& spec) -> std::unique_ptr<Representation> {
      const FlatBakeOptions options = flat_bake_options(spec);
      const OptionReader reader(flat_type, spec);
      const DrawOptions draw{.nailboard = reader.choice("depth", {"flat", "nailboard"}) == 1,
                             .blend = reader.choice("blend", {"1", "3"}) == 1,
                             .floor = reader.flag("floor"),
                             .list = reader.choice("shade", {"lit", "list"}) == 1,
                             .parallax = static_cast<int>(reader.integer("parallax", 0, 8)),
                             .layers = static_cast<int>(reader.integer("layers", 0, 4096)),
                             .between = read_between(reader)};
      const bool between = draw.between != FramesBetween::nearest;
      if (draw.list && (draw.nailboard || draw.blend || draw.floor || draw.parallax > 0 || between))
        throw Error("representation 'flat'", "shade=list has one fetch: no stored depth, one view, no floor of its own",
                    "leave out depth, blend, parallax, frames_between and floor, or shade=list");
      if (draw.blend && between)
        throw Error("representation 'flat'", "three views of two frames would be six pictures a fragment",
                    "leave out blend or frames_between");
      return std::make_unique<FlatRepresentation>(context, options, draw);
    },
    .required_by = true,
    .view_sampling = [](const Spec& spec, const scene::Character& character,
                        const std::shared_ptr<const scene::PoseBank>& bank) -> ViewSampling {
      ViewSampling sampling = forecast_flat(character, bank, flat_bake_options(spec)).sampling;
      sampling.surface_depth = OptionReader(flat_type, spec).choice("depth", {"flat", "nailboard"}) == 1;
      return sampling;
    },
    .floor = "the same polygons and fetches without lighting",
    .suits = {.new_clips = "no: every clip is baked",
              .close_by = "texels are seen, and the card has no depth of its own but with depth=nailboard",
              .from_above = "the nearest of the stored views",
              .shadows = "none: light is that of stored normals"},
};

}  // namespace crowdbench::renderers
