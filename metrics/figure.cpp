#include "metrics/figure.h"

#include "metrics/sizes.h"

namespace crowdbench::metrics {
namespace {

// Buffers of their own, cut to a box.
struct Cut {
  Image8 codes;
  ImageU32 ids;
  ImageF depth;

  Cut(const Buffers& from, const Box& box) : codes(crop(*from.codes, box)), ids(crop(*from.ids, box)) {
    if (from.depth) depth = crop(*from.depth, box);
  }
  Buffers buffers() const {
    Buffers out;
    out.codes = &codes;
    out.ids = &ids;
    if (!depth.empty()) out.depth = &depth;
    return out;
  }
};

}  // namespace

std::optional<double> FigureScores::value(std::string_view name) const {
  for (const Scored& one : scores)
    if (one.score->name == name) return one.result.value;
  return std::nullopt;
}

FigureScores score_figure(ScoreTable table, const Buffers& reference, const Buffers& test,
                          const FigureOptions& options) {
  require_same_size(*reference.codes, *test.codes);
  require_same_size(*reference.codes, *reference.ids);
  FigureScores out;
  const Mask a = mask_of(*reference.ids);
  const Mask b = mask_of(*test.ids);
  out.box = crop_box(a, b);
  if (!out.box) {
    ScoreInput whole{reference, test};
    if (options.display) look_at(*options.display, whole);
    out.scores = absent_scores(table, given(whole) | kNeedsRegion, "nothing is drawn in either picture");
    return out;
  }
  const Cut cut_reference(reference, *out.box);
  const Cut cut_test(test, *out.box);
  const Mask either = crop(union_of(a, b), *out.box);
  ScoreInput input{cut_reference.buffers(), cut_test.buffers()};
  input.region = &either;
  if (options.display) look_at(*options.display, input);
  input.maps = options.maps;
  Shared shared;
  out.scores = score_pictures(table, input, shared);
  return out;
}

}  // namespace crowdbench::metrics
