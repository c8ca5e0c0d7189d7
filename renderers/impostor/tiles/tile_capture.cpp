#include "renderers/impostor/tiles/tile_capture.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.h"
#include "renderers/frame/frame_resources.h"
#include "renderers/gl/objects.h"
#include "renderers/gl/program.h"
#include "renderers/impostor/tiles/packing.h"
#include "renderers/mesh/mesh.h"
#include "renderers/shaders/bindings.shared.h"
#include "scene/cast/cast.h"

namespace crowdbench::renderers {
namespace {

constexpr int kSamples = 3;  // a side of a texel
constexpr int kPage = 1024;  // texels a side, unless a tile is larger

// `CaptureView` of capture.glsl, std430.
struct CaptureView {
  glm::vec4 x, y, z, w, place;
};

}  // namespace

// Based on: Badoiu and Clarkson 2003, "Smaller core-sets for balls": steps of 1 / (i + 1) towards the farthest point.
CaptureSphere enclosing_sphere(const std::vector<std::vector<glm::vec3>>& sets) {
  CaptureSphere sphere;
  glm::vec3 low(INFINITY);
  glm::vec3 high(-INFINITY);
  size_t count = 0;
  for (const auto& set : sets)
    for (const glm::vec3& p : set) {
      low = glm::min(low, p);
      high = glm::max(high, p);
      ++count;
    }
  if (count == 0) return sphere;
  const auto farthest = [&] {
    glm::dvec3 best = sphere.centre;
    double most = -1;
    const glm::vec3 centre(sphere.centre);
    for (const auto& set : sets)
      for (const glm::vec3& p : set) {
        const glm::vec3 d = p - centre;
        const double square = glm::dot(d, d);
        if (square > most) {
          most = square;
          best = p;
        }
      }
    return best;
  };
  sphere.centre = 0.5 * (glm::dvec3(low) + glm::dvec3(high));
  constexpr int kSteps = 100;
  for (int i = 1; i <= kSteps; ++i) sphere.centre += (farthest() - sphere.centre) / (i + 10.0);
  sphere.radius = glm::distance(farthest(), sphere.centre);
  return sphere;
}

TileRect tile_bounds(const std::vector<glm::vec3>& points, const glm::dvec3& centre, const ViewBasis& basis,
                     double texel) {
  if (points.empty()) return {};
  const glm::vec3 right(basis.right / texel);
  const glm::vec3 up(basis.up / texel);
  const auto offset_x = static_cast<float>(glm::dot(basis.right, centre) / texel);
  const auto offset_y = static_cast<float>(glm::dot(basis.up, centre) / texel);
  glm::vec2 low(INFINITY);
  glm::vec2 high(-INFINITY);
  for (const glm::vec3& p : points) {
    const glm::vec2 q(glm::dot(right, p), glm::dot(up, p));
    low = glm::min(low, q);
    high = glm::max(high, q);
  }
  // A hundredth of a texel for what the GPU rounds differently.
  const int x0 = static_cast<int>(std::floor(low.x - offset_x - 0.01F));
  const int y0 = static_cast<int>(std::floor(low.y - offset_y - 0.01F));
  const int x1 = static_cast<int>(std::ceil(high.x - offset_x + 0.01F));
  const int y1 = static_cast<int>(std::ceil(high.y - offset_y + 0.01F));
  return {x0, y0, x1 - x0, y1 - y0};
}

struct TileCapture::State {
  gl::Context& context;
  scene::Cast cast;
  CaptureScale scale;
  bool glows;
  FrameResources resources;
  std::unique_ptr<Representation> mesh;
  gl::VertexArray no_vertices;
  gl::Program resolve;

