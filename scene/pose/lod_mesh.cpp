#include "scene/pose/lod_mesh.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/parallel.h"
#include "scene/character/simplify.h"
#include "scene/character/surface_distance.h"
#include "scene/character/surface_gauge.h"

namespace crowdbench::scene {
namespace {

constexpr size_t kPoses = 8;
constexpr size_t kMostPoses = 24;  // where there are more clips than that, some of them
// Quadrics of many vertices in many poses would not fit: 80 bytes each.
constexpr size_t kMostVerticesTimesPoses = 4'000'000;
constexpr size_t kPlaces = 2000;  // of a surface in a pose, by area
constexpr size_t kLeastTriangles = 4;

struct Pose {
  int bank_clip;
  double phase;
};

// Poses of all clips, evenly over their phases. between: halfway between those that are given without.
std::vector<Pose> poses_of(const PoseBank& bank, bool between) {
  const size_t clips = bank.clips().size();
  const size_t used = std::min(clips, kMostPoses);
  const bool still = std::ranges::all_of(bank.clips(), [](const BankClip& clip) { return clip.samples <= 1; });
  const size_t each = still ? 1 : std::max<size_t>(1, kPoses / used);
  std::vector<Pose> out;
  for (size_t c = 0; c < used; ++c)
    for (size_t k = 0; k < each; ++k)
      out.push_back({static_cast<int>(c * clips / used),
                     (static_cast<double>(k) + (between ? 0.5 : 0.0)) / static_cast<double>(each)});
  return out;
}

std::vector<glm::vec3> posed(const Mesh& mesh, const PoseBank& bank, const Pose& pose) {
  return skin_points(mesh, bank.palette(bank.sample(pose.bank_clip, pose.phase)));
}

// Of so many things a pose, as many poses as keep their number within `most`, evenly; one at least.
std::vector<Pose> thinned(const std::vector<Pose>& poses, size_t each, size_t most) {
  const size_t kept = std::min(poses.size(), std::max<size_t>(1, most / std::max<size_t>(1, each)));
  std::vector<Pose> out;
  for (size_t i = 0; i < kept; ++i) out.push_back(poses[i * poses.size() / kept]);
  return out;
}

std::vector<std::vector<glm::vec3>> shown_poses(const Character& character, const PoseBank& bank) {
  std::vector<std::vector<glm::vec3>> out;
  for (const Pose& pose : thinned(poses_of(bank, false), character.mesh.positions.size(), kMostVerticesTimesPoses))
    out.push_back(posed(character.mesh, bank, pose));
  return out;
}

// The poses that an error is judged in, and where surfaces are looked at in the i-th of so many.
std::vector<Pose> judged_poses(const Character& character, const PoseBank& bank) {
  return thinned(poses_of(bank, true), character.triangles(), kMostLodTriangles);
}
SurfacePlaces judged_places(size_t i, size_t poses) {
  return {.by_area = kPlaces, .most_corners = kMostLodCorners / poses, .turn = i};
}

// Whether the largest error of a mesh, as lod_error measures it, is within a bound.
class ErrorGauge {
 public:
  ErrorGauge(const Character& character, const PoseBank& bank) : bank_(bank), poses_(judged_poses(character, bank)) {
    for (size_t i = 0; i < poses_.size(); ++i) {
      const std::vector<glm::vec3> own = posed(character.mesh, bank, poses_[i]);
      gauges_.emplace_back(Surface{own, character.mesh.indices}, judged_places(i, poses_.size()));
    }
  }
  bool is_within(const Mesh& mesh, double bound) {
    std::atomic<bool> within = true;
    parallel_for(poses_.size(), 0, [&](size_t i) {
      if (!within) return;
      const std::vector<glm::vec3> other = posed(mesh, bank_, poses_[i]);
      if (!gauges_[i].is_within({other, mesh.indices}, bound)) within = false;
    });
    return within;
  }

