#include "renderers/frame/depth_storage.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/error.h"
#include "renderers/frame/frame_resources.h"
#include "renderers/frame/frame_state.h"
#include "renderers/gl/objects.h"

namespace crowdbench::renderers {
namespace {

GLenum format_of(const DepthStorage& storage) {
  switch (storage.format) {
    case DepthFormat::fixed16: return GL_DEPTH_COMPONENT16;
    case DepthFormat::fixed24: return GL_DEPTH_COMPONENT24;
    case DepthFormat::float32: break;
  }
  return GL_DEPTH_COMPONENT32F;
}

glm::dmat4 projection_to(const scene::Frame& frame, const StoredDepth& stored) {
  const double aspect = static_cast<double>(frame.width) / static_cast<double>(frame.height);
  glm::dmat4 out = scene::projection(frame.camera, aspect);
  out[2][2] = -stored.offset;  // eye space looks along -Z, and w is the depth
  out[3][2] = stored.slope;
  return out;
}

}  // namespace

StoredDepth stored_depth(const scene::Camera& camera, const DepthStorage& storage) {
  const double near = camera.near;
  // Both of [near, far] over far - near, in a form that has a limit.
  const double ratio = camera.far > 0 ? near / camera.far : 0.0;
  const StoredDepth reversed{-ratio / (1 - ratio), near / (1 - ratio)};
  return storage.reversed ? reversed : StoredDepth{1 - reversed.offset, -reversed.slope};
}

double stored_step(const DepthStorage& storage, double z) {
  if (storage.format == DepthFormat::fixed16) return 1 / 65535.0;
  if (storage.format == DepthFormat::fixed24) return 1 / 16777215.0;
  const auto value = static_cast<float>(std::max(z, 0.0));
  return static_cast<double>(std::nextafter(value, 2.0F)) - static_cast<double>(value);
}

Capture capture_stored(gl::Context& context, Renderer& renderer, const scene::Frame& frame,
                       Representation& representation, const DepthStorage& storage) {
  context.make_current();
  const auto colour = gl::Texture::make_2d(context, GL_SRGB8_ALPHA8, frame.width, frame.height);
  const auto ids = gl::Texture::make_2d(context, GL_R32UI, frame.width, frame.height);
  const auto depth = gl::Texture::make_2d(context, format_of(storage), frame.width, frame.height);
  const gl::Framebuffer framebuffer(context, std::vector<const gl::Texture*>{&colour, &ids}, &depth);
  const StoredDepth stored = stored_depth(frame.camera, storage);
  FrameResources& resources = renderer.resources();
  resources.upload(frame);
  resources.set_projection(frame, projection_to(frame, stored));
  const AgentLists everybody = all_agents(frame);
  framebuffer.bind();
  glViewport(0, 0, frame.width, frame.height);
  begin_frame(frame, true, storage.reversed);
  representation.draw(frame, resources, everybody, {.ids = true});
  GLint function = 0;
  glGetIntegerv(GL_DEPTH_FUNC, &function);
  if (function != (storage.reversed ? GL_GREATER : GL_LESS))
    throw Error("depth storage",
                "this representation sets a depth function of its own, which is that of reversed depth",
                "use one that does not, or reversed depth");
  Capture out;
  out.colour = read_upright<uint8_t>(colour, 4, GL_RGBA, GL_UNSIGNED_BYTE);
  out.ids = read_upright<uint32_t>(ids, 1, GL_RED_INTEGER, GL_UNSIGNED_INT);
  out.depth = read_upright<float>(depth, 1, GL_DEPTH_COMPONENT, GL_FLOAT);
  // What the shader was given.
  const StoredDepth rounded{static_cast<double>(static_cast<float>(stored.offset)),
                            static_cast<double>(static_cast<float>(stored.slope))};
  for (size_t i = 0; i < out.depth.data.size(); ++i) {
    const double metres = rounded.metres(static_cast<double>(out.depth.data[i]));
    out.depth.data[i] =
        out.ids.data[i] != 0 && metres > 0 ? static_cast<float>(metres) : std::numeric_limits<float>::infinity();
  }
  return out;
}

}  // namespace crowdbench::renderers
