// What every page of the reports begins and ends with, so that all of them open without a network and look alike.
#pragma once
#include <string>
#include <string_view>

namespace crowdbench::reports {

// From the document's type to the page's heading. title: plain text.
std::string page_head(std::string_view title);
// Footer, the chart library with its licences, the page's script, and the end of the document. source: the file that
// the page was made from, or empty. Throws Error when the program was built without the chart library.
std::string page_foot(std::string_view source);

// A chart with its heading; specification: Vega-Lite as JSON text. number: unique on the page.
std::string chart_block(std::string_view specification, std::string_view title, int number);

}  // namespace crowdbench::reports
