#include "bench/stage/coverage.h"

#include <algorithm>
#include <vector>

#include "renderers/frame/capture.h"
#include "scene/cast/cast.h"
#include "scene/character/simplify.h"

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
  struct Parts {
    renderers::Renderer renderer;
    std::unique_ptr<renderers::Representation> mesh;
    Parts(gl::Context& context, const scene::Cast& cast)
        : renderer(context, cast), mesh(renderers::make_representation({context, cast}, renderers::reference_spec())) {}
  };
  auto parts = std::make_shared<Parts>(context, cast);
  return [parts](const scene::Frame& frame) { return coverage_of(parts->renderer.capture(frame, *parts->mesh).ids); };
}

scene::Solved solve_with_mesh(gl::Context& context, const scene::Scenario& scenario, const scene::Cast& cast) {
  constexpr uint32_t kFewAgents = 300;  // the mesh itself is quick enough
  constexpr size_t kDraftTriangles = 500;
  const scene::MeasureCoverage mesh = mesh_coverage(context, cast);
  if (scenario.crowd.agents < kFewAgents) return scene::solve_occupancy(scenario, cast, mesh);
  scene::Cast drafts = cast;  // with the same pose banks: joints and clips are untouched
  for (auto& character : drafts.characters)
    character = std::make_shared<const scene::Character>(scene::simplified(*character, kDraftTriangles));
  return scene::solve_occupancy(scenario, cast, mesh, mesh_coverage(context, drafts));
}

}  // namespace crowdbench::bench
