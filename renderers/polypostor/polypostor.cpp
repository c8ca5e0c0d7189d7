#include "renderers/polypostor/polypostor.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <span>
#include <tuple>

#include "core/error.h"
#include "renderers/bake/bake_loader.h"
#include "renderers/frame/frame_resources.h"
#include "renderers/gl/objects.h"
#include "renderers/gl/per_sample.h"
#include "renderers/gl/program.h"
#include "renderers/impostor/tiles/level_order.h"
#include "renderers/impostor/tiles/tile_textures.h"
#include "renderers/impostor/views/view_options.h"
#include "renderers/polypostor/polypostor.shared.h"
#include "renderers/polypostor/polypostor_bake.h"
#include "renderers/polypostor/polypostor_required.h"
#include "renderers/shaders/bindings.shared.h"

namespace crowdbench::renderers {
namespace {

enum class Debug : uint8_t { none, wire, lines, parts, stretch };

// `Table` of polypostor.comp, std430, without its views.
struct TableHeader {
  glm::vec4 centre;
  glm::ivec4 grid;
  glm::vec4 span;
  glm::uvec4 counts;
  glm::vec4 units;
  glm::uvec4 clips[CB_POLYPOSTOR_CLIPS];
};
// `Figure` of polypostor.comp, std430.
struct Figure {
  glm::mat4 clip_from_units;
  glm::vec4 light_blend;
  glm::uvec4 pose;
};
struct Command {
  uint32_t indices, instances, first_index, first_vertex, first_instance;
};
struct LineVertex {
  glm::vec4 clip, colour;
};

struct CharacterPolygons {
  gl::Texture albedo, normals, materials, word_texels;
  gl::Texture emission;  // of a character that glows
  gl::Buffer table, sets, ranges, indices, vertices, words;
  gl::VertexArray vertex_array;
  glm::vec3 centre{0.0F};
  double texel = 0;
  float texels_a_unit = 0;
  int levels = 0;
  bool fades = false;      // from step to step: two figures an agent
  uint64_t triangles = 0;  // of level 0, mean over the views
  PolypostorBake bake;     // without its images; empty but for the facts unless lines are drawn
};

template <typename T>
gl::Buffer upload_buffer(gl::Context& context, const std::vector<T>& values) {
  static const T nothing{};
  return values.empty() ? gl::Buffer(context, sizeof(T), &nothing) : gl::Buffer(context, values);
}

gl::Buffer upload_table(gl::Context& context, const PolypostorBake& bake, const ViewGrid& grid) {
  TableHeader header{};
  header.centre = {bake.centre[0], bake.centre[1], bake.centre[2], bake.unit};
  const ViewGridUniforms uniforms = view_grid_uniforms(grid);
  header.grid = uniforms.grid;
  header.span = uniforms.span;
  header.counts = {bake.views, static_cast<uint32_t>(bake.clips.size()), bake.levels, bake.ranges_by_frame};
  header.units = {bake.unit_z, 0.0F, 0.0F, 0.0F};
  for (size_t c = 0; c < bake.clips.size(); ++c) header.clips[c] = {bake.clips[c].frames, 0U, 0U, 0U};
  std::vector<glm::vec4> table(sizeof header / sizeof(glm::vec4));
  std::memcpy(static_cast<void*>(table.data()), static_cast<const void*>(&header), sizeof header);
  const std::vector<glm::vec4> axes = view_axes(grid);
  table.insert(table.end(), axes.begin(), axes.end());
  return {context, table};
}

// Steps that show the same images as the step before, the first's being the last one, get its range: by their ranges
// the placing knows where images fade.
void share_ranges(PolypostorBake& bake) {
  if (bake.ranges_by_frame == 0) return;
  const auto corners = [&](const PolypostorRange& range) {
    return std::span(bake.indices).subspan(range.first_index, range.indices);
  };
  const auto alike = [&](const PolypostorRange& a, const PolypostorRange& b) {
    return std::ranges::equal(corners(a), corners(b));
  };
  for (size_t s = 0; s < bake.sets.size(); ++s) {
    if (bake.sets[s].words == 0) continue;  // nobody sees it
    const uint32_t frames = bake.clips[s / bake.views % bake.clips.size()].frames;
    PolypostorRange* const first = bake.ranges.data() + bake.sets[s].first_range;
    for (uint32_t f = 1; f < frames; ++f)
      if (alike(first[f], first[f - 1])) first[f] = first[f - 1];
    for (uint32_t f = frames; f-- > 1 && alike(first[f], first[0]);) first[f] = first[0];
  }
}

CharacterPolygons upload(gl::Context& context, PolypostorBake bake, const ViewGrid& grid, bool keep) {
  CharacterPolygons out;
  out.centre = {bake.centre[0], bake.centre[1], bake.centre[2]};
  out.texel = static_cast<double>(bake.texel);
  out.texels_a_unit = bake.unit / bake.texel;
  out.levels = static_cast<int>(bake.levels);
  share_ranges(bake);
  out.fades = bake.ranges_by_frame != 0;
  out.table = upload_table(context, bake, grid);
  if (bake.layers > 0) {
    const auto make = [&](unsigned stored, unsigned format, const std::vector<uint8_t>& texels) {
      return upload_layers(context, stored, format, bake.width, bake.height, bake.layers, texels);
    };
    out.albedo = make(GL_RGBA8, GL_RGBA, bake.albedo);
    out.normals = make(GL_RG8, GL_RG, bake.normals);
    out.materials = make(GL_R8, GL_RED, bake.materials);
    if (bake.emission_peak > 0) out.emission = make(GL_SRGB8_ALPHA8, GL_RGBA, bake.emission);
  }
  out.sets = upload_buffer(context, bake.sets);
  out.ranges = upload_buffer(context, bake.ranges);
  out.indices = upload_buffer(context, bake.indices);
  out.vertices = upload_buffer(context, bake.vertices);
  out.words = upload_buffer(context, bake.words);
  out.word_texels = gl::Texture::make_buffer(context, GL_R32UI, out.words);
  const gl::Attribute vertex{CB_POLYPOSTOR_ATTRIBUTE_VERTEX, 4, GL_UNSIGNED_SHORT, false, true, 0};
  out.vertex_array =
      gl::VertexArray(context, out.vertices, sizeof(PolypostorVertex), std::span(&vertex, 1), &out.indices);
  const uint64_t views = uint64_t{bake.views} * bake.clips.size();
  uint64_t drawn = 0;  // views that there are
  for (uint64_t s = 0; s < views; ++s) {
    if (bake.sets[s].words == 0) continue;
    out.triangles += bake.ranges[bake.sets[s].first_range].indices / 3;
    ++drawn;
  }
  out.triangles = drawn == 0 ? 0 : (out.triangles + drawn / 2) / drawn;
  bake.albedo = {};
  bake.normals = {};
  bake.materials = {};
  bake.emission = {};
  if (!keep) {
    bake.words = {};
    bake.indices = {};
    bake.vertices = {};
  }
  out.bake = std::move(bake);
  return out;
}

void check_limits(const gl::Context& context, const PolypostorBake& bake, const std::string& character) {
  const gl::Limits& limits = context.limits();
  const auto refuse = [&](const std::string& what) {
    throw Error(fmt::format("polypostor bake of {}", character), what, "lower texels, frames or views");
  };
  if (bake.layers > std::min(limits.array_layers, 2048))
    refuse(fmt::format("{} layers are more than {}", bake.layers, std::min(limits.array_layers, 2048)));
  if (bake.words.size() > static_cast<size_t>(limits.texel_buffer))
    refuse(
        fmt::format("{} corners in all frames are more than this driver's {}", bake.words.size(), limits.texel_buffer));
}

// What to say of a bake whose outlines are torn by more than they should be; empty where they are not.
std::string torn_text(const std::string& character, const PolypostorBake& bake, const PolypostorBakeOptions& options) {
  constexpr double kTorn = 5;  // per mille of the silhouette, the mean over views and poses
  if (bake.torn <= kTorn) return {};
  return fmt::format(
      "{}: outlines leave {:.1f} per mille of the silhouette torn, {:.0f} at worst, more than {:g}; {} mends more",
      printable(character), bake.torn, bake.torn_most, kTorn,
      options.key != KeyChoice::enough ? std::string("key=enough")
                                       : fmt::format("vertices={}", std::min(2 * options.corners, 32)));
}

class PolypostorRepresentation : public Representation {
 public:
  PolypostorRepresentation(const MakeContext& make, const PolypostorBakeOptions& options, Debug debug, bool floor)
      : context_(make.context), floor_(floor), debug_(debug), grid_(options.grid) {
    const auto start = std::chrono::steady_clock::now();
    BakeLoader loader(make.policy(), {"polypostor", "polypostors", "images",
                                      "lower texels or views, use fewer clips or characters, or raise --bake-budget"});
    for (size_t c = 0; c < make.cast.characters.size(); ++c) {
      const auto& character = make.cast.characters[c];
      const auto& bank = make.cast.banks[c];
      if (bank->clips().size() > CB_POLYPOSTOR_CLIPS)
        throw Error(fmt::format("polypostor bake of {}", character->name),
                    fmt::format("{} clips; {} is the most", bank->clips().size(), CB_POLYPOSTOR_CLIPS),
                    "use fewer clips");
      loader.warn(coarse_frames_text(*character, *bank, options.frames));
      const std::string key = polypostor_cache_key(*character, *bank, options, context_.renderer(), context_.version());
      auto bake = loader.load<PolypostorBake>(
          character->name, key, deserialise_polypostor, [&](uint64_t left, const BakeProgress& progress) {
            return bake_polypostor(context_, character, bank, options, left, progress);
          });
      loader.warn(torn_text(character->name, bake, options));
      if (make.required_by) {
        const std::vector<uint8_t> needed =
            needed_views(bake, options.grid, [&](const auto& see) { make.required_by(c, see); });
        kept_.whole += view_count(bake);
        kept_.whole_bytes += gpu_bytes(bake);
        bake = only_views(bake, needed);
        kept_.kept += view_count(bake);
        kept_.kept_bytes += gpu_bytes(bake);
      }
      check_limits(context_, bake, character->name);
      characters_.push_back(upload(context_, std::move(bake), options.grid, draws_lines()));
    }
    records_ = loader.records();
    filtered_ = page_sampler(context_, GL_LINEAR);
    nearest_ = page_sampler(context_, GL_NEAREST);
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  void draw(const scene::Frame& frame, const FrameResources& resources, const AgentLists& agents,
            const Pass& pass) override {
    const gl::PerSampleScope by_sample(pass.samples);
    for (size_t c = 0; c < characters_.size(); ++c) {
      const CharacterPolygons& polygons = characters_[c];
      if (agents[c].empty() || !polygons.albedo) continue;
      order_.sort(frame, frame.agents[c], agents[c], polygons.centre, polygons.texel, polygons.levels);
      resources.draw_listed(c, order_.all(), [&](uint32_t count) {
        const uint32_t figures = place_figures(polygons, count);
        filtered_.bind(CB_POLYPOSTOR_TEXTURE_ALBEDO);
        filtered_.bind(CB_POLYPOSTOR_TEXTURE_NORMALS);
        nearest_.bind(CB_POLYPOSTOR_TEXTURE_MATERIALS);
        polygons.albedo.bind(CB_POLYPOSTOR_TEXTURE_ALBEDO);
        polygons.normals.bind(CB_POLYPOSTOR_TEXTURE_NORMALS);
        polygons.materials.bind(CB_POLYPOSTOR_TEXTURE_MATERIALS);
        polygons.word_texels.bind(CB_POLYPOSTOR_TEXTURE_WORDS);
        const bool glows = polygons.emission && !paints();
        const gl::Program& p = program(pass, glows);
        p.use();
        std::array<GLint, 4> viewport{};
        glGetIntegerv(GL_VIEWPORT, viewport.data());
        p.set(CB_LOCATION_SAMPLES, static_cast<float>(viewport[3]) / static_cast<float>(frame.height));
        if (glows) {
          filtered_.bind(CB_POLYPOSTOR_TEXTURE_EMISSION);
          polygons.emission.bind(CB_POLYPOSTOR_TEXTURE_EMISSION);
          p.set(CB_POLYPOSTOR_LOCATION_PEAK, polygons.bake.emission_peak);
        }
        if (debug_ == Debug::stretch) p.set(CB_POLYPOSTOR_LOCATION_TEXELS, polygons.texels_a_unit);
        polygons.vertex_array.set_instance_records(figures_, sizeof(Figure), kFigure);
        polygons.vertex_array.bind();
        glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_.name());
        glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_SHORT, nullptr, static_cast<GLsizei>(figures), 0);
        glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
        if (draws_lines()) draw_lines(polygons, figures, pass);
      });
    }
    for (const unsigned unit : {CB_POLYPOSTOR_TEXTURE_ALBEDO, CB_POLYPOSTOR_TEXTURE_NORMALS,
                                CB_POLYPOSTOR_TEXTURE_MATERIALS, CB_POLYPOSTOR_TEXTURE_EMISSION})
      glBindSampler(unit, 0);
  }

