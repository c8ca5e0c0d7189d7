#pragma once
#include <string_view>

namespace crowdbench {
std::string_view version();       // "0.1.0"
std::string_view git_revision();  // `git describe --always --dirty` at configure time, or "unknown"
}  // namespace crowdbench
