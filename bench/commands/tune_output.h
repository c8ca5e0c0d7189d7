// What `tune` prints: for people, as JSON, as a page.
#pragma once
#include <string>
#include <vector>

#include "bench/experiments/tune_report.h"
#include "core/json.h"

namespace crowdbench::bench {

void print_tune(const TuneReport& report);
Json tune_json(const TuneReport& report);
// One self-contained HTML page. Throws Error when the program was built without the chart library.
std::string tune_page_of(const TuneReport& report);

// ---- sentences that the text and the page share
// With the next taller height that was measured: between the two the switch may be anywhere.
std::string switch_certainty_text(const TuneReport& report, const TuneSwitch& one);
// "one texel a pixel would switch at 24.1 pixels (31.2 m): there 95 % of the figures have ..."
std::string predicted_text(const TuneReport& report, const PredictedSwitch& one);
// "flat, to which the rule changes nowhere: keeps the threshold by itself from 20.0 pixels (24.1 m) on"
std::string unchosen_text(const TuneReport& report, size_t subject, const UnchosenCandidate& one);
// Why 5 % of the figures are not bounded; empty where they are.
std::string few_views_text(size_t views);
std::string lens_text(const TuneReport& report, const LensSpread& spread);
std::string lens_verdict(const std::vector<LensSpread>& spreads);
std::string budget_text(const TuneReport& report, const TuneAnswer& answer);
std::string saving_text(const TuneAnswer& answer);
std::string promise_text(const SpeedPromise& promise);
std::string score_promise_text(const TuneReport& report);
// What is promised of a character that was not tuned, or that and why nothing is.
std::string others_promise_text(const TuneReport& report);
// What the proof found, a sentence each without its full stop: of speed, score and error; of another character of
// all three.
std::vector<std::string> proof_texts(const TuneReport& report);

}  // namespace crowdbench::bench