  Footprint footprint() const override {
    Footprint out;
    for (const CharacterPolygons& c : characters_) {
      out.texture_bytes += c.albedo.bytes() + c.normals.bytes() + c.materials.bytes() + c.emission.bytes();
      for (const gl::Buffer* b : {&c.table, &c.sets, &c.ranges, &c.indices, &c.vertices, &c.words})
        out.buffer_bytes += b->size();
    }
    out.disk_bytes = disk_bytes_of(records_);
    out.buffer_bytes += figures_.size() + commands_.size() + lines_.size();
    out.upload_bytes_per_frame = order_.agents() * sizeof(uint32_t);
    return out;
  }

  BakeInfo bake_info() const override {
    BakeInfo info = bake_info_of(records_);
    info.seconds = seconds_;
    double frames = 0;
    double emission = 0;
    for (const CharacterPolygons& c : characters_) {
      frames += c.bake.frames;
      emission += static_cast<double>(c.emission.bytes());
    }
    if (!characters_.empty()) {
      const PolypostorBake& bake = characters_[0].bake;
      info.facts = {{"views", bake.views},
                    {"frames", frames},
                    {"levels", bake.levels},
                    {"texel_mm", characters_[0].texel * 1000},
                    {"emission_bytes", emission},
                    {"parts", bake.parts},
                    {"parts_seen", bake.parts_seen},
                    {"corners_a_part", bake.corners_seen},
                    {"outline_error", bake.outline_error},
                    {"repaired", bake.repaired},
                    {"torn", bake.torn},
                    {"torn_most", bake.torn_most}};
      for (auto& fact : view_error_facts(grid_)) info.facts.push_back(std::move(fact));
    }
    if (kept_.whole > 0) info.kept.push_back(kept_);
    return info;
  }

