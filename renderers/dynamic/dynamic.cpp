// Based on: A. Aubel, R. Boulic and D. Thalmann, "Animated impostors for real-time display of numerous virtual humans"
// (1998) and "Real-time display of virtual humans: levels of details and impostors" (2000). Differs from the sources:
// README.md.
#include "renderers/dynamic/dynamic.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <map>
#include <numbers>
#include <optional>
#include <span>

#include "renderers/bake/emission.h"
#include "renderers/dynamic/dynamic.shared.h"
#include "renderers/dynamic/tile_states.h"
#include "renderers/frame/frame_resources.h"
#include "renderers/gl/per_sample.h"
#include "renderers/gl/program.h"
#include "renderers/impostor/tiles/tile_textures.h"
#include "renderers/mesh/mesh_draw.h"
#include "renderers/shaders/bindings.shared.h"
#include "scene/cast/cast.h"

namespace crowdbench::renderers {
namespace {

constexpr int kSide = TileAtlas::kSide;
constexpr double kFloorPixels = 96;  // across the tile that all agents of a floor share

struct DynamicOptions {
  TileRules rules;
  size_t joints = 0;
  uint64_t budget = 0;  // bytes of pages
  int samples = 1;      // a texel, that a tile is drawn with
  bool floor = false;
};

// As dynamic.vert reads it.
struct QuadRecord {
  glm::vec4 centre;  // w: the id's bits
  glm::vec4 right, up;
  glm::vec4 extent;
  glm::vec4 place;
};
static_assert(sizeof(QuadRecord) == CB_DYNAMIC_TEXELS * sizeof(glm::vec4));

// The framebuffer and viewport of whoever draws, put back at the end.
class KeptView {
 public:
  KeptView() {
    glGetIntegerv(GL_FRAMEBUFFER_BINDING, &framebuffer_);
    glGetIntegerv(GL_VIEWPORT, viewport_.data());
  }
  ~KeptView() {
    glDisable(GL_SCISSOR_TEST);
    glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(framebuffer_));
    glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
  }
  KeptView(const KeptView&) = delete;
  KeptView& operator=(const KeptView&) = delete;

