// The report: one self-contained HTML page that opens without a network.
#pragma once
#include <string>
#include <string_view>

#include "store/store.h"

namespace crowdbench::reports {

struct PageOptions {
  std::string source;  // the result file's name, for the footer
};
// The page's bytes, UTF-8. Everything is inside: data, pictures (PNG as data URIs), the chart library. The page's own
// content security policy forbids it to load anything. contents: read with pictures. Throws Error when the program was
// built without the chart library, or when the file holds no measurement.
std::string report_page(const StoreContents& contents, const PageOptions& options = {});

// Text for an HTML element or a quoted attribute.
std::string html_escape(std::string_view text);
// JSON for the inside of a <script>: every `<` becomes \u003c.
std::string script_json(std::string_view json);
std::string base64(const std::vector<uint8_t>& bytes);

}  // namespace crowdbench::reports
