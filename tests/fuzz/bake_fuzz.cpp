// Whatever small character, the bakes' work on the CPU ends in something sound or in one Error: no number that is none,
// every bound kept that headers promise. Pose bank, fewer triangles, relief, surfels, a view of polypostors, and the
// truth. Not asked of polypostors: that positions keep within kPolypostorReach before they are stored. They do not (a
// corner at twice the radius was seen), and storing clamps them.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>

#include "core/float_traps.h"
#include "renderers/polypostor/polypostor_plan.h"
#include "renderers/polypostor/polypostor_view.h"
#include "renderers/relief/relief_bake.h"
#include "renderers/surfel/surfel_cloud.h"
#include "scene/character/simplify.h"
#include "scene/pose/normalise.h"
#include "tests/fuzz/fuzz_check.h"
#include "tests/fuzz/random_character.h"
#include "truth/truth.h"

namespace crowdbench {
namespace {

void require(bool holds) {
  if (!holds) std::abort();
}
template <class Vector>
void require_finite(const Vector& v) {
  for (int i = 0; i < v.length(); ++i) require(std::isfinite(v[i]));
}

void check_bank(const scene::PoseBank& bank) {
  for (const scene::Mat3x4& matrix : bank.matrices())
    for (const glm::vec4& row : matrix.rows) require_finite(row);
  require_finite(bank.bounds_min());
  require_finite(bank.bounds_max());
  for (int i = 0; i < 3; ++i) require(bank.bounds_min()[i] <= bank.bounds_max()[i]);
}

void check_simplified(const scene::Character& character, const scene::PoseBank& bank) {
  const std::vector<std::vector<glm::vec3>> poses = {scene::skin_points(character.mesh, bank.palette({}))};
  const size_t asked = 1 + character.triangles() / 2;
  const scene::SimplifiedMesh fewer = scene::simplify(character, poses, asked);
  require(fewer.mesh.indices.size() / 3 <= asked || !fewer.why_more.empty());
  for (const uint32_t index : fewer.mesh.indices) require(index < fewer.mesh.positions.size());
}

void check_relief(const scene::Character& character) {
  renderers::ReliefBakeOptions options;
  options.map_size = 16;
  const renderers::ReliefModel model = renderers::bake_relief(character, options);
  for (const renderers::ReliefBox& box : model.boxes) {
    require_finite(box.size);
    for (int c = 0; c < 4; ++c) require_finite(box.bind_from_unit[c]);
    for (const glm::vec3& corner : box.hull) {
      require_finite(corner);
      for (int i = 0; i < 3; ++i) require(corner[i] >= -1e-5F && corner[i] <= 1 + 1e-5F);
    }
  }
  require(model.depth.size() == 6 * model.texels() && model.extent.size() == model.depth.size());
  for (size_t i = 0; i < model.depth.size(); i += 2) {
    const bool empty = model.depth[i] == 65535 && model.depth[i + 1] == 0;
    require(empty || model.depth[i] <= model.depth[i + 1]);
    require(empty || (model.extent[i] <= model.depth[i] && model.extent[i + 1] >= model.depth[i + 1]));
  }
}

void check_surfels(const scene::Character& character, const scene::PoseBank& bank) {
  const renderers::SurfelCloud cloud = renderers::make_surfel_cloud(character, bank, 64, 1);
  require(cloud.surfels.size() <= 64);
  glm::vec3 low(INFINITY);
  glm::vec3 high(-INFINITY);
  for (const glm::vec3& p : character.mesh.positions) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const float slack = 1e-5F * (1 + glm::length(high - low) + glm::length(high));
  for (const renderers::Surfel& s : cloud.surfels) {
    require_finite(s.position);
    for (int i = 0; i < 3; ++i) require(s.position[i] >= low[i] - slack && s.position[i] <= high[i] + slack);
    require(std::abs(glm::length(s.normal) - 1) < 1e-4F);
    require(std::abs(s.weights.x + s.weights.y + s.weights.z + s.weights.w - 1) < 1e-4F);
    for (int k = 0; k < 4; ++k) require(s.joints[k] < character.skeleton.joints.size());
    require_finite(s.colour);
    require(s.reach >= 0);  // and a number
  }
}

void check_polypostor(const scene::Character& character, const std::shared_ptr<const scene::PoseBank>& bank) {
  renderers::PolypostorBakeOptions options;
  options.grid = renderers::parse_view_grid("sphere-4x2", 0, "bake_fuzz");
  options.frames.frames = 2;
  options.texels = 16;
  const renderers::PolypostorPlan plan = renderers::plan_polypostors(character, bank, options);
  renderers::ViewParts view;
  renderers::fit_view(plan, options.grid.basis(5), options.key, view);
  for (const auto& sheets : view.sheets)
    for (const renderers::Sheet& sheet : sheets) {
      const auto corners = static_cast<int>(sheet.fit.polygon.size());
      for (const auto& triangle : sheet.fit.triangles)
        for (const uint16_t corner : triangle) require(corner < corners);
      for (const renderers::Polyline& pose : sheet.fit.poses) {
        require(pose.size() == sheet.fit.polygon.size());
        for (const glm::dvec2& p : pose) require_finite(p);
      }
      for (const glm::dvec2& turn : sheet.fit.turns) require(std::abs(glm::length(turn) - 1) < 1e-6);
    }
}

void check_truth(const scene::Cast& cast) {
  scene::Frame frame;
  frame.width = frame.height = 12;
  frame.agents.resize(1);
  frame.outfits.emplace_back();
  scene::FrameAgent agent;
  agent.id = 1;
  frame.agents[0].push_back(agent);
  const glm::dvec3 middle(0.5F * (cast.banks[0]->bounds_min() + cast.banks[0]->bounds_max()));
  frame.camera.eye = middle + glm::dvec3(0, 0, 2 * glm::length(glm::dvec3(cast.banks[0]->bounds_max()) - middle));
  frame.camera.target = middle;
  const truth::TruthPicture seen = truth::cast_truth(cast, frame);
  for (size_t i = 0; i < seen.ids.data.size(); ++i) {
    require(seen.ids.data[i] <= 1);
    if (seen.ids.data[i] == 0) continue;
    require(std::isfinite(seen.depth.data[i]));
    const double* n = &seen.normal.data[3 * i];
    require(std::abs(std::hypot(n[0], n[1], n[2]) - 1) < 1e-9);
  }
  for (const float light : seen.linear.data) require(std::isfinite(light));
}

}  // namespace
}  // namespace crowdbench

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace crowdbench;
  const FloatTraps traps;
  fuzz::answers([&] {
    scene::Character made = fuzz::random_character(data, size);
    scene::normalise(made, {});
    scene::Cast cast;
    const std::vector<int> clips = made.clips.empty() ? std::vector<int>{-1} : std::vector<int>{0};
    cast.characters.push_back(std::make_shared<const scene::Character>(std::move(made)));
    cast.banks.push_back(std::make_shared<const scene::PoseBank>(*cast.characters[0], clips));
    cast.shares.push_back(1.0);
    const scene::Character& character = *cast.characters[0];
    const scene::PoseBank& bank = *cast.banks[0];
    check_bank(bank);
    check_simplified(character, bank);
    fuzz::answers([&] { check_relief(character); });
    fuzz::answers([&] { check_surfels(character, bank); });
    fuzz::answers([&] { check_polypostor(character, cast.banks[0]); });
    fuzz::answers([&] { check_truth(cast); });
  });
  return 0;
}
