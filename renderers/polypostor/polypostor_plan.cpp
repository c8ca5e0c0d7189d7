#include "renderers/polypostor/polypostor_plan.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "renderers/bake/emission.h"
#include "renderers/polypostor/polypostor_key.h"
#include "scene/pose/hidden.h"

namespace crowdbench::renderers {
namespace {

constexpr uint32_t kFineLevels = 2;
constexpr int kCoarseCorners = 4;
// Texels of a tier's finest level around an image: bilinear filtering then reads one gutter.
constexpr double kRoom = 0.5;

// How far away the eye is that outlines are fitted for. A figure of p pixels in a picture of 480 rows of 30 degrees is
// 900 / p of its heights away; what perspective does to it in pixels is p times the difference of inverse distances.
// That is nowhere more from 240 pixels down than it is here at 240, a quarter of what it would be of parallel rays.
constexpr double kEyeHeights = 5;
constexpr double kEyeRadii = 3;   // of the sphere, at least
constexpr double kTallest = 240;  // pixels of a figure that outlines are to hold for
// Texels: masks of three samples a texel tell no less, and what is drawn of level 0 shows half of one.
constexpr double kLeastSlack = 0.3;
constexpr double kMostSlack = 0.5;

double height_of(const std::vector<std::vector<glm::vec3>>& positions) {
  float low = INFINITY;
  float high = -INFINITY;
  for (const auto& frame : positions)
    for (const glm::vec3& p : frame) {
      low = std::min(low, p.y);
      high = std::max(high, p.y);
    }
  return static_cast<double>(high) - static_cast<double>(low);
}

// Rotated as the positions are: joints scale little.
std::vector<glm::vec3> posed_normals(const scene::Mesh& mesh, const std::vector<scene::Mat3x4>& palette) {
  std::vector<glm::vec3> normals(mesh.normals.size());
  for (size_t v = 0; v < normals.size(); ++v) {
    glm::vec3 sum(0.0F);
    for (int k = 0; k < scene::kInfluences; ++k) {
      const scene::Mat3x4& m = palette[mesh.joints[v][k]];
      const glm::vec3& n = mesh.normals[v];
      sum += mesh.weights[v][k] * glm::vec3(glm::dot(glm::vec3(m.rows[0]), n), glm::dot(glm::vec3(m.rows[1]), n),
                                            glm::dot(glm::vec3(m.rows[2]), n));
    }
    normals[v] = sum;
  }
  return normals;
}

// Which sides of a triangle are seen.
struct Sides {
  bool mirrored = false;  // its front is where it runs clockwise
  bool two_sided = false;
};
std::vector<Sides> sides_of(const scene::Character& character) {
  std::vector<Sides> out(character.triangles());
  for (const scene::Primitive& p : character.mesh.primitives) {
    const bool two_sided = character.materials[static_cast<size_t>(p.material)].double_sided;
    for (uint32_t t = p.first_index / 3; t < (p.first_index + p.index_count) / 3; ++t) out[t] = {p.mirrored, two_sided};
  }
  return out;
}

}  // namespace

PolypostorPlan plan_polypostors(const scene::Character& character, const std::shared_ptr<const scene::PoseBank>& bank,
                                const PolypostorBakeOptions& options) {
  PolypostorPlan plan;
  FrameCount poses = options.frames;
  poses.poses = kPosesAFrame;
  plan.frames = stored_frames(character, bank, poses);
  for (size_t f = 0; f < plan.frames.size(); ++f) plan.palettes.push_back(plan.frames.palette(f));
  const auto positions = plan.frames.positions(character.mesh);
  plan.sphere = capture_sphere(character, positions);
  plan.texel = 2 * plan.sphere.radius / options.texels;
  const double height = height_of(positions) / plan.texel;
  plan.eye = std::max(kEyeHeights * height, kEyeRadii * plan.sphere.radius / plan.texel);
  plan.slack = std::clamp(height / kTallest, kLeastSlack, kMostSlack);
  plan.quantum = kPolypostorReach * options.texels / 4094.0;
  plan.emission_peak = emission_peak(character);

  const BodyParts parts = options.cuts == "auto"
                              ? find_parts(character)
                              : cut_parts(character, options.cuts, "representation 'polypostor', option 'parts'");
  const auto levels = static_cast<uint32_t>(tile_levels(options.texels));
  const uint32_t fine = std::min(levels, kFineLevels);
  const auto add_tier = [&](const PartMap& map, uint32_t first_level, uint32_t count, int corners) {
    if (map.count > kPolypostorParts)
      throw Error(fmt::format("polypostor bake of {}", character.name),
                  fmt::format("{} parts; {} is the most", map.count, kPolypostorParts), "name fewer joints");
    PolypostorTier tier;
    tier.cut = cut_at_parts(character, map, {plan.palettes, plan.slack * plan.texel});
    tier.first_level = first_level;
    tier.levels = count;
    tier.texel = std::exp2(first_level);
    tier.fit = {.corners = corners, .room = kRoom, .quantum = plan.quantum / tier.texel};
    const scene::Mesh& mesh = tier.cut.character->mesh;
    tier.tones = vertex_tones(*tier.cut.character);
    for (const auto& palette : plan.palettes) {
      tier.positions.push_back(scene::shown_positions(mesh, palette));
      tier.normals.push_back(posed_normals(mesh, palette));
    }
    const std::vector<Sides> sides = sides_of(*tier.cut.character);
    for (const auto& triangles : tier.cut.triangles) {
      auto& of_part = tier.corners.emplace_back();
      auto& two_sided = tier.two_sided.emplace_back();
      for (const uint32_t t : triangles) {
        const uint32_t* of = &mesh.indices[size_t{3} * t];
        const bool mirrored = sides[t].mirrored;
        of_part.insert(of_part.end(), {of[0], of[mirrored ? 2 : 1], of[mirrored ? 1 : 2]});
        two_sided.push_back(sides[t].two_sided ? 1 : 0);
      }
      auto& by_frame = tier.moments.emplace_back();
      for (const auto& posed : tier.positions) by_frame.push_back(surface_moments(posed, of_part));
    }
    plan.tiers.push_back(std::move(tier));
  };
  add_tier(parts.fine, 0, fine, options.corners);
  if (levels > fine) add_tier(parts.coarse, fine, levels - fine, kCoarseCorners);
  return plan;
}

}  // namespace crowdbench::renderers
