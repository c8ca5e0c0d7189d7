// LodSwitch: which of two representations draws an agent, by a rule on where it stands, with hysteresis and
// cross-fades.
#pragma once
#include <cstdint>
#include <vector>

#include "renderers/representation.h"

namespace crowdbench::renderers {

//   distance: metres from the eye to the agent's pivot (Euclidean); farther agents are far.
//   height:   pixels that the character's height covers at the eye-space depth of its middle; lower ones are far.
//   ratio:    pixels that one texel of the far representation spans at that depth; agents whose texels span fewer are
//             far.
//   nearest:  the `value` agents whose pivots are nearest to the eye are near (of two as far, the one with the lower
//             id), over all characters; all others are far.
struct LodPolicy {
  enum class Rule : uint8_t { distance, height, ratio, nearest };
  Rule rule = Rule::distance;
  double value = 20;
  // An agent turns far beyond (1 + hysteresis) times the switch distance, and near again within 1 / (1 + hysteresis) of
  // it. With `nearest` agents are compared as if those that are near stood (1 + hysteresis) times nearer and those that
  // are far as many times farther: a far one takes the place of a near one when it is (1 + hysteresis)^2 times nearer,
  // and exactly `value` agents are near at any time.
  double hysteresis = 0;
  // Ticks over which both representations share the agent's pixels: in the j-th the new one has j / (fade + 1) of them,
  // by ordered dither. 0: it changes from one tick to the next.
  int fade = 0;
  // Near agents beyond (1 - match) times the switch distance, and those that fade, show the pose of the far
  // representation's stored frame. 0: none.
  double match = 0;
  bool has_history() const { return hysteresis > 0 || fade > 0; }
};

// What the rule needs to know of a character, metres at scale 1.
struct LodCharacter {
  double height = 1.75;
  double texel = 0;  // of the far representation; 0: it has none
};

// The depth or distance in metres at which an agent of scale 1 on the view axis changes over, from the rule itself. Not
// for `nearest`.
double switch_distance(const LodPolicy& policy, const LodCharacter& character, const scene::Camera& camera, int rows);

// Lists keep the order of the agents given; an agent is in exactly one of near, far and fading[1 .. fade].
struct LodSplit {
  AgentLists near, far;
  std::vector<AgentLists> fading;  // [m]: the far representation has m / (fade + 1) of the agent's pixels
  AgentLists matched;              // of near and fading: those that show the far representation's stored frame
  size_t count(const AgentLists& lists) const;
};

// By agent id: how many of fade + 1 shares of the agent's pixels the far representation has, whatever the rule says;
// kNotHeld, or no entry: as the rule says.
using HeldShares = std::vector<uint8_t>;
inline constexpr uint8_t kNotHeld = 255;

// The state of a sequence of frames is a function of those frames: of the first one by the rule alone, of each further
// one by the rule and the state before. A frame continues the sequence when its tick is at most kMostTicks after the
// last one's; a frame of the same tick is the same moment again; any other begins anew, as does an agent that was not
// among those of the frame before. Without hysteresis and fade every frame stands for itself.
class LodSwitch {
 public:
  static constexpr uint64_t kMostTicks = 8;
  LodSwitch(const LodPolicy& policy, std::vector<LodCharacter> characters);
  // Valid until the next call. The state follows the rule, held or not.
  const LodSplit& split(const scene::Frame& frame, const AgentLists& agents, const HeldShares& held = {});
  const LodPolicy& policy() const { return policy_; }

 private:
  struct AgentState {
    uint64_t stamp = 0;  // of the frame that wrote it
    bool far = false;
    uint8_t step = 0;  // of the fade, 1..fade; 0: none
  };
  void measure(const scene::Frame& frame, const AgentLists& agents);
  void begin(const scene::Frame& frame);
  // Of the frame before; null when it had no such agent or is no predecessor of the frame at hand.
  const AgentState* last_state(uint32_t id) const;

  LodPolicy policy_;
  std::vector<LodCharacter> characters_;
  LodSplit split_;
  // Of the frame at hand: by character and place in its list.
  std::vector<std::vector<double>> relative_;  // distance over the switch distance
  std::vector<std::vector<bool>> beyond_;      // what the rule says without a state
  std::vector<std::pair<float, uint32_t>> order_;
  std::vector<AgentState> before_, now_;  // by id
  uint64_t before_stamp_ = 0, now_stamp_ = 0, stamps_ = 0;
  uint64_t tick_ = 0, elapsed_ = 0;
};

}  // namespace crowdbench::renderers
