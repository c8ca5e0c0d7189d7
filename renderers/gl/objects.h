// OpenGL objects: move-only RAII types without virtual functions.
//
// A moved-from or default object has name 0 and may be destroyed or assigned to, nothing else. An object that outlives
// its context calls no GL. Storage is immutable in size: to grow, assign a new object. Bytes of storage are counted in
// Context::allocated(). GL's integer types are spelled out here (unsigned for GLuint and GLenum, int for GLsizei), so
// that this header does not bring GL's.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

#include "renderers/gl/context.h"

namespace crowdbench::gl {

// May be copied to the GPU byte by byte (GLM's vectors are not trivially copyable in every version, yet plain).
template <typename T>
inline constexpr bool kPlain = std::is_standard_layout_v<T>&& std::is_trivially_destructible_v<T>;

// What the object types have in common: a name on a context.
class Object {
 public:
  unsigned name() const { return name_; }
  explicit operator bool() const { return name_ != 0; }

 protected:
  using Delete = void (*)(unsigned name);
  Object() = default;
  Object(Context& context, Delete destroy) : state_(context.state()), destroy_(destroy) { context.make_current(); }
  ~Object() { release(); }
  Object(Object&& other) noexcept { swap(other); }
  Object& operator=(Object&& other) noexcept {
    if (this != &other) {
      release();
      swap(other);
    }
    return *this;
  }
  void release() noexcept;
  void count_buffer(uint64_t bytes);
  void count_texture(uint64_t bytes);

  unsigned name_ = 0;

 private:
  void swap(Object& other) noexcept;
  std::shared_ptr<ContextState> state_;
  Delete destroy_ = nullptr;
  uint64_t buffer_bytes_ = 0;
  uint64_t texture_bytes_ = 0;
};

// A buffer of fixed size (glNamedBufferStorage), writable from the CPU by write().
class Buffer : public Object {
 public:
  Buffer() = default;
  // bytes > 0; data may be null: then the contents are undefined.
  Buffer(Context& context, size_t bytes, const void* data = nullptr);
  template <typename T>
  Buffer(Context& context, const std::vector<T>& values) : Buffer(context, values.size() * sizeof(T), values.data()) {
    static_assert(kPlain<T>);
  }
  size_t size() const { return size_; }
  // glNamedBufferSubData. offset + bytes <= size().
  void write(const void* data, size_t bytes, size_t offset = 0) const;
  template <typename T>
  void write(const std::vector<T>& values) const {
    static_assert(kPlain<T>);
    write(values.data(), values.size() * sizeof(T));
  }
  // Waits for the GPU. glGetNamedBufferSubData.
  void read(void* data, size_t bytes, size_t offset = 0) const;
  // glBindBufferBase / glBindBufferRange; target is GL_SHADER_STORAGE_BUFFER, GL_UNIFORM_BUFFER, ...
  void bind(unsigned target, unsigned index) const;
  void bind_range(unsigned target, unsigned index, size_t offset, size_t bytes) const;

 private:
  size_t size_ = 0;
};

// A 2D or 2D array texture of fixed size (glTextureStorage2D/3D).
class Texture : public Object {
 public:
  Texture() = default;
  // levels 0: a whole mip chain down to 1x1. format is a sized internal format, GL_RGBA8 for example.
  static Texture make_2d(Context& context, unsigned format, int width, int height, int levels = 1);
  static Texture make_array(Context& context, unsigned format, int width, int height, int layers, int levels = 0);
  // 2D, of `samples` samples a texel: drawn into and resolved by a blit, never read. Throws Error where the driver has
  // fewer.
  static Texture make_multisampled(Context& context, unsigned format, int width, int height, int samples);
  // A buffer seen as a row of texels (texelFetch of a samplerBuffer); counts no bytes of its own. The buffer must
  // outlive this.
  static Texture make_buffer(Context& context, unsigned format, const Buffer& buffer);
  int width() const { return width_; }
  int height() const { return height_; }
  int layers() const { return layers_; }
  int levels() const { return levels_; }
  unsigned format() const { return format_; }
  // Bytes of every level and layer.
  uint64_t bytes() const { return bytes_; }
  // Tightly packed pixels of one level (of one layer); format and type as GL_RGBA, GL_UNSIGNED_BYTE.
  void write(int level, int layer, unsigned format, unsigned type, const void* pixels) const;
  // glGenerateTextureMipmap.
  void generate_mipmaps() const;
  // Waits for the GPU. One whole level (all layers) into `bytes` bytes.
  void read(int level, unsigned format, unsigned type, void* pixels, size_t bytes) const;
  // glBindTextureUnit.
  void bind(unsigned unit) const;

