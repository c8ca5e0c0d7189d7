// Numbers and names as the sentences and tables of an analysis write them. For the sources of this folder.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/counted.h"
#include "studies/analysis/visual_angle.h"

namespace crowdbench::studies::text {

using crowdbench::counted;  // not studies::counted, which is of answers
// A name from a file, without control characters; "all" where it is empty.
std::string named(const std::string& name);
std::string percent(uint64_t part, uint64_t whole);  // "29 %"; "-" of nothing
std::string p_text(double p);                        // "0.012", "< 0.001"
std::string number(std::optional<double> value);     // four digits; "-" for none
// "3 to 5"; an end that is not there is open.
std::string ends_text(const std::optional<double>& low, const std::optional<double>& high);

// "1.35 degrees of visual angle (95 % interval 1.1 to 1.7, with the error of calibration, 4 %, of 12 participants)".
std::string angle_text(const AngleThreshold& angle, double confidence);

// A field of a CSV file that is a name: spreadsheets run what begins with = + - @ (or a tab or return before them) as a
// formula, so that an apostrophe stands before it, which they take for "this is text". Numbers stay as they are.
std::string spreadsheet_safe(const std::string& field);

}  // namespace crowdbench::studies::text
