#include "core/float_traps.h"

#include <cfenv>  // says, too, whether this is glibc

#include "core/sanitizer.h"

#if CROWDBENCH_HAS_SANITIZER && defined(__GLIBC__) && defined(__x86_64__)
#define CROWDBENCH_TRAPS 1
#else
#define CROWDBENCH_TRAPS 0
#endif

namespace crowdbench {
namespace {

#if CROWDBENCH_TRAPS
constexpr int kFaults = FE_INVALID | FE_DIVBYZERO;

// To these and no others of kFaults; what was raised before would trap at once. Returns those of before.
int set_traps(int faults) {
  const int before = fegetexcept() & kFaults;
  feclearexcept(kFaults);
  fedisableexcept(kFaults & ~faults);
  feenableexcept(faults);
  return before;
}
#else
constexpr int kFaults = 0;
int set_traps(int /*faults*/) { return 0; }
#endif

}  // namespace

bool float_traps_work() { return CROWDBENCH_TRAPS != 0; }

FloatTraps::FloatTraps() : before_(set_traps(kFaults)) {}
FloatTraps::~FloatTraps() { set_traps(before_); }

FloatFaultsMeant::FloatFaultsMeant() : before_(set_traps(0)) {}
FloatFaultsMeant::~FloatFaultsMeant() { set_traps(before_); }

}  // namespace crowdbench
