// `ratio`: how many times as fast as another one representation is, drawn in rounds on one scene.
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/stage/stage_facts.h"
#include "bench/timing/control.h"
#include "bench/timing/image_check.h"
#include "bench/timing/timing.h"
#include "renderers/representation.h"
#include "scene/cast/cast.h"
#include "scene/scenario/scenario.h"

namespace crowdbench::bench {

constexpr int kLeastPairs = 20;
// The mesh is the yardstick: above this many times its own floor (the same draw with a static pose) no figure stands.
constexpr double kMeshFloorBound = 1.4;

struct RatioRequest {
  renderers::Spec of;
  renderers::Spec to;
  scene::Scenario scenario;  // with the occupancy to solve for, where one is wanted
  int pairs = 24;            // >= kLeastPairs
  uint64_t order_seed = kOrderSeed;
  uint64_t bake_budget = uint64_t{512} << 20;
};

struct RatioReport {
  std::string of, to;
  std::string headline;  // "cpu", "wall" or "gpu"
  // t(to) / t(of): above 1 `of` is the faster.
  std::optional<MedianRatio> cpu, wall, gpu;
  MedianRatio headline_ratio;
  MedianRatio mesh_floor;  // t(mesh) / t(mesh:floor=1), headline metric
  bool is_void = false;    // mesh_floor above its bound
  std::string void_reason;
  std::optional<Control> control;      // the mesh once more, as if it were another (A/A), headline metric
  MedianRatio to_low_polygon;          // t(the characters' meshes simplified to 500 triangles) / t(of), headline metric
  uint64_t low_polygon_triangles = 0;  // of one agent of each character
  ImageCheck of_check, to_check, mesh_check;
  bool valid = true;
  std::vector<std::string> faults;              // of the image checks
  uint64_t triangles = 0;                       // of the characters' meshes, one agent of each
  uint64_t of_triangles = 0, to_triangles = 0;  // submitted for one agent of each character
  StageFacts stage;
  struct Median {
    std::string name;
    double cpu_ns = 0, wall_ns = 0;
    std::optional<double> gpu_ns;
  };
  std::vector<Median> medians;  // of every representation timed
  // Of those that draw levels of detail, each named once.
  struct Levels {
    std::string name;
    std::vector<renderers::LevelInfo> levels;
  };
  std::vector<Levels> levels;
  int warmup_frames = 0;
  bool settled = true;
  uint64_t order_seed = 0;  // of the order within a round (TimingPlan)
  std::string renderer;
  bool software = false;
};

// The times that the figures are made of; all of the same rounds.
struct RatioTimes {
  std::span<const SampleRow> of, to;
  std::span<const SampleRow> mesh, mesh_floor;
  std::span<const SampleRow> low_polygon;  // the meshes of 500 triangles
  std::span<const SampleRow> mesh_again;   // the mesh's control
};
// Fills in cpu, wall and gpu, headline_ratio, mesh_floor, control and to_low_polygon, and whether the mesh is too far
// above its floor for any of it to stand. Throws Error when the headline's clock gave no time for a frame.
void put_ratios(RatioReport& report, const RatioTimes& times, Metric headline);

// Solves the scene with the mesh, checks the pictures, warms up and times. Progress on a terminal. Throws Error
// (unknown representation, fewer pairs than kLeastPairs, a bake over its budget) and Interrupted.
RatioReport measure_ratio(gl::Context& context, const scene::Cast& cast, const RatioRequest& request);

}  // namespace crowdbench::bench
