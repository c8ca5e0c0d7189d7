// Based on: Beacco, Spanlang, Andujar and Pelechano, "A flexible approach for output-sensitive rendering of animated
// characters" (CGF 2011): one box a joint, six dual-depth relief maps a box. Differs from the source: the two faces of
// an axis are captured together, so that their depths agree exactly and are stored once; depth has 16 bits before the
// renderer chooses how many it keeps; a texel is covered when its centre is.
#include "renderers/relief/relief_bake.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "renderers/bake/emission.h"
#include "renderers/impostor/tiles/half_plane.h"
#include "renderers/relief/relief_capture.h"
#include "renderers/relief/relief_clip.h"
#include "renderers/relief/relief_cube.h"
#include "scene/character/alpha_coverage.h"
#include "scene/pose/pose.h"

namespace crowdbench::renderers {
namespace {

using scene::Character;

// The box, without its maps' resolution: bounds in the joint's frame, tight around the triangles.
struct Bounds {
  glm::dvec3 low{std::numeric_limits<double>::infinity()};
  glm::dvec3 high{-std::numeric_limits<double>::infinity()};
  glm::dvec3 metres{0.0};  // at the capture pose
  double longest = 0;      // of these
};

// Drops the triangles that the piece's own limits leave nothing of.
Bounds bounds_of(const Character& character, Piece& piece, const std::vector<glm::dvec3>& positions,
                 const glm::dmat4& capture_from_bind) {
  const glm::dmat4 joint_from_bind = character.skeleton.joints[static_cast<size_t>(piece.joint())].inverse_bind;
  const glm::dmat4 joint_from_capture = joint_from_bind * glm::inverse(capture_from_bind);
  Bounds bounds;
  const auto holds = [&](const Skirt& skirt) {
    const Polygon part = clipped(
        taken(corners_of(character.mesh, skirt.triangle, positions, joint_from_capture), skirt), piece.low, piece.high);
    for (size_t k = 0; k < part.count; ++k) {
      bounds.low = glm::min(bounds.low, part.corners[k]);
      bounds.high = glm::max(bounds.high, part.corners[k]);
    }
    return part.count > 0;
  };
  std::erase_if(piece.triangles, [&](uint32_t t) { return !holds(whole(t)); });
  // Beside none of its own there is nothing to close.
  std::erase_if(piece.skirts, [&](const Skirt& s) { return piece.triangles.empty() || !holds(s); });
  const glm::dmat3 capture_from_joint(glm::inverse(joint_from_capture));
  for (int a = 0; a < 3; ++a) {
    bounds.metres[a] = glm::length(capture_from_joint[a]) * (bounds.high[a] - bounds.low[a]);
    bounds.longest = std::max(bounds.longest, bounds.metres[a]);
  }
  return bounds;
}

// The parts of a piece whose box is too long, each overlapping the next by a texel so that no crack shows between them.
std::vector<Piece> parts_of(const Piece& piece, const Bounds& bounds, double longest, int texels) {
  glm::ivec3 parts(1);
  for (int a = 0; a < 3; ++a) parts[a] = std::clamp(static_cast<int>(std::ceil(bounds.metres[a] / longest)), 1, 16);
  std::vector<Piece> out;
  for (int k = 0; k < parts.x * parts.y * parts.z; ++k) {
    const glm::dvec3 cell(k % parts.x, k / parts.x % parts.y, k / parts.x / parts.y);
    const glm::dvec3 size = (bounds.high - bounds.low) / glm::dvec3(parts);
    Piece& part = out.emplace_back(piece);
    for (int a = 0; a < 3; ++a) {
      if (parts[a] == 1) continue;
      part.low[a] = bounds.low[a] + (cell[a] - 1.0 / texels) * size[a];
      part.high[a] = bounds.low[a] + (cell[a] + 1.0 + 1.0 / texels) * size[a];
    }
  }
  return out;
}

// The prism along the box's longest edge around points in unit coordinates: the square of the other two coordinates,
// cut by four lines at 45 degrees as far out as the points and `margin` reach.
std::array<glm::vec3, kHullPoints> hull_of(const std::vector<glm::dvec3>& points, const glm::dvec3& size,
                                           double margin) {
  const int along = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const int u = (along + 1) % 3;
  const int v = (along + 2) % 3;
  std::vector<glm::dvec2> outline{
      {margin, margin}, {1 - margin, margin}, {1 - margin, 1 - margin}, {margin, 1 - margin}};
  for (const glm::dvec2& outward : {glm::dvec2(1, 1), glm::dvec2(-1, 1), glm::dvec2(-1, -1), glm::dvec2(1, -1)}) {
    double reach = -std::numeric_limits<double>::infinity();
    for (const glm::dvec3& p : points) reach = std::max(reach, outward.x * p[u] + outward.y * p[v]);
    // Of points on one line along the box a point is left, or by rounding nothing: what was left before stays.
    if (auto cut = cut_by_half_plane(outline, outward, reach); !cut.empty()) outline = std::move(cut);
  }
  std::array<glm::vec3, kHullPoints> hull{};
  for (size_t i = 0; i < kHullPoints; ++i) {
    const glm::dvec2& p = outline[std::min(i / 2, outline.size() - 1)];
    hull[i][along] = static_cast<float>(i % 2 == 0 ? margin : 1 - margin);
    hull[i][u] = static_cast<float>(p.x);
    hull[i][v] = static_cast<float>(p.y);
  }
  return hull;
}

// What one box captures, and from where.
struct Capture {
  Piece piece;
  glm::dmat4 capture_from_bind;  // of the piece at the capture pose
  Bounds bounds;
};

// Lays the box around its bounds: half a texel more a side, so that the extreme vertices fall on texel centres; a flat
// box gets a thickness. Where a node mirrors the joint, x runs the other way: maps are then laid as those of a figure
// whose data is mirrored (a joint's axes turn with the figure, but stay right-handed), texel for texel.
BoxSpace place_box(const CaptureSource& source, const Capture& capture, ReliefBox& box) {
  const auto n = static_cast<double>(box.texels);
  const glm::dmat4 joint_from_bind = source.character.skeleton.joints[static_cast<size_t>(box.joint())].inverse_bind;
  const glm::dvec3 centre = 0.5 * (capture.bounds.low + capture.bounds.high);
  const glm::dvec3 extent = capture.bounds.high - capture.bounds.low;
  const double least = 1e-3 * std::max({extent.x, extent.y, extent.z, 1e-9});
  const glm::dvec3 size = glm::max(extent * (n / (n - 1)), glm::dvec3(least));
  glm::dmat4 joint_from_unit(1.0);
  for (int a = 0; a < 3; ++a) joint_from_unit[a][a] = size[a];
  joint_from_unit[3] = glm::dvec4(centre - 0.5 * size, 1.0);
  box.bind_from_unit = glm::inverse(joint_from_bind) * joint_from_unit;
  if (glm::determinant(glm::dmat3(capture.capture_from_bind * box.bind_from_unit)) < 0) {
    box.bind_from_unit[3] += box.bind_from_unit[0];
    box.bind_from_unit[0] = -box.bind_from_unit[0];
  }
  const glm::dmat4 capture_from_unit = capture.capture_from_bind * box.bind_from_unit;
  for (int a = 0; a < 3; ++a) box.size[a] = glm::length(glm::dvec3(capture_from_unit[a]));
  for (size_t k = 0; k < capture.piece.shares.size(); ++k) {
    const Share& share = capture.piece.shares[k];
    box.movers[k] = {share.joint, share.weight, share.weight * box.bind_from_unit + share.change * capture_from_unit};
  }
  return {glm::inverse(capture_from_unit), glm::dmat3(glm::inverse(box.bind_from_unit)),
          glm::dmat3(glm::inverse(capture.capture_from_bind)), capture.piece.shares.size() > 1};
}

// All that a piece captures.
std::vector<Skirt> held(const Piece& piece) {
  std::vector<Skirt> all;
  for (const uint32_t t : piece.triangles) all.push_back(whole(t));
  all.insert(all.end(), piece.skirts.begin(), piece.skirts.end());
  return all;
}

// The hull of all that the box holds of its piece.
std::array<glm::vec3, kHullPoints> hull_within(const CaptureSource& source, const BoxSpace& space, const Piece& piece,
                                               const ReliefBox& box) {
  std::vector<glm::dvec3> points;
  for (const Skirt& skirt : held(piece)) {
    const Polygon part = clipped(
        taken(corners_of(source.character.mesh, skirt.triangle, source.positions, space.unit_from_capture), skirt),
        glm::dvec3(-kOutside), glm::dvec3(1.0 + kOutside));
    points.insert(points.end(), part.corners.begin(), part.corners.begin() + static_cast<long>(part.count));
  }
  return hull_of(points, box.size, 0.5 / static_cast<double>(box.texels));
}

// Fills in the model's box, and its part of the maps.
void capture_box(const CaptureSource& source, const Capture& capture, size_t index, ReliefModel& model) {
  ReliefBox& box = model.boxes[index];
  const BoxSpace space = place_box(source, capture, box);
  box.hull = hull_within(source, space, capture.piece, box);
  const std::vector<Skirt> all = held(capture.piece);
  for (int axis = 0; axis < 3; ++axis) {
    if (!model.cube)
      capture_axis(source, space, all, capture.piece.texel > 0, index, axis, model);
    else
      for (const int side : {0, 1}) capture_cube_face(source, space, all, index, axis, side, model);
  }
}

// A cut piece's box has half as many texels from where these are at most this much of what it makes do with.
constexpr double kHalved = 0.7;

// The boxes to capture, in the model's order.
struct Plan {
  std::vector<ReliefBox> boxes;  // joints, texels and place; the rest comes with the capture
  std::vector<Capture> captures;
  size_t texels = 0;  // of one map of every box
};

Plan plan_boxes(const Character& character, const ReliefBakeOptions& options, const std::vector<glm::dmat4>& palette,
                const std::vector<glm::dvec3>& positions) {
  const Carriers carriers = options.carriers.empty() ? own_carriers(character) : options.carriers;
  std::vector<int> given(carriers.size(), 0);  // of each carrier
  for (size_t joint = 0; joint < options.texels_of_joint.size(); ++joint) {
    int& most = given[static_cast<size_t>(carriers[joint])];
    most = std::max(most, options.texels_of_joint[joint]);
  }
  Plan plan;
  const auto add = [&](Piece piece, const glm::dmat4& matrix, const Bounds& size) {
    const int side = given[static_cast<size_t>(piece.joint())];
    ReliefBox& box = plan.boxes.emplace_back();
    box.movers[0].joint = piece.joint();
    box.texels = side > 0 ? side : options.map_size;
    plan.captures.push_back({std::move(piece), matrix, size});
  };
  for (Piece& piece : options.pieces.empty() ? joint_pieces(character, options.rule, options.threshold, carriers)
                                             : std::vector<Piece>(options.pieces)) {
    // A matrix that flattens space cannot carry a box; such a piece draws nothing.
    const glm::dmat4 matrix = matrix_of(piece, palette);
    if (std::abs(glm::determinant(glm::dmat3(matrix))) < 1e-12 ||
        std::abs(glm::determinant(character.skeleton.joints[static_cast<size_t>(piece.joint())].inverse_bind)) < 1e-18)
      continue;
    const Bounds whole = bounds_of(character, piece, positions, matrix);
    if (options.longest <= 0 || whole.longest <= options.longest) {
      add(std::move(piece), matrix, whole);
      continue;
    }
    for (Piece& part : parts_of(piece, whole, options.longest, options.map_size)) {
      const Bounds size = bounds_of(character, part, positions, matrix);
      if (!part.triangles.empty()) add(std::move(part), matrix, size);
    }
  }
  double longest = 0;
  for (const Capture& capture : plan.captures) longest = std::max(longest, capture.bounds.longest);
  const double texel = std::max(options.texel, longest / options.map_size);
  for (size_t i = 0; i < plan.boxes.size(); ++i) {
    ReliefBox& box = plan.boxes[i];
    const double most = std::max(options.by_area ? 0.5 * texel : 0.0, kHalved * plan.captures[i].piece.texel);
    if (given[static_cast<size_t>(box.joint())] == 0)
      while (box.texels > 16 && plan.captures[i].bounds.longest <= most * box.texels) box.texels /= 2;
    box.first = plan.texels;
    plan.texels += ReliefModel::box_texels(box);
  }
  return plan;
}

}  // namespace

size_t relief_texels(const Character& character, const ReliefBakeOptions& options) {
  const std::vector<glm::dmat4> palette = capture_palette(character, options.capture);
  return plan_boxes(character, options, palette, scene::skin_positions(character.mesh, palette)).texels;
}

ReliefModel bake_relief(const Character& character, const ReliefBakeOptions& options, const BakeProgress& progress) {
  const std::vector<glm::dmat4> palette = capture_palette(character, options.capture);
  const std::vector<glm::dvec3> positions = scene::skin_positions(character.mesh, palette);
  const std::vector<glm::dvec3> normals = scene::skin_normals(character.mesh, palette);
  std::vector<int> material_of_triangle(character.triangles());
  for (const scene::Primitive& primitive : character.mesh.primitives)
    for (uint32_t i = primitive.first_index / 3; i < (primitive.first_index + primitive.index_count) / 3; ++i)
      material_of_triangle[i] = primitive.material;
  std::vector<LinearPyramid> pyramids;
  pyramids.reserve(character.images.size());
  std::vector<float> thresholds(character.images.size(), 0.0F);
  for (const scene::Material& m : character.materials)
    if (m.base_colour_image >= 0) {
      float& own = thresholds[static_cast<size_t>(m.base_colour_image)];
      own = std::max(own, scene::alpha_threshold(m));
    }
  for (size_t i = 0; i < character.images.size(); ++i) pyramids.emplace_back(character.images[i], thresholds[i]);

  ReliefModel model;
  model.emission_peak = emission_peak(character);
  const CaptureSource source{character, positions, normals, material_of_triangle, pyramids, model.emission_peak};
  const Plan plan = plan_boxes(character, options, palette, positions);
  if (plan.boxes.empty())
    throw Error(character.name, "has no triangle that a joint moves, so there is nothing to capture",
                "use another character");
  model.boxes = plan.boxes;
  for (const Capture& capture : plan.captures) {
    model.triangles_of_box.push_back(static_cast<int>(capture.piece.triangles.size()));
    model.patches = model.patches || capture.piece.texel > 0;
  }
  model.cube = options.cube;
  model.depth.resize(plan.texels * model.depth_maps() * 2);
  if (!model.cube) model.extent.resize(plan.texels * 3 * 2);
  model.colour.resize((plan.texels + model.coarse_texels()) * 6 * 4);
  model.normal.resize(plan.texels * 6 * 4);
  if (model.emission_peak > 0) model.emission.resize(plan.texels * 6 * 4);

  parallel_for(
      model.boxes.size(), 0, [&](size_t i) { capture_box(source, plan.captures[i], i, model); },
      [&](size_t done) {
        throw_if_interrupted();
        if (progress) progress(done, model.boxes.size());
      });
  return model;
}

uint64_t relief_nominal_bytes(size_t joints, int map_size) {
  return uint64_t{joints} * 6 * 2 * static_cast<uint64_t>(map_size) * static_cast<uint64_t>(map_size) * 4;
}

}  // namespace crowdbench::renderers