  uint64_t triangles(size_t character) const override { return characters_[character].triangles; }
  double texel_metres(size_t character) const override { return characters_[character].texel; }

 private:
  static constexpr std::array<gl::Attribute, 6> kFigure = {
      gl::Attribute{CB_POLYPOSTOR_ATTRIBUTE_CLIP, 4, GL_FLOAT, false, false, 0},
      gl::Attribute{CB_POLYPOSTOR_ATTRIBUTE_CLIP + 1, 4, GL_FLOAT, false, false, 16},
      gl::Attribute{CB_POLYPOSTOR_ATTRIBUTE_CLIP + 2, 4, GL_FLOAT, false, false, 32},
      gl::Attribute{CB_POLYPOSTOR_ATTRIBUTE_CLIP + 3, 4, GL_FLOAT, false, false, 48},
      gl::Attribute{CB_POLYPOSTOR_ATTRIBUTE_LIGHT, 4, GL_FLOAT, false, false, 64},
      gl::Attribute{CB_POLYPOSTOR_ATTRIBUTE_POSE, 4, GL_UNSIGNED_INT, false, true, 80}};

  using Variant = std::tuple<bool, bool, bool, bool>;  // ids, touched, dithered, glows

  static constexpr glm::vec3 kOutline{1.0F, 0.9F, 0.1F};
  static constexpr glm::vec3 kInner{0.6F, 0.3F, 0.05F};
  static constexpr glm::vec3 kFrom{0.05F, 0.6F, 0.1F};
  static constexpr glm::vec3 kTo{0.1F, 0.2F, 0.9F};
  static constexpr glm::vec3 kMove{1.0F, 0.1F, 0.05F};

