// Which tiles there are, what each was drawn of, and which of them a frame makes stale.
#pragma once
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "renderers/dynamic/pose_probe.h"
#include "renderers/dynamic/tile_atlas.h"
#include "renderers/dynamic/tile_view.h"
#include "renderers/representation.h"

namespace crowdbench::renderers {

struct TileRules {
  double pose = 0;    // metres that a distance between two points of the body may change
  double angle = 0;   // radians that the direction to the eye may turn about the agent
  double size = 0;    // share that the pixels a metre may grow or shrink
  double ratio = 1;   // texels a pixel
  int largest = 256;  // texels: who is taller has no tile
  bool always_anew() const { return pose == 0 && angle == 0 && size == 0; }
};

// What a tile shows.
struct TileRecord {
  scene::FrameAgent agent;
  TileView view;
  std::vector<float> distances;  // PoseProbe
  double pixels = 0;             // of the picture, a metre
  TileAtlas::Place place;
  bool drawn = false;  // false: the place does not hold it yet
};

// What the tests need to know of a character.
struct TileCharacter {
  Box box;  // of the body in every pose
  PoseProbe probe;
};

// The state of a sequence of frames is a function of those frames: a frame continues it when its tick is at most
// kMostTicks after the last one's and its light is the same; the same frame again is the same moment; any other begins
// anew, with no tiles.
class TileStates {
 public:
  static constexpr uint64_t kMostTicks = 8;
  TileStates(const TileRules& rules, std::vector<TileCharacter> characters, uint32_t pages);
  void begin(const scene::Frame& frame);
  // The tile of an agent of the frame at hand, tested; null where it has none: too near, too tall, or no place left.
  TileRecord* update(const scene::Frame& frame, size_t character, uint32_t agent);
  uint64_t refreshes() const { return refreshes_; }  // tiles that the frame at hand made anew
  size_t tiles() const { return atlas_.tiles(); }

 private:
  bool is_stale(const TileRecord& known, const TileRecord& seen) const;

  TileRules rules_;
  std::vector<TileCharacter> characters_;
  TileAtlas atlas_;
  std::unordered_map<uint64_t, TileRecord> records_;  // by character and id
  bool begun_ = false;
  glm::dvec3 picture_right_{1, 0, 0};  // of the frame at hand, world space
  uint64_t tick_ = 0, moment_ = 0, frame_hash_ = 0, light_hash_ = 0, refreshes_ = 0;
};

}  // namespace crowdbench::renderers
