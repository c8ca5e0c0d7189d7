// Based on: Beacco, Spanlang, Andujar and Pelechano, "Efficient rendering of animated characters through optimized
// per-joint impostors" (2012). Differs from the source: README.md.
#include "renderers/perjoint/perjoint.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <map>
#include <numbers>

#include "core/error.h"
#include "renderers/bake/bake_loader.h"
#include "renderers/frame/frame_resources.h"
#include "renderers/gl/objects.h"
#include "renderers/gl/per_sample.h"
#include "renderers/gl/program.h"
#include "renderers/impostor/tiles/level_order.h"
#include "renderers/impostor/tiles/tile_textures.h"
#include "renderers/impostor/views/view_options.h"
#include "renderers/perjoint/perjoint.shared.h"
#include "renderers/perjoint/perjoint_bake.h"
#include "renderers/shaders/bindings.shared.h"

namespace crowdbench::renderers {
namespace {

constexpr double kLowest = -89.9;  // degrees: joints are seen from all sides

// `Table` of perjoint_table.glsl, std140.
struct JointTable {
  glm::ivec4 grid;
  glm::vec4 span;
  glm::vec4 scale;
  glm::uvec4 first;
};

// `piece_texels` of perjoint.vert.
struct PieceRecord {
  std::array<std::array<float, 4>, 3> inverse;
  std::array<float, 4> centre;
  std::array<float, 4> joint;  // the first
};

struct CharacterPieces {
  std::vector<gl::Buffer> tables;  // by level
  gl::Buffer tiles, outlines, axes, pieces, indices, few_indices;
  gl::Texture tile_texels, outline_texels, view_texels, piece_texels;
  gl::Texture albedo, surface, emission;
  gl::VertexArray vertex_array, few_vertex_array;
  uint32_t count = 0;
  glm::vec3 centre{0.0F};
  double texel = 0;
  uint32_t views = 0;
  double mean_border = 0;
  std::array<float, 4> torn{};
};

// The strips of all pieces' outlines as triangles, of their first `corners` corners.
std::vector<uint32_t> piece_indices(uint32_t pieces, uint32_t corners) {
  std::vector<uint32_t> indices;
  for (uint32_t p = 0; p < pieces; ++p)
    for (uint32_t t = 0; t + 2 < corners; ++t)
      for (uint32_t k = 0; k < 3; ++k) indices.push_back(p * CB_PERJOINT_CORNERS + t + k);
  return indices;
}

void check_tables(const gl::Context& context, const PerJointBake& bake, const std::string& character) {
  if (bake.outlines.size() > static_cast<uint64_t>(context.limits().texel_buffer))
    throw Error("per-joint impostors of " + character,
                fmt::format("{} joints of {} views need too large a table", bake.pieces, bake.views),
                "give fewer views, or raise least");
}

CharacterPieces upload_pieces(gl::Context& context, const PerJointBake& bake, const ViewGrid& grid,
                              const scene::PoseBank& bank) {
  CharacterPieces out;
  out.count = bake.pieces;
  out.texel = bake.texel;
  out.views = bake.views;
  out.torn = bake.torn;
  out.centre = 0.5F * (bank.bounds_min() + bank.bounds_max());
  for (const float b : bake.borders) out.mean_border += static_cast<double>(b) / std::max(1U, bake.pieces);
  if (bake.pieces == 0 || bake.layers == 0) return out;
  const ViewGridUniforms uniforms = view_grid_uniforms(grid);
  for (uint32_t level = 0; level < bake.levels; ++level) {
    const JointTable table{uniforms.grid,
                           uniforms.span,
                           {bake.texel * std::exp2(static_cast<float>(level)), 1.0F / static_cast<float>(bake.width),
                            1.0F / static_cast<float>(bake.height), bake.emission_peak},
                           {level * bake.pieces * bake.views, bake.views, static_cast<uint32_t>(bank.joints()), 0U}};
    out.tables.emplace_back(context, sizeof table, &table);
  }
  std::vector<PieceRecord> records;
  for (uint32_t p = 0; p < bake.pieces; ++p)
    records.push_back({{bake.inverse[3 * p], bake.inverse[3 * p + 1], bake.inverse[3 * p + 2]},
                       bake.centres[p],
                       {static_cast<float>(bake.joints[p]), 0, 0, 0}});
  out.pieces = gl::Buffer(context, records);
  out.piece_texels = gl::Texture::make_buffer(context, GL_RGBA32F, out.pieces);
  out.tiles = gl::Buffer(context, bake.tiles);
  out.tile_texels = gl::Texture::make_buffer(context, GL_RGBA32F, out.tiles);
  out.outlines = gl::Buffer(context, bake.outlines);
  out.outline_texels = gl::Texture::make_buffer(context, GL_RG32F, out.outlines);
  out.axes = gl::Buffer(context, view_axes(grid));
  out.view_texels = gl::Texture::make_buffer(context, GL_RGBA32F, out.axes);
  const auto page = [&](unsigned stored, const std::vector<uint8_t>& texels) {
    return upload_layers(context, stored, GL_RGBA, bake.width, bake.height, bake.layers, texels);
  };
  out.albedo = page(GL_RGBA8, bake.albedo);
  out.surface = page(GL_RGBA8, bake.surface);
  if (!bake.emission.empty()) out.emission = page(GL_SRGB8_ALPHA8, bake.emission);
  out.indices = gl::Buffer(context, piece_indices(bake.pieces, CB_PERJOINT_CORNERS));
  out.few_indices = gl::Buffer(context, piece_indices(bake.pieces, CB_PERJOINT_FEW));
  out.vertex_array = gl::VertexArray(context);
  glVertexArrayElementBuffer(out.vertex_array.name(), out.indices.name());
  out.few_vertex_array = gl::VertexArray(context);
  glVertexArrayElementBuffer(out.few_vertex_array.name(), out.few_indices.name());
  return out;
}

struct PerJointDraw {
  bool stored_depth = true;
  bool floor = false;
};

class PerJointRepresentation : public Representation {
 public:
  PerJointRepresentation(const MakeContext& make, const PerJointOptions& options, const PerJointDraw& draw)
      : context_(make.context), draw_(draw), grid_(options.grid) {
    const auto start = std::chrono::steady_clock::now();
    BakeLoader loader(make.policy(), {"perjoint", "per-joint impostors", "tiles",
                                      "lower texels or views, use fewer characters, or raise --bake-budget"});
    for (size_t c = 0; c < make.cast.characters.size(); ++c) {
      const auto& character = make.cast.characters[c];
      const scene::PoseBank& bank = *make.cast.banks[c];
      const std::string key = perjoint_cache_key(*character, bank, options, context_.renderer(), context_.version());
      const PerJointBake bake = loader.load<PerJointBake>(
          character->name, key, deserialise_perjoint, [&](uint64_t left, const BakeProgress& progress) {
            return bake_perjoint(context_, character, bank, options, left, progress);
          });
      check_tables(context_, bake, character->name);
      characters_.push_back(upload_pieces(context_, bake, options.grid, bank));
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
    nearest_.bind(CB_PERJOINT_TEXTURE_SURFACE);
    for (size_t c = 0; c < characters_.size(); ++c) {
      const CharacterPieces& pieces = characters_[c];
      if (agents[c].empty() || pieces.tables.empty()) continue;
      order_.sort(frame, frame.agents[c], agents[c], pieces.centre, pieces.texel,
                  static_cast<int>(pieces.tables.size()));
      const gl::Program& used = program(pass, static_cast<bool>(pieces.emission));
      resources.draw_posed(c, order_.all(), [&](uint32_t first, uint32_t count) {
        used.use();
        bind(pieces);
        draw_levels(pieces, used, first, count);
      });
    }
    for (const unsigned unit : kFiltered) glBindSampler(unit, 0);
    glBindSampler(CB_PERJOINT_TEXTURE_SURFACE, 0);
  }

  Footprint footprint() const override {
    Footprint out;
    for (const CharacterPieces& c : characters_) {
      out.texture_bytes += c.albedo.bytes() + c.surface.bytes() + c.emission.bytes();
      for (const gl::Buffer* b : {&c.tiles, &c.outlines, &c.axes, &c.pieces, &c.indices, &c.few_indices})
        out.buffer_bytes += b->size();
      for (const gl::Buffer& table : c.tables) out.buffer_bytes += table.size();
    }
    out.disk_bytes = disk_bytes_of(records_);
    out.upload_bytes_per_frame = order_.agents() * sizeof(uint32_t);
    return out;
  }

  BakeInfo bake_info() const override {
    BakeInfo info = bake_info_of(records_);
    info.seconds = seconds_;
    if (characters_.empty()) return info;
    const CharacterPieces& c = characters_[0];
    info.facts = {
        {"views", c.views},           {"joints_drawn", c.count},      {"levels", static_cast<double>(c.tables.size())},
        {"texel_mm", c.texel * 1000}, {"mean_border", c.mean_border}, {"border_holes", c.torn[0]},
        {"border_strays", c.torn[1]}, {"cut_holes", c.torn[2]},       {"cut_strays", c.torn[3]}};
    for (auto& fact : view_error_facts(grid_)) info.facts.push_back(std::move(fact));
    return info;
  }

  uint64_t triangles(size_t character) const override {
    return uint64_t{characters_[character].count} * (CB_PERJOINT_CORNERS - 2);
  }
  double texel_metres(size_t character) const override { return characters_[character].texel; }

 private:
  static constexpr unsigned kFiltered[] = {CB_PERJOINT_TEXTURE_ALBEDO, CB_PERJOINT_TEXTURE_EMISSION};

  using Variant = std::array<bool, 4>;  // ids, touched, dithered, glows

  static void bind(const CharacterPieces& pieces) {
    pieces.tile_texels.bind(CB_TEXTURE_TILES);
    pieces.outline_texels.bind(CB_TEXTURE_OUTLINES);
    pieces.view_texels.bind(CB_TEXTURE_VIEWS);
    pieces.piece_texels.bind(CB_PERJOINT_TEXTURE_PIECES);
    pieces.albedo.bind(CB_PERJOINT_TEXTURE_ALBEDO);
    pieces.surface.bind(CB_PERJOINT_TEXTURE_SURFACE);
    if (pieces.emission) pieces.emission.bind(CB_PERJOINT_TEXTURE_EMISSION);
  }

  // Those of the listed agents [first, first + count) that are of each level.
  void draw_levels(const CharacterPieces& pieces, const gl::Program& used, uint32_t first, uint32_t count) const {
    uint32_t begin = 0;
    for (size_t l = 0; l < pieces.tables.size(); ++l) {
      const auto end = begin + static_cast<uint32_t>(order_.at_level(static_cast<int>(l)).size());
      const uint32_t low = std::max(begin, first);
      const uint32_t high = std::min(end, first + count);
      begin = end;
      if (low >= high) continue;
      const bool few = l >= CB_PERJOINT_FEW_FROM;
      const uint32_t indices = pieces.count * 3 * ((few ? CB_PERJOINT_FEW : CB_PERJOINT_CORNERS) - 2);
      used.set(CB_LOCATION_FIRST, low);
      used.set(CB_LOCATION_SLOT, low - first);
      pieces.tables[l].bind(GL_UNIFORM_BUFFER, CB_UNIFORM_TABLE);
      (few ? pieces.few_vertex_array : pieces.vertex_array).bind();
      glDrawElementsInstanced(GL_TRIANGLES, static_cast<GLsizei>(indices), GL_UNSIGNED_INT, nullptr,
                              static_cast<GLsizei>(high - low));
    }
  }

  const gl::Program& program(const Pass& pass, bool glows) {
    const Variant variant = {pass.ids, pass.touched, pass.dithered, glows};
    auto found = programs_.find(variant);
    if (found == programs_.end()) {
      gl::Defines defines;
      if (pass.ids) defines.emplace_back("CB_IDS", "");
      if (pass.touched) defines.emplace_back("CB_TOUCHED", "");
      if (pass.dithered) defines.emplace_back("CB_DITHER", "");
      if (glows) defines.emplace_back("CB_EMISSIVE", "");
      if (draw_.floor) defines.emplace_back("CB_FLOOR", "");
      if (draw_.stored_depth) defines.emplace_back("CB_STORED_DEPTH", "");
      found =
          programs_
              .emplace(variant,
                       gl::Program(context_, {"renderers/perjoint/perjoint.vert", "renderers/perjoint/perjoint.frag"},
                                   defines))
              .first;
    }
    return found->second;
  }

  gl::Context& context_;
  PerJointDraw draw_;
  ViewGrid grid_;
  double seconds_ = 0;
  std::vector<BakeRecord> records_;
  std::vector<CharacterPieces> characters_;
  gl::Sampler filtered_, nearest_;
  std::map<Variant, gl::Program> programs_;
  LevelOrder order_;  // of the frame being drawn
};

// 0: found by the clips.
float parse_border(const std::string& value, const std::string& where) {
  if (value == "auto") return 0;
  float number = 0;
  const char* end = value.data() + value.size();
  const auto [stop, fault] = std::from_chars(value.data(), end, number);
  if (fault != std::errc{} || stop != end || !(number >= 0.01F && number <= 0.5F))
    throw Error(where, fmt::format("'{}' is neither auto nor a number from 0.01 to 0.5", printable(value)));
  return number;
}

void check_border(const std::string& value, const std::string& where) { (void)parse_border(value, where); }

void check_joint_views(const std::string& value, const std::string& where) {
  const ViewGrid grid = parse_view_grid(value, kLowest * std::numbers::pi / 180, where);
  if (grid.kind == GridKind::hemi || grid.mirrored)
    throw Error(where, fmt::format("'{}' does not look at a joint from all sides", printable(value)),
                "give sphere-AxE or cube-N");
}

OptionDoc joint_views_option() {
  OptionDoc option = views_option();
  option.values = "sphere-AxE|cube-N";
  option.default_value = "cube-5";
  option.meaning = "the view grid of each joint, all round: azimuths x elevations, or N a side";
  option.check = check_joint_views;
  return option;
}

PerJointOptions perjoint_options(const Spec& spec) {
  const OptionReader reader(perjoint_type, spec);
  PerJointOptions options;
  check_joint_views(reader.text("views"), reader.where("views"));
  options.grid = parse_view_grid(reader.text("views"), kLowest * std::numbers::pi / 180, reader.where("views"));
  options.texels = static_cast<int>(reader.integer("texels", 16, 1024));
  options.least = reader.number("least", 0, 20) / 100;
  options.border = parse_border(reader.text("border"), reader.where("border"));
  return options;
}

}  // namespace

const RepresentationType perjoint_type = {
    .name = "perjoint",
    .summary = "per-joint impostors: a picture a joint and view, moved as the joint is, lit at run time",
    .options = {joint_views_option(),
                {"texels", "16..1024", "128", "texels across the sphere round the rest pose"},
                {"least", "0..20", "0.6", "percent of the surface: a joint that moves less goes with the one above it"},
                {"border", "auto|0.01..0.5", "auto",
                 "share of weight that a joint's picture ends at: found by what the clips in use tear, or one for all; "
                 "0.5 cuts, less overlaps",
                 check_border},
                {"depth", "plane|stored", "stored", "the polygon's own, or every texel's stored depth"}},
    .make = [](const MakeContext& context, const Spec& spec) -> std::unique_ptr<Representation> {
      const OptionReader reader(perjoint_type, spec);
      const PerJointDraw draw{.stored_depth = reader.choice("depth", {"plane", "stored"}) == 1,
                              .floor = reader.flag("floor")};
      return std::make_unique<PerJointRepresentation>(context, perjoint_options(spec), draw);
    },
    .floor = "the same polygons and fetches without lighting",
    .suits = {.new_clips = "yes: pictures follow the joints; borders were chosen by the clips of the bake",
              .close_by = "texels are seen, and joints bend as cut-outs do",
              .from_above = "yes: captured from all sides",
              .shadows = "at the stored depth of each texel; light is that of stored normals"},
};

}  // namespace crowdbench::renderers
