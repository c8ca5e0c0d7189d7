// Numbers of things, in sentences.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace crowdbench {

// "1 trial", "12 trials", "0 trials".
std::string counted(uint64_t count, std::string_view one, std::string_view many);

}  // namespace crowdbench
