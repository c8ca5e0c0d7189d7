// FrameResources: one frame on the GPU, shared by every representation: the frame's uniforms, the agents, the outfits,
// the pose banks, and the posed palettes of those agents whose representation asks for them.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "renderers/gl/objects.h"
#include "scene/crowd/crowd.h"
#include "scene/frame/frame.h"

namespace crowdbench::renderers {

// The uniform block `FrameUniforms` of shaders/frame.glsl, std140; matrices column-major.
struct FrameUniforms {
  glm::mat4 clip_from_world;
  glm::mat4 view_from_world;
  glm::mat4 projection;
  glm::vec4 light_direction;
  glm::vec4 light;
  glm::vec4 viewport;
  glm::vec4 lens;
  glm::vec4 background;
  glm::vec4 ground_origin;
};

// `AgentRecord` of shaders/frame.glsl, std430.
struct AgentRecord {
  glm::vec4 position_scale;
  glm::vec4 heading_blend;
  glm::uvec4 pose;
  glm::uvec4 identity;
};

// Agents a frame may hold, over all characters: an agent's place and its material share 32 bits on their way through
// the rasteriser.
inline constexpr uint32_t kMaxFrameAgents = 1U << 20U;

// Bytes of one palette buffer, at most.
inline constexpr uint64_t kPaletteBlock = uint64_t{128} << 20;

class FrameResources {
 public:
  // Uploads the pose banks of the cast. `context` and `cast` must outlive this. Palettes are computed in batches of at
  // most `palette_block` bytes (one agent at least), fewer where the driver's limits ask for it. Throws Error when a
  // bank is larger than the driver's storage block.
  FrameResources(gl::Context& context, const scene::Cast& cast, uint64_t palette_block = kPaletteBlock);
  ~FrameResources();
  FrameResources(const FrameResources&) = delete;
  FrameResources& operator=(const FrameResources&) = delete;

  // Uploads everything of one frame but palettes. Throws Error above kMaxFrameAgents.
  void upload(const scene::Frame& frame);
  // Another projection from eye space than scene::projection's, the frame's view and all else as it was; until
  // upload().
  void set_projection(const scene::Frame& frame, const glm::dmat4& projection) const;
  // Binds the uniform block, the agents and the outfits at their places in shaders/bindings.shared.h.
  void bind() const;

  // The agents' records anew from a frame of the same agents, some of which show another pose; holds until upload().
  void update_agents(const scene::Frame& frame) const;

  // Passes with `dithered` draw the pixels whose threshold in (0, 1) lies in [low, high); upload() sets [0, 1).
  struct DitherRange {
    float low = 0;
    float high = 1;
  };
  void set_dither(const DitherRange& range) const;
  const DitherRange& dither() const;

  // Position in the agents' storage of the first agent of a character.
  uint32_t first_agent(size_t character) const;

  // Draws a list of agents of one character (indices into frame.agents[character]) that needs no palettes: uploads the
  // list, binds CB_STORAGE_LIST, and calls `draw(count)` once, unless the list is empty. In the shader,
  // agents[list[gl_InstanceID]] is the agent.
  void draw_listed(size_t character, std::span<const uint32_t> agents,
                   const std::function<void(uint32_t count)>& draw) const;
  // The same with posed palettes: before each call of draw(first, count), the palettes of list positions [first, first
  // + count) are computed on the GPU and CB_STORAGE_PALETTE and CB_TEXTURE_PALETTE are bound; the matrix of joint j of
  // the agent at list position first + i is palette[(i * joints + j) * 3 .. + 2], camera-relative world from bind
  // space. Several calls when the palettes of all do not fit one storage block (kPaletteBlock).
  void draw_posed(size_t character, std::span<const uint32_t> agents,
                  const std::function<void(uint32_t first, uint32_t count)>& draw) const;

  // Within a `draw` callback: the list as a buffer of uint, for an attribute that advances once an instance.
  const gl::Buffer& list() const;

  // Bytes of the buffers: banks and what a frame needs.
  uint64_t bytes() const;
  // Bytes sent to the GPU for the last frame, lists included.
  uint64_t upload_bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace crowdbench::renderers
