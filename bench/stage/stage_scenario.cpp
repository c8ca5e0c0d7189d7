#include "bench/stage/stage_scenario.h"

#include <algorithm>

#include "bench/stage/coverage.h"
#include "renderers/representation.h"
#include "scene/pose/lod_mesh.h"

namespace crowdbench::bench {
namespace {

// The cast to search with; std::nullopt: the cast itself.
std::optional<scene::Cast> draft_of(const scene::Cast& cast, uint32_t agents) {
  const bool fine = std::all_of(cast.characters.begin(), cast.characters.end(),
                                [](const auto& character) { return character->triangles() <= kDraftTriangles; });
  if (agents < kDraftAgents || fine) return std::nullopt;
  scene::Cast draft = cast;  // with the same pose banks: joints and clips are untouched
  const renderers::Spec spec = level_spec(kDraftTriangles);
  for (size_t c = 0; c < draft.characters.size(); ++c) {
    auto level = renderers::reference_type().level(spec, cast.characters[c], cast.banks[c], {});
    draft.characters[c] =
        std::make_shared<const scene::Character>(scene::with_mesh(*cast.characters[c], std::move(level->mesh)));
  }
  return draft;
}

}  // namespace

bool must_solve(const scene::Scenario& scenario) { return scenario.occupancy && scenario.crowd.agents != 0; }

Staged stage_as_given(const scene::Scenario& scenario, const scene::Cast& cast) {
  return {scenario, scene::make_crowd(scenario, cast, scene::stage_view(scenario)), scenario.camera.at(0), {}};
}

Staged stage_scenario(const scene::Scenario& scenario, const scene::Cast& cast, gl::Context& context) {
  if (!must_solve(scenario)) return stage_as_given(scenario, cast);
  const std::optional<scene::Cast> draft = draft_of(cast, scenario.crowd.agents);
  scene::Solved solved = scene::solve_occupancy(scenario, cast, mesh_coverage(context, cast),
                                                draft ? mesh_coverage(context, *draft) : scene::MeasureCoverage{});
  return {std::move(solved.scenario), std::move(solved.crowd), solved.camera, solved.search};
}

}  // namespace crowdbench::bench
