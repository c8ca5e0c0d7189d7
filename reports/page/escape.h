// Text made fit for the place in a page where it stands.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace crowdbench::reports {

// Text for an HTML element or a quoted attribute.
std::string html_escape(std::string_view text);
// JSON for the inside of a <script>: every `<` becomes \u003c.
std::string script_json(std::string_view json);
// Script text that may stand inside <script> ... </script>: no end tag, no comment opening, no source map address.
std::string inline_script(std::string_view script);
// Text for the inside of an HTML comment: no two hyphens stand side by side.
std::string comment_text(std::string_view text);
// RFC 4648, with padding.
std::string base64(const std::vector<uint8_t>& bytes);

}  // namespace crowdbench::reports
