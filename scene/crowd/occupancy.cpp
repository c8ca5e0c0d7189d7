// Differs from measuring once and scaling: coverage saturates as agents hide each other, so the solver walks along one
// monotone parameter (spacing, then distance) by the secant method on ln(-ln(1 - coverage)), which is a straight line
// in the logarithm of the parameter for agents at random places.
#include "scene/crowd/occupancy.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "core/progress.h"
#include "scene/cast/cast.h"
#include "scene/crowd/crowd_stage.h"
#include "scene/scenario/scenario.h"

namespace crowdbench::scene {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;
constexpr double kClosest = 0.7;   // metres: spacing of a standing crowd
constexpr double kWidest = 100.0;  // metres: spacing at most, the scenario's range
constexpr double kAccept = 0.002;  // of the picture: nearer than this is found
constexpr double kUnreachable = 0.01;
constexpr int kMeasurements = 14;              // over both stages
constexpr double kBelowHorizon = 5 * kDegree;  // of the picture's upper edge: only ground is in view
constexpr double kArmsLength = 0.4;            // body heights: the nearest agent's depth at least

// A camera on a balcony: the scenario's own direction and field of view, tilted so that the ground fills the picture.
// `rise` is the eye's height above the plane that is kept in view; everything else follows from it in proportion, so
// that a smaller rise is the same picture with larger people.
class Balcony {
 public:
  Balcony(const Scenario& scenario, const Cast& cast) : agents_(scenario.crowd.agents), height_(stage_height(cast)) {
    const Camera camera = scenario.camera.at(0.0);
    const glm::dvec3 towards = camera.target - camera.eye;
    const double along = std::hypot(towards.x, towards.z);
    ahead_ = along > 0 ? glm::dvec3{towards.x / along, 0.0, towards.z / along} : glm::dvec3{0.0, 0.0, -1.0};
    const double steepest = 85.0 * kDegree;
    pitch_ = std::clamp(std::atan2(-towards.y, along), std::min(camera.fov_y / 2 + kBelowHorizon, steepest), steepest);
    const double low = std::min(pitch_ + camera.fov_y / 2, 89.0 * kDegree);
    const double high = std::max(pitch_ - camera.fov_y / 2, kBelowHorizon);
    near_ = depth_at(std::max(low, high));
    far_ = depth_at(std::min(low, high));
    // A few agents stand about the middle, so that none is a dot while another fills the picture.
    const double middle = std::sqrt(near_ * far_);
    const double ratio = std::sqrt(1.0 + 0.5 * std::sqrt(static_cast<double>(agents_)));
    near_ = std::max(near_, middle / ratio);
    far_ = std::min(far_, middle * ratio);
    Scenario probe = scenario;
    set(probe, 1.0);
    const StageView view = stage_view(probe);
    area_ = ViewGround(view, probe.crowd.centre.y - view.camera.eye.y + kKeptInView * height_).area();
  }

  // Places camera and stage depths.
  void set(Scenario& scenario, double rise) const {
    scenario.crowd.stage_near = rise * near_;
    scenario.crowd.stage_far = rise * far_;
    const double middle = rise * (near_ + far_) / 2;
    const double ground = (middle - rise * std::sin(pitch_)) / std::cos(pitch_);
    Camera camera = scenario.camera.at(0.0);
    camera.eye = scenario.crowd.centre + glm::dvec3{0.0, kKeptInView * height_ + rise, 0.0} - ground * ahead_;
    camera.target = camera.eye + middle * (std::cos(pitch_) * ahead_ - glm::dvec3{0.0, std::sin(pitch_), 0.0});
    camera.up = {0.0, 1.0, 0.0};
    scenario.camera.keys = {{0.0, camera}};
  }

  // At which the ground in view holds the agents at this spacing, with room for the cells that its edges cut.
  double rise_for(double spacing) const { return spacing * std::sqrt((agents_ + std::sqrt(agents_)) / area_); }
  double spacing_for(double rise) const { return rise / rise_for(1.0); }
  // At which the nearest agent is at arm's length.
  double least_rise(double near_plane) const { return std::max(kArmsLength * height_, 2.0 * near_plane) / near_; }