  State(gl::Context& context_, scene::Cast cast_, const CaptureScale& scale_)
      : context(context_),
        cast(std::move(cast_)),
        scale(scale_),
        glows(scale.peak > 0),
        resources(context, cast),
        mesh(make_mesh_capture({.context = context, .cast = cast}, scale.peak)),
        no_vertices(context),
        resolve(context, {"renderers/shaders/screen.vert", "renderers/impostor/tiles/resolve.frag"},
                glows ? gl::Defines{{"CB_SAMPLES", std::to_string(kSamples)}, {"CB_EMISSIVE", ""}}
                      : gl::Defines{{"CB_SAMPLES", std::to_string(kSamples)}}) {}
};

TileCapture::TileCapture(gl::Context& context, std::shared_ptr<const scene::Character> character,
                         std::shared_ptr<const scene::PoseBank> bank, const CaptureScale& scale) {
  scene::Cast cast;
  cast.characters = {std::move(character)};
  cast.banks = {std::move(bank)};
  cast.shares = {1.0};
  state_ = std::make_unique<State>(context, std::move(cast), scale);
}

TileCapture::~TileCapture() = default;

namespace {

// What a page is drawn to, kSamples times as large a side, what it is resolved to, and where that is read to.
struct PageTargets {
  gl::Context& context;
  int width;  // texels, resolved
  int height;
  gl::Texture depth;
  std::vector<gl::Texture> fine;  // albedo, surface, and emission where the character glows
  std::vector<gl::Texture> coarse;
  gl::Framebuffer capture;
  gl::Framebuffer resolve;
  std::vector<std::vector<uint8_t>> texels;  // RGBA, of each of coarse

  PageTargets(gl::Context& context_, int width_, int height_, size_t images)
      : context(context_),
        width(width_),
        height(height_),
        depth(gl::Texture::make_2d(context, GL_DEPTH_COMPONENT32F, width * kSamples, height * kSamples)),
        fine(make(images, kSamples)),
        coarse(make(images, 1)),
        capture(context, pointers(fine), &depth),
        resolve(context, pointers(coarse), nullptr),
        texels(images, std::vector<uint8_t>(static_cast<size_t>(width) * static_cast<size_t>(height) * 4)) {}

  void clear_for_capture() const {
    capture.bind();
    glViewport(0, 0, width * kSamples, height * kSamples);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
    glFrontFace(GL_CCW);
    glCullFace(GL_BACK);
    const std::array<float, 4> nothing{};
    for (size_t i = 0; i < fine.size(); ++i) glClearBufferfv(GL_COLOR, static_cast<GLint>(i), nothing.data());
    glClearBufferfv(GL_DEPTH, 0, nothing.data());
  }

  void bind_for_resolve() const {
    resolve.bind();
    glViewport(0, 0, width, height);
    glDisable(GL_DEPTH_TEST);
    for (size_t i = 0; i < fine.size(); ++i) fine[i].bind(static_cast<unsigned>(i));
  }

  void read() {
    for (size_t i = 0; i < coarse.size(); ++i)
      coarse[i].read(0, GL_RGBA, GL_UNSIGNED_BYTE, texels[i].data(), texels[i].size());
  }

  // The texels of a tile that lies at `place`.
  std::vector<CapturedTexel> cut_out(const TileRect& rect, const PackPlace& place) const {
    std::vector<CapturedTexel> out(static_cast<size_t>(rect.width) * static_cast<size_t>(rect.height));
    auto to = out.begin();
    for (int y = 0; y < rect.height; ++y)
      for (int x = 0; x < rect.width; ++x, ++to) {
        const auto from = static_cast<std::ptrdiff_t>(
            4 * (static_cast<size_t>(place.y + y) * static_cast<size_t>(width) + static_cast<size_t>(place.x + x)));
        std::copy_n(texels[0].begin() + from, 4, to->albedo.begin());
        std::copy_n(texels[1].begin() + from, 4, to->surface.begin());
        if (texels.size() > 2) std::copy_n(texels[2].begin() + from, 3, to->emission.begin());
      }
    return out;
  }

 private:
  std::vector<gl::Texture> make(size_t images, int scale) const {
    std::vector<gl::Texture> textures;
    for (size_t i = 0; i < images; ++i)
      textures.push_back(gl::Texture::make_2d(context, GL_RGBA8, width * scale, height * scale));
    return textures;
  }
  static std::vector<const gl::Texture*> pointers(const std::vector<gl::Texture>& textures) {
    std::vector<const gl::Texture*> all;
    for (const gl::Texture& texture : textures) all.push_back(&texture);
    return all;
  }
};

// The framebuffer and viewport of whoever asks, put back at the end.
class KeptTarget {
 public:
  KeptTarget() {
    glGetIntegerv(GL_FRAMEBUFFER_BINDING, &framebuffer_);
    glGetIntegerv(GL_VIEWPORT, viewport_.data());
  }
  ~KeptTarget() {
    glEnable(GL_DEPTH_TEST);
    glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(framebuffer_));
    glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
  }
  KeptTarget(const KeptTarget&) = delete;
  KeptTarget& operator=(const KeptTarget&) = delete;