  bool draws_lines() const { return debug_ == Debug::wire || debug_ == Debug::lines; }
  bool paints() const { return debug_ == Debug::parts || debug_ == Debug::stretch; }

  // Figures and commands of the listed agents, on the GPU: how many.
  uint32_t place_figures(const CharacterPolygons& polygons, uint32_t count) {
    const uint32_t figures = polygons.fades ? 2 * count : count;
    if (figures_.size() < figures * sizeof(Figure)) {
      const size_t room = std::bit_ceil(figures);
      figures_ = gl::Buffer(context_, room * sizeof(Figure));
      commands_ = gl::Buffer(context_, room * sizeof(Command));
    }
    if (!place_) {
      gl::Defines defines;
      if (paints()) defines.emplace_back("CB_DEBUG", "");
      place_ = gl::Program(context_, {"renderers/polypostor/polypostor.comp"}, defines);
    }
    polygons.table.bind(GL_SHADER_STORAGE_BUFFER, CB_POLYPOSTOR_STORAGE_TABLE);
    polygons.sets.bind(GL_SHADER_STORAGE_BUFFER, CB_POLYPOSTOR_STORAGE_SETS);
    polygons.ranges.bind(GL_SHADER_STORAGE_BUFFER, CB_POLYPOSTOR_STORAGE_RANGES);
    figures_.bind(GL_SHADER_STORAGE_BUFFER, CB_POLYPOSTOR_STORAGE_FIGURES);
    commands_.bind(GL_SHADER_STORAGE_BUFFER, CB_POLYPOSTOR_STORAGE_COMMANDS);
    place_.use();
    place_.set(CB_LOCATION_COUNT, count);
    uint32_t first = 0;
    for (int l = 0; l < polygons.levels; ++l) {
      place_.set(CB_POLYPOSTOR_LOCATION_LEVELS + l, first);
      first += static_cast<uint32_t>(order_.at_level(l).size());
    }
    glDispatchCompute((count + CB_POLYPOSTOR_GROUP - 1) / CB_POLYPOSTOR_GROUP, 1, 1);
    glMemoryBarrier(GL_COMMAND_BARRIER_BIT | GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT);
    return figures;
  }

