// What cases are measured with: a context, casts with their representations made once, frames, and how two pictures
// differ.
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "bench/stability/stability.h"
#include "renderers/frame/capture.h"
#include "renderers/frame/depth_storage.h"
#include "renderers/gl/context.h"
#include "scene/cast/cast.h"
#include "scene/crowd/crowd.h"

namespace crowdbench::bench {

struct DepthTruth;  // depth_truth.h

class Fixture {
 public:
  // small, full: as StabilityRequest has them.
  Fixture(gl::Context& context, bool small, bool full, bool use_cache);
  ~Fixture();
  Fixture(const Fixture&) = delete;
  Fixture& operator=(const Fixture&) = delete;

  // Whom cases are asked of from now on. Drops what was made for another.
  void ask(const renderers::Spec& spec);
  const renderers::Spec& asked() const { return spec_; }
  const renderers::RepresentationType& type() const;
  // Whether the representation asked draws stored views of the character, and so claims no surface near by.
  bool stores_views() const { return type().view_sampling != nullptr; }
  // A side of a picture: fewer pixels in the small form.
  int side(int pixels) const { return small_ ? pixels / 2 : pixels; }
  bool small() const { return small_; }
  bool full() const { return full_; }
  gl::Context& context() { return context_; }

  // The mannequin of 500 triangles in its walk: what most cases show.
  const scene::Cast& walker();
  // What is asked about, drawing the walker. Made at the first use.
  renderers::Representation& representation();
  // The reference, drawing the walker.
  renderers::Representation& mesh();
  // linear: also Capture::linear, where a colour that is not a number shows.
  renderers::Capture draw(const scene::Frame& frame, bool linear = false);
  renderers::Capture draw_mesh(const scene::Frame& frame);
  // What is asked about, drawing the walker into another depth buffer than every other picture.
  renderers::Capture draw_stored(const scene::Frame& frame, const renderers::DepthStorage& storage);
  // What the cases of depth buffers are held against, made by the first of them.
  std::shared_ptr<const DepthTruth>& depth_truth() { return depth_truth_; }
  // Stands for what is asked about, drawing the walker, until the next ask(): for tests that plant a fault.
  void replace(std::unique_ptr<renderers::Representation> representation);

 private:
  gl::Context& context_;
  bool small_, full_, use_cache_;
  renderers::Spec spec_;
  std::optional<scene::Cast> walker_;
  std::unique_ptr<renderers::Renderer> renderer_;
  std::unique_ptr<renderers::Representation> representation_, mesh_;
  std::shared_ptr<const DepthTruth> depth_truth_;
};

// ---- frames

// Looks from `eye` to `target`, without agents, one white outfit. fov_deg: vertical.
scene::Frame empty_frame(const glm::dvec3& eye, const glm::dvec3& target, double fov_deg, int width, int height);
// clip: of the bank. heading in turns. ids count from 1.
void add_agent(scene::Frame& frame, const scene::Cast& cast, const glm::dvec3& place, double phase = 0,
               double heading_turns = 0, double scale = 1);

// ---- pictures

// The largest difference of a channel, code values of 8 bits, and where: fills measured, place, expected, got and the
// enlarged surroundings. Pictures of one size. `bound` is the caller's.
Found largest_difference(const Image8& expected, const Image8& got);
// The surroundings of a pixel, enlarged 16 times, the pixel itself framed. RGB.
Image8 enlarged(const Image8& picture, int x, int y);

// Pixels that no picture may have: a colour that is no finite number (where `linear` was captured), a depth that is
// neither infinite nor in [near, far] (to a float's spacing at its place), or that is infinite where an agent's id
// stands, an id of nobody in the frame.
struct Insane {
  uint64_t pixels = 0;
  int x = 0, y = 0;  // the first
  std::string what;  // of it
};
Insane insane_pixels(const renderers::Capture& capture, const scene::Frame& frame);

// How far from a smooth change two pictures of neighbouring moments are. Changed: a channel differs by more than
// `kSeen` code values.
inline constexpr int kSeen = 16;
struct StepChange {
  uint64_t changed = 0;  // pixels
  uint64_t edges = 0;    // neighbours in the first picture, right or below, that differ by more than kSeen
  int x = 0, y = 0;      // the largest change
};
StepChange step_change(const Image8& before, const Image8& after);
// What a picture may change by when its content moves `pixels` at most: every edge crosses the centre of a pixel with
// that probability on each of its two sides, so 2 x edges x pixels in the mean; the bound is six standard deviations of
// a Poisson count above, and 3 for counts near none.
double step_bound(uint64_t edges, double pixels);

}  // namespace crowdbench::bench
