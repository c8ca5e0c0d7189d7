// Many tests at once: p values adjusted so that a level holds for all of them together. Pure functions.
#pragma once
#include <span>
#include <vector>

namespace crowdbench {

// What is held when several p values are judged at one level.
enum class Correction {
  none,                // each test by itself: the chance of some false alarm grows with their number
  holm,                // the chance of even one false alarm (family-wise error), whatever the dependence of the tests
  benjamini_hochberg,  // the expected share of false alarms among all alarms (false discovery rate); independent tests,
                       // or positively dependent ones
};

// Adjusted p values, in the order given: test i is rejected at level alpha where adjusted[i] <= alpha.
// p: each in [0, 1], any order, equal ones allowed; none gives none. Adjusted values are at most 1 and at least p.
std::vector<double> adjusted_p_values(std::span<const double> p, Correction correction);

// The two by name.
std::vector<double> holm(std::span<const double> p);
std::vector<double> benjamini_hochberg(std::span<const double> p);

}  // namespace crowdbench
