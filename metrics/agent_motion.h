// How one agent of a picture was moved in another: what a shift by fractions of a pixel and a change of size explain.
//
// A picture has one sample a pixel, so that an outline that moved by a fraction of a pixel is known only to lie between
// two samples, and a colour between those around it. What a motion explains is judged by that: an outline by the four
// samples around where a pixel came from, a colour by what lies within a pixel of there.
//
// Based on: nothing published is followed. The starting point is the first and second moments of the two outlines (Hu,
// "Visual pattern recognition by moment invariants", 1962), improved by a pattern search (Hooke and Jeeves 1961).
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/image.h"

namespace crowdbench::metrics {

// A picture with who is where.
struct Layer {
  Image8 codes;  // RGB
  ImageU32 ids;
  ImageF depth;  // metres; empty: not known
};

// The pixels that show an agent.
struct Extent {
  int left = 0, top = 0, right = -1, bottom = -1;  // inclusive
  double x = 0, y = 0;                             // the mean
  double spread = 0;                               // the sum of squared distances from it, both axes
  size_t pixels = 0;
  void add(int px, int py);
};
using Extents = std::map<uint32_t, Extent>;
Extents extents_of(const ImageU32& ids);

struct Range {
  int left, top, right, bottom;  // inclusive
};
// Both extents, with a margin, within the picture.
Range around(const Extent& a, const Extent& b, const ImageU32& ids, int margin);

// A point q comes to lie at middle + scale (q - middle) + (dx, dy). Pixels, right and down.
struct Motion {
  double scale = 1, dx = 0, dy = 0;
  double middle_x = 0, middle_y = 0;
  bool none() const { return scale == 1 && dx == 0 && dy == 0; }
  bool whole() const;  // samples come to lie on samples
};

// One agent: what `source` shows of it, laid into `now`, against the test. `source` is `now`, or the same scene in
// other poses. Of one size; borrowed.
struct AgentPictures {
  const Layer& now;
  const Layer& source;
  const Layer& test;
  uint32_t id = 0;
};

// How far what the motion gives is from the test, over the pixels of `range` that show the agent in either.
struct Mismatch {
  // Squared code values: what is left of the colours after the best gain and offset of each channel, and a constant for
  // each pixel of the outline that is wrong. Whether an agent was also recoloured or darkened has no say in it.
  double cost = 0;
  double residual = 0;   // of the colours alone, a pixel
  size_t outline = 0;    // pixels that differ in whether they show the agent, by the nearest sample
  size_t uncovered = 0;  // of these, what the samples around do not explain
  size_t matched = 0;    // pixels of the agent to which the motion brings some of the agent
};
// stride: only every so many pixels are looked at, and counts are scaled.
Mismatch mismatch_of(const AgentPictures& agent, const Motion& motion, const Range& range, int stride = 1);

struct AgentMove {
  Motion motion;
  std::optional<double> farther;  // metres, where all of it is that much farther away, and as much smaller
  Mismatch before, after;
};
// What is left of the mismatch after whichever motion leaves least, whether or not it would be taken for one.
Mismatch least_mismatch(const AgentPictures& agent, const Extent& from, const Extent& to);

// About how many pixels of the agent's outline differ after a shift by one pixel: where it begins or ends along a row
// or a column of pixels, the mean of both.
double outline_length(const ImageU32& ids, uint32_t id, const Extent& extent);

// Nothing where it is where it was, or where no motion explains what changed.
std::optional<AgentMove> find_move(const AgentPictures& agent, const Extent& from, const Extent& to);

// Lays the agent into `now` as the motion has it; pixels that the samples around explain are the test's own. What it
// leaves is as the test has it, and so is what comes out from behind another agent; what stands before it and did
// before stays.
void put_in(const AgentPictures& agent, const Motion& motion, double farther, const Range& range, Layer& now);

}  // namespace crowdbench::metrics