  // The debug view's lines of one figure: the triangles of every polygon, or where each corner goes from one stored
  // frame to the next.
  void add_lines(const PolypostorBake& bake, const Figure& figure, const Command& command,
                 std::vector<LineVertex>& lines) const {
    const auto id = std::bit_cast<float>(figure.pose.w);
    const auto place = [&](uint32_t corner, float blend) {
      const uint32_t vertex = command.first_vertex + bake.indices[corner];
      const auto position = [&](uint32_t word) { return glm::vec3(word & 0xfffU, word >> 12U & 0xfffU, word >> 24U); };
      const glm::vec3 p =
          glm::mix(position(bake.words[vertex + figure.pose.x]), position(bake.words[vertex + figure.pose.y]), blend);
      return figure.clip_from_units * glm::vec4(p, 1.0F);
    };
    const auto line = [&](uint32_t a, float blend_a, uint32_t b, float blend_b, const glm::vec3& colour) {
      lines.push_back({place(a, blend_a), glm::vec4(colour, id)});
      lines.push_back({place(b, blend_b), glm::vec4(colour, id)});
    };
    // An edge of an outline belongs to one triangle, an inner one to two, in opposite directions.
    std::set<std::pair<uint16_t, uint16_t>> edges;
    const auto next = [](uint32_t t) { return t % 3 == 2 ? t - 2 : t + 1; };
    for (uint32_t t = 0; t < command.indices; ++t)
      edges.emplace(bake.indices[command.first_index + t], bake.indices[command.first_index + next(t)]);
    std::set<uint16_t> met;
    for (uint32_t t = 0; t < command.indices; ++t) {
      const uint32_t a = command.first_index + t;
      const uint32_t b = command.first_index + next(t);
      const bool inner = edges.count({bake.indices[b], bake.indices[a]}) > 0;
      if (debug_ == Debug::wire) {
        line(a, figure.light_blend.w, b, figure.light_blend.w, inner ? kInner : kOutline);
      } else if (!inner) {
        line(a, 0.0F, b, 0.0F, kFrom);
        line(a, 1.0F, b, 1.0F, kTo);
      }
      if (debug_ == Debug::lines && met.insert(bake.indices[a]).second) line(a, 0.0F, a, 1.0F, kMove);
    }
  }

