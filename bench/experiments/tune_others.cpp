#include "bench/experiments/tune_others.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "bench/experiments/tune_measure.h"

namespace crowdbench::bench {
namespace {

// Of one number of every character, and its interval.
template <typename Number>
double mean_of(const std::vector<CharacterDrawn>& some, Number number, Interval& interval, double least_variance = 0) {
  std::vector<double> values;
  double sum = 0;
  for (const CharacterDrawn& one : some) {
    values.push_back(number(one));
    sum += values.back();
  }
  interval = prediction_interval(values, least_variance);
  return sum / static_cast<double>(values.size());
}

}  // namespace

std::string no_promise_of_others(const TuneRequest& request) {
  if (request.budget_ns > 0) return "a rule within a budget is of the crowd that it was sought for";
  if (request.subjects.size() >= kLeastCharacters) return {};
  return fmt::format("{} tuned, and what differs between characters is known from {} on",
                     request.subjects.size() == 1 ? "one character was" : "two characters were", kLeastCharacters);
}

CharacterDrawn draw_character(gl::Context& context, const TuneRequest& tuned, const TuneProofRequest& request,
                              const TuneSubject& subject, const std::vector<uint64_t>& seeds) {
  assert(!seeds.empty());
  CharacterDrawn out;
  out.character = subject.character->name;
  out.representation = request.representation.text();
  out.times = time_seeds(context, request, seeds);
  const size_t each = std::max<size_t>(1, kCharacterFigures / seeds.size());
  std::vector<UnseenFigure> all;
  double sum = 0;
  for (size_t i = 0; i < seeds.size(); ++i) {
    sum += std::log(out.times[i].ratio);
    const std::vector<UnseenFigure> figures =
        draw_unseen(context, tuned, subject, request.representation, each, seeds[i]);
    out.scores.push_back(scores_of(*tuned.error.score, seeds[i], figures));
    all.insert(all.end(), figures.begin(), figures.end());
  }
  out.ratio = std::exp(sum / static_cast<double>(seeds.size()));
  const SeedScores together = scores_of(*tuned.error.score, 0, all);
  out.mean = together.mean;
  out.tail = together.tail;
  return out;
}

OthersPromise promised_of_others(const metrics::Score& score, std::vector<CharacterDrawn> left_out) {
  assert(left_out.size() >= kLeastCharacters);
  OthersPromise out;
  Interval logarithm;
  double open = 0;  // what the rounds of one character's seeds leave open, on average
  for (const CharacterDrawn& one : left_out) open += rounds_variance(one.times) / static_cast<double>(left_out.size());
  out.ratio = std::exp(mean_of(
      left_out, [](const CharacterDrawn& one) { return std::log(one.ratio); }, logarithm, open));
  out.ratio_of_another = {std::exp(logarithm.low), std::exp(logarithm.high)};
  out.mean = mean_of(
      left_out, [](const CharacterDrawn& one) { return one.mean; }, out.mean_of_another);
  out.tail = mean_of(
      left_out, [](const CharacterDrawn& one) { return one.tail; }, out.tail_of_another);
  out.mean_of_another = within_range(score, out.mean_of_another);
  out.tail_of_another = within_range(score, out.tail_of_another);
  out.left_out = std::move(left_out);
  return out;
}

OtherProof prove_other(const OthersPromise& promise, CharacterDrawn drawn) {
  OtherProof out;
  out.ratio_within = lies_within(promise.ratio_of_another, drawn.ratio);
  out.mean_within = lies_within(promise.mean_of_another, drawn.mean);
  out.tail_within = lies_within(promise.tail_of_another, drawn.tail);
  out.drawn = std::move(drawn);
  return out;
}

}  // namespace crowdbench::bench
