// The truth as the capture that representations are compared by.
#pragma once
#include "core/json.h"
#include "renderers/frame/capture.h"
#include "truth/judge.h"

namespace crowdbench::bench {

// What the truth is called beside representations: in options, pictures' metadata and the result store.
inline constexpr const char* kTruthName = "truth";

// Colours, ids and depths (rounded to float) of a truth with colours; linear as CaptureOptions asks.
renderers::Capture capture_of(const truth::TruthPicture& picture, const renderers::CaptureOptions& options = {});

// {"pixels", "covered", "wrong", "outline", "depth", "mask", "unexplained", "worst_distance_px", "largest_bound_px",
//  "inner", "worst_depth", "mean_colour", "worst_colour", "offenders": [{"x", "y", "id", "truth_id", "bound_px"}]}, as
// truth::Judgement says; "judged": what was.
Json judgement_json(const truth::Judgement& judgement, const std::string& judged);
// One line of it, for people.
std::string judgement_line(const truth::Judgement& judgement, const std::string& judged);

}  // namespace crowdbench::bench
