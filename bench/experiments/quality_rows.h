// The rows of the result store that a view of `quality` becomes.
#pragma once
#include <cstdint>
#include <string>

#include "bench/experiments/quality.h"
#include "store/store.h"

namespace crowdbench::bench {

// What is compared, as rows call it.
struct QualitySubject {
  std::string character;
  std::string clip;  // its name; "none" for the bind pose
};

// A comparison of kind "agent". display: that the scores were computed on.
ComparisonRow quality_row(int64_t run, const QualitySubject& subject, const QualityRow& row,
                          const metrics::ChosenDisplay& display);

// The pictures of a comparison that was written, cut to both figures: reference, test and difference. Nothing where
// neither picture shows one.
void write_quality_pictures(StoreWriter& store, int64_t run, int64_t comparison, const QualityRow& row,
                            const QualityPictures& pictures);

}  // namespace crowdbench::bench
