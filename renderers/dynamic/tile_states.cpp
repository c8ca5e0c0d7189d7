// Based on: A. Aubel, R. Boulic and D. Thalmann, "Animated impostors for real-time display of numerous virtual humans"
// (1998) and "Real-time display of virtual humans: levels of details and impostors" (2000): a tile is drawn anew when
// the pose, or the view of it, has changed by more than a threshold. Differs from the source: README.md.
#include "renderers/dynamic/tile_states.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/random.h"

namespace crowdbench::renderers {
namespace {

class Hash {
 public:
  void add(uint64_t value) { value_ = mix64(value_ * 0x9e3779b97f4a7c15ULL + value + 1); }
  void add(double value) { add(std::bit_cast<uint64_t>(value)); }
  void add(const glm::dvec3& v) {
    for (int i = 0; i < 3; ++i) add(v[i]);
  }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 0;
};

uint64_t hash_of_light(const scene::Frame& frame) {
  Hash hash;
  hash.add(glm::dvec3(frame.light.direction));
  hash.add(static_cast<double>(frame.light.ambient));
  hash.add(static_cast<double>(frame.light.diffuse));
  for (const scene::Outfit& outfit : frame.outfits)
    for (const glm::vec4& colour : outfit.colours) hash.add(glm::dvec3(colour));
  return hash.value();
}

// The axis to the right, world space, length 1.
glm::dvec3 picture_right(const scene::Frame& frame) { return glm::transpose(scene::view_rotation(frame.camera))[0]; }

uint64_t hash_of(const scene::Frame& frame) {
  Hash hash;
  hash.add(frame.camera.eye);
  hash.add(picture_right(frame));
  hash.add(frame.camera.fov_y);
  hash.add(static_cast<uint64_t>(frame.height));
  for (const auto& all : frame.agents)
    for (const scene::FrameAgent& a : all) {
      hash.add(glm::dvec3(a.position));
      hash.add(glm::dvec3(a.heading.x, a.heading.y, a.scale));
      hash.add(static_cast<double>(a.phase));
      hash.add(static_cast<uint64_t>(a.id) << 32U | static_cast<uint64_t>(a.bank_clip));
      hash.add(uint64_t{a.outfit});
    }
  return hash.value();
}

bool same_pose(const scene::FrameAgent& a, const scene::FrameAgent& b) {
  return a.pose.a == b.pose.a && a.pose.b == b.pose.b && a.pose.blend == b.pose.blend && a.heading == b.heading &&
         a.position == b.position && a.scale == b.scale;
}

}  // namespace

TileStates::TileStates(const TileRules& rules, std::vector<TileCharacter> characters, uint32_t pages)
    : rules_(rules), characters_(std::move(characters)), atlas_(pages) {}

void TileStates::begin(const scene::Frame& frame) {
  const uint64_t hash = hash_of(frame);
  const uint64_t light = hash_of_light(frame);
  if (begun_ && frame.tick == tick_ && hash == frame_hash_ && light == light_hash_) return;
  const bool follows = begun_ && frame.tick > tick_ && frame.tick - tick_ <= kMostTicks && light == light_hash_;
  if (!follows) {
    records_.clear();
    atlas_.clear();
  }
  begun_ = true;
  tick_ = frame.tick;
  frame_hash_ = hash;
  light_hash_ = light;
  picture_right_ = picture_right(frame);
  refreshes_ = 0;
  ++moment_;
}

bool TileStates::is_stale(const TileRecord& known, const TileRecord& seen) const {
  if (known.agent.outfit != seen.agent.outfit) return true;
  if (rules_.always_anew())
    return !same_pose(known.agent, seen.agent) || known.view.to_eye != seen.view.to_eye ||
           known.view.right != seen.view.right;
  const double grown = seen.pixels / known.pixels;
  if (std::max(grown, 1 / grown) > 1 + rules_.size) return true;
  if (glm::distance(known.view.to_eye, seen.view.to_eye) > 2 * std::sin(rules_.angle / 2)) return true;
  return static_cast<double>(largest_change(known.distances, seen.distances)) > rules_.pose;
}

TileRecord* TileStates::update(const scene::Frame& frame, size_t character, uint32_t agent) {
  const TileCharacter& c = characters_[character];
  const scene::FrameAgent& a = frame.agents[character][agent];
  const uint64_t id = uint64_t{character} << 32U | a.id;
  const auto none = [&]() -> TileRecord* {
    records_.erase(id);
    atlas_.give_up(id);
    return nullptr;
  };
  const glm::dvec3 eye = turned_back(-glm::dvec3(a.position), a.heading) / static_cast<double>(a.scale);
  const double focal = 0.5 * frame.height / std::tan(frame.camera.fov_y / 2);
  const double away = glm::distance(eye, c.box.centre());
  if (!(away > 0)) return none();
  TileRecord seen;
  seen.pixels = focal / away;
  const std::optional<TileView> view =
      tile_view(c.box, eye, turned_back(picture_right_, a.heading), 1 / (seen.pixels * rules_.ratio));
  if (!view) return none();
  seen.agent = a;
  seen.view = *view;
  seen.distances = c.probe.distances(a.pose);
  const auto known = records_.find(id);
  if (known != records_.end() && atlas_.find(id) && !is_stale(known->second, seen)) {
    atlas_.use(id, moment_);
    return &known->second;
  }
  const glm::ivec2 size = tile_texels(seen.view);
  if (size.y > rules_.largest) return none();
  const auto place = atlas_.take(id, size + 2, moment_);
  if (!place) return none();
  seen.place = *place;
  ++refreshes_;
  return &(records_[id] = std::move(seen));
}

}  // namespace crowdbench::renderers
