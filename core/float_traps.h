// Floating-point faults that end the program: an invalid operation (0/0, inf - inf, the root of a negative number, a
// value that no integer holds) and a division of a number by zero. Tests of core, truth and metrics, and the bakes that
// are fuzzed, run under them in sanitizer builds; a NaN that was given is carried on, as no operation makes it.
//
// Per thread; threads begin as their maker is. A driver's code is never run under them: vertex stages divide as they
// like.
#pragma once

namespace crowdbench {

// Whether this build and machine trap: sanitizer builds, where the processor can (x86 with glibc).
bool float_traps_work();

// While it lives this thread has the traps; without effect where they do not work. What happened before is forgotten.
class FloatTraps {
 public:
  FloatTraps();
  ~FloatTraps();
  FloatTraps(const FloatTraps&) = delete;
  FloatTraps& operator=(const FloatTraps&) = delete;

 private:
  int before_;
};

// A named place: while it lives this thread has none. Where a fault's result is meant, which a comment there says.
class FloatFaultsMeant {
 public:
  FloatFaultsMeant();
  ~FloatFaultsMeant();
  FloatFaultsMeant(const FloatFaultsMeant&) = delete;
  FloatFaultsMeant& operator=(const FloatFaultsMeant&) = delete;

 private:
  int before_;
};

}  // namespace crowdbench
