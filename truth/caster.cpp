#include "truth/caster.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/parallel.h"
#include "core/progress.h"

namespace crowdbench::truth {
namespace {

constexpr double kMargin = 0.01;  // pixels round an agent's bounds: more than their rounding

bool nearer(const Caster::Hit& a, const Caster::Hit& b) {
  return a.depth != b.depth ? a.depth < b.depth : a.agent != b.agent ? a.agent < b.agent : a.triangle < b.triangle;
}

}  // namespace

Caster::Caster(const scene::Cast& cast, const scene::Frame& frame, double step, unsigned threads, uint32_t only)
    : cast_(cast), frame_(frame), view_(frame), step_(step), threads_(threads), alone_(only != 0) {
  surfaces_.reserve(cast.characters.size());
  for (const auto& character : cast.characters) surfaces_.emplace_back(*character);
  for (uint32_t c = 0; c < frame.agents.size(); ++c)
    for (uint32_t a = 0; a < frame.agents[c].size(); ++a)
      if (only == 0 || frame.agents[c][a].id == only) {
        Bounds bounds;
        bounds.character = c;
        bounds.agent = a;
        bounds_.push_back(bounds);
      }
  parallel_for(
      bounds_.size(), threads_, [&](size_t i) { find_bounds(bounds_[i]); }, [](size_t) { throw_if_interrupted(); });
  for (uint32_t i = 0; i < bounds_.size(); ++i)
    if (bounds_[i].right >= bounds_[i].left) nearest_first_.push_back(i);
  std::ranges::sort(nearest_first_, [&](uint32_t a, uint32_t b) {
    return bounds_[a].nearest != bounds_[b].nearest ? bounds_[a].nearest < bounds_[b].nearest : a < b;
  });
}

AgentPose Caster::pose_of(const Bounds& bounds) const {
  return {*cast_.characters[bounds.character], *cast_.banks[bounds.character], agent_of(bounds)};
}

std::vector<glm::dvec3> Caster::positions_of(const Bounds& bounds) const {
  const AgentPose pose = pose_of(bounds);
  std::vector<glm::dvec3> out(cast_.characters[bounds.character]->mesh.positions.size());
  for (uint32_t v = 0; v < out.size(); ++v) out[v] = pose.position(v);
  return out;
}

void Caster::find_bounds(Bounds& bounds) const {
  glm::dvec2 low(std::numeric_limits<double>::infinity());
  glm::dvec2 high = -low;
  double nearest = low.x;
  double farthest = high.x;
  const std::vector<glm::dvec3> positions = positions_of(bounds);
  for (const glm::dvec3& position : positions) {
    const double depth = view_.depth(position);
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
    if (depth < view_.near()) continue;
    const glm::dvec2 place = view_.place(position);
    low = glm::min(low, place);
    high = glm::max(high, place);
  }
  bounds.nearest = nearest;
  if (positions.empty() || farthest < view_.near() || nearest > view_.far()) return;
  const glm::dvec2 size(frame_.width, frame_.height);
  // What reaches behind the near plane may be anywhere.
  if (nearest < view_.near()) {
    low = glm::dvec2(0.0);
    high = size;
  }
  low = glm::floor(glm::max(low - kMargin, 0.0));
  high = glm::floor(glm::min(high + kMargin, size - 0.5));
  if (low.x > high.x || low.y > high.y) return;
  bounds.left = static_cast<int>(low.x);
  bounds.top = static_cast<int>(low.y);
  bounds.right = static_cast<int>(high.x);
  bounds.bottom = static_cast<int>(high.y);
}

void Caster::cast_agent(uint32_t agent, const Places& places, std::vector<Hit>& hits,
                        std::vector<std::mutex>& rows) const {
  const Bounds& bounds = bounds_[agent];
  const int left = std::max(bounds.left, places.left);
  const int right = std::min(bounds.right, places.left + places.width - 1);
  const int top = std::max(bounds.top, places.top);
  const int bottom = std::min(bounds.bottom, places.top + places.height - 1);
  if (left > right || top > bottom) return;
  const auto run_of = [&](int y) {
    const size_t row = static_cast<size_t>(y - places.top) * static_cast<size_t>(places.width);
    return std::pair(places.first[row + static_cast<size_t>(left - places.left)],
                     places.first[row + static_cast<size_t>(right - places.left) + 1]);
  };
  // Behind everything that is known so far: it need not even be posed.
  bool hidden = true;
  for (int y = top; y <= bottom && hidden; ++y) {
    const std::lock_guard lock(rows[static_cast<size_t>(y - places.top)]);
    const auto [from, to] = run_of(y);
    for (uint32_t i = from; i < to && hidden; ++i) hidden = hits[i].depth < bounds.nearest;
  }
  if (hidden) return;

  const Surface& surface = surfaces_[bounds.character];
  const std::vector<glm::dvec3> positions = positions_of(bounds);
  const Bvh bvh(positions, surface.indices());
  std::vector<Hit> own;
  for (int y = top; y <= bottom; ++y) {
    const auto [from, to] = run_of(y);
    if (from == to) continue;
    std::mutex& row = rows[static_cast<size_t>(y - places.top)];
    {
      const std::lock_guard lock(row);
      own.assign(hits.begin() + from, hits.begin() + to);
    }
    for (uint32_t i = from; i < to; ++i) {
      Hit& known = own[i - from];
      const glm::dvec3 direction = view_.direction(places.at[i]);
      const Ray ray(glm::dvec3(0.0), direction);
      const auto drawn = [&](uint32_t triangle, const TriangleHit& hit) {
        if (!surface.drawn(triangle, hit.back)) return false;
        if (!surface.masked(triangle)) return true;
        const uint32_t* corners = surface.indices().data() + size_t{3} * triangle;
        const glm::dvec3 posed[3] = {positions[corners[0]], positions[corners[1]], positions[corners[2]]};
        return surface.above_cutoff(triangle, posed, hit.weights, view_, direction, step_) >= 0;
      };
      const ClosestHit found = bvh.closest(ray, view_.near(), std::min(view_.far(), known.depth), drawn);
      if (!found.found()) continue;
      const Hit hit{found.hit.t, {found.hit.weights.x, found.hit.weights.y}, agent, found.triangle, found.hit.back};
      if (nearer(hit, known)) known = hit;
    }
    const std::lock_guard lock(row);
    for (uint32_t i = from; i < to; ++i)
      if (nearer(own[i - from], hits[i])) hits[i] = own[i - from];
  }
}

std::vector<Caster::Hit> Caster::cast(const Places& places, const Advanced& advanced) const {
  std::vector<Hit> hits(places.at.size());
  std::vector<std::mutex> rows(static_cast<size_t>(places.height));
  parallel_for(
      nearest_first_.size(), threads_, [&](size_t i) { cast_agent(nearest_first_[i], places, hits, rows); },
      [&](size_t done) { advanced(static_cast<double>(done) / static_cast<double>(nearest_first_.size())); });
  return hits;
}

TruthPoint Caster::describe_one(const Hit& hit, const glm::dvec2& place, bool shade, bool whole) const {
  TruthPoint point;
  const glm::dvec3 direction = view_.direction(place);
  const std::optional<double> ground = alone_ ? std::nullopt : ground_depth(frame_, view_, direction);
  if (hit.agent == ~0U || (ground && *ground <= hit.depth)) {
    if (ground) point.depth = *ground;
    if (shade && whole)
      point.linear = ground ? ground_colour(frame_, view_, direction, *ground, step_) : glm::dvec3(frame_.background);
    return point;
  }
  const Bounds& bounds = bounds_[hit.agent];
  const scene::FrameAgent& agent = agent_of(bounds);
  const Surface& surface = surfaces_[bounds.character];
  point.id = agent.id;
  point.character = bounds.character;
  point.agent = bounds.agent;
  point.triangle = hit.triangle;
  point.material = surface.material_index(hit.triangle);
  point.back = hit.back;
  point.depth = hit.depth;
  point.weights = {hit.weights[0], hit.weights[1], 1 - hit.weights[0] - hit.weights[1]};
  if (!whole) return point;
  const TriangleHit on{hit.depth, point.weights, hit.back};
  const Surface::Shaded shaded =
      surface.shaded(hit.triangle, on, pose_of(bounds), agent.outfit, frame_, view_, direction, step_);
  point.normal = shaded.normal;
  if (shade) point.linear = shaded.linear;
  return point;
}

std::vector<TruthPoint> Caster::describe(const Places& places, const std::vector<Hit>& hits, bool shade,
                                         const std::function<bool(size_t place)>& whole) const {
  std::vector<TruthPoint> out(places.at.size());
  constexpr size_t kRun = 512;
  parallel_for((out.size() + kRun - 1) / kRun, threads_,
               [&](size_t run) {
                 for (size_t i = run * kRun; i < std::min(out.size(), (run + 1) * kRun); ++i)
                   out[i] = describe_one(hits[i], places.at[i], shade, whole(i));
               },
               [](size_t) { throw_if_interrupted(); });
  return out;
}

}  // namespace crowdbench::truth
