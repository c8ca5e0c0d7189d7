#include "renderers/gl/objects.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "core/error.h"

namespace crowdbench::gl {

void Object::release() noexcept {
  if (name_ != 0 && state_ && state_->alive) {
    const CurrentScope scope(*state_);
    destroy_(name_);
    state_->allocated.buffer_bytes -= buffer_bytes_;
    state_->allocated.texture_bytes -= texture_bytes_;
  }
  name_ = 0;
  buffer_bytes_ = 0;
  texture_bytes_ = 0;
  state_.reset();
}

void Object::swap(Object& other) noexcept {
  std::swap(name_, other.name_);
  std::swap(state_, other.state_);
  std::swap(destroy_, other.destroy_);
  std::swap(buffer_bytes_, other.buffer_bytes_);
  std::swap(texture_bytes_, other.texture_bytes_);
}

void Object::count_buffer(uint64_t bytes) {
  buffer_bytes_ = bytes;
  state_->allocated.buffer_bytes += bytes;
}

void Object::count_texture(uint64_t bytes) {
  texture_bytes_ = bytes;
  state_->allocated.texture_bytes += bytes;
}

Buffer::Buffer(Context& context, size_t bytes, const void* data)
    : Object(context, [](unsigned name) { glDeleteBuffers(1, &name); }), size_(bytes) {
  assert(bytes > 0);
  glCreateBuffers(1, &name_);
  while (glGetError() != GL_NO_ERROR) {
  }
  glNamedBufferStorage(name_, static_cast<GLsizeiptr>(bytes), data, GL_DYNAMIC_STORAGE_BIT);
  if (glGetError() == GL_OUT_OF_MEMORY)
    throw Error("OpenGL", fmt::format("out of memory for a buffer of {} bytes", bytes),
                "use fewer agents or smaller characters");
  count_buffer(bytes);
}

void Buffer::write(const void* data, size_t bytes, size_t offset) const {
  assert(offset + bytes <= size_);
  if (bytes > 0) glNamedBufferSubData(name_, static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes), data);
}

void Buffer::read(void* data, size_t bytes, size_t offset) const {
  assert(offset + bytes <= size_);
  glGetNamedBufferSubData(name_, static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes), data);
}

void Buffer::bind(unsigned target, unsigned index) const { glBindBufferBase(target, index, name_); }

void Buffer::bind_range(unsigned target, unsigned index, size_t offset, size_t bytes) const {
  assert(offset + bytes <= size_);
  glBindBufferRange(target, index, name_, static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes));
}

TexelSize texel_size(unsigned format) {
  switch (format) {
    case GL_R8:
    case GL_R8UI: return {1, 1};
    case GL_RG8:
    case GL_R16:
    case GL_DEPTH_COMPONENT16: return {2, 1};
    case GL_RGB8: return {3, 1};
    case GL_RGB10_A2:
    case GL_RGBA8:
    case GL_SRGB8_ALPHA8:
    case GL_RG16:
    case GL_R32F:
    case GL_R32UI:
    case GL_DEPTH_COMPONENT24:
    case GL_DEPTH_COMPONENT32F: return {4, 1};
    case GL_RGBA16:
    case GL_RGBA16F:
    case GL_RG32F:
    case GL_RG32UI: return {8, 1};
    case GL_RGBA32F:
    case GL_RGBA32UI: return {16, 1};
    case GL_COMPRESSED_RGB_S3TC_DXT1_EXT:
    case GL_COMPRESSED_SRGB_S3TC_DXT1_EXT:
    case GL_COMPRESSED_RED_RGTC1: return {8, 4};
    case GL_COMPRESSED_RGBA_S3TC_DXT5_EXT:
    case GL_COMPRESSED_RG_RGTC2:
    case GL_COMPRESSED_RGBA_BPTC_UNORM:
    case GL_COMPRESSED_SRGB_ALPHA_BPTC_UNORM: return {16, 4};
    default: assert(!"a format without a known size"); return {};
  }
}

int mip_levels(int width, int height) {
  int levels = 1;
  for (int side = std::max(width, height); side > 1; side /= 2) ++levels;
  return levels;
}

uint64_t texture_bytes(unsigned format, int width, int height, int layers, int levels) {
  const TexelSize texel = texel_size(format);
  uint64_t bytes = 0;
  for (int level = 0; level < levels; ++level) {
    const auto blocks = [&](int side) { return (std::max(side >> level, 1) + texel.block - 1) / texel.block; };
    bytes += static_cast<uint64_t>(blocks(width)) * static_cast<uint64_t>(blocks(height)) *
             static_cast<uint64_t>(layers) * static_cast<uint64_t>(texel.bytes);
  }
  return bytes;
}