 private:
  GLint framebuffer_ = 0;
  std::array<GLint, 4> viewport_{};
};

// Clip space of a tile's points: their texels on the lattice, moved to the tile's place on the page.
CaptureView capture_view(const CaptureTile& tile, const PackPlace& place, const Packing& packing,
                         const CaptureScale& scale) {
  const auto row = [&](const glm::dvec3& axis, double by, double offset) {
    return glm::vec4(glm::dvec4(axis * by, offset - glm::dot(axis, scale.centre) * by));
  };
  const glm::dvec2 corner(2.0 * (place.x - tile.rect.x) / packing.width - 1,
                          2.0 * (place.y - tile.rect.y) / packing.height - 1);
  CaptureView view{row(tile.basis.right, 2 / (scale.texel * packing.width), corner.x),
                   row(tile.basis.up, 2 / (scale.texel * packing.height), corner.y),
                   row(tile.basis.to_eye, 0.5 / scale.range, 0.5),
                   {0, 0, 0, 1},
                   {corner.x, corner.y, 0, 0}};
  if (scale.eye > 0) {
    view.w = row(tile.basis.to_eye, -1 / scale.eye, 1);
    // What is nearest stays within the depth range when it is divided.
    view.z *= static_cast<float>(std::max(0.0, 1 - scale.range / scale.eye));
  }
  return view;
}

Packing pack_captures(std::span<const CaptureTile> tiles, const gl::Limits& limits) {
  std::vector<PackSize> sizes;
  for (const CaptureTile& t : tiles) sizes.push_back({t.rect.width, t.rect.height});
  const int largest = std::min(limits.texture_size, limits.viewport_size) / kSamples;
  Packing packing = pack_tiles(sizes, std::min(kPage, largest));
  if (packing.layers > 0 && (packing.width > largest || packing.height > largest))
    throw Error("bake",
                fmt::format("a tile of {} x {} texels is more than this driver's targets hold ({} a side)",
                            packing.width, packing.height, largest),
                "lower texels");
  return packing;
}

}  // namespace

void TileCapture::capture(std::span<const CaptureTile> tiles, const Done& done) {
  State& s = *state_;
  s.context.make_current();
  const Packing packing = pack_captures(tiles, s.context.limits());
  if (packing.layers == 0) return;
  const KeptTarget kept;
  PageTargets targets(s.context, packing.width, packing.height, s.glows ? 3 : 2);
  for (int page = 0; page < packing.layers; ++page) {
    std::vector<size_t> here;
    for (size_t i = 0; i < tiles.size(); ++i)
      if (packing.places[i].layer == page && tiles[i].wanted) here.push_back(i);
    if (here.empty()) continue;

    std::vector<CaptureView> views;
    scene::Frame frame;
    frame.width = packing.width * kSamples;
    frame.height = packing.height * kSamples;
    frame.outfits.resize(1);
    frame.agents.resize(1);
    for (const size_t i : here) {
      views.push_back(capture_view(tiles[i], packing.places[i], packing, s.scale));
      scene::FrameAgent agent;
      agent.pose = tiles[i].pose;
      frame.agents[0].push_back(agent);
    }
    const gl::Buffer view_buffer(s.context, views);
    AgentLists everybody(1);
    everybody[0].resize(here.size());
    std::iota(everybody[0].begin(), everybody[0].end(), 0U);

    targets.clear_for_capture();
    s.resources.upload(frame);
    view_buffer.bind(GL_SHADER_STORAGE_BUFFER, CB_STORAGE_CAPTURE);
    s.mesh->draw(frame, s.resources, everybody, {});

    targets.bind_for_resolve();
    s.no_vertices.bind();
    s.resolve.use();
    glDrawArrays(GL_TRIANGLES, 0, 3);
    targets.read();

    std::vector<std::vector<CapturedTexel>> captured;
    for (const size_t i : here) captured.push_back(targets.cut_out(tiles[i].rect, packing.places[i]));
    done(here, captured);
  }
}

}  // namespace crowdbench::renderers
