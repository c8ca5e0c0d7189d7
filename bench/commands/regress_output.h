// What `regress` says: a table for a terminal, Markdown for a pull request, JUnit XML for a build server, JSON.
#pragma once
#include <filesystem>
#include <string>

#include "bench/experiments/regress.h"
#include "core/json.h"

namespace crowdbench::bench {

// Every point's time, the scores and pictures that changed, what is missing, the verdict. Points are numbered from 1:
// times, then scores, then pictures; regress_explanation takes these numbers.
std::string regress_text(const RegressReport& report);
std::string regress_markdown(const RegressReport& report);
// A test case a point; worse is a failure, unclear is skipped, with its reason.
std::string regress_junit(const RegressReport& report);
Json regress_json(const RegressReport& report);

// All that is known of the points of a number, or of those whose description holds the text. folder: not empty, and the
// pictures of both sides and their difference are written there, named in the text. Throws Error where no point is
// meant.
std::string regress_explanation(const RegressReport& report, const std::string& point,
                                const std::filesystem::path& folder);

}  // namespace crowdbench::bench