Texture::Texture(Context& context, unsigned target, unsigned format, int width, int height, int layers, int levels)
    : Object(context, [](unsigned name) { glDeleteTextures(1, &name); }),
      format_(format),
      width_(width),
      height_(height),
      layers_(layers),
      levels_(levels > 0 ? levels : mip_levels(width, height)),
      array_(target == GL_TEXTURE_2D_ARRAY) {
  const Limits& limits = context.limits();
  if (width < 1 || height < 1 || layers < 1 || width > limits.texture_size || height > limits.texture_size ||
      layers > std::max(limits.array_layers, 1))
    throw Error("OpenGL",
                fmt::format("a texture of {} x {} x {} is outside this driver's limit of {} x {} x {}", width, height,
                            layers, limits.texture_size, limits.texture_size, limits.array_layers),
                "use a smaller size");
  bytes_ = texture_bytes(format, width, height, layers, levels_);
  glCreateTextures(target, 1, &name_);
  while (glGetError() != GL_NO_ERROR) {
  }
  if (array_)
    glTextureStorage3D(name_, levels_, format, width, height, layers);
  else
    glTextureStorage2D(name_, levels_, format, width, height);
  if (glGetError() == GL_OUT_OF_MEMORY)
    throw Error("OpenGL", fmt::format("out of memory for a texture of {} bytes", bytes_),
                "lower the bake budget, the resolution or the number of tiles");
  count_texture(bytes_);
}

Texture::Texture(Context& context) : Object(context, [](unsigned name) { glDeleteTextures(1, &name); }) {}

Texture Texture::make_buffer(Context& context, unsigned format, const Buffer& buffer) {
  Texture texture(context);
  texture.format_ = format;
  texture.levels_ = 1;
  texture.width_ = static_cast<int>(buffer.size() / static_cast<size_t>(texel_size(format).bytes));
  texture.height_ = texture.layers_ = 1;
  glCreateTextures(GL_TEXTURE_BUFFER, 1, &texture.name_);
  glTextureBuffer(texture.name_, format, buffer.name());
  return texture;
}

Texture Texture::make_2d(Context& context, unsigned format, int width, int height, int levels) {
  return {context, GL_TEXTURE_2D, format, width, height, 1, levels};
}

Texture Texture::make_multisampled(Context& context, unsigned format, int width, int height, int samples) {
  const Limits& limits = context.limits();
  if (samples > limits.samples)
    throw Error("samples", fmt::format("{} samples a pixel are more than this driver's {}", samples, limits.samples),
                "use fewer, or supersample");
  if (width < 1 || height < 1 || width > limits.texture_size || height > limits.texture_size)
    throw Error("OpenGL",
                fmt::format("a picture of {} x {} is outside this driver's limit of {} x {}", width, height,
                            limits.texture_size, limits.texture_size),
                "use a smaller size");
  Texture texture(context);
  texture.format_ = format;
  texture.width_ = width;
  texture.height_ = height;
  texture.layers_ = texture.levels_ = 1;
  texture.bytes_ = texture_bytes(format, width, height) * static_cast<uint64_t>(samples);
  glCreateTextures(GL_TEXTURE_2D_MULTISAMPLE, 1, &texture.name_);
  while (glGetError() != GL_NO_ERROR) {
  }
  glTextureStorage2DMultisample(texture.name_, samples, format, width, height, GL_TRUE);
  if (glGetError() == GL_OUT_OF_MEMORY)
    throw Error("OpenGL", fmt::format("out of memory for a picture of {} bytes", texture.bytes_),
                "use fewer samples or a smaller size");
  texture.count_texture(texture.bytes_);
  return texture;
}

Texture Texture::make_array(Context& context, unsigned format, int width, int height, int layers, int levels) {
  return {context, GL_TEXTURE_2D_ARRAY, format, width, height, layers, levels};
}

void Texture::write(int level, int layer, unsigned format, unsigned type, const void* pixels) const {
  const int w = std::max(width_ >> level, 1);
  const int h = std::max(height_ >> level, 1);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  const TexelSize texel = texel_size(format_);
  if (texel.block > 1) {
    const int size = (w + texel.block - 1) / texel.block * ((h + texel.block - 1) / texel.block) * texel.bytes;
    if (array_)
      glCompressedTextureSubImage3D(name_, level, 0, 0, layer, w, h, 1, format_, size, pixels);
    else
      glCompressedTextureSubImage2D(name_, level, 0, 0, w, h, format_, size, pixels);
  } else if (array_) {
    glTextureSubImage3D(name_, level, 0, 0, layer, w, h, 1, format, type, pixels);
  } else {
    glTextureSubImage2D(name_, level, 0, 0, w, h, format, type, pixels);
  }
}

void Texture::generate_mipmaps() const { glGenerateTextureMipmap(name_); }

void Texture::read(int level, unsigned format, unsigned type, void* pixels, size_t bytes) const {
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glGetTextureImage(name_, level, format, type, static_cast<GLsizei>(bytes), pixels);
}

void Texture::bind(unsigned unit) const { glBindTextureUnit(unit, name_); }

