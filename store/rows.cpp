#include "store/rows.h"

#include <fmt/format.h>

#include "core/error.h"

namespace crowdbench {

const char* status_name(Status status) {
  switch (status) {
    case Status::valid: return "valid";
    case Status::invalid: return "invalid";
    case Status::unreachable: return "unreachable";
    case Status::skipped: return "skipped";
    case Status::stopped: return "stopped";
  }
  return "invalid";
}

Status status_of(const std::string& name) {
  for (const Status status : kStatuses)
    if (name == status_name(status)) return status;
  throw Error("status", fmt::format("'{}' is not a status", printable(name)));
}

}  // namespace crowdbench
