// Error by cause as it is printed, alike in every command: as JSON (`crowdbench schema --results` documents it) and as
// lines.
#pragma once
#include <span>
#include <string>

#include "bench/experiments/cause_words.h"
#include "core/json.h"
#include "metrics/picture_causes.h"

namespace crowdbench::bench {

// {"squared": {cause: amount or null}, "residue", "total", "pixels", "largest"}
Json cause_row_json(const metrics::CauseErrors& errors, const metrics::CauseRow& row);
// The row of the whole, with "order", "reasons" and, where there is more than one agent or `changes`, "agents".
Json causes_json(const metrics::CauseErrors& errors, std::span<const metrics::AgentChange> changes = {},
                 bool agents = true);
Json cause_ranges_json(std::span<const CauseRange> ranges);

// "pose 12 %, silhouette 70 %, texture 18 %; residue 0.1 %" of the available causes whose amount is not 0.
std::string cause_shares_text(const metrics::CauseRow& row);
// A line for each reason why causes could not be told.
void print_untold(const metrics::CauseErrors& errors);
// A line for the whole, one for each agent that has an error, and what could not be told.
void print_causes(const metrics::CauseErrors& errors, std::span<const metrics::AgentChange> changes);

}  // namespace crowdbench::bench
