#include "bench/experiments/tune_pictures.h"

#include <algorithm>

#include "bench/experiments/tune_measure.h"
#include "metrics/pseudocolour.h"
#include "metrics/silhouette.h"

namespace crowdbench::bench {

std::vector<TuneSwitchPictures> draw_switches(gl::Context& context, const TuneRequest& request,
                                              const TuneAnswer& answer) {
  std::vector<TuneSwitchPictures> out;
  for (const TuneSwitch& one : answer.switches) {
    const TuneSubject& subject = request.subjects[one.pop.subject];
    TuneSwitchPictures drawn;
    drawn.subject = one.pop.subject;
    drawn.view = tune_views(request.blocks, subject, request.seed)[one.pop.block];
    drawn.view.height_px = one.height_px;
    drawn.pop = one.pop.worst;
    QualitySetup setup;
    setup.character = subject.character;
    setup.representations = {request.candidates[one.change.from].text(), request.candidates[one.change.to].text()};
    setup.views = {drawn.view};
    setup.antialiasing = request.cost.antialiasing;
    setup.bake_budget = request.cost.bake_budget;
    setup.use_cache = request.cost.use_cache;
    setup.display = request.display;
    setup.table = {&request.pop.score, 1};
    std::vector<renderers::Capture> captures;
    compute_quality(context, setup,
                    [&](const QualityRow&, const QualityPictures& pictures) { captures.push_back(pictures.test); });
    const renderers::Capture& before = captures[0];
    const renderers::Capture& after = captures[1];
    if (const auto box = metrics::crop_box(metrics::mask_of(before.ids), metrics::mask_of(after.ids), 6)) {
      drawn.before = metrics::crop(before.colour, *box);
      drawn.after = metrics::crop(after.colour, *box);
      drawn.difference = metrics::crop(metrics::pseudocolour(metrics::error_levels(before.colour, after.colour)), *box);
    }
    out.push_back(std::move(drawn));
  }
  return out;
}

}  // namespace crowdbench::bench
