// What a process says that a fault ends, its own or a driver's.
#pragma once

namespace crowdbench {

// From now on SIGSEGV, SIGBUS, SIGILL, SIGFPE and SIGABRT write one line to stderr before they end the process as they
// would have. Sanitizers say more: in their builds nothing changes.
void install_fatal_signal_line();

}  // namespace crowdbench
