#include "renderers/frame/capture.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cassert>
#include <limits>
#include <numeric>
#include <optional>

#include "core/colour.h"
#include "core/error.h"
#include "renderers/frame/frame_resources.h"
#include "renderers/frame/frame_state.h"
#include "renderers/gl/objects.h"
#include "renderers/gl/program.h"
#include "scene/cast/cast.h"

namespace crowdbench::renderers {

struct Target::State {
  gl::Context& context;
  Pass pass;
  gl::Texture colour, ids, depth;
  gl::Framebuffer framebuffer;
  gl::Texture samples;  // with several samples a pixel: what is drawn into, before `colour`
  gl::Framebuffer sampled;
  // Of the last draw: eye-space depth = b / (stored depth + a).
  mutable float depth_a = 0, depth_b = 0;
};

Target::Target(gl::Context& context, int width, int height, Pass pass)
    : state_(std::make_unique<State>(State{context, pass, {}, {}, {}, {}, {}, {}})) {
  State& s = *state_;
  const GLenum format = pass.linear ? GL_RGBA32F : GL_SRGB8_ALPHA8;
  s.colour = gl::Texture::make_2d(context, format, width, height);
  if (pass.samples > 1) {
    assert(!pass.ids && !pass.touched && !pass.texels);
    s.samples = gl::Texture::make_multisampled(context, format, width, height, pass.samples);
    s.depth = gl::Texture::make_multisampled(context, GL_DEPTH_COMPONENT32F, width, height, pass.samples);
    s.sampled = gl::Framebuffer(context, std::vector<const gl::Texture*>{&s.samples}, &s.depth);
    s.framebuffer = gl::Framebuffer(context, std::vector<const gl::Texture*>{&s.colour}, nullptr);
    return;
  }
  s.depth = gl::Texture::make_2d(context, GL_DEPTH_COMPONENT32F, width, height);
  std::vector<const gl::Texture*> colours = {&s.colour};
  if (pass.ids) {
    s.ids = gl::Texture::make_2d(context, GL_R32UI, width, height);
    colours.push_back(&s.ids);
  }
  s.framebuffer = gl::Framebuffer(context, colours, &s.depth);
}

Target::~Target() = default;
Target::Target(Target&&) noexcept = default;
Target& Target::operator=(Target&&) noexcept = default;

int Target::width() const { return state_->colour.width(); }
int Target::height() const { return state_->colour.height(); }
const Pass& Target::pass() const { return state_->pass; }
void Target::bind() const {
  (pass().samples > 1 ? state_->sampled : state_->framebuffer).bind();
  glViewport(0, 0, width(), height());
}
// The samples' mean in linear light, for the frame buffer decodes and encodes sRGB.
void Target::resolve() const {
  if (pass().samples == 1) return;
  glBlitNamedFramebuffer(state_->sampled.name(), state_->framebuffer.name(), 0, 0, width(), height(), 0, 0, width(),
                         height(), GL_COLOR_BUFFER_BIT, GL_NEAREST);
}
unsigned Target::framebuffer() const { return state_->framebuffer.name(); }

Capture Target::read() const {
  const State& s = *state_;
  s.context.make_current();
  Capture out;
  if (s.pass.linear)
    out.linear = read_upright<float>(s.colour, 4, GL_RGBA, GL_FLOAT);
  else
    out.colour = read_upright<uint8_t>(s.colour, 4, GL_RGBA, GL_UNSIGNED_BYTE);
  if (s.pass.samples > 1) {
    // Alpha to coverage leaves what it was given.
    for (size_t i = 3; i < out.linear.data.size(); i += 4) out.linear.data[i] = 1.0F;
    for (size_t i = 3; i < out.colour.data.size(); i += 4) out.colour.data[i] = 255;
    return out;
  }
  if (s.pass.ids) out.ids = read_upright<uint32_t>(s.ids, 1, GL_RED_INTEGER, GL_UNSIGNED_INT);
  out.depth = read_upright<float>(s.depth, 1, GL_DEPTH_COMPONENT, GL_FLOAT);
  for (float& d : out.depth.data) d = d > 0.0F ? s.depth_b / (d + s.depth_a) : std::numeric_limits<float>::infinity();
  return out;
}

struct Renderer::State {
  gl::Context& context;
  FrameResources resources;
  gl::VertexArray no_vertices;
  std::optional<gl::Program> ground, ground_ids;
  std::vector<Target> targets;  // kept from one capture to the next
  AgentLists everybody;

  State(gl::Context& context_, const scene::Cast& cast)
      : context(context_), resources(context_, cast), no_vertices(context_) {}

  void draw_ground(const Pass& pass) {
    std::optional<gl::Program>& program = pass.ids ? ground_ids : ground;
    if (!program) {
      gl::Defines defines;
      if (pass.ids) defines.emplace_back("CB_IDS", "");
      program.emplace(
          context,
          std::initializer_list<std::string_view>{"renderers/shaders/screen.vert", "renderers/shaders/ground.frag"},
          defines);
    }
    resources.bind();
    no_vertices.bind();
    program->use();
    glDrawArrays(GL_TRIANGLES, 0, 3);
  }

