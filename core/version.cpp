#include "core/version.h"

namespace crowdbench {
std::string_view version() { return CROWDBENCH_VERSION; }
std::string_view git_revision() { return CROWDBENCH_REVISION; }
}  // namespace crowdbench
