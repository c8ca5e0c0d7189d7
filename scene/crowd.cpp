// Based on: Roberts, "The unreasonable effectiveness of quasirandom sequences" (2018) for the stratified placement over
// a view (the additive recurrence of the plastic number, here in 64-bit fixed point so that it is exact); dart throwing
// on a background grid as in Bridson, "Fast Poisson disk sampling in arbitrary dimensions" (2007). Differs from the
// source: darts are thrown over the whole square instead of around earlier points, so that the n-th dart is a hash of n
// alone.
#include "scene/crowd.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/error.h"
#include "core/portable_math.h"
#include "core/random.h"

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
  kPaletteChoice = 32,  // + part
  kPaletteShade = 64    // + part
};

constexpr double kJitter = 0.15;        // spacings, either way: neighbours stay 0.7 spacings apart
constexpr double kDiskDistance = 0.75;  // spacings; 81 % of the density at which dart throwing jams
constexpr double kBody = 1.0;           // metres around a pivot that a body may reach: lanes wrap so far out of view

// A measured length enters the crowd rounded, so that the last bits of the machine's sine do not.
double rounded(double value) { return static_cast<double>(static_cast<int64_t>(value * 65536.0 + 0.5)) / 65536.0; }

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

// Of half the vertical field of view.
double half_tangent(const Camera& camera) {
  const SinCos half = sincos_turns(camera.fov_y / 2 / 6.283185307179586);
  return half.sin / half.cos;
}

uint64_t ceil_sqrt(uint64_t n) {
  auto root = static_cast<uint64_t>(std::sqrt(static_cast<double>(n)));
  while (root * root < n) ++root;
  return root;
}

struct Place {
  double x;
  double z;
};

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

