// QUEST+: chooses the next stimulus of an adaptive measurement so that the answer is expected to tell most, and keeps
// what is known of the observer as a posterior over a grid of parameters.
#pragma once
#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

namespace crowdbench::studies {

// P(yes) = guess + (1 - guess - lapse) F:
//   weibull_db     F = 1 - exp(-10^(slope (x - threshold) / 20)), x in decibel
//   weibull_log10  F = 1 - exp(-10^(slope (x - threshold))), x a decadic logarithm
//   normal         F = Phi((x - threshold) / slope): threshold is the mean and slope the standard deviation
//   logistic       F = 1 / (1 + exp(-(x - threshold) / slope))
enum class QuestFunction { weibull_db, weibull_log10, normal, logistic };

struct QuestSettings {
  QuestFunction function = QuestFunction::normal;
  bool falling = false;         // 1 - F in place of F: seen less often where x is larger
  std::vector<double> stimuli;  // what may be shown
  // The grid: values of each parameter, one where it is known. All combinations, uniform before the first answer.
  std::vector<double> threshold, slope, guess, lapse;
};

class QuestPlus {
 public:
  // All lists not empty; guess + lapse below 1.
  explicit QuestPlus(const QuestSettings& settings);

  struct Choice {
    size_t stimulus = 0;          // of settings.stimuli; the first of equally good ones
    double expected_entropy = 0;  // of the posterior after the answer, in nats
  };
  Choice next() const;
  // Of every stimulus, were it shown next.
  std::vector<double> expected_entropies() const;
  // An answer that no point of the grid allows (a "yes" where P(yes) is 0 at all of them) tells nothing.
  void answer(size_t stimulus, bool yes);
  // To a trial with nothing to see, where yes is a guess: P(yes) = guess.
  void answer_to_nothing(bool yes);

  // Of threshold, slope, guess and lapse.
  using Parameters = std::array<double, 4>;
  Parameters mean() const;
  Parameters sd() const;
  Parameters mode() const;  // the grid point of the highest posterior, the first of equals
  std::vector<double> marginal(size_t parameter) const;
  double entropy() const;

  double psi(size_t stimulus, size_t point) const { return yes_[stimulus * points_ + point]; }

 private:
  size_t index_of(size_t point, size_t parameter) const;
  template <typename Likelihood>
  void update(const Likelihood& of_yes, bool yes);

  std::array<std::vector<double>, 4> grid_;
  size_t points_ = 0;
  size_t stimuli_ = 0;
  std::vector<double> posterior_;         // by grid point, the last parameter fastest
  std::vector<double> yes_;               // P(yes) by stimulus and grid point
  std::vector<double> yes_log_, no_log_;  // p log p of it, and of the answer no
};

}  // namespace crowdbench::studies
