// A tuned rule in the settings of engines whose levels of a mesh are chosen by a curve or by an error instead of by a
// size: what a rule sets there, and back.
//
// Unity's Mesh LOD (6.2 and later) takes for a figure whose bounding sphere is D pixels in diameter
//   level = floor(max(0, bias - slope log2(D / threshold)))
// with the slope and bias of Mesh.LodSelectionCurve and QualitySettings.meshLodThreshold (1 by default), as the
// scriptable render pipeline's culling computes it (com.unity.render-pipelines.core, InstanceCuller). D here takes the
// Euclidean distance to the middle of the bounds, as there.
//
// Godot (4.x) takes the coarsest level whose error, as the importer states it, spans at most
// rendering/mesh_lod/lod_change/threshold_pixels (1 by default) at the distance to the bounds' nearest point, with
// GeometryInstance3D.lod_bias 1.
#pragma once
#include <glm/vec3.hpp>
#include <optional>
#include <span>

namespace crowdbench::bench {

// The diameter in pixels of the sphere around a box. bounds: the box's edges, metres. distance: to its middle, metres.
double sphere_pixels(const glm::dvec3& bounds, double distance, int rows, double fov_y);

struct MeshLodCurve {
  double slope = 1, bias = 0;
};
// The curve by which levels 1, 2, ... begin at these diameters, falling: through one of them with slope 1, through two
// exactly, through more by least squares in log2. Nothing without one, or where they do not fall.
std::optional<MeshLodCurve> mesh_lod_curve(std::span<const double> sphere_px);
// And back: the diameter at which a level (from 1 on) begins.
double mesh_lod_begins(const MeshLodCurve& curve, size_t level, double threshold = 1);
// The level of a figure before it is cut to a whole number and to the levels that there are.
double mesh_lod_level(const MeshLodCurve& curve, double sphere_px, double threshold = 1);

// The threshold in pixels at which a level of that error (metres) begins at that distance, for bounds seen from the
// front; and back, the distance to the bounds' middle at which it begins.
double godot_threshold_pixels(double error, const glm::dvec3& bounds, double distance, int rows, double fov_y);
double godot_lod_distance(double error, const glm::dvec3& bounds, double threshold_px, int rows, double fov_y);

}  // namespace crowdbench::bench