  const gl::Program& line_program(const Pass& pass) {
    auto& p = line_programs_[{pass.ids, pass.dithered}];
    if (!p) {
      gl::Defines defines;
      if (pass.ids) defines.emplace_back("CB_IDS", "");
      if (pass.dithered) defines.emplace_back("CB_DITHER", "");
      p = gl::Program(context_, {"renderers/polypostor/lines.vert", "renderers/polypostor/lines.frag"}, defines);
    }
    return p;
  }

  // Over the picture.
  void draw_lines(const CharacterPolygons& polygons, uint32_t count, const Pass& pass) {
    std::vector<Figure> figures(count);
    std::vector<Command> commands(count);
    figures_.read(figures.data(), count * sizeof(Figure));
    commands_.read(commands.data(), count * sizeof(Command));
    std::vector<LineVertex> lines;
    for (uint32_t i = 0; i < count; ++i) add_lines(polygons.bake, figures[i], commands[i], lines);
    if (lines.empty()) return;
    if (lines_.size() < lines.size() * sizeof(LineVertex))
      lines_ = gl::Buffer(context_, std::bit_ceil(lines.size()) * sizeof(LineVertex));
    lines_.write(lines);
    const std::array<gl::Attribute, 2> attributes = {gl::Attribute{0, 4, GL_FLOAT, false, false, 0},
                                                     gl::Attribute{1, 4, GL_FLOAT, false, false, 16}};
    const gl::VertexArray vertex_array(context_, lines_, sizeof(LineVertex), attributes, nullptr);
    vertex_array.bind();
    line_program(pass).use();
    glDepthFunc(GL_ALWAYS);
    glDrawArrays(GL_LINES, 0, static_cast<GLsizei>(lines.size()));
    glDepthFunc(GL_GREATER);
  }

