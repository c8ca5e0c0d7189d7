// Popping: what the switch of one agent shows across its very frame, against the same two frames without the switch.
//
// Three pictures: T[t-1], the frame before as it was drawn; T[t], the frame as it was drawn; and H[t], the same frame
// had the agent kept the look that it had in the frame before. Everything that moves moves in T[t] and in H[t] alike,
// so that what is between them is the switch alone. It is isolated by id: only pixels that carry the agent's id in T[t]
// or H[t] count, and what is seen of them is computed on the box around these, widened by pop_margin().
//
// Source: our own, by substitution; FLIP and ColorVideoVDP as in their headers, luma of BT.601. Ranges: pop_scores().
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "metrics/display.h"
#include "metrics/registry.h"
#include "metrics/silhouette.h"

namespace crowdbench::metrics {

// One number that is said of a pop.
struct PopScore {
  std::string_view name;    // key in JSON
  std::string_view title;   // for people, in the middle of a sentence
  std::string_view column;  // head of a column in a terminal, at most 9 characters
  std::string_view unit;
  Direction direction = Direction::lower_is_better;
  int digits = 3;
  double equal = 0;  // without a pop
  std::string_view computes;
};
// The first is the one by which pops are sorted: how visible they are.
std::span<const PopScore> pop_scores();
// Whether value `a` is more visible than `b`.
bool is_worse(const PopScore& score, double a, double b);
// "9.123", or "-" where there is none.
std::string value_text(const PopScore& score, const std::optional<double>& value);

// All of one size, borrowed. Codes: sRGB-encoded, alpha is ignored.
struct PopFrames {
  const Image8* before = nullptr;       // T[t-1]
  const Image8* shown = nullptr;        // T[t]
  const Image8* held = nullptr;         // H[t]
  const ImageU32* shown_ids = nullptr;  // agent index + 1, 0 = nothing
  const ImageU32* held_ids = nullptr;
};

struct PopView {
  const Display* display = nullptr;  // where it is looked at
  bool display_is_default = false;   // nobody chose it: FLIP keeps to its own distance (ScoreInput)
  double fps = 30;                   // above 0
  unsigned threads = 0;              // as parallel_for
};

struct Pop {
  uint64_t pixels = 0;                        // that carry the id in T[t] or H[t]
  Box box;                                    // around them, widened, cut to the picture
  std::vector<std::optional<double>> values;  // by pop_scores()
};
// Pixels around an agent that belong to its box: half a degree of visual angle, and no less than 32. FLIP's filters end
// within it; ColorVideoVDP's coarsest bands reach further and see the box only, over which it pools: a small box at the
// picture's edge dilutes less.
int pop_margin(const PopView& view);
// Nothing where no pixel carries the id. Throws Error when sizes differ.
std::optional<Pop> score_pop(const PopFrames& frames, uint32_t id, const PopView& view);

// Every score with what is said of it above, as Markdown.
std::string pop_scores_markdown();

}  // namespace crowdbench::metrics
