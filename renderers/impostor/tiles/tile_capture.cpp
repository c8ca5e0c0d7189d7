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
  glm::vec4 x, y, z;
};

}  // namespace

std::vector<glm::vec3> posed_positions(const scene::Mesh& mesh, const std::vector<scene::Mat3x4>& palette) {
  std::vector<glm::vec3> positions(mesh.positions.size());
  for (size_t v = 0; v < positions.size(); ++v) {
    const glm::vec4 p(mesh.positions[v], 1.0F);
    glm::vec3 sum(0.0F);
    for (int k = 0; k < scene::kInfluences; ++k) {
      const float weight = mesh.weights[v][k];
      if (weight == 0.0F) continue;
      const scene::Mat3x4& m = palette[mesh.joints[v][k]];
      sum += weight * glm::vec3(glm::dot(m.rows[0], p), glm::dot(m.rows[1], p), glm::dot(m.rows[2], p));
    }
    positions[v] = sum;
  }
  return positions;
}

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

void TileCapture::capture(std::span<const CaptureTile> tiles, const Done& done) {
  State& s = *state_;
  s.context.make_current();
  std::vector<PackSize> sizes;
  for (const CaptureTile& t : tiles) sizes.push_back({t.rect.width, t.rect.height});
  const int largest = std::min(s.context.limits().texture_size, s.context.limits().viewport_size) / kSamples;
  const Packing packing = pack_tiles(sizes, std::min(kPage, largest));
  if (packing.layers == 0) return;
  if (packing.width > largest || packing.height > largest)
    throw Error("bake",
                fmt::format("a tile of {} x {} texels is more than this driver's targets hold ({} a side)",
                            packing.width, packing.height, largest),
                "lower texels");

  const int width = packing.width * kSamples;
  const int height = packing.height * kSamples;
  const auto target = [&](unsigned format, int w, int h) { return gl::Texture::make_2d(s.context, format, w, h); };
  const gl::Texture albedo = target(GL_RGBA8, width, height);
  const gl::Texture surface = target(GL_RGBA8, width, height);
  const gl::Texture depth = target(GL_DEPTH_COMPONENT32F, width, height);
  const gl::Texture albedo_page = target(GL_RGBA8, packing.width, packing.height);
  const gl::Texture surface_page = target(GL_RGBA8, packing.width, packing.height);
  gl::Texture emission;
  gl::Texture emission_page;
  std::vector<const gl::Texture*> fine = {&albedo, &surface};
  std::vector<const gl::Texture*> coarse = {&albedo_page, &surface_page};
  if (s.glows) {
    emission = target(GL_RGBA8, width, height);
    emission_page = target(GL_RGBA8, packing.width, packing.height);
    fine.push_back(&emission);
    coarse.push_back(&emission_page);
  }
  const gl::Framebuffer capture_target(s.context, fine, &depth);
  const gl::Framebuffer resolve_target(s.context, coarse, nullptr);

  GLint framebuffer_before = 0;
  glGetIntegerv(GL_FRAMEBUFFER_BINDING, &framebuffer_before);
  std::array<GLint, 4> viewport_before{};
  glGetIntegerv(GL_VIEWPORT, viewport_before.data());

  const size_t page_bytes = static_cast<size_t>(packing.width) * static_cast<size_t>(packing.height) * 4;
  std::vector<uint8_t> albedo_texels(page_bytes);
  std::vector<uint8_t> surface_texels(page_bytes);
  std::vector<uint8_t> emission_texels(s.glows ? page_bytes : 0);
  for (int page = 0; page < packing.layers; ++page) {
    std::vector<size_t> here;
    for (size_t i = 0; i < tiles.size(); ++i)
      if (packing.places[i].layer == page && tiles[i].wanted) here.push_back(i);
    if (here.empty()) continue;

    // Clip-space x of a point: its texel on the lattice, moved to the tile's place on the page.
    std::vector<CaptureView> views;
    scene::Frame frame;
    frame.width = width;
    frame.height = height;
    frame.outfits.resize(1);
    frame.agents.resize(1);
    for (const size_t i : here) {
      const CaptureTile& t = tiles[i];
      const PackPlace& place = packing.places[i];
      const auto row = [&](const glm::dvec3& axis, double scale, double offset) {
        return glm::vec4(glm::dvec4(axis * scale, offset - glm::dot(axis, s.scale.centre) * scale));
      };
      views.push_back(
          {row(t.basis.right, 2 / (s.scale.texel * packing.width), 2.0 * (place.x - t.rect.x) / packing.width - 1),
           row(t.basis.up, 2 / (s.scale.texel * packing.height), 2.0 * (place.y - t.rect.y) / packing.height - 1),
           row(t.basis.to_eye, 0.5 / s.scale.range, 0.5)});
      scene::FrameAgent agent;
      agent.pose = t.pose;
      frame.agents[0].push_back(agent);
    }
    const gl::Buffer view_buffer(s.context, views);
    AgentLists everybody(1);
    everybody[0].resize(here.size());
    std::iota(everybody[0].begin(), everybody[0].end(), 0U);

    capture_target.bind();
    glViewport(0, 0, width, height);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
    glFrontFace(GL_CCW);
    glCullFace(GL_BACK);
    const std::array<float, 4> nothing{};
    glClearBufferfv(GL_COLOR, 0, nothing.data());
    glClearBufferfv(GL_COLOR, 1, nothing.data());
    if (s.glows) glClearBufferfv(GL_COLOR, 2, nothing.data());
    glClearBufferfv(GL_DEPTH, 0, nothing.data());
    s.resources.upload(frame);
    view_buffer.bind(GL_SHADER_STORAGE_BUFFER, CB_STORAGE_CAPTURE);
    s.mesh->draw(frame, s.resources, everybody, {});

    resolve_target.bind();
    glViewport(0, 0, packing.width, packing.height);
    glDisable(GL_DEPTH_TEST);
    albedo.bind(0);
    surface.bind(1);
    if (s.glows) emission.bind(2);
    s.no_vertices.bind();
    s.resolve.use();
    glDrawArrays(GL_TRIANGLES, 0, 3);
    albedo_page.read(0, GL_RGBA, GL_UNSIGNED_BYTE, albedo_texels.data(), page_bytes);
    surface_page.read(0, GL_RGBA, GL_UNSIGNED_BYTE, surface_texels.data(), page_bytes);
    if (s.glows) emission_page.read(0, GL_RGBA, GL_UNSIGNED_BYTE, emission_texels.data(), page_bytes);

    std::vector<std::vector<CapturedTexel>> captured;
    for (const size_t i : here) {
      const TileRect& rect = tiles[i].rect;
      const PackPlace& place = packing.places[i];
      std::vector<CapturedTexel> texels(static_cast<size_t>(rect.width) * static_cast<size_t>(rect.height));
      for (int y = 0; y < rect.height; ++y)
        for (int x = 0; x < rect.width; ++x) {
          const size_t from = 4 * (static_cast<size_t>(place.y + y) * static_cast<size_t>(packing.width) +
                                   static_cast<size_t>(place.x + x));
          CapturedTexel& to = texels[static_cast<size_t>(y) * static_cast<size_t>(rect.width) + static_cast<size_t>(x)];
          std::copy_n(albedo_texels.begin() + static_cast<std::ptrdiff_t>(from), 4, to.albedo.begin());
          std::copy_n(surface_texels.begin() + static_cast<std::ptrdiff_t>(from), 4, to.surface.begin());
          if (s.glows) std::copy_n(emission_texels.begin() + static_cast<std::ptrdiff_t>(from), 3, to.emission.begin());
        }
      captured.push_back(std::move(texels));
    }
    done(here, captured);
  }
  glEnable(GL_DEPTH_TEST);
  glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(framebuffer_before));
  glViewport(viewport_before[0], viewport_before[1], viewport_before[2], viewport_before[3]);
}

}  // namespace crowdbench::renderers
