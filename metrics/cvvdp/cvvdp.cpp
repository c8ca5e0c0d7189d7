// Based on: see cvvdp.h.
#include "metrics/cvvdp/cvvdp.h"

#include <algorithm>
#include <optional>
#include <thread>

#include "core/error.h"
#include "metrics/cvvdp/window.h"
#include "metrics/not_finite.h"
#include "metrics/sizes.h"

namespace crowdbench::metrics {

using namespace vdp;

namespace {

unsigned thread_count(unsigned wanted) {
  return wanted > 0 ? wanted : std::clamp(std::thread::hardware_concurrency(), 1U, 8U);
}

}  // namespace

double cvvdp_jod(double q) { return jod_of(q); }

std::string cvvdp_obstacle(int width, int height) {
  if (std::min(width, height) >= 2) return {};
  return "a side is below 2 pixels";
}

std::string cvvdp_obstacle(const ImageF& reference, const ImageF& test) {
  const std::string text = not_finite_text(not_finite(reference), not_finite(test));
  if (!text.empty()) return text;
  return cvvdp_obstacle(reference.width, reference.height);
}

class Cvvdp::State {
 public:
  State(const Display& display, CvvdpOptions options)
      : display_(display), options_(std::move(options)), threads_(thread_count(options_.threads)), colours_(display) {}

  template <typename T>
  void take(const Image<T>& reference, const Image<T>& test);
  CvvdpResult finish();
  size_t frames() const { return frames_; }

 private:
  void require_next(int width, int height) const;
  void begin_clip();
  void compare_until(size_t frames);
  void compare(const FramePlanes& planes, FrameComparison& comparison);

  Display display_;
  CvvdpOptions options_;
  unsigned threads_;
  OpponentColours colours_;
  size_t frames_ = 0;  // taken
  int width_ = 0, height_ = 0;
  std::array<OpponentPlanes, 2> first_;  // until a second frame makes it a clip
  std::optional<FrameWindow> window_;
  std::optional<FrameComparison> comparison_;
  FramePlanes channels_;  // of the frame that is compared
  std::vector<FrameQ> q_;
};

void Cvvdp::State::require_next(int width, int height) const {
  if (frames_ == 0) {
    const std::string obstacle = cvvdp_obstacle(width, height);
    if (!obstacle.empty()) throw Error({}, obstacle, "compare pictures of at least 2 x 2 pixels");
    return;
  }
  if (width != width_ || height != height_)
    throw Error({}, fmt::format("frame {} is {} x {}, those before {} x {}", frames_, width, height, width_, height_),
                "compare clips of one size");
  if (!(options_.fps > 0 && options_.fps <= 1000))
    throw Error({}, "a clip is compared without its frame rate", "give it, above 0 and at most 1000 per second");
}

template <typename T>
void Cvvdp::State::take(const Image<T>& reference, const Image<T>& test) {
  require_same_size(reference, test);
  require_next(reference.width, reference.height);
  width_ = reference.width;
  height_ = reference.height;
  if (frames_ == 1) begin_clip();
  std::array<OpponentPlanes, 2>& place = frames_ == 0 ? first_ : window_->place(frames_);
  colours_.planes(test, place[0], threads_);
  colours_.planes(reference, place[1], threads_);
  ++frames_;
  const size_t needed = options_.padding == Padding::replicate ? 2 : window_ ? window_->length() : 2;
  if (frames_ >= needed) compare_until(frames_);
}

void Cvvdp::State::begin_clip() {
  window_.emplace(options_.fps, options_.padding);
  window_->place(0) = std::move(first_);
  comparison_.emplace(width_, height_, display_.pixels_per_degree, kChannels, threads_);
}

void Cvvdp::State::compare_until(size_t frames) {
  while (q_.size() < frames) {
    window_->filter(q_.size(), frames, channels_, threads_);
    compare(channels_, *comparison_);
  }
}

void Cvvdp::State::compare(const FramePlanes& planes, FrameComparison& comparison) {
  FloatPlane map;
  q_.push_back(comparison.compare(planes, options_.map ? &map : nullptr));
  if (!options_.map) return;
  CvvdpMap out;
  out.q = frame_difference(q_.back());
  out.jod = ImageF(map.width, map.height, 1);
  std::copy(map.data.begin(), map.data.end(), out.jod.data.begin());
  options_.map(q_.size() - 1, std::move(out));
}

CvvdpResult Cvvdp::State::finish() {
  if (frames_ == 0) throw Error({}, "there is no picture to compare", "show at least one");
  const bool still = frames_ == 1;
  if (still) {
    comparison_.emplace(width_, height_, display_.pixels_per_degree, kStillChannels, threads_);
    for (size_t p = 0; p < 2; ++p)
      for (size_t c = 0; c < kStillChannels; ++c) channels_[p][c] = std::move(first_[p][c]);
    compare(channels_, *comparison_);
  } else {
    compare_until(frames_);
  }
  CvvdpResult result;
  result.still = still;
  result.frequencies = comparison_->frequencies();
  for (const FrameQ& q : q_) result.frame_q.push_back(frame_difference(q));
  result.q = pooled(result.frame_q, still);
  result.jod = jod_of(result.q);
  for (size_t c = 0; c < q_[0].size(); ++c) {
    std::vector<double> alone;
    for (const FrameQ& q : q_) alone.push_back(channel_difference(q, c));
    result.channel_q.push_back(pooled(alone, still));
  }
  result.by_frame = std::move(q_);
  return result;
}

Cvvdp::Cvvdp(const Display& display, CvvdpOptions options)
    : state_(std::make_unique<State>(display, std::move(options))) {}
Cvvdp::~Cvvdp() = default;

void Cvvdp::take(const Image8& reference, const Image8& test) { state_->take(reference, test); }
void Cvvdp::take(const Image16& reference, const Image16& test) { state_->take(reference, test); }
void Cvvdp::take(const ImageF& reference, const ImageF& test) {
  require_same_size(reference, test);
  const std::string obstacle = cvvdp_obstacle(reference, test);
  if (!obstacle.empty()) throw Error({}, obstacle, "compare finite pictures of at least 2 x 2 pixels");
  state_->take(reference, test);
}
size_t Cvvdp::frames() const { return state_->frames(); }
CvvdpResult Cvvdp::finish() { return state_->finish(); }

namespace {

template <typename T>
CvvdpResult of_pair(const Image<T>& reference, const Image<T>& test, const Display& display, CvvdpOptions options) {
  Cvvdp one(display, std::move(options));
  one.take(reference, test);
  return one.finish();
}

}  // namespace

CvvdpResult cvvdp(const Image8& reference, const Image8& test, const Display& display, CvvdpOptions options) {
  return of_pair(reference, test, display, std::move(options));
}
CvvdpResult cvvdp(const Image16& reference, const Image16& test, const Display& display, CvvdpOptions options) {
  return of_pair(reference, test, display, std::move(options));
}
CvvdpResult cvvdp(const ImageF& reference, const ImageF& test, const Display& display, CvvdpOptions options) {
  return of_pair(reference, test, display, std::move(options));
}

}  // namespace crowdbench::metrics
