// Based on: Roberts, "The unreasonable effectiveness of quasirandom sequences" (2018) for the stratified placement over
// a view (the additive recurrence of the plastic number, here in 64-bit fixed point so that it is exact); dart throwing
// on a background grid as in Bridson, "Fast Poisson disk sampling in arbitrary dimensions" (2007). Differs from the
// source: darts are thrown over the whole square instead of around earlier points, so that the n-th dart is a hash of n
// alone.
#include "scene/crowd/crowd.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <tuple>

#include "core/error.h"
#include "core/portable_math.h"
#include "core/progress.h"
#include "core/random.h"
#include "scene/crowd/crowd_stage.h"

namespace crowdbench::scene {
namespace {

// One random number an agent (or lane, or dart) and purpose. Values are part of every crowd: never renumber.
enum Purpose : uint64_t {
  kOffsetX = 1,
  kOffsetZ = 2,
  kHeading = 3,
  kCharacter = 4,
  kClip = 5,
  kPhase = 6,
  kSpeed = 7,
  kScale = 8,
  kOutfit = 9,
  kDartX = 10,
  kDartZ = 11,
  kLaneClip = 12,
  kLaneSpeed = 13,
  kLaneOffset = 14,
  kStratumX = 15,
  kStratumZ = 16,
  kCellX = 17,
  kCellZ = 18,
  kPaletteChoice = 32,  // + slot
  kPaletteShade = 64    // + slot
};

constexpr double kLaneJitter = 0.15;             // spacings, either way: neighbours in lanes stay 0.7 spacings apart
constexpr double kPersonalSpace = 0.49;          // metres between the pivots of jittered neighbours, a person's breadth
constexpr double kDiskDistance = 0.75;           // spacings; 81 % of the density at which dart throwing jams
constexpr uint64_t kStepsBetweenChecks = 65536;  // whether the user wants to stop: every few milliseconds
constexpr double kBody = 1.0;  // metres around a pivot that a body may reach: lanes wrap so far out of view

// A measured length enters the crowd rounded, so that the last bits of the machine's sine do not.
double rounded(double value) { return static_cast<double>(static_cast<int64_t>(value * 65536.0 + 0.5)) / 65536.0; }
double rounded_either_way(double value) { return value < 0 ? -rounded(-value) : rounded(value); }

// How a clip moves its agent over the ground, rounded likewise. Along `across` and `ahead`, a unit vector to the
// character's left and to where it faces.
struct GroundMotion {
  double speed = 0;  // metres a second at playback speed 1 and scale 1
  double across = 0;
  double ahead = 1;
  double turns = 0;  // a second
};

GroundMotion ground_motion(const BankClip& clip) {
  GroundMotion out;
  out.speed = rounded(clip.ground_speed);
  out.turns = rounded_either_way(clip.turns);
  const double across = rounded_either_way(clip.direction.x);
  const double ahead = rounded_either_way(clip.direction.y);
  const double length = std::sqrt(across * across + ahead * ahead);
  if (length > 0) {
    out.across = across / length;
    out.ahead = ahead / length;
  }
  return out;
}

struct Way {
  double x = 0;
  double z = 0;
};

// Where an agent of this heading goes: a unit vector of the ground.
Way way_of(const GroundMotion& motion, double sine, double cosine) {
  return {motion.across * cosine + motion.ahead * sine, motion.ahead * cosine - motion.across * sine};
}

// Where one gets who goes so many metres that way while it turns: along an arc.
Way turned_way(const Way& way, double metres, double turns) {
  if (turns == 0) return {metres * way.x, metres * way.z};
  const SinCos turn = sincos_turns(turns);
  const double radius = metres / (6.283185307179586 * turns);
  const double ahead = radius * turn.sin;
  const double aside = radius * (1.0 - turn.cos);  // towards +X of who goes along +Z
  return {ahead * way.x + aside * way.z, ahead * way.z - aside * way.x};
}

double floor_exact(double x) {
  const auto whole = static_cast<double>(static_cast<int64_t>(x));
  return whole > x ? whole - 1.0 : whole;
}

// x - period * floor(x / period + 1/2), in [-period/2, period/2).
double wrap(double x, double period) {
  double wrapped = x - period * floor_exact(x / period + 0.5);
  if (wrapped >= period / 2) wrapped -= period;
  if (wrapped < -period / 2) wrapped += period;
  return wrapped;
}

uint64_t ceil_sqrt(uint64_t n) {
  auto root = static_cast<uint64_t>(std::sqrt(static_cast<double>(n)));
  while (root * root < n) ++root;
  return root;
}

using Place = GroundPoint;

// The k-th cell of a square spiral around (0, 0): every prefix is as square as it can be.
Place spiral_cell(uint64_t k) {
  if (k == 0) return {0.0, 0.0};
  const uint64_t ring = (ceil_sqrt(k + 1)) / 2;  // cells of ring r: (2r-1)^2 .. (2r+1)^2 - 1
  const uint64_t side = 2 * ring;
  const uint64_t first = (side - 1) * (side - 1);
  const uint64_t leg = (k - first) / side;
  const auto along = static_cast<double>((k - first) % side);
  const auto r = static_cast<double>(ring);
  switch (leg) {
    case 0: return {r, 1.0 - r + along};
    case 1: return {r - 1.0 - along, r};
    case 2: return {-r, r - 1.0 - along};
    default: return {1.0 - r + along, -r};
  }
}

double signed_unit(uint64_t seed, uint64_t index, uint64_t purpose) {
  return 2.0 * random_unit(seed, index, purpose) - 1.0;
}

// How far, in spacings, a jittered agent may leave its cell's middle either way: a person's breadth stays between two
// neighbours, and rows do not show where there is more room than that.
double jitter_of(const CrowdSettings& crowd) {
  if (crowd.placement != PlacementKind::jittered || crowd.agents < 2) return 0.0;
  return std::clamp((1.0 - kPersonalSpace / crowd.spacing) / 2, 0.0, 0.35);
}

// Positions relative to the stage's middle.
std::vector<Place> place_cells(const Scenario& scenario) {
  const double spacing = scenario.crowd.spacing;
  const double jitter = jitter_of(scenario.crowd);
  const uint32_t n = scenario.crowd.agents;
  // An even square of cells has its middle half a cell beside the first.
  const double shift = ceil_sqrt(n) % 2 == 0 ? 0.5 : 0.0;
  std::vector<Place> places(n);
  for (uint32_t i = 0; i < n; ++i) {
    const Place cell = spiral_cell(i);
    places[i] = {(cell.x - shift + jitter * signed_unit(scenario.seed, i, kOffsetX)) * spacing,
                 (cell.z - shift + jitter * signed_unit(scenario.seed, i, kOffsetZ)) * spacing};
  }
  return places;
}

struct Box {
  Place low;
  double width = 0;
  double depth = 0;
};

// Throws darts into a box, where `inside` allows, until as many as there are agents stuck; false when they jam first.
template <typename Inside>
bool throw_darts(const Scenario& scenario, const Box& box, const Inside& inside, std::vector<Place>& places) {
  const uint32_t n = scenario.crowd.agents;
  const double distance = kDiskDistance * scenario.crowd.spacing;
  const double cell = distance / 1.4142135623730951;  // at most one point a cell
  const auto columns = static_cast<int64_t>(box.width / cell) + 1;
  const auto rows = static_cast<int64_t>(box.depth / cell) + 1;
  std::vector<uint32_t> grid(static_cast<size_t>(columns * rows), 0);  // index + 1
  places.clear();
  const uint64_t darts = uint64_t{400} * n + 1000;
  for (uint64_t dart = 0; dart < darts && places.size() < n; ++dart) {
    if (dart % kStepsBetweenChecks == 0) throw_if_interrupted();
    const double x = random_unit(scenario.seed, dart, kDartX) * box.width;
    const double z = random_unit(scenario.seed, dart, kDartZ) * box.depth;
    const Place at{box.low.x + x, box.low.z + z};
    if (!inside(at)) continue;
    const auto column = static_cast<int64_t>(x / cell);
    const auto row = static_cast<int64_t>(z / cell);
    bool free = true;
    for (int64_t r = std::max<int64_t>(0, row - 2); free && r <= std::min(rows - 1, row + 2); ++r)
      for (int64_t c = std::max<int64_t>(0, column - 2); free && c <= std::min(columns - 1, column + 2); ++c) {
        const uint32_t other = grid[static_cast<size_t>(r * columns + c)];
        if (other == 0) continue;
        const double dx = places[other - 1].x - at.x;
        const double dz = places[other - 1].z - at.z;
        free = dx * dx + dz * dz >= distance * distance;
      }
    if (!free) continue;
    places.push_back(at);
    grid[static_cast<size_t>(row * columns + column)] = static_cast<uint32_t>(places.size());
  }
  return places.size() == n;
}

std::vector<Place> place_poisson(const Scenario& scenario) {
  std::vector<Place> places;
  double side = std::sqrt(static_cast<double>(scenario.crowd.agents)) * scenario.crowd.spacing;
  const auto everywhere = [](const Place&) { return true; };
  while (!throw_darts(scenario, {{-side / 2, -side / 2}, side, side}, everywhere, places)) side *= 1.05;
  return places;
}

// The box around the part of the ground up to this norm, turned by (sine, cosine) about the ground's middle.
Box box_around(const ViewGround& ground, double norm, const SinCos& turn) {
  const Place middle = ground.at(0, 0);
  Place low{1e300, 1e300};
  Place high{-1e300, -1e300};
  for (const double across : {-norm, norm})
    for (const double along : {-norm, norm}) {
      const Place at = ground.at(across, along);
      const double dx = at.x - middle.x;
      const double dz = at.z - middle.z;
      const Place turned{dx * turn.cos - dz * turn.sin, dx * turn.sin + dz * turn.cos};
      low = {std::min(low.x, turned.x), std::min(low.z, turned.z)};
      high = {std::max(high.x, turned.x), std::max(high.z, turned.z)};
    }
  return {low, high.x - low.x, high.z - low.z};
}

// Positions relative to the eye: the cells nearest to the middle of the ground in view, as its own shape measures
// nearness, so that they fill that shape.
std::vector<Place> place_view(const Scenario& scenario, const ViewGround& ground) {
  const CrowdSettings& crowd = scenario.crowd;
  const uint32_t n = crowd.agents;
  const Place middle = ground.at(0, 0);
  // Jittered rows stand askew to the view, so that no aisle points at the eye.
  const SinCos turn = sincos_turns(crowd.placement == PlacementKind::jittered ? 0.0738 : 0.0);
  const double jitter = jitter_of(crowd);
  struct Cell {
    double norm;
    int32_t column;
    int32_t row;
  };
  std::vector<Cell> cells;
  const auto place = [&](double column, double row) {
    const double x = column * crowd.spacing;
    const double z = row * crowd.spacing;
    return Place{middle.x + x * turn.cos + z * turn.sin, middle.z - x * turn.sin + z * turn.cos};
  };
  for (double reach = 1.25; cells.size() < n; reach *= 1.25) {
    cells.clear();
    const Box box = box_around(ground, reach, turn);
    const auto index = [&](double metres) { return static_cast<int32_t>(floor_exact(metres / crowd.spacing)); };
    for (int32_t row = index(box.low.z); row <= index(box.low.z + box.depth) + 1; ++row) {
      throw_if_interrupted();
      for (int32_t column = index(box.low.x); column <= index(box.low.x + box.width) + 1; ++column)
        if (const double norm = ground.norm(place(column, row)); norm <= reach) cells.push_back({norm, column, row});
    }
  }
  const auto nearer = [](const Cell& a, const Cell& b) {
    return std::tie(a.norm, a.row, a.column) < std::tie(b.norm, b.row, b.column);
  };
  std::nth_element(cells.begin(), cells.begin() + n - 1, cells.end(), nearer);
  cells.resize(n);
  std::sort(cells.begin(), cells.end(), nearer);
  std::vector<Place> places(n);
  if (crowd.placement == PlacementKind::poisson) {
    double reach = cells.back().norm;
    for (;; reach *= 1.05) {
      Box box = box_around(ground, reach, {0.0, 1.0});
      box.low = {box.low.x + middle.x, box.low.z + middle.z};
      if (throw_darts(
              scenario, box, [&](const Place& at) { return ground.norm(at) <= reach; }, places))
        return places;
    }
  }
  for (uint32_t i = 0; i < n; ++i) {
    const Cell& cell = cells[i];
    const uint64_t key =
        static_cast<uint64_t>(static_cast<uint32_t>(cell.column)) << 32 | static_cast<uint32_t>(cell.row);
    const double x = jitter * signed_unit(scenario.seed, key, kCellX);
    const double z = jitter * signed_unit(scenario.seed, key, kCellZ);
    places[i] = place(cell.column + x, cell.row + z);
    if (ground.norm(places[i]) > 1) places[i] = place(cell.column + 0.5 * x, cell.row + 0.5 * z);
    if (ground.norm(places[i]) > 1) places[i] = place(cell.column, cell.row);  // stays in view
  }
  return places;
}

// Positions relative to the eye, uniform in depth and across the view: the ground thins out as 1 / depth, which covers
// near and far parts of the picture alike.
std::vector<Place> place_frustum(const Scenario& scenario, const ViewGround& ground) {
  const uint32_t n = scenario.crowd.agents;
  // Around the sequence's own places, so that even a few agents are spread over the picture, with a little of the seed.
  const double jitter = n < 4 ? 0.0 : 0.3 / std::sqrt(static_cast<double>(n));
  const auto unit = [&](uint64_t fixed, uint32_t agent, uint64_t purpose) {
    const double at = static_cast<double>((fixed * agent + (uint64_t{1} << 63)) >> 11) * 0x1.0p-53 +
                      jitter * signed_unit(scenario.seed, agent, purpose);
    return at - floor_exact(at);
  };
  std::vector<Place> places(n);
  for (uint32_t i = 0; i < n; ++i)
    places[i] = ground.at(2.0 * unit(0xc13fa9a902a6328fULL, i, kStratumX) - 1.0,
                          2.0 * unit(0x91e10da5c79e7b1dULL, i, kStratumZ) - 1.0);
  return places;
}

struct Moving {
  uint16_t character;
  uint16_t clip;
  GroundMotion ground;
};

std::vector<Moving> moving_clips(const Cast& cast) {
  std::vector<Moving> moving;
  for (size_t c = 0; c < cast.banks.size(); ++c) {
    const size_t before = moving.size();
    const auto& clips = cast.banks[c]->clips();
    for (size_t k = 0; k < clips.size(); ++k)
      if (const GroundMotion ground = ground_motion(clips[k]);
          ground.speed > 0.05 && ground.turns == 0 && clips[k].seconds > 0)
        moving.push_back({static_cast<uint16_t>(c), static_cast<uint16_t>(k), ground});
    if (moving.size() == before)
      throw Error("crowd.motion",
                  "`lanes` needs walkers, and no clip in use of " + cast.characters[c]->name + " goes straight on",
                  "add a walking clip to its `clips`, or use motion `treadmill`");
  }
  return moving;
}

// Half the length of the axis that the view sees of any lane, bodies included: beyond it an agent may wrap unseen.
double visible_reach(const StageView& view, const glm::dvec3& centre, Place axis, uint64_t lanes, double spacing) {
  const glm::dmat3 rotation = view_rotation(view.camera);
  const double wide = half_tangent(view.camera) * view.aspect;
  double reach = 0;
  for (uint64_t lane = 0; lane < lanes; ++lane) {
    const double side = (static_cast<double>(lane) - static_cast<double>(lanes - 1) / 2) * spacing;
    const glm::dvec3 origin = rotation * (centre + glm::dvec3{side * axis.z, 0.0, -side * axis.x} - view.camera.eye);
    const glm::dvec3 along = rotation * glm::dvec3{axis.x, 0.0, axis.z};
    // Clip the line origin + u * along by: in front, nearer than far_depth, right of the left edge, left of the right.
    double low = -1e300;
    double high = 1e300;
    const auto clip = [&](double at_zero, double slope) {  // keeps at_zero + slope * u >= 0
      if (slope > 0)
        low = std::max(low, -at_zero / slope);
      else if (slope < 0)
        high = std::min(high, -at_zero / slope);
      else if (at_zero < 0)
        high = -1e300;
    };
    clip(-origin.z, -along.z);
    clip(view.far_depth + origin.z, along.z);
    clip(-origin.z * wide + origin.x, -along.z * wide + along.x);
    clip(-origin.z * wide - origin.x, -along.z * wide - along.x);
    if (low < high) reach = std::max({reach, std::abs(low), std::abs(high)});
  }
  return reach + kBody;
}

struct Lanes {
  uint64_t count = 1;
  double period = 0;
  SinCos axis{0.0, 1.0};
  bool both_ways = false;
};

Lanes plan_lanes(const Scenario& scenario, const StageView& view) {
  const CrowdSettings& crowd = scenario.crowd;
  Lanes lanes;
  lanes.count = std::max<uint64_t>(1, ceil_sqrt(crowd.agents));
  lanes.both_ways = !crowd.heading_deg;
  lanes.axis = sincos_turns(crowd.heading_deg.value_or(90.0) / 360.0);
  const uint64_t longest = (crowd.agents + lanes.count - 1) / lanes.count;
  const double filled = static_cast<double>(longest) * crowd.spacing;
  const double reach = visible_reach(view, crowd.centre, {lanes.axis.sin, lanes.axis.cos}, lanes.count, crowd.spacing);
  lanes.period = rounded(std::max(filled, 2 * reach)) + crowd.spacing;
  return lanes;
}

void fill_lanes(const Scenario& scenario, const Cast& cast, const Lanes& lanes, Crowd& crowd) {
  const CrowdSettings& settings = scenario.crowd;
  const bool walk = settings.motion == MotionKind::lanes;
  const std::vector<Moving> moving = walk ? moving_clips(cast) : std::vector<Moving>{};
  const auto capacity = static_cast<uint64_t>(lanes.period / settings.spacing);
  for (uint32_t i = 0; i < settings.agents; ++i) {
    const uint64_t lane = i % lanes.count;
    const uint64_t members = (settings.agents - lane + lanes.count - 1) / lanes.count;
    const uint64_t slot = (i / lanes.count) * capacity / members;
    const double pitch = lanes.period / static_cast<double>(capacity);
    const double lane_start = random_unit(scenario.seed, lane, kLaneOffset) * pitch;
    const double along = wrap(static_cast<double>(slot) * pitch + lane_start +
                                  kLaneJitter * settings.spacing * signed_unit(scenario.seed, i, kOffsetX),
                              lanes.period);
    const double side = (static_cast<double>(lane) - static_cast<double>(lanes.count - 1) / 2 +
                         kLaneJitter * signed_unit(scenario.seed, i, kOffsetZ)) *
                        settings.spacing;
    crowd.x[i] = settings.centre.x + along * lanes.axis.sin + side * lanes.axis.cos;
    crowd.z[i] = settings.centre.z + along * lanes.axis.cos - side * lanes.axis.sin;
    const double sign = lanes.both_ways && lane % 2 == 1 ? -1.0 : 1.0;
    crowd.heading_sin[i] = sign * lanes.axis.sin;
    crowd.heading_cos[i] = sign * lanes.axis.cos;
    if (!walk) continue;
    // One ground speed a lane; each agent takes its character's nearest clip, plays it as fast as that needs, and faces
    // so that the clip takes it along the lane: who walks sideways or backward looks across the lane or back.
    const Moving& leader = moving[random_below(scenario.seed, lane, kLaneClip, moving.size())];
    const double target =
        leader.ground.speed * (1.0 + settings.speed_variation * signed_unit(scenario.seed, lane, kLaneSpeed));
    const Moving* best = nullptr;
    for (const Moving& clip : moving) {
      if (clip.character != crowd.character[i]) continue;
      if (best == nullptr || std::abs(clip.ground.speed - target) < std::abs(best->ground.speed - target)) best = &clip;
    }
    assert(best != nullptr);
    crowd.bank_clip[i] = best->clip;
    crowd.speed[i] = target / (best->ground.speed * crowd.scale[i]);
    if (best->ground.across == 0 && best->ground.ahead > 0) continue;
    const double sine = crowd.heading_sin[i];
    const double cosine = crowd.heading_cos[i];
    crowd.heading_sin[i] = sine * best->ground.ahead - cosine * best->ground.across;
    crowd.heading_cos[i] = cosine * best->ground.ahead + sine * best->ground.across;
  }
}

// What each agent is, wherever it stands.
void draw_agents(const Scenario& scenario, const Cast& cast, Crowd& crowd) {
  const CrowdSettings& settings = scenario.crowd;
  const uint32_t n = settings.agents;
  const uint64_t seed = scenario.seed;
  for (auto* values :
       {&crowd.x, &crowd.z, &crowd.heading_sin, &crowd.heading_cos, &crowd.phase, &crowd.speed, &crowd.scale})
    values->resize(n);
  crowd.character.resize(n);
  crowd.bank_clip.resize(n);
  crowd.outfit.resize(n);
  for (uint32_t i = 0; i < n; ++i) {
    const double draw = random_unit(seed, i, kCharacter);
    size_t character = 0;
    for (double below = cast.shares[0]; draw >= below && character + 1 < cast.shares.size();)
      below += cast.shares[++character];
    crowd.character[i] = static_cast<uint16_t>(character);
    crowd.bank_clip[i] = static_cast<uint16_t>(random_below(seed, i, kClip, cast.banks[character]->clips().size()));
    crowd.phase[i] = random_unit(seed, i, kPhase);
    crowd.speed[i] = 1.0 + settings.speed_variation * signed_unit(seed, i, kSpeed);
    crowd.scale[i] = 1.0 + settings.scale_variation * signed_unit(seed, i, kScale);
    crowd.outfit[i] = static_cast<uint32_t>(random_below(seed, i, kOutfit, settings.outfits));
    const double turns = settings.heading_deg ? *settings.heading_deg / 360.0 : random_unit(seed, i, kHeading);
    const SinCos heading = sincos_turns(turns);
    crowd.heading_sin[i] = heading.sin;
    crowd.heading_cos[i] = heading.cos;
  }
}

// Where agents stand that do not walk in lanes, and how far those go that walk freely. At least one agent.
void fill_places(const Scenario& scenario, const Cast& cast, const StageView& view, Crowd& crowd) {
  const CrowdSettings& settings = scenario.crowd;
  const bool plaza = settings.stage == Stage::plaza;
  std::vector<Place> places;
  if (plaza) {
    places = settings.placement == PlacementKind::poisson ? place_poisson(scenario) : place_cells(scenario);
  } else {
    const ViewGround ground(view, settings.centre.y - view.camera.eye.y + kKeptInView * stage_height(cast));
    places = settings.stage == Stage::view ? place_view(scenario, ground) : place_frustum(scenario, ground);
  }
  Place low{1e300, 1e300};
  Place high{-1e300, -1e300};
  for (uint32_t i = 0; i < settings.agents; ++i) {
    crowd.x[i] = places[i].x + (plaza ? settings.centre.x : view.camera.eye.x);
    crowd.z[i] = places[i].z + (plaza ? settings.centre.z : view.camera.eye.z);
    low = {std::min(low.x, crowd.x[i]), std::min(low.z, crowd.z[i])};
    high = {std::max(high.x, crowd.x[i]), std::max(high.z, crowd.z[i])};
  }
  if (settings.motion == MotionKind::free) {
    crowd.wrap_x = (low.x + high.x) / 2;
    crowd.wrap_z = (low.z + high.z) / 2;
    crowd.period = std::max({high.x - low.x, high.z - low.z, 1.0}) + settings.spacing;
  }
}

}  // namespace

StageView stage_view(const Scenario& scenario) {
  return {scenario.camera.at(0.0), static_cast<double>(scenario.width) / scenario.height, scenario.crowd.stage_near,
          scenario.crowd.stage_far};
}

Crowd make_crowd(const Scenario& scenario, const Cast& cast, const StageView& view) {
  const CrowdSettings& settings = scenario.crowd;
  assert(!cast.banks.empty() && cast.banks.size() == cast.shares.size());
  Crowd crowd;
  crowd.seed = scenario.seed;
  crowd.motion = settings.motion;
  crowd.palette = make_outfits(scenario.seed, settings.outfits);
  draw_agents(scenario, cast, crowd);

  crowd.wrap_x = settings.centre.x;
  crowd.wrap_z = settings.centre.z;
  const bool lanes_moving = settings.motion == MotionKind::lanes;
  if (lanes_moving || (settings.placement == PlacementKind::lanes && settings.stage != Stage::frustum)) {
    const Lanes lanes = plan_lanes(scenario, view);
    crowd.period = lanes.period;
    fill_lanes(scenario, cast, lanes, crowd);
  } else if (settings.agents > 0) {
    fill_places(scenario, cast, view, crowd);
  }
  return crowd;
}

Frame make_frame(const Scenario& scenario, const Cast& cast, const Crowd& crowd, const Camera& camera, uint64_t tick,
                 bool cull) {
  Frame frame;
  frame.tick = tick;
  frame.origin = camera.eye;
  frame.camera = camera;
  frame.width = scenario.width;
  frame.height = scenario.height;
  frame.antialiasing = scenario.antialiasing;
  frame.light = scenario.light;
  frame.background = glm::vec4(scenario.background, 1.0F);
  frame.ground = scenario.ground;
  frame.ground_height = scenario.crowd.centre.y;
  frame.outfits = crowd.palette;
  frame.agents.resize(cast.banks.size());

  // The view's planes through the eye, pointing inwards, in world axes.
  const glm::dmat3 axes = glm::transpose(view_rotation(camera));
  const double tall = half_tangent(camera);
  const double wide = tall * scenario.width / scenario.height;
  const glm::dvec3 forward = -axes[2];
  const glm::dvec3 sides[4] = {glm::normalize(wide * forward + axes[0]), glm::normalize(wide * forward - axes[0]),
                               glm::normalize(tall * forward + axes[1]), glm::normalize(tall * forward - axes[1])};

  struct Kind {
    const PoseBank* bank;
    glm::dvec3 middle;
    double radius;
    std::vector<double> cycles;  // a second, by clip; 0 for a still pose
    std::vector<GroundMotion> ground;
  };
  std::vector<Kind> kinds;
  for (const auto& bank : cast.banks) {
    const glm::dvec3 low = bank->bounds_min();
    const glm::dvec3 high = bank->bounds_max();
    Kind kind{bank.get(), (low + high) * 0.5, glm::length(high - low) * 0.5, {}, {}};
    for (const BankClip& clip : bank->clips()) {
      kind.cycles.push_back(clip.seconds > 0 ? 1.0 / clip.seconds : 0.0);
      kind.ground.push_back(ground_motion(clip));
    }
    kinds.push_back(std::move(kind));
  }

  const double seconds = static_cast<double>(tick) / scenario.tick_rate;
  const double ground = scenario.crowd.centre.y - camera.eye.y;
  for (size_t i = 0; i < crowd.size(); ++i) {
    if (i % kStepsBetweenChecks == 0) throw_if_interrupted();
    const Kind& kind = kinds[crowd.character[i]];
    const uint16_t clip = crowd.bank_clip[i];
    double sine = crowd.heading_sin[i];
    double cosine = crowd.heading_cos[i];
    const double scale = crowd.scale[i];
    double x = crowd.x[i];
    double z = crowd.z[i];
    if (crowd.motion != MotionKind::treadmill) {
      const GroundMotion& ground_of = kind.ground[clip];
      const double played_seconds = crowd.speed[i] * seconds;
      const double metres = ground_of.speed * crowd.speed[i] * scale * seconds;
      const Way way = way_of(ground_of, sine, cosine);
      if (crowd.motion == MotionKind::lanes) {
        // Along the lane; across it nothing changes.
        const double along = (x - crowd.wrap_x) * way.x + (z - crowd.wrap_z) * way.z;
        const double step = wrap(along + metres, crowd.period) - along;
        x += step * way.x;
        z += step * way.z;
      } else {
        const Way gone = turned_way(way, metres, ground_of.turns * played_seconds);
        x = crowd.wrap_x + wrap(x - crowd.wrap_x + gone.x, crowd.period);
        z = crowd.wrap_z + wrap(z - crowd.wrap_z + gone.z, crowd.period);
        if (ground_of.turns != 0) {
          const SinCos turn = sincos_turns(ground_of.turns * played_seconds);
          const double before = sine;
          sine = before * turn.cos + cosine * turn.sin;
          cosine = cosine * turn.cos - before * turn.sin;
        }
      }
    }
    const glm::dvec3 at{x - camera.eye.x, ground, z - camera.eye.z};
    if (cull) {
      const glm::dvec3 m = kind.middle * scale;
      const glm::dvec3 middle = at + glm::dvec3{m.x * cosine + m.z * sine, m.y, m.z * cosine - m.x * sine};
      const double radius = kind.radius * scale;
      const double depth = glm::dot(middle, forward);
      bool outside = depth < camera.near - radius || (camera.far > 0 && depth > camera.far + radius);
      for (const glm::dvec3& side : sides) outside = outside || glm::dot(middle, side) < -radius;
      if (outside) continue;
    }
    const double played = crowd.phase[i] + crowd.speed[i] * seconds * kind.cycles[clip];
    const double phase = played - floor_exact(played);
    FrameAgent agent;
    agent.position = at;
    agent.scale = static_cast<float>(scale);
    agent.heading = {static_cast<float>(sine), static_cast<float>(cosine)};
    agent.pose = kind.bank->sample(clip, phase);
    agent.phase = std::min(static_cast<float>(phase), 0.99999994F);  // the largest float below 1
    agent.bank_clip = clip;
    agent.outfit = crowd.outfit[i];
    agent.id = static_cast<uint32_t>(i) + 1;
    frame.agents[crowd.character[i]].push_back(agent);
  }
  return frame;
}

std::vector<Outfit> make_outfits(uint64_t seed, uint32_t count) {
  // Linear-light factors, chosen by eye on the mannequin's pale cloth. Lists may be long: a colour is one hash away.
  static constexpr float kShirts[][3] = {{1.00F, 1.00F, 1.00F}, {0.95F, 0.30F, 0.22F}, {0.25F, 0.45F, 0.95F},
                                         {0.30F, 0.70F, 0.38F}, {1.05F, 0.80F, 0.28F}, {0.40F, 0.36F, 0.80F},
                                         {0.90F, 0.50F, 0.62F}, {0.30F, 0.72F, 0.78F}, {0.36F, 0.37F, 0.40F},
                                         {1.00F, 0.58F, 0.26F}, {0.72F, 0.66F, 0.52F}, {0.48F, 0.30F, 0.34F}};
  static constexpr float kTrousers[][3] = {{0.36F, 0.44F, 0.74F}, {0.32F, 0.33F, 0.36F}, {0.78F, 0.68F, 0.50F},
                                           {0.46F, 0.40F, 0.34F}, {0.60F, 0.62F, 0.66F}, {0.36F, 0.42F, 0.34F},
                                           {1.00F, 1.00F, 1.00F}, {0.34F, 0.36F, 0.52F}};
  static constexpr float kShoes[][3] = {
      {1.00F, 1.00F, 1.00F}, {0.36F, 0.33F, 0.31F}, {0.70F, 0.48F, 0.34F}, {1.20F, 1.20F, 1.20F}};
  static constexpr float kHair[][3] = {{0.42F, 0.38F, 0.36F}, {0.80F, 0.62F, 0.46F}, {1.00F, 1.00F, 1.00F},
                                       {1.45F, 1.20F, 0.80F}, {1.20F, 0.72F, 0.46F}, {1.25F, 1.25F, 1.30F}};
  static constexpr float kFair[3] = {1.04F, 1.01F, 1.00F};
  static constexpr float kDark[3] = {0.46F, 0.33F, 0.27F};
  std::vector<Outfit> outfits(count);
  for (uint32_t row = 0; row < count; ++row)
    for (int slot = 0; slot < kOutfitSlots; ++slot) {
      glm::vec4& colour = outfits[row].colours[static_cast<size_t>(slot)];
      colour = glm::vec4(1.0F);
      if (row == 0) continue;
      const auto pick = [&](const auto& list) -> const float* {
        return list[random_below(seed, row, kPaletteChoice + static_cast<uint64_t>(slot), std::size(list))];
      };
      const auto shade = static_cast<float>(random_unit(seed, row, kPaletteShade + static_cast<uint64_t>(slot)));
      if (slot == 0) {
        for (int c = 0; c < 3; ++c) colour[c] = kFair[c] + shade * (kDark[c] - kFair[c]);
        continue;
      }
      const float* base = slot == 1   ? pick(kHair)
                          : slot == 3 ? pick(kTrousers)
                          : slot == 4 ? pick(kShoes)
                                      : pick(kShirts);
      for (int c = 0; c < 3; ++c) colour[c] = base[c] * (0.92F + 0.16F * shade);
    }
  return outfits;
}

}  // namespace crowdbench::scene
