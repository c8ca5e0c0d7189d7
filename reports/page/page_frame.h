// What every page of the reports begins and ends with, so that all of them open without a network and look alike.
#pragma once
#include <string>
#include <string_view>

#include "reports/page/html_template.h"

namespace crowdbench::reports {

// The whole document around its content: style sheet, heading, footer, the chart library with its licences, the page's
// script. title: plain text. source: the file that the page was made from, or empty. Throws Error when the program was
// built without the chart library.
std::string page_frame(std::string_view title, Html content, std::string_view source);

}  // namespace crowdbench::reports