// Positions relative to the stage's middle.
std::vector<Place> place_cells(const Scenario& scenario, double jitter) {
  const double spacing = scenario.crowd.spacing;
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

// Throws darts into a square of `side` until `n` stuck; false when they jam first.
bool throw_darts(const Scenario& scenario, double side, std::vector<Place>& places) {
  const uint32_t n = scenario.crowd.agents;
  const double distance = kDiskDistance * scenario.crowd.spacing;
  const double cell = distance / 1.4142135623730951;  // at most one point a cell
  const auto cells = static_cast<int64_t>(side / cell) + 1;
  std::vector<uint32_t> grid(static_cast<size_t>(cells * cells), 0);  // index + 1
  places.clear();
  const uint64_t darts = uint64_t{400} * n + 1000;
  for (uint64_t dart = 0; dart < darts && places.size() < n; ++dart) {
    const Place at{random_unit(scenario.seed, dart, kDartX) * side, random_unit(scenario.seed, dart, kDartZ) * side};
    const auto cx = static_cast<int64_t>(at.x / cell);
    const auto cz = static_cast<int64_t>(at.z / cell);
    bool free = true;
    for (int64_t gz = std::max<int64_t>(0, cz - 2); free && gz <= std::min(cells - 1, cz + 2); ++gz)
      for (int64_t gx = std::max<int64_t>(0, cx - 2); free && gx <= std::min(cells - 1, cx + 2); ++gx) {
        const uint32_t other = grid[static_cast<size_t>(gz * cells + gx)];
        if (other == 0) continue;
        const double dx = places[other - 1].x - at.x;
        const double dz = places[other - 1].z - at.z;
        free = dx * dx + dz * dz >= distance * distance;
      }
    if (!free) continue;
    places.push_back(at);
    grid[static_cast<size_t>(cz * cells + cx)] = static_cast<uint32_t>(places.size());
  }
  for (Place& place : places) {
    place.x -= side / 2;
    place.z -= side / 2;
  }
  return places.size() == n;
}

std::vector<Place> place_poisson(const Scenario& scenario) {
  std::vector<Place> places;
  double side = std::sqrt(static_cast<double>(scenario.crowd.agents)) * scenario.crowd.spacing;
  while (!throw_darts(scenario, side, places)) side *= 1.05;
  return places;
}

double stage_height(const Cast& cast) {
  double height = 0;
  for (size_t c = 0; c < cast.characters.size(); ++c) height += cast.shares[c] * cast.characters[c]->placement.height;
  return rounded(height);
}

// World positions over what the view sees between the two depths. Uniform in depth and across the view: the ground
// thins out as 1 / depth, which covers near and far parts of the picture alike.
std::vector<Place> place_frustum(const Scenario& scenario, const Cast& cast, const StageView& view) {
  const uint32_t n = scenario.crowd.agents;
  const Camera& camera = view.camera;
  const glm::dmat3 rotation = view_rotation(camera);
  const glm::dmat3 axes = glm::transpose(rotation);  // columns: right, up, backward
  const double tall = half_tangent(camera);
  const double wide = tall * view.aspect;
  const double middle = scenario.crowd.centre.y + stage_height(cast) / 2;  // the point of a body that is kept in view
  // In the middle column a body's middle lies at y = rise + slope * depth in eye space; keep the depths where that is
  // within the picture.
  double nearest = view.near_depth;
  double farthest = view.far_depth;
  if (axes[1].y > 0.2) {
    const double rise = (middle - camera.eye.y) / axes[1].y;
    const double slope = axes[2].y / axes[1].y;
    for (const double side : {1.0, -1.0}) {  // side * (rise + slope * depth) + tall * depth >= 0
      const double gain = side * slope + tall;
      if (gain > 0) nearest = std::max(nearest, -side * rise / gain);
      if (gain < 0) farthest = std::min(farthest, -side * rise / gain);
    }
    if (!(nearest <= farthest)) {  // the view misses the stage: place it as it was asked for
      nearest = view.near_depth;
      farthest = view.far_depth;
    }
  }
  const uint64_t start_x = random_bits(scenario.seed, 0, kStratumX);
  const uint64_t start_z = random_bits(scenario.seed, 0, kStratumZ);
  std::vector<Place> places(n);
  for (uint32_t i = 0; i < n; ++i) {
    const double a = static_cast<double>((start_x + i * 0xc13fa9a902a6328fULL) >> 11) * 0x1.0p-53;
    const double b = static_cast<double>((start_z + i * 0x91e10da5c79e7b1dULL) >> 11) * 0x1.0p-53;
    glm::dvec3 eye_space;
    const double across = 2.0 * a - 1.0;
    if (axes[1].y > 0.2) {
      const double depth = nearest + b * (farthest - nearest);
      const double x = across * wide * depth;
      const double y = (middle - camera.eye.y - axes[0].y * x + axes[2].y * depth) / axes[1].y;
      eye_space = {x, y, -depth};
    } else {  // almost straight down or up: the ground has hardly any depth, so spread over the picture instead
      const glm::dvec3 ray = axes * glm::dvec3{across * wide, (2.0 * b - 1.0) * tall, -1.0};
      const double depth = ray.y != 0 ? (middle - camera.eye.y) / ray.y : view.near_depth;
      eye_space = glm::dvec3{across * wide, (2.0 * b - 1.0) * tall, -1.0} * std::max(depth, view.near_depth);
    }
    const glm::dvec3 at = camera.eye + axes * eye_space;
    places[i] = {at.x, at.z};
  }
  return places;
}

struct Moving {
  uint16_t character;
  uint16_t clip;
  double speed;  // metres a second at playback speed 1 and scale 1
};

std::vector<Moving> moving_clips(const Cast& cast) {
  std::vector<Moving> moving;
  for (size_t c = 0; c < cast.banks.size(); ++c) {
    const size_t before = moving.size();
    const auto& clips = cast.banks[c]->clips();
    for (size_t k = 0; k < clips.size(); ++k)
      if (const double speed = rounded(clips[k].ground_speed); speed > 0.05 && clips[k].seconds > 0)
        moving.push_back({static_cast<uint16_t>(c), static_cast<uint16_t>(k), speed});
    if (moving.size() == before)
      throw Error("crowd.motion", "`lanes` needs walkers, and no clip in use of " + cast.characters[c]->name + " moves",
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
                                  kJitter * settings.spacing * signed_unit(scenario.seed, i, kOffsetX),
                              lanes.period);
    const double side = (static_cast<double>(lane) - static_cast<double>(lanes.count - 1) / 2 +
                         kJitter * signed_unit(scenario.seed, i, kOffsetZ)) *
                        settings.spacing;
    crowd.x[i] = settings.centre.x + along * lanes.axis.sin + side * lanes.axis.cos;
    crowd.z[i] = settings.centre.z + along * lanes.axis.cos - side * lanes.axis.sin;
    const double way = lanes.both_ways && lane % 2 == 1 ? -1.0 : 1.0;
    crowd.heading_sin[i] = way * lanes.axis.sin;
    crowd.heading_cos[i] = way * lanes.axis.cos;
    if (!walk) continue;
    // One ground speed a lane; each agent takes its character's nearest clip and plays it as fast as that needs.
    const Moving& leader = moving[random_below(scenario.seed, lane, kLaneClip, moving.size())];
    const double target =
        leader.speed * (1.0 + settings.speed_variation * signed_unit(scenario.seed, lane, kLaneSpeed));
    const Moving* best = nullptr;
    for (const Moving& clip : moving) {
      if (clip.character != crowd.character[i]) continue;
      if (best == nullptr || std::abs(clip.speed - target) < std::abs(best->speed - target)) best = &clip;
    }
    assert(best != nullptr);
    crowd.bank_clip[i] = best->clip;
    crowd.speed[i] = target / (best->speed * crowd.scale[i]);
  }
}

}  // namespace

StageView stage_view(const Scenario& scenario) {
  return {scenario.camera.at(0.0), static_cast<double>(scenario.width) / scenario.height, scenario.crowd.stage_near,
          scenario.crowd.stage_far};
}

