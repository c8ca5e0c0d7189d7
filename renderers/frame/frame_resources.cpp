#include "renderers/frame/frame_resources.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <deque>

#include "core/error.h"
#include "renderers/gl/objects.h"
#include "renderers/gl/program.h"
#include "renderers/shaders/bindings.shared.h"
#include "scene/cast/cast.h"

namespace crowdbench::renderers {
namespace {

static_assert(CB_OUTFIT_SLOTS == scene::kOutfitSlots);
static_assert(sizeof(AgentRecord) == 64);
static_assert(sizeof(FrameUniforms) == 3 * 64 + 6 * 16);

constexpr size_t kPaletteBuffers = 4;  // in use within one frame before the first is used again
constexpr double kGridCell = 1.0;      // metres between the ground's lines

// A buffer that grows and never shrinks, and the same bytes as RGBA32F texels.
struct TexelBuffer {
  gl::Buffer buffer;
  gl::Texture texels;
};

// Makes room for `bytes`; true when there is a new buffer.
bool reserve(gl::Context& context, gl::Buffer& buffer, size_t bytes) {
  if (buffer.size() >= bytes) return false;
  const size_t size = std::max(bytes, std::min(buffer.size() * 2, bytes + (bytes >> 1)));
  buffer = gl::Buffer();
  buffer = gl::Buffer(context, size);
  return true;
}

constexpr size_t kTexelBytes = 16;

void reserve(gl::Context& context, TexelBuffer& both, size_t bytes) {
  const auto limit = static_cast<uint64_t>(context.limits().texel_buffer);
  if (bytes / kTexelBytes > limit)
    throw Error("OpenGL", fmt::format("a table of {} bytes is larger than this driver's {} texels", bytes, limit),
                "use fewer agents");
  if (reserve(context, both.buffer, std::max(bytes, kTexelBytes)))
    both.texels = gl::Texture::make_buffer(context, GL_RGBA32F, both.buffer);
}

}  // namespace

struct FrameResources::State {
  gl::Context& context;
  const scene::Cast& cast;
  gl::Buffer uniforms, dither_uniforms;
  DitherRange dither;
  TexelBuffer agents;
  TexelBuffer outfits;
  std::vector<gl::Buffer> banks;  // by character
  std::deque<gl::Buffer> lists;   // one a list of this frame, so that none is overwritten while a draw may read it
  size_t lists_used = 0;
  const gl::Buffer* current_list = nullptr;
  std::vector<TexelBuffer> palettes;
  size_t palettes_used = 0;
  gl::Program pose;
  std::vector<uint32_t> first_agent;
  std::vector<AgentRecord> records;
  std::vector<uint32_t> list;
  uint64_t upload_bytes = 0;
  uint64_t palette_block = 0;

  explicit State(gl::Context& context_, const scene::Cast& cast_) : context(context_), cast(cast_) {}

  void write_records(const scene::Frame& frame) {
    records.clear();
    for (const auto& all : frame.agents)
      for (const scene::FrameAgent& a : all)
        records.push_back({glm::vec4(a.position, a.scale), glm::vec4(a.heading, a.pose.blend, a.phase),
                           glm::uvec4(a.pose.a, a.pose.b, static_cast<uint32_t>(a.bank_clip), 0U),
                           glm::uvec4(a.outfit, a.id, static_cast<uint32_t>(a.bank_clip), 0U)});
    agents.buffer.write(records);
  }