 private:
  const PoseBank& bank_;
  std::vector<Pose> poses_;
  std::vector<SurfaceGauge> gauges_;
};

// The fewest triangles whose error stays within the bound, within a fiftieth; the error is taken to fall as triangles
// are added. All that are tried are moments of one simplification.
LodMesh within_error(const Character& character, const PoseBank& bank, double bound,
                     std::span<const std::vector<glm::vec3>> poses, const LodProgress& progress) {
  const size_t all = character.triangles();
  const auto advance = [&](size_t done) {
    if (progress) progress(done, 2 * all);
  };
  // Half of the work.
  const Simplification made(character, poses, kLeastTriangles, [&](size_t gone, size_t) { advance(gone); });
  ErrorGauge gauge(character, bank);
  size_t low = 0;
  size_t high = all;
  Mesh best = character.mesh;
  while (high - low > std::max<size_t>(1, high / 50)) {
    advance(2 * all - (high - low));
    constexpr size_t kFirst = 8;  // coarse tries cost least
    const size_t middle =
        low == 0 ? std::max<size_t>(1, high / kFirst)
                 : std::clamp(static_cast<size_t>(std::sqrt(static_cast<double>(low) * static_cast<double>(high))),
                              low + 1, high - 1);
    Mesh tried = made.at(std::max(middle, kLeastTriangles)).mesh;
    if (!gauge.is_within(tried, bound)) {
      low = middle;
      continue;
    }
    best = std::move(tried);
    high = middle;
  }
  return {std::move(best), {}};
}

}  // namespace

LodMesh make_lod_mesh(const Character& character, const PoseBank& bank, const LodRequest& request,
                      const LodProgress& progress) {
  const std::vector<std::vector<glm::vec3>> poses = shown_poses(character, bank);
  if (request.error > 0) return within_error(character, bank, request.error, poses, progress);
  const size_t triangles =
      request.ratio > 0 ? static_cast<size_t>(std::floor(request.ratio * static_cast<double>(character.triangles())))
                        : request.triangles;
  SimplifiedMesh made = simplify(character, poses, triangles, progress);
  return {std::move(made.mesh), std::move(made.why_more)};
}

Character with_mesh(const Character& character, Mesh mesh) {
  Character out = character;
  out.mesh = std::move(mesh);
  out.levels.clear();
  return out;
}

LodError lod_error(const Character& character, const Mesh& mesh, const PoseBank& bank) {
  const std::vector<Pose> poses = judged_poses(character, bank);
  std::vector<SurfaceDistance> found(poses.size());
  parallel_for(poses.size(), 0, [&](size_t i) {
    const std::vector<glm::vec3> own = posed(character.mesh, bank, poses[i]);
    const std::vector<glm::vec3> other = posed(mesh, bank, poses[i]);
    found[i] = surface_distance({own, character.mesh.indices}, {other, mesh.indices}, judged_places(i, poses.size()));
  });
  LodError out;
  double squares = 0;
  for (size_t i = 0; i < poses.size(); ++i) {
    squares += found[i].rms * found[i].rms;
    ++out.poses;
    out.places += found[i].places;
    if (found[i].max <= out.max) continue;
    out.max = found[i].max;
    out.bank_clip = poses[i].bank_clip;
    out.phase = poses[i].phase;
  }
  out.rms = std::sqrt(squares / static_cast<double>(out.poses));
  return out;
}

MeshoptimizerMesh meshoptimizer_mesh(const Character& character, const PoseBank& bank, size_t triangles) {
  const Mesh& mesh = character.mesh;
  const std::vector<glm::vec3> positions = posed(mesh, bank, {0, 0.0});
  std::vector<uint32_t> kept(mesh.indices.size());
  float error = 0;
  const size_t target = std::min(triangles * 3, mesh.indices.size());
  constexpr float kAnyError = 1e9F;
  kept.resize(meshopt_simplify(kept.data(), mesh.indices.data(), mesh.indices.size(), &positions[0].x, positions.size(),
                               sizeof(glm::vec3), target, kAnyError, 0U, &error));
  MeshoptimizerMesh out{
      mesh, double{error} * double{meshopt_simplifyScale(&positions[0].x, positions.size(), sizeof(glm::vec3))}};
  out.mesh.indices = std::move(kept);
  return out;
}

}  // namespace crowdbench::scene