Sampler::Sampler(Context& context, const SamplerOptions& options)
    : Object(context, [](unsigned name) { glDeleteSamplers(1, &name); }) {
  glCreateSamplers(1, &name_);
  glSamplerParameteri(name_, GL_TEXTURE_MIN_FILTER, static_cast<GLint>(options.min_filter));
  glSamplerParameteri(name_, GL_TEXTURE_MAG_FILTER, static_cast<GLint>(options.mag_filter));
  glSamplerParameteri(name_, GL_TEXTURE_WRAP_S, static_cast<GLint>(options.wrap_s));
  glSamplerParameteri(name_, GL_TEXTURE_WRAP_T, static_cast<GLint>(options.wrap_t));
}

void Sampler::bind(unsigned unit) const { glBindSampler(unit, name_); }

namespace {

// The attributes of one binding of a vertex array.
void describe_attributes(unsigned array, unsigned binding, std::span<const Attribute> attributes) {
  for (const Attribute& a : attributes) {
    glEnableVertexArrayAttrib(array, a.location);
    if (a.integer)
      glVertexArrayAttribIFormat(array, a.location, a.components, a.type, a.offset);
    else
      glVertexArrayAttribFormat(array, a.location, a.components, a.type, a.normalised ? GL_TRUE : GL_FALSE, a.offset);
    glVertexArrayAttribBinding(array, a.location, binding);
  }
}

}  // namespace

VertexArray::VertexArray(Context& context) : Object(context, [](unsigned name) { glDeleteVertexArrays(1, &name); }) {
  glCreateVertexArrays(1, &name_);
}

VertexArray::VertexArray(Context& context, const Buffer& vertices, int stride, std::span<const Attribute> attributes,
                         const Buffer* indices)
    : VertexArray(context) {
  glVertexArrayVertexBuffer(name_, 0, vertices.name(), 0, stride);
  describe_attributes(name_, 0, attributes);
  if (indices) glVertexArrayElementBuffer(name_, indices->name());
}

void VertexArray::add_stream(unsigned location, const Buffer& buffer, int components, int stride) const {
  // Binding 0 is the interleaved buffer; a stream takes the binding of its location.
  assert(location > 0);
  glVertexArrayVertexBuffer(name_, location, buffer.name(), 0, stride);
  glEnableVertexArrayAttrib(name_, location);
  glVertexArrayAttribFormat(name_, location, components, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(name_, location, location);
}

void VertexArray::set_vertices(const Buffer& vertices, size_t offset, int stride) const {
  glVertexArrayVertexBuffer(name_, 0, vertices.name(), static_cast<GLintptr>(offset), stride);
}

void VertexArray::set_instance_stream(unsigned location, const Buffer& buffer, size_t offset) const {
  assert(location > 0);
  glVertexArrayVertexBuffer(name_, location, buffer.name(), static_cast<GLintptr>(offset), sizeof(uint32_t));
  glEnableVertexArrayAttrib(name_, location);
  glVertexArrayAttribIFormat(name_, location, 1, GL_UNSIGNED_INT, 0);
  glVertexArrayAttribBinding(name_, location, location);
  glVertexArrayBindingDivisor(name_, location, 1);
}

void VertexArray::set_instance_records(const Buffer& buffer, int stride, std::span<const Attribute> attributes) const {
  const unsigned binding = attributes.front().location;
  assert(binding > 0);
  glVertexArrayVertexBuffer(name_, binding, buffer.name(), 0, stride);
  glVertexArrayBindingDivisor(name_, binding, 1);
  describe_attributes(name_, binding, attributes);
}

void VertexArray::bind() const { glBindVertexArray(name_); }

Framebuffer::Framebuffer(Context& context, std::span<const Texture* const> colours, const Texture* depth)
    : Object(context, [](unsigned name) { glDeleteFramebuffers(1, &name); }) {
  glCreateFramebuffers(1, &name_);
  std::vector<GLenum> buffers;
  for (const Texture* colour : colours) {
    const auto attachment = static_cast<GLenum>(GL_COLOR_ATTACHMENT0 + buffers.size());
    glNamedFramebufferTexture(name_, attachment, colour->name(), 0);
    buffers.push_back(attachment);
  }
  glNamedFramebufferDrawBuffers(name_, static_cast<GLsizei>(buffers.size()), buffers.data());
  if (depth) glNamedFramebufferTexture(name_, GL_DEPTH_ATTACHMENT, depth->name(), 0);
  const GLenum status = glCheckNamedFramebufferStatus(name_, GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE)
    throw Error("OpenGL", fmt::format("the driver refuses the frame buffer (status {:#x})", status));
}

void Framebuffer::bind() const { glBindFramebuffer(GL_FRAMEBUFFER, name_); }

Query::Query(Context& context, unsigned target)
    : Object(context, [](unsigned name) { glDeleteQueries(1, &name); }), target_(target) {
  glGenQueries(1, &name_);
}

void Query::begin() const { glBeginQuery(target_, name_); }
void Query::end() const { glEndQuery(target_); }

uint64_t Query::result() const {
  GLuint64 value = 0;
  glGetQueryObjectui64v(name_, GL_QUERY_RESULT, &value);
  return value;
}

}  // namespace crowdbench::gl