  // Uploads a list as positions in the agents' storage and binds it.
  void upload_list(size_t character, std::span<const uint32_t> chosen) {
    if (lists_used == lists.size()) lists.emplace_back();
    gl::Buffer& buffer = lists[lists_used++];
    reserve(context, buffer, chosen.size() * sizeof(uint32_t));
    list.resize(chosen.size());
    const uint32_t first = first_agent[character];
    for (size_t i = 0; i < chosen.size(); ++i) list[i] = first + chosen[i];
    buffer.write(list);
    upload_bytes += list.size() * sizeof(uint32_t);
    buffer.bind(GL_SHADER_STORAGE_BUFFER, CB_STORAGE_LIST);
    current_list = &buffer;
  }
};

FrameResources::FrameResources(gl::Context& context, const scene::Cast& cast, uint64_t palette_block)
    : state_(std::make_unique<State>(context, cast)) {
  State& s = *state_;
  s.palette_block = palette_block;
  context.make_current();
  s.uniforms = gl::Buffer(context, sizeof(FrameUniforms));
  s.dither_uniforms = gl::Buffer(context, sizeof(glm::vec4));
  for (const auto& bank : cast.banks) {
    const auto& matrices = bank->matrices();
    const size_t bytes = matrices.size() * sizeof(scene::Mat3x4);
    if (bytes > static_cast<uint64_t>(context.limits().storage_block))
      throw Error("pose bank",
                  fmt::format("{} bytes of poses do not fit this driver's storage block of {} bytes", bytes,
                              context.limits().storage_block),
                  "use fewer clips or a lower pose_rate");
    s.banks.emplace_back(context, matrices);
  }
  s.pose = gl::Program(context, {"renderers/shaders/pose.comp"});
  s.first_agent.assign(cast.characters.size(), 0);
}

FrameResources::~FrameResources() = default;

void FrameResources::upload(const scene::Frame& frame) {
  State& s = *state_;
  s.lists_used = 0;
  s.palettes_used = 0;

  FrameUniforms u;
  const double aspect = static_cast<double>(frame.width) / static_cast<double>(frame.height);
  const glm::dmat3 rotation = scene::view_rotation(frame.camera);
  const glm::dmat4 projection = scene::projection(frame.camera, aspect);
  u.view_from_world = glm::mat4(glm::dmat4(rotation));
  u.projection = glm::mat4(projection);
  u.clip_from_world = glm::mat4(projection * glm::dmat4(rotation));
  u.light_direction = glm::vec4(glm::normalize(frame.light.direction), 0.0F);
  u.light = {frame.light.ambient, frame.light.diffuse, 0.0F, 0.0F};
  const glm::vec2 size(frame.width, frame.height);
  u.viewport = glm::vec4(size, 1.0F / size);
  u.lens = {static_cast<float>(frame.camera.near), static_cast<float>(frame.camera.far),
            static_cast<float>(std::tan(frame.camera.fov_y / 2)), static_cast<float>(aspect)};
  u.background = frame.background;
  const auto within_cell = [](double x) { return static_cast<float>(x - std::floor(x / kGridCell) * kGridCell); };
  u.ground_origin = {within_cell(frame.origin.x), static_cast<float>(frame.origin.y - frame.ground_height),
                     within_cell(frame.origin.z), 0.0F};
  s.uniforms.write(&u, sizeof u);

  size_t count = 0;
  for (size_t c = 0; c < frame.agents.size(); ++c) {
    s.first_agent[c] = static_cast<uint32_t>(count);
    count += frame.agents[c].size();
  }
  if (count > kMaxFrameAgents)
    throw Error("agents", fmt::format("{} agents in one frame; {} is the most", count, kMaxFrameAgents),
                "lower the number of agents");
  reserve(s.context, s.agents, std::max<size_t>(count, 1) * sizeof(AgentRecord));
  s.write_records(frame);
  set_dither({});

  assert(!frame.outfits.empty());
  reserve(s.context, s.outfits, frame.outfits.size() * sizeof(scene::Outfit));
  s.outfits.buffer.write(frame.outfits);
  s.upload_bytes = sizeof u + s.records.size() * sizeof(AgentRecord) + frame.outfits.size() * sizeof(scene::Outfit);
}

void FrameResources::set_projection(const scene::Frame& frame, const glm::dmat4& projection) const {
  const glm::mat4 whole(projection * glm::dmat4(scene::view_rotation(frame.camera)));
  const glm::mat4 alone(projection);
  state_->uniforms.write(&whole, sizeof whole, offsetof(FrameUniforms, clip_from_world));
  state_->uniforms.write(&alone, sizeof alone, offsetof(FrameUniforms, projection));
}

void FrameResources::bind() const {
  const State& s = *state_;
  s.uniforms.bind(GL_UNIFORM_BUFFER, CB_UNIFORM_FRAME);
  s.dither_uniforms.bind(GL_UNIFORM_BUFFER, CB_UNIFORM_DITHER);
  s.agents.buffer.bind(GL_SHADER_STORAGE_BUFFER, CB_STORAGE_AGENTS);
  s.agents.texels.bind(CB_TEXTURE_AGENTS);
  s.outfits.texels.bind(CB_TEXTURE_OUTFITS);
}

void FrameResources::update_agents(const scene::Frame& frame) const {
  State& s = *state_;
  const size_t before = s.records.size();
  s.write_records(frame);
  assert(s.records.size() == before);
  (void)before;
  s.upload_bytes += s.records.size() * sizeof(AgentRecord);
}

void FrameResources::set_dither(const DitherRange& range) const {
  state_->dither = range;
  const glm::vec4 both(range.low, range.high, 0.0F, 0.0F);
  state_->dither_uniforms.write(&both, sizeof both);
}

const FrameResources::DitherRange& FrameResources::dither() const { return state_->dither; }

uint32_t FrameResources::first_agent(size_t character) const { return state_->first_agent[character]; }

void FrameResources::draw_listed(size_t character, std::span<const uint32_t> agents,
                                 const std::function<void(uint32_t count)>& draw) const {
  if (agents.empty()) return;
  bind();
  state_->upload_list(character, agents);
  draw(static_cast<uint32_t>(agents.size()));
}

void FrameResources::draw_posed(size_t character, std::span<const uint32_t> agents,
                                const std::function<void(uint32_t first, uint32_t count)>& draw) const {
  if (agents.empty()) return;
  State& s = *state_;
  bind();
  s.upload_list(character, agents);
  s.banks[character].bind(GL_SHADER_STORAGE_BUFFER, CB_STORAGE_POSE_BANK);
  const auto joints = static_cast<uint32_t>(s.cast.banks[character]->joints());
  const uint64_t agent_bytes = uint64_t{joints} * sizeof(scene::Mat3x4);
  const gl::Limits& limits = s.context.limits();
  const uint64_t block = std::min({s.palette_block, static_cast<uint64_t>(limits.storage_block),
                                   static_cast<uint64_t>(limits.texel_buffer) * kTexelBytes});
  const uint64_t batch = std::max<uint64_t>(block / agent_bytes, 1);
  for (uint64_t first = 0; first < agents.size(); first += batch) {
    const auto count = static_cast<uint32_t>(std::min<uint64_t>(batch, agents.size() - first));
    const size_t slot = s.palettes_used++ % kPaletteBuffers;
    if (slot == s.palettes.size()) s.palettes.emplace_back();
    TexelBuffer& palette = s.palettes[slot];
    reserve(s.context, palette, count * agent_bytes);
    palette.buffer.bind(GL_SHADER_STORAGE_BUFFER, CB_STORAGE_PALETTE);
    palette.texels.bind(CB_TEXTURE_PALETTE);
    s.pose.use();
    s.pose.set(CB_LOCATION_FIRST, static_cast<uint32_t>(first));
    s.pose.set(CB_LOCATION_JOINTS, joints);
    s.pose.set(CB_LOCATION_COUNT, count);
    // An earlier frame's or batch's draws may still read this buffer.
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    glDispatchCompute((count * joints + 63U) / 64U, 1, 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);
    draw(static_cast<uint32_t>(first), count);
  }
}

uint64_t FrameResources::bytes() const {
  const State& s = *state_;
  uint64_t total = s.uniforms.size() + s.dither_uniforms.size() + s.agents.buffer.size() + s.outfits.buffer.size();
  for (const gl::Buffer& b : s.banks) total += b.size();
  for (const gl::Buffer& b : s.lists) total += b.size();
  for (const TexelBuffer& b : s.palettes) total += b.buffer.size();
  return total;
}

const gl::Buffer& FrameResources::list() const {
  assert(state_->current_list);
  return *state_->current_list;
}

uint64_t FrameResources::upload_bytes() const { return state_->upload_bytes; }

}  // namespace crowdbench::renderers
