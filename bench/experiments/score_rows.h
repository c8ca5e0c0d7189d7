// Scores as others take them from metrics/: rows of the result store, and the descriptions that reports print them by.
#pragma once
#include <span>
#include <vector>

#include "metrics/registry.h"
#include "renderers/frame/capture.h"
#include "reports/model/score_doc.h"
#include "store/store.h"

namespace crowdbench::bench {

// What was drawn, for the scores: borrowed, the capture must outlive it.
metrics::Buffers buffers_of(const renderers::Capture& capture);

// One row a score, absent ones with their reason; further figures as "name.figure".
std::vector<ScoreRow> score_rows(std::span<const metrics::Scored> scores);

// The display columns of a comparison whose scores were computed on it.
void put_display(ComparisonRow& row, const metrics::ChosenDisplay& chosen);

// In the table's order.
std::vector<reports::ScoreDoc> score_docs(metrics::ScoreTable table);
// Of the scores of switches; the first two are the headlines.
std::vector<reports::ScoreDoc> pop_score_docs();

}  // namespace crowdbench::bench