 private:
  // Depth, at a rise of 1 m, of the plane seen so far below the horizon.
  double depth_at(double angle) const { return std::cos(pitch_) / std::tan(angle) + std::sin(pitch_); }

  double agents_;
  double height_;
  glm::dvec3 ahead_{0.0, 0.0, -1.0};
  double pitch_ = 0;
  double near_ = 0;  // metres at a rise of 1 m
  double far_ = 0;
  double area_ = 1;  // square metres at a rise of 1 m
};

// ln(-ln(1 - coverage)): a straight line in the logarithm of the density of agents at random places.
double straight(double coverage) { return std::log(-std::log(1.0 - std::clamp(coverage, 1e-7, 1.0 - 1e-7))); }
double unstraight(double y) { return 1.0 - std::exp(-std::exp(y)); }

class Solver {
 public:
  Solver(const Scenario& scenario, const Cast& cast, const MeasureCoverage& measure, double target)
      : scenario_(scenario), cast_(cast), measure_(measure), target_(target) {}

  Solved run() {
    const Balcony balcony(scenario_, cast_);
    const double least = balcony.least_rise(scenario_.camera.at(0.0).near);
    const bool in_lanes =
        scenario_.crowd.placement == PlacementKind::lanes || scenario_.crowd.motion == MotionKind::lanes;
    const double closest = std::max(kClosest, balcony.spacing_for(least));
    search(std::log(closest), std::log(std::max(kWidest, closest)),
           std::log(std::max(scenario_.crowd.spacing, closest)), [&](Scenario& s, double u) {
             s.crowd.stage = in_lanes ? Stage::plaza : Stage::view;
             s.crowd.spacing = std::exp(u);
             balcony.set(s, balcony.rise_for(s.crowd.spacing));
           });
    const bool too_sparse = best_.search.achieved < target_ - kAccept;
    if (too_sparse && scenario_.crowd.motion != MotionKind::lanes) {
      const double start = std::max(balcony.rise_for(kClosest), least);
      search(std::log(least), std::log(2.0 * start), std::log(start), [&](Scenario& s, double u) {
        s.crowd.stage = Stage::frustum;
        s.crowd.spacing = kClosest;
        balcony.set(s, std::exp(u));
      });
    }
    return std::move(best_);
  }

 private:
  // Coverage falls as u grows. Ends near the target, at an end of the range, or out of measurements.
  template <typename Set>
  void search(double low, double high, double u, const Set& set) {
    const double wanted = straight(target_);
    double before_u = 0;
    double before_y = 0;
    bool have_before = false;
    double least = low;
    double most = high;
    while (best_.search.measurements < kMeasurements) {
      Scenario trial = scenario_;
      set(trial, u);
      const double coverage = measure(std::move(trial));
      if (std::abs(coverage - target_) <= kAccept) return;
      if (coverage > target_)
        least = u;
      else
        most = u;
      if (most - least < 1e-5 || (u <= low && coverage < target_) || (u >= high && coverage > target_)) return;
      const double y = straight(coverage);
      double slope = have_before && std::abs(u - before_u) > 1e-9 ? (y - before_y) / (u - before_u) : -2.0;
      if (!(slope < -0.05)) slope = -2.0;
      before_u = u;
      before_y = y;
      have_before = true;
      const double next = u + (wanted - y) / slope;
      // Outside of what is known to hold the answer: its end if that was never tried, else the middle.
      if (next <= least)
        u = least == low ? low : (least + most) / 2;
      else if (next >= most)
        u = most == high ? high : (least + most) / 2;
      else
        u = next;
    }
  }

  double measure(Scenario trial) {
    progress_.advance();
    Crowd crowd = make_crowd(trial, cast_, stage_view(trial));
    const Camera camera = trial.camera.at(0.0);
    const Coverage coverage = measure_(make_frame(trial, cast_, crowd, camera, 0));
    const int count = best_.search.measurements + 1;
    if (count == 1 || std::abs(coverage.occupancy - target_) < std::abs(best_.search.achieved - target_)) {
      best_.scenario = std::move(trial);
      best_.crowd = std::move(crowd);
      best_.camera = camera;
      best_.search.achieved = coverage.occupancy;
    }
    best_.search.measurements = count;
    return coverage.occupancy;
  }