  const Target& target(int width, int height, const Pass& pass) {
    for (size_t i = 0; i < targets.size(); ++i)
      if (targets[i].pass() == pass) {
        if (targets[i].width() != width || targets[i].height() != height)
          targets[i] = Target(context, width, height, pass);
        return targets[i];
      }
    return targets.emplace_back(context, width, height, pass);
  }
};

Renderer::Renderer(gl::Context& context, const scene::Cast& cast) : state_(std::make_unique<State>(context, cast)) {}
Renderer::~Renderer() = default;

void Renderer::draw(const scene::Frame& frame, Representation& representation, const Target& target) {
  State& s = *state_;
  s.context.make_current();
  s.everybody.resize(frame.agents.size());
  for (size_t c = 0; c < frame.agents.size(); ++c) {
    const size_t before = s.everybody[c].size();
    s.everybody[c].resize(frame.agents[c].size());
    if (before < s.everybody[c].size())
      std::iota(s.everybody[c].begin() + static_cast<std::ptrdiff_t>(before), s.everybody[c].end(),
                static_cast<uint32_t>(before));
  }
  assert(target.width() % frame.width == 0 && target.height() == target.width() / frame.width * frame.height);
  s.resources.upload(frame);

  const double aspect = static_cast<double>(frame.width) / static_cast<double>(frame.height);
  const glm::dmat4 projection = scene::projection(frame.camera, aspect);
  target.state_->depth_a = static_cast<float>(projection[2][2]);
  target.state_->depth_b = static_cast<float>(projection[3][2]);

  target.bind();
  begin_frame(frame, target.pass().ids, true);
  if (frame.ground) s.draw_ground(target.pass());
  representation.draw(frame, s.resources, s.everybody, target.pass());
  target.resolve();
}

void Renderer::finish() { state_->context.finish(); }

Capture Renderer::capture(const scene::Frame& frame, Representation& representation, const CaptureOptions& options) {
  State& s = *state_;
  const int samples = frame.antialiasing.samples;
  const int k = frame.antialiasing.supersample;
  const int side = s.context.limits().viewport_size;
  if (samples != 1 && samples != 2 && samples != 4 && samples != 8)
    throw Error("samples", fmt::format("'{}' is not a number of samples a pixel", samples), "use 1, 2, 4 or 8");
  if (k < 1 || k % 2 == 0)
    throw Error("supersample", fmt::format("{} is not an odd number of samples a side", k), "use 1, 3, 5, ...");
  if (frame.width > side / k || frame.height > side / k)
    throw Error("size",
                fmt::format("{} x {} pixels with {} x {} samples are more than this driver's {} a side", frame.width,
                            frame.height, k, k, side),
                "use a smaller size or fewer samples");
  const auto take = [&](const Pass& pass) {
    const Target& target = s.target(frame.width * k, frame.height * k, pass);
    draw(frame, representation, target);
    return target.read();
  };
  const bool several = samples > 1;
  const auto colours = [&](bool linear) {
    return take(several ? Pass{.linear = linear, .samples = samples} : Pass{.ids = true, .linear = linear});
  };
  if (k == 1) {
    Capture out = take({.ids = true, .linear = false});
    if (several) out.colour = colours(false).colour;
    if (options.linear) out.linear = colours(true).linear;
    return out;
  }
  Capture fine = take({.ids = true, .linear = true});
  if (several) fine.linear = colours(true).linear;
  Capture out;
  out.colour = Image8(frame.width, frame.height, 4);
  ImageF linear(frame.width, frame.height, 4);
  out.depth = ImageF(frame.width, frame.height, 1);
  out.ids = ImageU32(frame.width, frame.height, 1);
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x) {
      double sum[3] = {0, 0, 0};
      for (int j = 0; j < k; ++j)
        for (int i = 0; i < k; ++i) {
          const float* sample = fine.linear.at(x * k + i, y * k + j);
          for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(sample[c]);
        }
      for (int c = 0; c < 3; ++c) {
        const double mean = sum[c] / (k * k);
        linear.at(x, y)[c] = static_cast<float>(mean);
        out.colour.at(x, y)[c] = linear_to_srgb8(mean);
      }
      linear.at(x, y)[3] = 1.0F;
      out.colour.at(x, y)[3] = 255;
      out.depth.at(x, y)[0] = fine.depth.at(x * k + k / 2, y * k + k / 2)[0];
      out.ids.at(x, y)[0] = fine.ids.at(x * k + k / 2, y * k + k / 2)[0];
    }
  if (options.linear) out.linear = std::move(linear);
  return out;
}

FrameResources& Renderer::resources() { return state_->resources; }

uint64_t Renderer::shared_bytes() const { return state_->resources.bytes(); }

}  // namespace crowdbench::renderers
