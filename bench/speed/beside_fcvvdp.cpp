#include "bench/speed/contest.h"

#ifdef CROWDBENCH_BESIDE_FCVVDP
#include <cvvdp.h>
#include <fmt/format.h>

#include <memory>

#include "core/error.h"
#include "metrics/cvvdp/cvvdp.h"

namespace crowdbench::bench {
namespace {

constexpr float kFps = 30;

void check(FcvvdpError status) {
  if (status != CVVDP_OK) throw Error("fcvvdp", cvvdp_error_string(status), "try other pictures");
}

FcvvdpImage image_of(const Image8& image) {
  return {image.width,          image.height, 3 * image.width, image.data.data(), CVVDP_PIXEL_FORMAT_RGB_UINT8,
          CVVDP_COLORSPACE_SRGB};
}

std::string jod_text(double jod) { return fmt::format("{:.4f}", jod); }

// A clip without an end, of one pair: a run is one frame more. Filled first, so that a run is one of the steady state.
// What it finds is of as many frames as there were, and not compared: the clip's row is a speed alone.
struct TheirClip {
  FcvvdpCtx* context = nullptr;
  FcvvdpImage reference, test;

  TheirClip(const Image8& a, const Image8& b) : reference(image_of(a)), test(image_of(b)) {
    check(cvvdp_create(a.width, a.height, kFps, CVVDP_DISPLAY_STANDARD_4K, 1, nullptr, &context));
    for (int i = 0; i < 10; ++i) take();
  }
  ~TheirClip() { cvvdp_destroy(context); }
  TheirClip(const TheirClip&) = delete;
  TheirClip& operator=(const TheirClip&) = delete;
  void take() {
    FcvvdpResult result{};
    check(cvvdp_process_frame(context, &reference, &test, &result));
  }
};

std::string their_picture(const Image8& a, const Image8& b) {
  const FcvvdpImage reference = image_of(a);
  const FcvvdpImage test = image_of(b);
  FcvvdpResult result{};
  check(cvvdp_compare_images(&reference, &test, CVVDP_DISPLAY_STANDARD_4K, 1, nullptr, &result));
  return jod_text(result.jod);
}

std::shared_ptr<metrics::Cvvdp> our_clip(const Image8& reference, const Image8& test) {
  metrics::CvvdpOptions options;
  options.fps = kFps;
  auto out = std::make_shared<metrics::Cvvdp>(metrics::default_display(), options);
  for (int i = 0; i < 10; ++i) out->take(reference, test);
  return out;
}

}  // namespace

void add_fcvvdp(std::vector<Duel>& to, const Image8& reference, const Image8& test) {
  to.push_back(
      {"ColorVideoVDP of a picture",
       {"ours", [&] { return jod_text(metrics::cvvdp(reference, test, metrics::default_display()).jod); }, "", {}},
       {"halidecx/fcvvdp " CROWDBENCH_BESIDE_FCVVDP ", C", [&] { return their_picture(reference, test); }, "", {}},
       2});
  const auto theirs = std::make_shared<TheirClip>(reference, test);
  const auto ours = our_clip(reference, test);
  to.push_back({"ColorVideoVDP of a frame of a clip at 30/s",
                {"ours",
                 [ours, &reference, &test] {
                   ours->take(reference, test);
                   return std::string("-");
                 },
                 "",
                 {}},
                {"halidecx/fcvvdp " CROWDBENCH_BESIDE_FCVVDP ", C",
                 [theirs] {
                   theirs->take();
                   return std::string("-");
                 },
                 "",
                 {}},
                2});
}

}  // namespace crowdbench::bench
#else
namespace crowdbench::bench {
void add_fcvvdp(std::vector<Duel>&, const Image8&, const Image8&) {}
}  // namespace crowdbench::bench
#endif