  const Scenario& scenario_;
  const Cast& cast_;
  const MeasureCoverage& measure_;
  double target_;
  Progress progress_{"solving for the view", kMeasurements};
  Solved best_;
};

}  // namespace

bool misses_occupancy(double requested, double achieved) { return std::abs(achieved - requested) > kUnreachable; }

OnScreen count_on_screen(const Scenario& scenario, const Cast& cast, const Crowd& crowd, const Camera& camera,
                         uint64_t tick) {
  const Frame frame = make_frame(scenario, cast, crowd, camera, tick, false);
  const glm::dmat3 rotation = view_rotation(camera);
  const double tall = std::tan(camera.fov_y / 2);
  const double wide = tall * scenario.width / scenario.height;
  OnScreen seen;
  for (size_t c = 0; c < frame.agents.size(); ++c) {
    const glm::vec3 low = cast.banks[c]->bounds_min();
    const glm::vec3 high = cast.banks[c]->bounds_max();
    for (const FrameAgent& agent : frame.agents[c]) {
      int inside = 0;
      int behind = 0;
      glm::dvec2 least{1e300};
      glm::dvec2 most{-1e300};
      for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 m = agent.scale * glm::vec3(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                                                    corner & 4 ? high.z : low.z);
        const glm::vec3 turned(m.x * agent.heading.y + m.z * agent.heading.x, m.y,
                               m.z * agent.heading.y - m.x * agent.heading.x);
        const glm::dvec3 q = rotation * glm::dvec3(agent.position + turned);
        if (-q.z < camera.near) {
          ++behind;
          continue;
        }
        const glm::dvec2 at{q.x / (-q.z * wide), q.y / (-q.z * tall)};
        inside += std::abs(at.x) <= 1 && std::abs(at.y) <= 1;
        least = glm::min(least, at);
        most = glm::max(most, at);
      }
      const bool apart = least.x > 1 || least.y > 1 || most.x < -1 || most.y < -1;
      if (inside == 8)
        ++seen.wholly;
      else if (behind == 8 || (behind == 0 && apart))
        ++seen.off;
      else
        ++seen.partly;
    }
  }
  return seen;
}

Solved solve_occupancy(const Scenario& scenario, const Cast& cast, const MeasureCoverage& measure,
                       const MeasureCoverage& draft) {
  assert(scenario.occupancy && scenario.crowd.agents > 0);
  const double target = *scenario.occupancy;
  Solved best;
  const auto keep_nearer = [&](Solved&& trial) {
    const int measurements = best.search.measurements + trial.search.measurements;
    const int drafts = best.search.drafts + trial.search.drafts;
    if (best.search.measurements == 0 ||
        std::abs(trial.search.achieved - target) < std::abs(best.search.achieved - target))
      best = std::move(trial);
    best.search.measurements = measurements;
    best.search.drafts = drafts;
  };
  Scenario start = scenario;
  double wanted = target;
  for (int attempt = 0; draft && attempt < 3; ++attempt) {
    Solved trial = Solver(start, cast, draft, wanted).run();
    const bool found = !misses_occupancy(wanted, trial.search.achieved);
    const double covered = measure(make_frame(trial.scenario, cast, trial.crowd, trial.camera, 0)).occupancy;
    trial.search.drafts = std::exchange(trial.search.measurements, 1);
    trial.search.achieved = covered;
    keep_nearer(std::move(trial));
    if (!found || std::abs(best.search.achieved - target) <= kAccept) break;
    wanted = unstraight(straight(wanted) + straight(target) - straight(covered));
    start.crowd.spacing = best.scenario.crowd.spacing;
  }
  // Without a stand-in, or where it led astray or to the end of its range.
  if (best.search.measurements == 0 || misses_occupancy(target, best.search.achieved))
    keep_nearer(Solver(start, cast, measure, target).run());
  best.search.requested = target;
  best.search.unreachable = misses_occupancy(target, best.search.achieved);
  return best;
}

}  // namespace crowdbench::scene
