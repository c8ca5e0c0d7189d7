// Comma-separated values, as RFC 4180 has them.
#pragma once
#include <string>
#include <string_view>

namespace crowdbench {

// A field: quoted where it holds a comma, a quotation mark or the end of a line, or begins or ends with a blank, which
// readers would take away.
std::string csv_field(std::string_view text);

}  // namespace crowdbench
