// Pop map: what a switch from the mesh to another representation would show, over views, clip phases and sizes.
//
// A pop is the difference between the last picture before a switch and the first one after it: mesh and impostor at the
// identical camera and frame. It has two parts: what the impostor gets wrong, and that it shows a stored frame of the
// clip (the pose error), which a mesh that takes on the stored frame before the switch does not add (hybrid's `match`).
// A cross-fade spreads the pop over its ticks; what counts then is the largest of its steps.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/experiments/quality.h"
#include "metrics/registry.h"
#include "renderers/frame/capture.h"

namespace crowdbench::bench {

struct PopRequest {
  std::shared_ptr<const scene::Character> character;
  renderers::Spec representation;         // the far one
  std::vector<double> azimuths_deg{0};    // as QualityView
  std::vector<double> elevations_deg{0};  //
  std::vector<double> phases{0};          // of the clip, [0, 1)
  std::vector<double> ratios{1};          // pixels a texel spans, where the representation has texels ...
  std::vector<double> heights_px;         // ... or, where given, the character's height in pixels instead
  int clip = -1;                          // into Character::clips; -1: the bind pose
  int fade = 4;                           // ticks, 1..60
  double pose_rate = 30;
  scene::Antialiasing antialiasing;
  uint64_t bake_budget = uint64_t{512} << 20;
  bool use_cache = true;
  metrics::ChosenDisplay display;
  metrics::ScoreTable table = metrics::scores();
};

// One kind of switch, over the union of the silhouettes of mesh and impostor: a value for each of pop_scores(); nothing
// where it does not exist.
struct PopScores {
  std::vector<std::optional<double>> cut;        // from one tick to the next
  std::vector<std::optional<double>> fade_step;  // the worst step of the cross-fade
};

struct PopCell {
  double azimuth_deg = 0, elevation_deg = 0, phase = 0;
  double shown_phase = 0;  // the stored frame's
  double ratio = 0;        // 0: the representation has no texels
  double height_px = 0;
  PopScores own;      // the mesh in its own pose: with the pose error
  PopScores matched;  // the mesh in the stored frame's pose
};

// The scores of a table that a switch can have: of two pictures of code values. Those that count no region are of the
// crop around the silhouettes.
std::vector<const metrics::Score*> pop_scores(metrics::ScoreTable table);
// Of those what `popmap` computes where no scores are asked for: those of a region and those of tables.
std::vector<const metrics::Score*> usual_pop_scores(metrics::ScoreTable table);

// Of one score over cells: mean, the bad end's 5 % (the 95th percentile where lower is better, else the 5th) and the
// worst. Of the cells that have the score; none: nothing. Infinite where cells are (equal pictures have no finite
// PSNR).
struct PopStatistic {
  double mean = 0, tail = 0, worst = 0;
  size_t worst_cell = 0;
};
// place: of the score in pop_scores().
std::optional<PopStatistic> summarise_pops(const std::vector<PopCell>& cells, const metrics::Score& score, size_t place,
                                           bool matched, bool fade);
// "p95" or "p05": which percentile the tail is.
const char* tail_name(const metrics::Score& score);

// Pictures of a cell: mesh in its own pose, mesh in the stored frame's, impostor.
struct PopPictures {
  renderers::Capture mesh, matched, impostor;
};

// Sizes outermost, then elevation, azimuth and phase. `seen` gets every cell with its pictures. Throws Error: ratios
// for a representation without texels.
std::vector<PopCell> compute_pop_map(gl::Context& context, const PopRequest& request,
                                     const std::function<void(const PopCell&, const PopPictures&)>& seen = {});

// The pictures of a cross-fade from a to b over `fade` ticks, both ends included: fade + 2 of them. Pixel by pixel from
// one or the other, by the ordered dither that the hybrid representation uses.
std::vector<Image8> fade_pictures(const Image8& a, const Image8& b, int fade);

}  // namespace crowdbench::bench
