// What the pages are put together from: charts, pictures, lists of them.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "reports/page/html_template.h"

namespace crowdbench::reports {

// A chart with its heading; specification: Vega-Lite as JSON text. number: unique on the page.
Html chart_block(std::string_view specification, std::string_view title, int number);

// A picture with a caption. png: the bytes of the file; alt: plain text.
Html figure_block(int width, int height, const std::vector<uint8_t>& png, std::string_view alt, Html caption);

// A list for a template: each row has the one value `html`.
std::vector<TemplateValues> html_rows(std::vector<Html> blocks);

}  // namespace crowdbench::reports
