// How far a bake has come.
#pragma once
#include <cstddef>
#include <functional>
#include <vector>

namespace crowdbench::renderers {

// Told after each piece of the work; total is the same in all calls. May throw (Interrupted, after Ctrl-C); empty where
// nobody asks.
using BakeProgress = std::function<void(size_t done, size_t total)>;

// The progress of a bake whose steps count different things, as one count of kTotal. It never goes back.
class BakeSteps {
 public:
  static constexpr size_t kTotal = 1000;
  // weights: of each step, about its share of the time; 0 or more. Says at once that nothing is done.
  BakeSteps(BakeProgress progress, const std::vector<double>& weights);
  // What the step is to tell: 0 of its total as it begins. All steps before it count as done, whether they came or not.
  // Not to outlive the steps.
  BakeProgress of(size_t step);
  void end();  // all of them are done

 private:
  void report(double share);
  BakeProgress progress_;
  std::vector<double> begins_;  // of each step, and of the end, which is 1: shares of the whole
  size_t done_ = 0;
};

}  // namespace crowdbench::renderers