 private:
  explicit Texture(Context& context);
  Texture(Context& context, unsigned target, unsigned format, int width, int height, int layers, int levels);
  unsigned format_ = 0;
  int width_ = 0, height_ = 0, layers_ = 0, levels_ = 0;
  uint64_t bytes_ = 0;
  bool array_ = false;
};

// Bytes of one texel (or of one 4x4 block of a compressed format: `block` is then 4).
struct TexelSize {
  int bytes = 0;
  int block = 1;
};
// Of the sized formats that this project uses; an unknown one is a bug and asserts.
TexelSize texel_size(unsigned format);
// Levels of a whole mip chain.
int mip_levels(int width, int height);
// Bytes of a texture: every level and layer.
uint64_t texture_bytes(unsigned format, int width, int height, int layers = 1, int levels = 1);

struct SamplerOptions {
  unsigned min_filter = 0x2703;  // GL_LINEAR_MIPMAP_LINEAR
  unsigned mag_filter = 0x2601;  // GL_LINEAR
  unsigned wrap_s = 0x2901;      // GL_REPEAT
  unsigned wrap_t = 0x2901;
};
class Sampler : public Object {
 public:
  Sampler() = default;
  Sampler(Context& context, const SamplerOptions& options);
  void bind(unsigned unit) const;
};

// One vertex attribute of a VertexArray.
struct Attribute {
  unsigned location = 0;
  int components = 1;
  unsigned type = 0x1406;  // GL_FLOAT
  bool normalised = false;
  bool integer = false;  // glVertexArrayAttribIFormat
  unsigned offset = 0;   // bytes in the vertex
};
class VertexArray : public Object {
 public:
  VertexArray() = default;
  // Without attributes: for shaders that make their vertices from gl_VertexID.
  explicit VertexArray(Context& context);
  // One interleaved buffer at binding 0; indices may be null. The buffers must outlive this.
  VertexArray(Context& context, const Buffer& vertices, int stride, std::span<const Attribute> attributes,
              const Buffer* indices);
  // A float attribute from a buffer of its own, tightly packed at `stride`; the buffer must outlive this.
  void add_stream(unsigned location, const Buffer& buffer, int components, int stride) const;
  // The interleaved buffer anew, from byte `offset` on: another of several runs of vertices of one layout.
  void set_vertices(const Buffer& vertices, size_t offset, int stride) const;
  // An attribute of one uint an instance, tightly packed from byte `offset` of the buffer.
  void set_instance_stream(unsigned location, const Buffer& buffer, size_t offset) const;
  // Attributes from records of `stride` bytes, one an instance, at a binding of their own (the first one's location).
  void set_instance_records(const Buffer& buffer, int stride, std::span<const Attribute> attributes) const;
  void bind() const;
};

class Framebuffer : public Object {
 public:
  Framebuffer() = default;
  // Colour attachments 0, 1, ... and an optional depth texture, which must outlive this. Throws Error when incomplete.
  Framebuffer(Context& context, std::span<const Texture* const> colours, const Texture* depth);
  void bind() const;
};

// A query object made by glGenQueries: glCreateQueries refuses pipeline statistics on Mesa.
class Query : public Object {
 public:
  Query() = default;
  // target: GL_SAMPLES_PASSED, GL_TIME_ELAPSED, GL_VERTEX_SHADER_INVOCATIONS, ...
  Query(Context& context, unsigned target);
  void begin() const;
  void end() const;
  // Waits for the result.
  uint64_t result() const;

 private:
  unsigned target_ = 0;
};

}  // namespace crowdbench::gl