 private:
  GLint framebuffer_ = 0;
  std::array<GLint, 4> viewport_{};
};

struct Page {
  gl::Texture texels;
  gl::Framebuffer target;
};

// An agent that is drawn by a tile.
struct Quad {
  uint32_t page = 0;
  QuadRecord record;
};
// A tile that is to be drawn anew.
struct Anew {
  uint32_t agent = 0;  // into the character's agents
  TileRecord* tile = nullptr;
};

class DynamicRepresentation : public Representation {
 public:
  DynamicRepresentation(const MakeContext& make, const DynamicOptions& options)
      : context_(make.context),
        options_(options),
        captured_(make.context, MeshUse::tile),
        skinned_(make.context, MeshUse::skinned),
        sampler_(page_sampler(make.context, GL_LINEAR)),
        no_vertices_(make.context) {
    const auto start = std::chrono::steady_clock::now();
    std::vector<TileCharacter> characters;
    bool glows = false;
    for (size_t c = 0; c < make.cast.characters.size(); ++c) {
      const scene::Character& character = *make.cast.characters[c];
      const scene::PoseBank& bank = *make.cast.banks[c];
      meshes_.push_back(upload_mesh(make.context, character, bank.joints(), MeshUse::skinned, {}));
      boxes_.push_back({bank.bounds_min(), bank.bounds_max()});
      const std::vector<JointPoint> points = choose_joint_points(character, bank, options.joints);
      characters.push_back({boxes_.back(), PoseProbe(bank, points)});
      glows = glows || emission_peak(character) > 0;
      state_facts(character, bank, points, characters.back().probe);
    }
    make_pages(glows);
    states_.emplace(options.rules, std::move(characters), static_cast<uint32_t>(pages_.size()));
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  void draw(const scene::Frame& frame, const FrameResources& resources, const AgentLists& agents,
            const Pass& pass) override {
    if (options_.floor)
      update_floor(frame, agents);
    else
      update(frame, agents);
    draw_anew(frame, resources);
    draw_quads(resources, pass);
    for (size_t c = 0; c < meshes_.size(); ++c)
      if (!meshes_[c].groups.empty())
        resources.draw_posed(c, near_[c], [&](uint32_t first, uint32_t count) {
          skinned_.draw(meshes_[c], pass, resources.list(), first, count);
        });
    MeshDraw::done();
  }

  bool has_history() const override { return !options_.floor && !options_.rules.always_anew(); }

  void advance(const scene::Frame& frame, const AgentLists& agents) override {
    if (!has_history()) return;
    states_->begin(frame);
    for (size_t c = 0; c < agents.size(); ++c)
      if (!meshes_[c].groups.empty())
        for (const uint32_t i : agents[c]) (void)states_->update(frame, c, i);
  }

  Footprint footprint() const override {
    Footprint out;
    out.texture_bytes = depth_.bytes() + sampled_.bytes();
    for (const Page& page : pages_) out.texture_bytes += page.texels.bytes();
    out.buffer_bytes = rows_buffer_.size() + quads_buffer_.size();
    out.upload_bytes_per_frame = quads_buffer_.size() + rows_buffer_.size();
    for (const CharacterMesh& m : meshes_) {
      out.texture_bytes += m.texture_bytes();
      out.buffer_bytes += m.buffer_bytes();
    }
    return out;
  }

  BakeInfo bake_info() const override {
    BakeInfo info;
    info.seconds = seconds_;
    info.facts = facts_;
    return info;
  }

  // Of its rectangle.
  uint64_t triangles(size_t) const override { return 2; }

 private:
  void make_pages(bool glows) {
    // Light that is given off may be brighter than a display's white.
    const unsigned format = glows ? GL_RGBA16F : GL_SRGB8_ALPHA8;
    const int samples = std::min(options_.samples, context_.limits().samples);
    const auto target = [&](unsigned one) {
      return samples > 1 ? gl::Texture::make_multisampled(context_, one, kSide, kSide, samples)
                         : gl::Texture::make_2d(context_, one, kSide, kSide);
    };
    depth_ = target(GL_DEPTH_COMPONENT32F);
    if (samples > 1) {
      sampled_ = target(format);
      sampled_target_ = gl::Framebuffer(context_, std::vector<const gl::Texture*>{&sampled_}, &depth_);
    }
    const uint64_t page_bytes = gl::texture_bytes(format, kSide, kSide);
    const uint64_t pages = options_.floor ? 1 : std::max<uint64_t>(options_.budget / page_bytes, 1);
    for (uint64_t i = 0; i < pages; ++i) {
      Page& page = pages_.emplace_back();
      page.texels = gl::Texture::make_2d(context_, format, kSide, kSide);
      page.target =
          gl::Framebuffer(context_, std::vector<const gl::Texture*>{&page.texels}, samples > 1 ? nullptr : &depth_);
    }
    facts_.insert(facts_.begin(), {{"pages", static_cast<double>(pages)},
                                   {"atlas_mib", static_cast<double>(pages * page_bytes) / (1 << 20)}});
  }

  // Of several characters the largest.
  void state_facts(const scene::Character& character, const scene::PoseBank& bank,
                   const std::vector<JointPoint>& points, const PoseProbe& probe) {
    constexpr double kMillimetres = 1000;
    const PoseStaleness stale = pose_staleness(character, bank, probe, options_.rules.pose);
    const std::vector<std::pair<std::string, double>> own = {{"joints", static_cast<double>(points.size())},
                                                             {"pose_refreshes_a_second", stale.refreshes},
                                                             {"stale_pose_rms_mm", stale.rms * kMillimetres},
                                                             {"stale_pose_max_mm", stale.max * kMillimetres}};
    if (facts_.empty()) facts_ = own;
    for (size_t i = 0; i < own.size(); ++i) facts_[i].second = std::max(facts_[i].second, own[i].second);
  }

  // Fills quads_, anew_ and near_.
  void update(const scene::Frame& frame, const AgentLists& agents) {
    states_->begin(frame);
    clear_lists();
    for (size_t c = 0; c < meshes_.size(); ++c)
      for (const uint32_t i : agents[c]) {
        TileRecord* tile = meshes_[c].groups.empty() ? nullptr : states_->update(frame, c, i);
        if (tile == nullptr) {
          near_[c].push_back(i);
          continue;
        }
        if (!tile->drawn) anew_[c].push_back({i, tile});
        add_quad(frame.agents[c][i], *tile, tile->view);
      }
  }

  // Every agent shows its character's one tile, seen from the front and laid across its own view.
  void update_floor(const scene::Frame& frame, const AgentLists& agents) {
    clear_lists();
    for (size_t c = 0; c < meshes_.size(); ++c) {
      if (agents[c].empty() || meshes_[c].groups.empty()) continue;
      if (floor_tiles_.size() <= c) floor_tiles_.resize(c + 1);
      TileRecord& tile = floor_tiles_[c];
      if (!tile.drawn) {
        const glm::dvec3 size = boxes_[c].high - boxes_[c].low;
        const double texel = std::max({size.x, size.y, size.z}) / kFloorPixels;
        const glm::dvec3 eye = boxes_[c].centre() + glm::dvec3(0, 0, 10 * glm::length(size));
        tile.view = *tile_view(boxes_[c], eye, {1, 0, 0}, texel);
        const auto at = static_cast<int>(c);
        tile.place.corner = glm::ivec2(at % 4, at / 4 % 4) * (kSide / 4);
        tile.place.size = glm::ivec2(kSide / 4);
        anew_[c].push_back({agents[c][0], &tile});
      }
      for (const uint32_t i : agents[c]) {
        const scene::FrameAgent& a = frame.agents[c][i];
        const glm::dvec3 eye = turned_back(-glm::dvec3(a.position), a.heading) / static_cast<double>(a.scale);
        TileView view = tile.view;
        view.to_eye = glm::normalize(eye - view.centre);
        view.right = glm::normalize(glm::cross(glm::dvec3(0, 1, 1e-9), view.to_eye));
        view.up = glm::cross(view.to_eye, view.right);
        add_quad(a, tile, view);
      }
    }
  }

  void clear_lists() {
    quads_.clear();
    anew_.assign(meshes_.size(), {});
    near_.assign(meshes_.size(), {});
  }

  void add_quad(const scene::FrameAgent& a, const TileRecord& tile, const TileView& view) {
    const glm::vec3 centre = a.position + a.scale * glm::vec3(turned(view.centre, a.heading));
    const glm::dvec2 texels = (tile.view.high - tile.view.low) / tile.view.texel;
    const glm::dvec2 low = glm::dvec2(tile.place.corner) + 1.0;
    const glm::vec2 from(low / static_cast<double>(kSide));
    const glm::vec2 to((low + texels) / static_cast<double>(kSide));
    quads_.push_back({tile.place.page,
                      {glm::vec4(centre, std::bit_cast<float>(a.id)),
                       glm::vec4(a.scale * glm::vec3(turned(view.right, a.heading)), 0.0F),
                       glm::vec4(a.scale * glm::vec3(turned(view.up, a.heading)), 0.0F),
                       glm::vec4(glm::vec2(tile.view.low), glm::vec2(tile.view.high)), glm::vec4(from, to)}});
  }

  void draw_anew(const scene::Frame& frame, const FrameResources& resources) {
    const auto any = [](const std::vector<Anew>& list) { return !list.empty(); };
    if (std::none_of(anew_.begin(), anew_.end(), any)) return;
    // Each as it was when its tile became stale, which may have been in a frame that was not drawn.
    scene::Frame posed = frame;
    for (size_t c = 0; c < anew_.size(); ++c) {
      std::stable_sort(anew_[c].begin(), anew_[c].end(),
                       [](const Anew& a, const Anew& b) { return a.tile->place.page < b.tile->place.page; });
      for (const Anew& one : anew_[c]) {
        scene::FrameAgent& agent = posed.agents[c][one.agent];
        if (!options_.floor) agent = one.tile->agent;
        agent.position = glm::vec3(0.0F);
        agent.scale = 1;
        if (options_.floor) {
          agent.heading = {0.0F, 1.0F};
          agent.pose = {};
        }
      }
    }
    resources.update_agents(posed);
    {
      const KeptView kept;
      glEnable(GL_SCISSOR_TEST);
      for (size_t c = 0; c < anew_.size(); ++c)
        for (size_t from = 0; from < anew_[c].size();) {
          size_t end = from + 1;
          while (end < anew_[c].size() && anew_[c][end].tile->place.page == anew_[c][from].tile->place.page) ++end;
          draw_page(c, posed, std::span(anew_[c]).subspan(from, end - from), resources);
          from = end;
        }
    }
    resources.update_agents(frame);
    MeshDraw::done();
  }

  // What is bound: where the tiles go, or all of it where it keeps nothing. (Of a target of several samples, Mesa's
  // zink 22.3 loses clears that are bounded by a scissor.)
  void clear(std::span<const Anew> tiles) const {
    const std::array<float, 4> nothing{};
    const auto clear_within = [&](const glm::ivec2& corner, const glm::ivec2& size) {
      glScissor(corner.x, corner.y, size.x, size.y);
      glClearBufferfv(GL_COLOR, 0, nothing.data());
      glClearBufferfv(GL_DEPTH, 0, nothing.data());
    };
    if (sampled_) return clear_within(glm::ivec2(0), glm::ivec2(kSide));
    for (const Anew& one : tiles) clear_within(one.tile->place.corner, one.tile->place.size);
  }

  // Tiles of one character on one page.
  void draw_page(size_t c, const scene::Frame& posed, std::span<const Anew> tiles, const FrameResources& resources) {
    const gl::Framebuffer& page = pages_[tiles.front().tile->place.page].target;
    (sampled_ ? sampled_target_ : page).bind();
    glViewport(0, 0, kSide, kSide);
    clear(tiles);
    std::vector<uint32_t> list;
    std::vector<TileRows> rows;
    for (const Anew& one : tiles) {
      const TileAtlas::Place& place = one.tile->place;
      list.push_back(one.agent);
      rows.push_back(tile_rows(one.tile->view, posed.agents[c][one.agent].heading, place.corner + 1, kSide));
      one.tile->drawn = true;
    }
    glScissor(0, 0, kSide, kSide);
    resources.draw_posed(c, list, [&](uint32_t first, uint32_t count) {
      write(rows_buffer_, rows_texels_, rows.data() + first, count * sizeof(TileRows));
      rows_texels_.bind(CB_TEXTURE_TILE_ROWS);
      captured_.draw(meshes_[c], {}, resources.list(), first, count);
    });
    if (!sampled_) return;
    for (const Anew& one : tiles) {
      const glm::ivec2 low = one.tile->place.corner;
      const glm::ivec2 high = low + one.tile->place.size;
      glBlitNamedFramebuffer(sampled_target_.name(), page.name(), low.x, low.y, high.x, high.y, low.x, low.y, high.x,
                             high.y, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    }
  }

  void draw_quads(const FrameResources& resources, const Pass& pass) {
    if (quads_.empty()) return;
    std::stable_sort(quads_.begin(), quads_.end(), [](const Quad& a, const Quad& b) { return a.page < b.page; });
    std::vector<QuadRecord> records;
    records.reserve(quads_.size());
    for (const Quad& quad : quads_) records.push_back(quad.record);
    write(quads_buffer_, quads_texels_, records.data(), records.size() * sizeof(QuadRecord));
    const gl::PerSampleScope by_sample(pass.samples);
    resources.bind();
    glDisable(GL_CULL_FACE);
    sampler_.bind(CB_DYNAMIC_TEXTURE_PAGE);
    quads_texels_.bind(CB_DYNAMIC_TEXTURE_RECORDS);
    no_vertices_.bind();
    const gl::Program& program = program_of(pass);
    program.use();
    for (size_t from = 0; from < quads_.size();) {
      size_t end = from + 1;
      while (end < quads_.size() && quads_[end].page == quads_[from].page) ++end;
      pages_[quads_[from].page].texels.bind(CB_DYNAMIC_TEXTURE_PAGE);
      program.set(CB_LOCATION_FIRST, static_cast<unsigned>(from));
      glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(6 * (end - from)));
      from = end;
    }
    glBindSampler(CB_DYNAMIC_TEXTURE_PAGE, 0);
  }

  void write(gl::Buffer& buffer, gl::Texture& texels, const void* data, size_t bytes) {
    if (buffer.size() < bytes) {
      texels = gl::Texture();
      buffer = gl::Buffer();
      buffer = gl::Buffer(context_, std::bit_ceil(bytes));
      texels = gl::Texture::make_buffer(context_, GL_RGBA32F, buffer);
    }
    buffer.write(data, bytes);
  }

  const gl::Program& program_of(const Pass& pass) {
    const std::array<bool, 3> variant = {pass.ids, pass.dithered, pass.touched};
    auto found = programs_.find(variant);
    if (found == programs_.end()) {
      gl::Defines defines;
      if (pass.ids) defines.emplace_back("CB_IDS", "");
      if (pass.dithered) defines.emplace_back("CB_DITHER", "");
      if (pass.touched) defines.emplace_back("CB_TOUCHED", "");
      found = programs_
                  .emplace(variant,
                           gl::Program(context_, {"renderers/dynamic/dynamic.vert", "renderers/dynamic/dynamic.frag"},
                                       defines))
                  .first;
    }
    return found->second;
  }

  gl::Context& context_;
  DynamicOptions options_;
  MeshDraw captured_, skinned_;
  gl::Sampler sampler_;
  gl::VertexArray no_vertices_;
  std::vector<CharacterMesh> meshes_;
  std::vector<Box> boxes_;
  gl::Texture depth_, sampled_;  // of the page being drawn; sampled_: its colours, where samples are several
  gl::Framebuffer sampled_target_;
  std::vector<Page> pages_;
  std::optional<TileStates> states_;
  std::vector<TileRecord> floor_tiles_;
  gl::Buffer rows_buffer_, quads_buffer_;
  gl::Texture rows_texels_, quads_texels_;
  std::map<std::array<bool, 3>, gl::Program> programs_;  // by ids, dither, touched
  std::vector<std::pair<std::string, double>> facts_;
  double seconds_ = 0;
  // Of the frame being drawn.
  std::vector<Quad> quads_;
  std::vector<std::vector<Anew>> anew_;
  AgentLists near_;  // without a tile: drawn as the mesh
};

}  // namespace

const RepresentationType dynamic_type = {
    .name = "dynamic",
    .summary =
        "impostors drawn at run time: an agent's billboard, drawn anew when its pose or its view has changed enough",
    .options = {{"pose", "0..10", "0.05", "metres that a distance between two points of the body may change"},
                {"angle", "0..90", "4", "degrees that the direction to the eye may turn about the agent"},
                {"size", "0..10", "0.1", "share by which the pixels a metre may grow or shrink"},
                {"joints", "2..16", "6", "points of the body whose distances are watched"},
                {"ratio", "0.25..4", "1", "texels a pixel"},
                {"samples", "1|2|4|8", "4", "a texel, that a tile is drawn with: its outline is the mean of as many"},
                {"largest", "8..510", "256", "texels: agents that are taller are drawn as the mesh"},
                {"budget", "1..4096", "32", "MiB of tiles; agents that find no place are drawn as the mesh"}},
    .make = [](const MakeContext& context, const Spec& spec) -> std::unique_ptr<Representation> {
      const OptionReader reader(dynamic_type, spec);
      DynamicOptions options;
      options.rules.pose = reader.number("pose", 0, 10);
      options.rules.angle = reader.number("angle", 0, 90) * std::numbers::pi / 180;
      options.rules.size = reader.number("size", 0, 10);
      options.rules.ratio = reader.number("ratio", 0.25, 4);
      options.rules.largest = static_cast<int>(reader.integer("largest", 8, 510));
      options.joints = static_cast<size_t>(reader.integer("joints", 2, 16));
      options.budget = static_cast<uint64_t>(reader.integer("budget", 1, 4096)) << 20;
      options.samples = 1 << reader.choice("samples", {"1", "2", "4", "8"});
      options.floor = reader.flag("floor");
      return std::make_unique<DynamicRepresentation>(context, options);
    },
    .floor = "one tile a character, shown by all its agents, without tests and never drawn anew",
    .suits = {.new_clips = "yes: drawn anew from the mesh",
              .close_by = "drawn anew at their size, at the mesh's cost and more",
              .from_above = "yes: from where the eye is",
              .shadows = "at the pose of the tile, of one limb on another alone; a card in depth"},
};

}  // namespace crowdbench::renderers