  const gl::Program& program(const Pass& pass, bool glows) {
    const Variant variant(pass.ids, pass.touched, pass.dithered, glows);
    auto found = programs_.find(variant);
    if (found == programs_.end()) {
      gl::Defines defines;
      if (pass.ids) defines.emplace_back("CB_IDS", "");
      if (pass.touched) defines.emplace_back("CB_TOUCHED", "");
      if (pass.dithered) defines.emplace_back("CB_DITHER", "");
      if (glows) defines.emplace_back("CB_EMISSIVE", "");
      if (floor_) defines.emplace_back("CB_FLOOR", "");
      if (paints()) defines.emplace_back("CB_DEBUG", "");
      if (debug_ == Debug::stretch) defines.emplace_back("CB_DEBUG_STRETCH", "");
      found = programs_
                  .emplace(variant,
                           gl::Program(context_,
                                       {"renderers/polypostor/polypostor.vert", "renderers/polypostor/polypostor.frag"},
                                       defines))
                  .first;
    }
    return found->second;
  }

  gl::Context& context_;
  bool floor_;
  Debug debug_;
  ViewGrid grid_;
  double seconds_ = 0;
  std::vector<BakeRecord> records_;
  Kept kept_{.unit = "views of clips"};  // where only the required part is
  std::vector<CharacterPolygons> characters_;
  gl::Sampler filtered_, nearest_;
  gl::Program place_;
  std::map<Variant, gl::Program> programs_;
  std::map<std::pair<bool, bool>, gl::Program> line_programs_;  // ids, dithered
  gl::Buffer figures_, commands_, lines_;
  LevelOrder order_;
};

}  // namespace

namespace {

PolypostorBakeOptions bake_options(const Spec& spec) {
  const OptionReader reader(polypostor_type, spec);
  PolypostorBakeOptions options;
  options.grid = read_view_grid(reader);
  options.frames = read_frame_count(reader);
  options.texels = static_cast<int>(reader.integer("texels", 16, 1024));
  options.corners = static_cast<int>(reader.integer("vertices", 4, 32));
  options.key = static_cast<KeyChoice>(reader.choice("key", {"first", "most_visible", "two_keys", "enough"}));
  options.cuts = reader.text("parts");
  return options;
}

}  // namespace

const RepresentationType polypostor_type = {
    .name = "polypostor",
    .summary = "polypostors: an image a body part and view, moved through the clip by a polygon, lit at run time",
    .options =
        {views_option(),
         el_min_option(),
         frames_option("stored frames a clip; between them corners move along lines"),
         fps_option(),
         {"texels", "16..1024", "128", "texels across the captured width, the diameter of the character's sphere"},
         {"vertices", "4..32", "8",
          "corners of a part's polygon, at most, twice as many where key=enough needs them; small figures have four"},
         {"key", "first|most_visible|two_keys|enough", "enough",
          "the frame whose image of a part is kept: the first that shows it, the one that shows most of all frames, "
          "two, or as many as it takes that no outline is torn"},
         {"parts", "auto|J+J+...", "auto",
          "found from the skeleton, or the joints that begin a part, by name or index"},
         {"debug", "none|wire|lines|parts|stretch", "none",
          "over the picture: polygons, where corners go in the next stored frame, parts in colour, stretch of the "
          "images"}},
    .make = [](const MakeContext& context, const Spec& spec) -> std::unique_ptr<Representation> {
      const OptionReader reader(polypostor_type, spec);
      const auto debug = static_cast<Debug>(reader.choice("debug", {"none", "wire", "lines", "parts", "stretch"}));
      return std::make_unique<PolypostorRepresentation>(context, bake_options(spec), debug, reader.flag("floor"));
    },
    .required_by = true,
    .view_sampling = [](const Spec& spec, const scene::Character& character,
                        const std::shared_ptr<const scene::PoseBank>& bank) -> ViewSampling {
      return sample_polypostors(character, bank, bake_options(spec));
    },
    .floor = "the same polygons and fetches without lighting",
    .suits = {.new_clips = "no: every clip is baked",
              .close_by = "pieces of a picture are seen to slide",
              .from_above = "the nearest of the stored views",
              .shadows = "none: light is that of stored normals"},
};

}  // namespace crowdbench::renderers
