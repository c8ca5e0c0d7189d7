#include "core/counted.h"

#include <fmt/format.h>

namespace crowdbench {

std::string counted(uint64_t count, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

}  // namespace crowdbench
