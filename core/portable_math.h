// Sine and cosine from + - * / alone, so that a crowd has the same bytes on every x86-64 machine (libm differs by
// version).
#pragma once

namespace crowdbench {

struct SinCos {
  double sin;
  double cos;
};

// turns: an angle in turns (1 = 360 degrees), any finite value up to about 2^40. Absolute error below 1e-15.
SinCos sincos_turns(double turns);

}  // namespace crowdbench
