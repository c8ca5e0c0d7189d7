// A model of what a frame of each representation costs: time = a + b agents + c covered pixels + ..., with the terms
// that predict best what they were not fitted to, and how well they do. Pure functions of the store's rows.
//
// Fitted by least squares of relative errors, with coefficients above 0 (more work is never cheaper): all subsets of
// the terms are tried, and the one whose leave-one-out error is least is taken, of equal ones the smaller. What is said
// of its accuracy comes from a second cross-validation around that choice (leaving one out, or one of 40 parts where
// there are more points): each point is predicted by terms and coefficients that were chosen without it.
//
// Based on: M. Stone, "Cross-validatory choice and assessment of statistical predictions", Journal of the Royal
// Statistical Society B 36 (1974); C. L. Lawson and R. J. Hanson, "Solving least squares problems", 1974, ch. 23
// (non-negative least squares; here by enumeration).
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/statistics.h"
#include "reports/model/scene.h"

namespace crowdbench::reports {

// What a term counts. The first four are known before a frame is drawn; the others are counted in one.
//   fine  covered pixels, each by how small the figures are: times the natural logarithm of how many figures of the
//   mean
//         size would fill the picture. Pixels of small figures cost more: neighbours share fewer texels, and more of
//         them lie at an edge. Found in measured times of impostors, from 28,000 down to 46 pixels a figure; no
//         source's.
enum class CostTerm : uint8_t { frame, agents, covered, fine, touched, fragments, vertices, primitives };
const char* cost_term_name(CostTerm term);  // "agents", "covered_px", ...
std::string cost_term_text(CostTerm term);  // for people: "a covered pixel"
inline constexpr size_t kCostTerms = 8;
inline constexpr size_t kTermsBeforehand = 4;
// The count of `fine`: 0 without agents or covered pixels.
double fine_pixels(double picture_px, double agents, double covered_px);

// One timed point. counts: by CostTerm, 1 for `frame`; nothing where it was not counted.
struct CostPoint {
  uint32_t agents = 0;
  double occupancy = 0;  // requested
  double time_ns = 0;
  std::vector<std::optional<double>> counts;
};
// Those of a representation, in the order of agents and occupancy.
std::vector<CostPoint> cost_points(const Scene& scene, const std::string& representation);

struct CostCoefficient {
  CostTerm term = CostTerm::frame;
  double ns = 0;  // for each that is counted
};

struct CostFit {
  std::vector<CostCoefficient> terms;
  double held_out = 0;  // root mean square of the relative errors of leaving one out, by which the terms were chosen
};
// Of terms that every point counts, the first `allowed` ones. Nothing with fewer than four points.
std::optional<CostFit> fit_cost(const std::vector<CostPoint>& points, size_t allowed = kCostTerms);
double predicted_ns(const CostFit& fit, const CostPoint& point);

// A point and what the others say of it.
struct CostPrediction {
  CostPoint point;
  double predicted_ns = 0;
  // Whether the others surround it: it lies in the convex hull of theirs over the logarithm of the agents and the
  // occupancy (those of the scenario's own view by themselves). Beyond it the model is stretched, as where a corner of
  // what was measured is left out; break-evens are told within what was measured alone.
  bool between = false;
};
struct CostModel {
  std::string representation;
  std::string absent;  // why there is none; empty where there is
  CostFit fit;         // of all points
  std::vector<CostPrediction> held_out;
  double error = 0;      // root mean square of the relative errors of held_out
  size_t within_15 = 0;  // predictions within 15 % of what was measured
  // Of those between the points that they were predicted from.
  size_t between = 0, between_within_15 = 0;
  double between_error = 0;  // root mean square; 0 where there are none
  Interval within_share;     // 95 %, Clopper and Pearson
};
// allowed: as fit_cost.
CostModel cost_model(const Scene& scene, const std::string& representation, size_t allowed = kCostTerms);

}  // namespace crowdbench::reports