Crowd make_crowd(const Scenario& scenario, const Cast& cast, const StageView& view) {
  const CrowdSettings& settings = scenario.crowd;
  const uint32_t n = settings.agents;
  const uint64_t seed = scenario.seed;
  assert(!cast.banks.empty() && cast.banks.size() == cast.shares.size());
  Crowd crowd;
  crowd.seed = seed;
  crowd.motion = settings.motion;
  crowd.palette = make_outfits(seed, settings.outfits);
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

  crowd.wrap_x = settings.centre.x;
  crowd.wrap_z = settings.centre.z;
  const bool frustum = settings.stage == Stage::frustum && settings.motion != MotionKind::lanes;
  if (!frustum && (settings.motion == MotionKind::lanes || settings.placement == PlacementKind::lanes)) {
    const Lanes lanes = plan_lanes(scenario, view);
    crowd.period = lanes.period;
    fill_lanes(scenario, cast, lanes, crowd);
    return crowd;
  }
  std::vector<Place> places;
  if (frustum)
    places = place_frustum(scenario, cast, view);
  else if (settings.placement == PlacementKind::poisson)
    places = place_poisson(scenario);
  else
    places = place_cells(scenario, settings.placement == PlacementKind::jittered ? kJitter : 0.0);
  Place low{1e300, 1e300};
  Place high{-1e300, -1e300};
  for (uint32_t i = 0; i < n; ++i) {
    crowd.x[i] = places[i].x + (frustum ? 0.0 : settings.centre.x);
    crowd.z[i] = places[i].z + (frustum ? 0.0 : settings.centre.z);
    low = {std::min(low.x, crowd.x[i]), std::min(low.z, crowd.z[i])};
    high = {std::max(high.x, crowd.x[i]), std::max(high.z, crowd.z[i])};
  }
  if (settings.motion == MotionKind::free && n > 0) {
    crowd.wrap_x = (low.x + high.x) / 2;
    crowd.wrap_z = (low.z + high.z) / 2;
    crowd.period = std::max({high.x - low.x, high.z - low.z, 1.0}) + settings.spacing;
  }
  return crowd;
}

Frame make_frame(const Scenario& scenario, const Cast& cast, const Crowd& crowd, const Camera& camera, uint64_t tick,
                 bool cull) {
  Frame frame;
  frame.origin = camera.eye;
  frame.camera = camera;
  frame.width = scenario.width;
  frame.height = scenario.height;
  frame.light = scenario.light;
  frame.background = glm::vec4(scenario.background, 1.0F);
  frame.ground = scenario.ground;
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
    std::vector<double> ground_speed;
  };
  std::vector<Kind> kinds;
  for (const auto& bank : cast.banks) {
    const glm::dvec3 low = bank->bounds_min();
    const glm::dvec3 high = bank->bounds_max();
    Kind kind{bank.get(), (low + high) * 0.5, glm::length(high - low) * 0.5, {}, {}};
    for (const BankClip& clip : bank->clips()) {
      kind.cycles.push_back(clip.seconds > 0 ? 1.0 / clip.seconds : 0.0);
      kind.ground_speed.push_back(rounded(clip.ground_speed));
    }
    kinds.push_back(std::move(kind));
  }

  const double seconds = static_cast<double>(tick) / scenario.tick_rate;
  const double ground = scenario.crowd.centre.y - camera.eye.y;
  for (size_t i = 0; i < crowd.size(); ++i) {
    const Kind& kind = kinds[crowd.character[i]];
    const uint16_t clip = crowd.bank_clip[i];
    const double sine = crowd.heading_sin[i];
    const double cosine = crowd.heading_cos[i];
    const double scale = crowd.scale[i];
    double x = crowd.x[i];
    double z = crowd.z[i];
    if (crowd.motion != MotionKind::treadmill) {
      const double way = kind.ground_speed[clip] * crowd.speed[i] * scale * seconds;
      if (crowd.motion == MotionKind::lanes) {
        // Along the heading; across it nothing changes.
        const double along = (x - crowd.wrap_x) * sine + (z - crowd.wrap_z) * cosine;
        const double step = wrap(along + way, crowd.period) - along;
        x += step * sine;
        z += step * cosine;
      } else {
        x = crowd.wrap_x + wrap(x - crowd.wrap_x + way * sine, crowd.period);
        z = crowd.wrap_z + wrap(z - crowd.wrap_z + way * cosine, crowd.period);
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
    for (int part = 0; part < kParts; ++part) {
      glm::vec4& colour = outfits[row].colours[part];
      colour = glm::vec4(1.0F);
      if (row == 0) continue;
      const auto pick = [&](const auto& list) -> const float* {
        return list[random_below(seed, row, kPaletteChoice + static_cast<uint64_t>(part), std::size(list))];
      };
      const auto shade = static_cast<float>(random_unit(seed, row, kPaletteShade + static_cast<uint64_t>(part)));
      if (part == 0) {
        for (int c = 0; c < 3; ++c) colour[c] = kFair[c] + shade * (kDark[c] - kFair[c]);
        continue;
      }
      const float* base = part == 1   ? pick(kHair)
                          : part == 3 ? pick(kTrousers)
                          : part == 4 ? pick(kShoes)
                                      : pick(kShirts);
      for (int c = 0; c < 3; ++c) colour[c] = base[c] * (0.92F + 0.16F * shade);
    }
  return outfits;
}

}  // namespace crowdbench::scene
