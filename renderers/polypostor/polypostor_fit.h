// How the polygon around a part's key image moves through a clip: which point of each frame's outline each corner goes
// to, and a triangulation that never folds. All in texels, y up; polygons counter-clockwise.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "renderers/polypostor/polypostor_contour.h"

namespace crowdbench::renderers {

// The cost of sending corner i, carried by the part's own motion to p_i, to sample s_{a_i} of a frame's outline, square
// texels:
//   sum over i of |s_{a_i} - p_i|^2
//     + edge * (|s_{a_i} - s_{a_{i+1}}| - |p_i - p_{i+1}|)^2
//     + turn * l_i^2 * (turning of the outline at a_i - turning of p at i)^2
// where l_i is the shorter edge of p at i, and the outline's turning is the angle between its chords to the samples
// that lie the lengths of p's edges before and after a_i along it.
struct CorrespondenceWeights {
  double edge = 0.5;
  double turn = 0.05;
};
// at[i]: sample of corner i; going round once, each later than the one before.
struct Correspondence {
  std::vector<size_t> at;
  double cost = 0;
};
// samples: evenly spaced along the outline, at least as many as there are corners. The least cost over all monotone
// cyclic correspondences, exactly: dynamic programming for every sample that corner 0 may go to, in the order of that
// corner's own cost, until that alone exceeds what was found.
Correspondence correspond(const Polyline& samples, const Polyline& predicted,
                          const CorrespondenceWeights& weights = {});
double correspondence_cost(const Polyline& samples, const Polyline& predicted, std::span<const size_t> at,
                           const CorrespondenceWeights& weights = {});

using Triangle = std::array<uint16_t, 3>;

// The triangulation of the polygon's corners whose triangles are all counter-clockwise in `key` and in the fewest
// `poses` inverted, and among those the least stretched. Poses: as many corners each. Empty when `key` has none.
std::vector<Triangle> triangulate(const Polyline& key, std::span<const Polyline> poses);
// Triangles of a pose whose area is not positive (less than kLeastTriangle square texels).
inline constexpr double kLeastTriangle = 1e-4;
size_t inverted_triangles(const Polyline& pose, std::span<const Triangle> triangles);

// The similarity (turn, uniform scale, shift; no reflection) that takes `from` to `to` with the least squares.
struct Similarity {
  double a = 1, b = 0;  // (x, y) -> (a x - b y, b x + a y) + shift
  glm::dvec2 shift{0.0};
  glm::dvec2 operator()(const glm::dvec2& p) const { return glm::dvec2(a * p.x - b * p.y, b * p.x + a * p.y) + shift; }
};
Similarity fit_similarity(const Polyline& from, const Polyline& to);

struct FitOptions {
  int corners = 8;
  double margin = 0.7;  // texels around the key outline
  double room = 1;      // texels beyond its bounding box
  double quantum = 0;   // positions are whole multiples of it; 0: as they are
};

// One key image's polygon through all frames.
struct Fit {
  size_t key = 0;    // frame
  Polyline polygon;  // around the key's image; empty: the part is never seen
  std::vector<Triangle> triangles;
  std::vector<Polyline> poses;     // one a frame; where the part is not seen all corners are one point
  std::vector<glm::dvec2> turns;   // cos and sin of the part's turn in the plane since the key, one a frame
  std::vector<double> errors;      // texels, one a frame: mean distance between the moved outline and the frame's own
  std::vector<Polyline> outlines;  // the key's, moved to every frame; empty where the part is not seen
  size_t repaired = 0;             // frames in which triangles would have been inverted
};

// Who says how well a frame's outline is shown. Functions that are not given: what lies between the outlines, and all
// is seen.
inline constexpr double kHidden = 0.25;  // of what is amiss where nobody sees it, beside as much that shows
struct Onlooker {
  // What it costs to show `moved`, the key's outline as a pose has it, for the frame's: square texels, of what is torn
  // wholly, of what lies between the outlines kHidden.
  std::function<double(size_t frame, const Polyline& moved)> cost;
  // Whether a point of the frame's outline is one of the whole figure's.
  std::function<bool(size_t frame, const glm::dvec2& p)> sees;
};

// image: the outline of the key's image. contours: where outlines are to be, one a frame, empty where the part is not
// seen; the key's is the image's own where both are seen alike. carry(p): where the part's own motion takes a point
// beside the image's outline, one point a frame. Where that motion alone explains a frame's outline it is taken as it
// is; elsewhere the cost decides between that motion, what it becomes when it is moved onto the frame's outline, and
// what corners become that start from the correspondence. No triangle is inverted in any frame, nor half-way between
// two in which it is seen (where that can be had by making the two more alike to the image; `repaired` counts). An
// image without outline gives an empty polygon.
Fit fit_part(const Polyline& image, std::span<const Polyline> contours, size_t key,
             const std::function<Polyline(const glm::dvec2& p)>& carry, const FitOptions& options,
             const Onlooker& onlooker = {});

}  // namespace crowdbench::renderers
