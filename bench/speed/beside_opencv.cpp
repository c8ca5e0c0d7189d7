#include "bench/speed/contest.h"

#ifdef CROWDBENCH_OPENCV_QUALITY
#include <fmt/format.h>

#include <memory>
#include <opencv2/quality/qualityssim.hpp>

#include "metrics/mat.h"
#include "metrics/ssim.h"

namespace crowdbench::bench {
namespace {

struct Planes {
  Image8 reference, test;
};

// Green as bytes, as that module takes it, and as ours takes a plane of luma.
Image8 green_of(const Image8& image) {
  Image8 out(image.width, image.height, 1);
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = image.data[i * static_cast<size_t>(image.channels) + 1];
  return out;
}

}  // namespace

void add_opencv(std::vector<Duel>& to, const Image8& reference, const Image8& test) {
  auto of = std::make_shared<Planes>();
  of->reference = green_of(reference);
  of->test = green_of(test);
  to.push_back({"SSIM of one channel",
                {"ours",
                 [of] {
                   const auto found = metrics::ssim(metrics::luma601(of->reference), metrics::luma601(of->test));
                   return found ? fmt::format("{:.4f}", found->mean) : std::string("not available");
                 },
                 "",
                 {}},
                {"OpenCV " CV_VERSION ", quality module",
                 [of] {
                   return fmt::format("{:.4f}",
                                      cv::quality::QualitySSIM::compute(metrics::view(of->reference),
                                                                        metrics::view(of->test), cv::noArray())[0]);
                 },
                 "",
                 {}},
                1});
}

}  // namespace crowdbench::bench
#else
namespace crowdbench::bench {
void add_opencv(std::vector<Duel>&, const Image8&, const Image8&) {}
}  // namespace crowdbench::bench
#endif
