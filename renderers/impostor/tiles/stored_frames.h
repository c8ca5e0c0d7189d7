// Stored frames: the poses that a bake of tiles takes pictures of.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "renderers/impostor/tiles/tile_capture.h"
#include "renderers/representation.h"
#include "scene/character/character.h"
#include "scene/pose/pose_bank.h"

namespace crowdbench {
class Sha256;
}

namespace crowdbench::renderers {

// How many frames of a clip are stored.
struct FrameCount {
  int frames = 10;             // a clip
  double frames_a_second = 0;  // in place of it; 0: not
  int poses = 1;               // a frame: at it, and evenly spread on the way to the next
  int of(double cycle_seconds) const;
};
inline constexpr int kMostStoredFrames = 4096;  // a clip
// Motion that is stored more coarsely is warned about.
inline constexpr double kFewFramesASecond = 4;

// The options `frames` and `fps`.
OptionDoc frames_option(const std::string& meaning);
OptionDoc fps_option();
FrameCount read_frame_count(const OptionReader& reader);

// One clip of the character's bank.
struct StoredClip {
  uint32_t first_frame = 0;  // over all clips
  uint32_t frames = 1;       // at phases 0, 1 / frames, ...
};

struct StoredFrames {
  struct Pose {
    bool moves = false;  // which bank it is of
    scene::PoseSample sample;
  };
  std::vector<StoredClip> clips;                  // one a clip of the bank
  std::vector<Pose> poses;                        // by frame
  std::shared_ptr<const scene::PoseBank> moving;  // evenly spaced frames of the clips that move; null where none does
  std::shared_ptr<const scene::PoseBank> still;   // the given bank

  size_t size() const { return poses.size(); }
  const std::shared_ptr<const scene::PoseBank>& bank(bool moves) const { return moves ? moving : still; }
  std::vector<scene::Mat3x4> palette(size_t frame) const;
  // scene::shown_positions of every frame.
  std::vector<std::vector<glm::vec3>> positions(const scene::Mesh& mesh) const;
};

// So many of every clip of the bank that moves; of a clip of a single sample that one pose, exactly. Throws Error: more
// than kMostStoredFrames.
StoredFrames stored_frames(const scene::Character& character, const std::shared_ptr<const scene::PoseBank>& bank,
                           const FrameCount& count);

// The coarsest of the bank's moving clips, where it has fewer than kFewFramesASecond: a line that says so and what
// helps; else empty. stored: how many frames of a clip are; helps: what to do about that clip.
std::string coarse_clip_text(const scene::Character& character, const scene::PoseBank& bank,
                             const std::function<int(const scene::BankClip&)>& stored,
                             const std::function<std::string(const scene::BankClip&)>& helps);
// Of frames by the options `frames` and `fps`.
std::string coarse_frames_text(const scene::Character& character, const scene::PoseBank& bank, const FrameCount& count);

int most_frames(const StoredFrames& frames);  // of any clip

// How far the farthest vertex moves from each stored frame to the next of its clip, metres; none of a still pose.
// positions: StoredFrames::positions.
std::vector<double> pose_steps(const StoredFrames& frames, const std::vector<std::vector<glm::vec3>>& positions);

// enclosing_sphere of the character's stored frames. Throws Error where its radius is 0.
CaptureSphere capture_sphere(const scene::Character& character, const std::vector<std::vector<glm::vec3>>& positions);

// Levels of a bake of `texels` across the sphere. The coarsest still has sixteen texels along the figure, and smaller
// pictures of it are point-sampled from there: coarser ones are blobs that overlap less in a dense crowd than figures
// do (at four texels 5 % more of the picture was covered by 30,000 agents), and their texels would no longer save time.
int tile_levels(int texels);

// What the stored frames of a bank depend on beside the character.
void hash_poses(Sha256& hash, const scene::PoseBank& bank, const FrameCount& count);

}  // namespace crowdbench::renderers
