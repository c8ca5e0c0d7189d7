// Based on: I. Rudomin and E. Millan, "Point based rendering and displaced subdivision for interactive animation of
// crowds of clothed characters" (2004); discs in the surface's plane: H. Pfister et al., "Surfels" (2000). Differs from
// the sources: README.md.
#include "renderers/surfel/surfel.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "renderers/bake/bake_loader.h"
#include "renderers/frame/frame_resources.h"
#include "renderers/gl/per_sample.h"
#include "renderers/gl/program.h"
#include "renderers/mesh/mesh_data.h"
#include "renderers/shaders/bindings.shared.h"
#include "renderers/surfel/surfel_area.h"
#include "renderers/surfel/surfel_cloud.h"
#include "renderers/surfel/surfel_level.h"
#include "scene/cast/cast.h"

namespace crowdbench::renderers {
namespace {

struct SurfelVertex {
  float position[3];
  float reach;
  uint32_t normal;  // 10:10:10:2 signed normalised
  uint16_t joints[4];
  float weights[4];
  float colour[3];
  uint32_t bits;  // slot, unlit << 8, double-sided << 9
  float emissive[3];
};

struct CharacterSurfels {
  gl::Buffer vertices;
  gl::VertexArray vertex_array;
  uint32_t joints = 0;
  std::vector<SurfelLevel> levels;
  float tall = 0;  // metres
};

struct SurfelOptions {
  size_t points = 0;
  SurfelRule rule;
  bool floor = false;
};

SurfelVertex vertex_of(const Surfel& s) {
  SurfelVertex v{};
  for (int i = 0; i < 3; ++i) {
    v.position[i] = s.position[i];
    v.colour[i] = s.colour[i];
    v.emissive[i] = s.emissive[i];
  }
  v.reach = std::min(s.reach, 1e9F);
  v.normal = pack_normal(s.normal);
  for (int i = 0; i < 4; ++i) {
    v.joints[i] = s.joints[i];
    v.weights[i] = s.weights[i];
  }
  v.bits = s.slot | (s.unlit ? 0x100U : 0U) | (s.double_sided ? 0x200U : 0U);
  return v;
}

class SurfelRepresentation : public Representation {
 public:
  SurfelRepresentation(const MakeContext& make, const SurfelOptions& options)
      : context_(make.context), options_(options) {
    const auto start = std::chrono::steady_clock::now();
    for (size_t c = 0; c < make.cast.characters.size(); ++c) {
      const scene::PoseBank& bank = *make.cast.banks[c];
      const scene::Character& character = *make.cast.characters[c];
      add(make_surfel_cloud(character, bank, options.points, options.rule.cover,
                            bake_progress(make.policy(), "surfels", character.name)),
          bank);
    }
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  void draw(const scene::Frame& frame, const FrameResources& resources, const AgentLists& agents,
            const Pass& pass) override {
    const gl::PerSampleScope per_sample(pass.samples);
    const gl::Program& program = program_of(pass);
    int viewport[4] = {};
    glGetIntegerv(GL_VIEWPORT, viewport);
    program.set(CB_LOCATION_SAMPLES, static_cast<float>(viewport[3]) / static_cast<float>(frame.height));
    glEnable(GL_PROGRAM_POINT_SIZE);
    for (size_t c = 0; c < characters_.size(); ++c) {
      const CharacterSurfels& character = characters_[c];
      if (character.levels.empty() || agents[c].empty()) continue;
      sort_by_level(character, frame, frame.agents[c], agents[c]);
      if (options_.floor)
        resources.draw_listed(c, sorted_,
                              [&](uint32_t count) { draw_batch(character, program, resources.list(), 0, count); });
      else
        resources.draw_posed(c, sorted_, [&](uint32_t first, uint32_t count) {
          draw_batch(character, program, resources.list(), first, count);
        });
    }
    glDisable(GL_PROGRAM_POINT_SIZE);
  }

  Footprint footprint() const override {
    Footprint out;
    for (const CharacterSurfels& c : characters_) out.buffer_bytes += c.vertices.size();
    return out;
  }

  BakeInfo bake_info() const override {
    constexpr double kMillimetres = 1000;
    BakeInfo info;
    info.seconds = seconds_;
    double points = 0;
    double radius = 0;
    for (const CharacterSurfels& c : characters_) {
      if (c.levels.empty()) continue;
      points += c.levels.back().points;
      radius = std::max(radius, c.levels.back().radius);
    }
    info.facts = {{"points", points}, {"radius_mm", radius * kMillimetres}};
    return info;
  }

  // A point's square is two.
  uint64_t triangles(size_t character) const override {
    const auto& levels = characters_[character].levels;
    return levels.empty() ? 0 : 2 * uint64_t{levels.back().points};
  }

  // How far the smallest discs reach: nothing finer is shown.
  double texel_metres(size_t character) const override {
    const auto& levels = characters_[character].levels;
    return levels.empty() ? 0 : levels.back().radius * options_.rule.cover;
  }

 private:
  void add(const SurfelCloud& cloud, const scene::PoseBank& bank) {
    using V = SurfelVertex;
    CharacterSurfels& out = characters_.emplace_back();
    out.joints = static_cast<uint32_t>(bank.joints());
    out.levels = cloud.levels;
    out.tall = longest_side(bank);
    if (out.levels.empty()) return;
    std::vector<V> vertices;
    const std::vector<scene::Mat3x4> first_pose = bank.palette(bank.sample(0, 0.0));
    for (const Surfel& s : cloud.surfels) vertices.push_back(vertex_of(options_.floor ? in_pose(s, first_pose) : s));
    out.vertices = gl::Buffer(context_, vertices);
    std::vector<gl::Attribute> attributes = {
        {CB_ATTRIBUTE_POSITION, 4, GL_FLOAT, false, false, offsetof(V, position)},
        {CB_ATTRIBUTE_NORMAL, 4, GL_INT_2_10_10_10_REV, true, false, offsetof(V, normal)},
        {CB_ATTRIBUTE_UV, 1, GL_UNSIGNED_INT, false, true, offsetof(V, bits)},
        {CB_ATTRIBUTE_COLOUR, 3, GL_FLOAT, false, false, offsetof(V, colour)},
        {CB_ATTRIBUTE_EMISSIVE_UV, 3, GL_FLOAT, false, false, offsetof(V, emissive)},
    };
    if (!options_.floor) {
      attributes.push_back({CB_ATTRIBUTE_JOINTS, 4, GL_UNSIGNED_SHORT, false, true, offsetof(V, joints)});
      attributes.push_back({CB_ATTRIBUTE_WEIGHTS, 4, GL_FLOAT, false, false, offsetof(V, weights)});
    }
    out.vertex_array = gl::VertexArray(context_, out.vertices, sizeof(V), attributes, nullptr);
  }

  const gl::Program& program_of(const Pass& pass) {
    const std::pair<bool, bool> variant{pass.ids, pass.dithered};
    auto& slot = pass.touched ? touched_ : programs_[variant];
    if (!slot) {
      gl::Defines defines;
      if (options_.floor) defines.emplace_back("CB_STATIC", "");
      if (pass.ids) defines.emplace_back("CB_IDS", "");
      if (pass.dithered) defines.emplace_back("CB_DITHER", "");
      if (pass.touched) defines.emplace_back("CB_TOUCHED", "");
      slot = gl::Program(context_, {"renderers/surfel/surfel.vert", "renderers/surfel/surfel.frag"}, defines);
    }
    return slot;
  }

  // Fills sorted_ and first_: agents by level, those of one level in the order of the list.
  void sort_by_level(const CharacterSurfels& character, const scene::Frame& frame,
                     const std::vector<scene::FrameAgent>& all, const std::vector<uint32_t>& listed) {
    const double focal = 0.5 * frame.height / std::tan(frame.camera.fov_y / 2);
    // Rows are right, up and backward.
    const glm::dvec3 backward = glm::transpose(scene::view_rotation(frame.camera))[2];
    first_.assign(character.levels.size() + 1, 0);
    levels_.clear();
    for (const uint32_t i : listed) {
      const double depth = -glm::dot(backward, glm::dvec3(all[i].position));
      const double metre = focal * static_cast<double>(all[i].scale) / std::max(depth, frame.camera.near);
      levels_.push_back(surfel_level(character.levels, options_.rule, metre, static_cast<double>(character.tall)));
      ++first_[levels_.back() + 1];
    }
    for (size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
    std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
    sorted_.resize(listed.size());
    for (size_t i = 0; i < listed.size(); ++i) sorted_[next[levels_[i]]++] = listed[i];
  }

  // The agents of sorted_ from `first` on.
  void draw_batch(const CharacterSurfels& character, const gl::Program& program, const gl::Buffer& list, uint32_t first,
                  uint32_t count) {
    program.use();
    program.set(CB_LOCATION_TALL, character.tall);
    if (!options_.floor) program.set(CB_LOCATION_JOINTS, character.joints);
    for (size_t k = 0; k < character.levels.size(); ++k) {
      const uint32_t from = std::max(first_[k], first);
      const uint32_t end = std::min(first_[k + 1], first + count);
      if (from >= end) continue;
      if (!options_.floor) program.set(CB_LOCATION_FIRST, from - first);
      const SurfelLevel& level = character.levels[k];
      program.set(CB_LOCATION_RADIUS, static_cast<float>(level.radius * options_.rule.cover * level.closed));
      program.set(CB_LOCATION_REACH, static_cast<float>(level.reach * level.closed));
      program.set(CB_LOCATION_THIN, static_cast<float>(level.thin / level.closed));
      character.vertex_array.set_instance_stream(CB_ATTRIBUTE_AGENT, list, from * sizeof(uint32_t));
      character.vertex_array.bind();
      glDrawArraysInstanced(GL_POINTS, 0, static_cast<GLsizei>(level.points), static_cast<GLsizei>(end - from));
    }
  }

  gl::Context& context_;
  SurfelOptions options_;
  std::map<std::pair<bool, bool>, gl::Program> programs_;  // by ids and dither
  gl::Program touched_;
  std::vector<CharacterSurfels> characters_;
  double seconds_ = 0;
  // Of the character being drawn.
  std::vector<uint32_t> first_, sorted_;
  std::vector<size_t> levels_;
};

}  // namespace

const RepresentationType surfel_type = {
    .name = "surfel",
    .summary = "point clouds: skinned surfels, discs of the surface, as many as the figure's pixels ask for",
    .options = {{"points", "64..65536", "16384", "a character, at most"},
                {"size", "0.3..16", "1", "pixels: the fewest points whose discs have at most this radius are drawn"},
                {"cover", "0.5..4", "1.5",
                 "radius of a disc over the largest gap in the first pose: other poses stretch"}},
    .make = [](const MakeContext& context, const Spec& spec) -> std::unique_ptr<Representation> {
      const OptionReader reader(surfel_type, spec);
      SurfelOptions options;
      options.points = static_cast<size_t>(reader.integer("points", 64, 65536));
      options.rule.size = reader.number("size", 0.3, 16);
      options.rule.cover = reader.number("cover", 0.5, 4);
      options.floor = reader.flag("floor");
      return std::make_unique<SurfelRepresentation>(context, options);
    },
    .floor = "the same points in one pose, without skinning",
    .suits = {.new_clips = "yes: points are skinned when they are drawn",
              .close_by = "discs are seen",
              .from_above = "yes",
              .shadows = "at the depth of its discs"},
};

}  // namespace crowdbench::renderers
