#include "bench/stage/coverage.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <memory>
#include <vector>

namespace crowdbench::bench {

scene::Coverage coverage_of(const ImageU32& ids) {
  scene::Coverage coverage;
  std::vector<bool> seen;
  for (const uint32_t id : ids.data) {
    if (id == 0) continue;
    ++coverage.covered_px;
    if (id >= seen.size()) seen.resize(static_cast<size_t>(id) + 1);
    coverage.agents_visible += seen[id] ? 0 : 1;
    seen[id] = true;
  }
  coverage.occupancy = ids.empty() ? 0.0 : static_cast<double>(coverage.covered_px) / static_cast<double>(ids.pixels());
  return coverage;
}

scene::MeasureCoverage mesh_coverage(gl::Context& context, const scene::Cast& cast) {
  struct MeshRenderer {
    renderers::Renderer renderer;
    std::unique_ptr<renderers::Representation> mesh;
    MeshRenderer(gl::Context& context, const scene::Cast& cast)
        : renderer(context, cast), mesh(renderers::make_representation({context, cast}, renderers::reference_spec())) {}
  };
  auto drawn = std::make_shared<MeshRenderer>(context, cast);
  return [drawn](const scene::Frame& frame) {
    scene::Frame bare = frame;
    bare.ground = false;
    bare.antialiasing = {};
    return coverage_of(drawn->renderer.capture(bare, *drawn->mesh).ids);
  };
}

uint64_t touched_pixels(gl::Context& context, renderers::Renderer& renderer, const scene::Frame& frame,
                        renderers::Representation& representation) {
  assert(!frame.ground);
  const renderers::Target target(context, frame.width, frame.height, renderers::Pass{.touched = true});
  renderer.draw(frame, representation, target);
  const ImageF depth = target.read().depth;
  return static_cast<uint64_t>(
      std::count_if(depth.data.begin(), depth.data.end(), [](float d) { return std::isfinite(d); }));
}

}  // namespace crowdbench::bench
