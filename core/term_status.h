// What a process that SIGTERM ends says to the scheduler that sent it.
#pragma once

namespace crowdbench {

// From now on interrupt_status() (core/progress.h) is this after SIGTERM, and not 143: a scheduler that takes its
// machine back shall see that the work waits to be gone on with. 0: as before. After Ctrl-C nothing changes.
void set_term_status(int status);

}  // namespace crowdbench
