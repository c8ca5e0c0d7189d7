#include "bench/experiments/quality_rows.h"

#include "bench/experiments/bench_run.h"
#include "bench/experiments/score_rows.h"
#include "metrics/silhouette.h"

namespace crowdbench::bench {

ComparisonRow quality_row(int64_t run, const QualitySubject& subject, const QualityRow& row,
                          const metrics::ChosenDisplay& display) {
  ComparisonRow out;
  out.run = run;
  out.kind = "agent";
  out.representation = row.representation;
  out.reference = row.reference;
  out.character = subject.character;
  out.height_px = row.view.height_px;
  out.azimuth_deg = row.view.azimuth_deg;
  out.elevation_deg = row.view.elevation_deg;
  out.clip = subject.clip;
  out.time = row.view.time;
  out.scores = score_rows(row.scores.scores);
  put_display(out, display);
  return out;
}

void write_quality_pictures(StoreWriter& store, int64_t run, int64_t comparison, const QualityRow& row,
                            const QualityPictures& pictures) {
  const auto box = metrics::crop_box(metrics::mask_of(pictures.reference.ids), metrics::mask_of(pictures.test.ids), 8);
  if (!box) return;
  write_pictures(store, run, comparison, metrics::crop(pictures.reference.colour, *box),
                 metrics::crop(pictures.test.colour, *box), row.reference, row.representation, false);
}

}  // namespace crowdbench::bench
