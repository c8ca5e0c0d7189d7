// An analysis as JSON, and as Markdown for a paper's supplement.
#pragma once
#include <string>
#include <vector>

#include "core/json.h"
#include "studies/analysis/analysis.h"

namespace crowdbench::studies {

// Every number with the name that the headers of the analysis give it; what does not exist is null or left out, and its
// state says why.
Json analysis_json(const Analysis& analysis);

// What analysis_text() says, behind the sentences of `standing` (how the analysis was planned).
std::string analysis_markdown(const Analysis& analysis, const std::vector<std::string>& standing = {});

// The same for a terminal: names as they are, "height_px" and not "height\_px".
std::string analysis_plain(const Analysis& analysis, const std::vector<std::string>& standing = {});

std::string_view tie_rule_text(TieRule rule);  // "drop", "split", "no"

}  // namespace crowdbench::studies
