#include "bench/stage/truth_capture.h"

#include <fmt/format.h>

namespace crowdbench::bench {

renderers::Capture capture_of(const truth::TruthPicture& picture, const renderers::CaptureOptions& options) {
  renderers::Capture out;
  out.colour = picture.colour;
  if (options.linear) out.linear = picture.linear;
  out.depth = ImageF(picture.depth.width, picture.depth.height, 1);
  for (size_t i = 0; i < out.depth.data.size(); ++i) out.depth.data[i] = static_cast<float>(picture.depth.data[i]);
  out.ids = picture.ids;
  return out;
}

Json judgement_json(const truth::Judgement& judgement, const std::string& judged) {
  Json offenders = Json::array();
  for (const truth::JudgedPixel& pixel : judgement.offenders)
    offenders.push_back(
        {{"x", pixel.x}, {"y", pixel.y}, {"id", pixel.id}, {"truth_id", pixel.truth_id}, {"bound_px", pixel.bound}});
  return {{"judged", judged},
          {"pixels", judgement.pixels},
          {"covered", judgement.covered},
          {"wrong", judgement.wrong},
          {"outline", judgement.outline},
          {"depth", judgement.depth},
          {"mask", judgement.mask},
          {"unexplained", judgement.unexplained},
          {"worst_distance_px", judgement.worst_distance},
          {"largest_bound_px", judgement.largest_bound},
          {"inner", judgement.inner},
          {"worst_depth", judgement.worst_depth},
          {"mean_colour", judgement.mean_colour},
          {"worst_colour", judgement.worst_colour},
          {"offenders", offenders}};
}

std::string judgement_line(const truth::Judgement& j, const std::string& judged) {
  return fmt::format(
      "{}: {} of {} pixels show another agent than the truth: {} within {:.4f} pixels of an outline, {} by depth, {} "
      "by "
      "masks, {} unexplained; inside, colours are off by {:.2f} code values in the mean",
      judged, j.wrong, j.pixels, j.outline, j.largest_bound, j.depth, j.mask, j.unexplained, j.mean_colour);
}

}  // namespace crowdbench::bench
