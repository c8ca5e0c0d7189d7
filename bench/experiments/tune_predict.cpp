#include "bench/experiments/tune_predict.h"

#include <cmath>

#include "core/error.h"

namespace crowdbench::bench {

TunePrediction predict(gl::Context& context, const TuneRequest& request, const TuneSubject& subject,
                       const renderers::Spec& candidate) {
  scene::Cast cast;
  cast.characters = {subject.character};
  cast.banks = {std::make_shared<const scene::PoseBank>(*subject.character, std::vector<int>{subject.clip}, 30)};
  cast.shares = {1.0};
  renderers::MakeContext make{.context = context, .cast = cast};
  make.bake_budget = request.cost.bake_budget;
  make.use_cache = request.cost.use_cache;
  TunePrediction out;
  try {
    const auto representation = renderers::make_representation(make, candidate);
    out.texel = representation->texel_metres(0);
    for (const auto& [name, value] : representation->bake_info().facts)
      if (name == "error_max_mm") out.error = value / 1000;
  } catch (const Error&) {  // refused: the tuning says why
  }
  return out;
}

double pixels_spanned(double metres, const TuneSubject& subject, double height_px) {
  return metres * height_px / subject.character->placement.height;
}

std::optional<double> height_of_one_pixel(double metres, const TuneSubject& subject) {
  if (!(metres > 0)) return std::nullopt;
  return subject.character->placement.height / metres;
}

}  // namespace crowdbench::bench
