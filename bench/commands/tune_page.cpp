// The page of a tuning, from what was found: every number as the tables of the page show it.
#include "reports/page/tune_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "bench/commands/score_json.h"
#include "bench/commands/tune_output.h"
#include "bench/experiments/score_rows.h"
#include "bench/experiments/tune_measure.h"
#include "core/image_io.h"
#include "metrics/pseudocolour.h"
#include "reports/model/amplified.h"

namespace crowdbench::bench {
namespace {

constexpr const char* kNone = "–";

std::string metres(double value) { return fmt::format("{:.1f}", value); }
std::string pixels(double value) { return fmt::format("{:.1f}", value); }

std::string name_of(const TuneReport& report, size_t subject) {
  return report.request.subjects[subject].character->name;
}

std::string score_of(const metrics::Score& score, double value) { return metrics::value_text(score, value); }

std::string interval_text(double low, double high, int digits) {
  return fmt::format("{:.{}f} to {:.{}f}", low, digits, high, digits);
}

reports::TunePageSwitch switch_of(const TuneReport& report, size_t subject, const TuneSwitch& one) {
  reports::TunePageSwitch out;
  out.from = candidate_name(report, one.change.from);
  out.to = candidate_name(report, one.change.to);
  out.height = pixels(one.height_px);
  out.depth = metres(depth_in_report(report, subject, one.height_px));
  out.height_interval = out.depth_interval = out.ratio = out.hysteresis = kNone;
  if (one.certainty.decided()) {
    const Interval& height = *one.certainty.height_px;
    out.height_interval = interval_text(height.low, height.high, 1);
    out.depth_interval =
        interval_text(depth_in_report(report, subject, height.high), depth_in_report(report, subject, height.low), 1);
  }
  if (!report.predicted.empty())
    if (const double texel = report.predicted[subject][one.change.to].texel; texel > 0)
      out.ratio = fmt::format("{:.2f}", pixels_spanned(texel, report.request.subjects[subject], one.height_px));
  if (one.hysteresis > 0) out.hysteresis = fmt::format("{:.1f} %", 100 * one.hysteresis);
  out.pop = fmt::format("{} {}", report.request.pop.score->title, score_of(*report.request.pop.score, one.pop.tail));
  out.next = pixels(report.request.heights_px[one.change.bin - 1]);
  out.sure = fmt::format("{:.1f} %{}", 100 * one.certainty.share, one.certainty.decided() ? "" : ", undecided");
  return out;
}

// With a capital and a full stop.
std::string sentence(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text + ".";
}

// "Nearer than 12.3 m draw mesh; from there on flat."
std::vector<std::string> answer_sentences(const TuneReport& report, size_t subject, const TuneAnswer& answer) {
  if (!answer.plan) return {"There is no rule: " + no_plan_text(report, answer) + "."};
  std::vector<std::string> out;
  const std::string near = candidate_name(report, answer.plan->candidate[0]);
  if (answer.switches.empty()) {
    out.push_back(fmt::format("Draw {} at every distance{}.", near,
                              answer.budget ? "" : ": nothing cheaper keeps the thresholds"));
  } else {
    std::string text = fmt::format("From the eye to {} m draw {}",
                                   metres(depth_in_report(report, subject, answer.switches[0].height_px)), near);
    for (const TuneSwitch& one : answer.switches)
      text += fmt::format("; from {} m on (figures of {} pixels and less) {}",
                          metres(depth_in_report(report, subject, one.height_px)), pixels(one.height_px),
                          candidate_name(report, one.change.to));
    out.push_back(text + ".");
    const auto unsure = std::count_if(answer.switches.begin(), answer.switches.end(),
                                      [](const TuneSwitch& one) { return !one.certainty.decided(); });
    if (unsure == 0)
      out.emplace_back("Every change is in at least 95 % of the resampled measurements.");
    else
      out.push_back(fmt::format("Undecided, in fewer than 95 % of the resampled measurements: {} of {} {}.", unsure,
                                answer.switches.size(), answer.switches.size() == 1 ? "change" : "changes"));
  }
  const metrics::Score& score = *report.request.error.score;
  const char* worse = score.direction == metrics::Direction::higher_is_better ? "of less" : "of more";
  const std::string few = few_views_text(report.result.subjects[subject].views);
  if (answer.budget)
    out.push_back(budget_text(report, answer) + ".");
  else
    out.push_back(fmt::format("Of the figures that each {} there, {} {} {} than {:g}.", few.empty() ? "draws" : "drew",
                              few.empty() ? "no more than 5 % have" : "none had", score.title, worse,
                              report.request.error.value));
  if (!few.empty()) out.push_back(sentence(few));
  if (report.request.subjects.size() > 1) out.push_back("Metres are those of " + name_of(report, subject) + ".");
  if (agents_in_view(answer) > 0) out.push_back(saving_text(answer) + ".");
  return out;
}

std::vector<std::string> proof_lines(const TuneReport& report) {
  std::vector<std::string> out;
  if (report.promise)
    for (const std::string& text :
         {promise_text(*report.promise), score_promise_text(report), others_promise_text(report)})
      out.push_back(sentence(text));
  if (report.proof)
    for (const std::string& text : proof_texts(report)) out.push_back(sentence(text));
  return out;
}

void add_seeds(const std::vector<SeedTimes>& seeds, const std::string& purpose,
               std::vector<std::vector<std::string>>& rows) {
  for (const SeedTimes& one : seeds)
    rows.push_back({std::to_string(one.seed), purpose, fmt::format("{:.3f}", one.ratio),
                    interval_text(one.interval.low, one.interval.high, 3),
                    fmt::format("{:.2f}", 1e-6 * one.reference_ns), fmt::format("{:.2f}", 1e-6 * one.plan_ns)});
}

reports::TuneCurve curve_of(const TuneReport& report, size_t subject, size_t candidate) {
  const TuneMeasured& measured = report.result.subjects[subject];
  const auto& plan = report.result.together.plan;
  reports::TuneCurve out;
  out.representation = candidate_name(report, candidate);
  for (size_t b = 0; b < report.request.heights_px.size(); ++b) {
    const TuneError& error = measured.errors[candidate][b];
    reports::TunePoint point;
    point.height_px = report.request.heights_px[b];
    point.depth = depth_in_report(report, subject, point.height_px);
    point.allowed = error.allowed;
    point.chosen = plan && plan->candidate[b] == candidate;
    if (!error.values.empty()) {
      point.tail = error.tail;
      point.low = error.interval.low;
      point.high = error.interval.high;
    }
    out.points.push_back(point);
  }
  const std::vector<AgentCost>& costs = measured.costs.costs[candidate];
  for (size_t h = 0; h < costs.size(); ++h) {
    reports::TuneCost cost;
    cost.height_px = measured.cost_heights_px[h];
    cost.depth = depth_in_report(report, subject, cost.height_px);
    cost.ns = costs[h].ns;
    if (costs[h].resolved) {
      cost.low_ns = costs[h].interval.low;
      cost.high_ns = costs[h].interval.high;
    }
    out.costs.push_back(cost);
  }
  return out;
}

// Of the rule for all characters, at this one's distances.
std::vector<reports::TuneMark> marks_of(const TuneReport& report, size_t subject) {
  std::vector<reports::TuneMark> out;
  for (const TuneSwitch& one : report.result.together.switches) {
    const double depth = depth_in_report(report, subject, one.height_px);
    const std::string to = candidate_name(report, one.change.to);
    out.push_back({to, depth, false, fmt::format("from {} m, {} px", metres(depth), pixels(one.height_px))});
    for (const PredictedSwitch& rule : predicted_switches(report, subject, one.change.to, one.height_px))
      out.push_back({to, rule.depth_m, true,
                     fmt::format("{}: {} m, {} px", rule.rule, metres(rule.depth_m), pixels(rule.height_px))});
  }
  for (const UnchosenCandidate& one : unchosen_candidates(report, subject, report.result.together))
    for (const PredictedSwitch& rule : one.rules)
      out.push_back({candidate_name(report, one.candidate), rule.depth_m, true,
                     fmt::format("{}: {} m, {} px", rule.rule, metres(rule.depth_m), pixels(rule.height_px))});
  return out;
}

reports::TunePageCharacter character_of(const TuneReport& report, size_t subject) {
  const TuneMeasured& measured = report.result.subjects[subject];
  const metrics::Score& score = *report.request.error.score;
  const auto& plan = report.result.together.plan;
  reports::TunePageCharacter out;
  out.name = name_of(report, subject);
  out.measured = fmt::format(
      "{} views and moments at each of {} heights. Time: one more agent of the height in the "
      "picture, {} rounds.",
      measured.views, report.request.heights_px.size(), report.request.cost.rounds);
  if (const std::string few = few_views_text(measured.views); !few.empty()) out.measured += " " + sentence(few);
  if (!report.result.alone.empty())
    for (const std::string& line : answer_sentences(report, subject, report.result.alone[subject]))
      out.alone.push_back((out.alone.empty() ? "By itself: " : "") + line);
  out.graph.doc = score_docs({&report.request.error.score, 1})[0];
  out.graph.threshold = report.request.error.value;
  out.graph.bounded = report.request.budget_ns <= 0;
  for (size_t c = 0; c < report.request.candidates.size(); ++c) {
    if (measured.refused[c].empty())
      out.graph.curves.push_back(curve_of(report, subject, c));
    else
      out.notes.push_back(fmt::format("{} is left out: {}", candidate_name(report, c), measured.refused[c]));
  }
  out.graph.marks = marks_of(report, subject);
  for (size_t b = 0; b < report.request.heights_px.size(); ++b) {
    const double height = report.request.heights_px[b];
    std::vector<std::string> row{pixels(height), metres(depth_in_report(report, subject, height)),
                                 fmt::format("{:.0f}", measured.table.agents[b])};
    for (size_t c = 0; c < report.request.candidates.size(); ++c) {
      if (!measured.refused[c].empty()) continue;
      if (plan && plan->candidate[b] == c) out.chosen.push_back((row.size() - 3) / 2);
      const TuneError& error = measured.errors[c][b];
      row.push_back(error.values.empty() ? kNone : score_of(score, error.tail));
      row.push_back(fmt::format("{:.2f}", 1e-3 * measured.table.cost[c][b]));
    }
    out.rows.push_back(std::move(row));
  }
  return out;
}

// measured_px: from where on the candidate is drawn, or keeps the threshold by itself; 0: nowhere.
reports::TunePageRule rule_of(const TuneReport& report, const std::string& to, const PredictedSwitch& rule,
                              double measured_px) {
  const metrics::Score& score = *report.request.error.score;
  const bool known = !rule.beyond && !rule.error->values.empty();
  const bool nowhere = !(measured_px > 0);
  return {to,
          rule.rule,
          nowhere ? "nowhere" : pixels(measured_px),
          nowhere ? kNone : metres(depth_in_report(report, 0, measured_px)),
          pixels(rule.height_px),
          metres(rule.depth_m),
          known ? fmt::format("{} {} or {}", score.title, score_of(score, rule.error->promised),
                              score.direction == metrics::Direction::higher_is_better ? "more" : "less")
                : "not measured there",
          !known                ? kNone
          : rule.error->allowed ? fmt::format("enough ({:g})", report.request.error.value)
                                : fmt::format("not enough ({:g})", report.request.error.value),
          known ? fmt::format("{:.2f}", 1e-3 * rule.cost_ns) : kNone};
}

void add_rules(const TuneReport& report, reports::TunePage& page) {
  for (const TuneSwitch& one : report.result.together.switches)
    for (const PredictedSwitch& rule : predicted_switches(report, 0, one.change.to, one.height_px))
      page.rules.push_back(rule_of(report, candidate_name(report, one.change.to), rule, one.height_px));
  for (const UnchosenCandidate& one : unchosen_candidates(report, 0, report.result.together))
    for (const PredictedSwitch& rule : one.rules)
      page.rules.push_back(
          rule_of(report, candidate_name(report, one.candidate) + " (not in the rule)", rule, one.kept_px.value_or(0)));
}

void add_engines(const TuneReport& report, reports::TunePage& page) {
  const TuneAnswer& answer = report.result.together;
  const SwitchCostRequest& lens = report.request.cost;
  for (const TuneSwitch& one : answer.switches) {
    const EngineSizes engines = engines_in_report(report, 0, one.height_px);
    const auto godot = godot_pixels_in_report(report, 0, one);
    page.engines.push_back(
        {candidate_name(report, one.change.to), fmt::format("{:.2f}", depth_in_report(report, 0, one.height_px)),
         fmt::format("{:.2f}", 100 * engines.unity_height), fmt::format("{:.4f}", engines.unreal_size),
         fmt::format("{:.2f}", engines.godot_metres), godot ? fmt::format("{:.2f}", *godot) : kNone});
  }
  page.engine_notes.push_back(
      fmt::format("Of {}, through a lens of {:.1f} degrees in a picture {} pixels high; sizes are of the box around "
                  "the clip's poses. "
                  "Metres and Godot's visibility range hold for that lens alone; the others are of the screen.",
                  name_of(report, 0), glm::degrees(lens.fov_y), lens.height));
  page.engine_notes.push_back(
      "Unity LODGroup: screenRelativeTransitionHeight at lodBias 1; at another QualitySettings.lodBias multiply by it. "
      "Unreal: ComputeBoundsScreenSize, the bounding sphere's diameter over the screen. Godot: mesh LOD threshold is "
      "mesh_lod/lod_change/threshold_pixels at which a level of that error begins.");
  if (const auto curve = mesh_lod_in_report(report, 0, answer)) {
    std::string text = fmt::format(
        "Unity Mesh LOD (6.2 and later) of the mesh's levels: LodSelectionCurve slope {:.3f}, "
        "bias {:.3f} at meshLodThreshold 1; levels begin at bounding spheres of",
        curve->slope, curve->bias);
    for (size_t level = 1; level <= mesh_switches(report, answer); ++level)
      text += fmt::format("{} {:.1f}", level > 1 ? "," : "", mesh_lod_begins(*curve, level));
    page.engine_notes.push_back(text + " pixels.");
  }
}

reports::TunePagePicture picture_of(const Image8& image, const std::string& caption) {
  // Small figures are shown enlarged, by whole multiples so that their pixels stay what they are.
  const int zoom = std::max(1, 240 / std::max(image.height, 1));
  Image8 rgb(image.width, image.height, 3);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) std::copy_n(image.at(x, y), 3, rgb.at(x, y));
  return {caption, rgb.width * zoom, rgb.height * zoom, encode_png(rgb)};
}

void add_pictures(const TuneReport& report, reports::TunePage& page) {
  const metrics::Score& pop = *report.request.pop.score;
  for (size_t i = 0; i < report.pictures.size(); ++i) {
    const TuneSwitchPictures& drawn = report.pictures[i];
    if (drawn.before.data.empty()) continue;
    const PlannedSwitch& change = report.result.together.switches[i].change;
    const std::string from = candidate_name(report, change.from);
    const std::string to = candidate_name(report, change.to);
    reports::TunePagePictures one;
    one.title = fmt::format("{} to {} at {} pixels: {}, azimuth {:.0f}°, elevation {:.0f}°: {} {}", from, to,
                            pixels(drawn.view.height_px), name_of(report, drawn.subject), drawn.view.azimuth_deg,
                            drawn.view.elevation_deg, pop.title, score_of(pop, drawn.pop));
    one.pictures = {picture_of(drawn.before, from), picture_of(drawn.after, to),
                    picture_of(drawn.difference, "what differs")};
    if (const auto amplified = reports::amplified_difference(drawn.before, drawn.after))
      one.pictures.push_back(
          picture_of(amplified->picture, fmt::format("difference × {}, of each channel, {} code values at most",
                                                     amplified->factor, amplified->largest)));
    page.pictures.push_back(std::move(one));
  }
  page.picture_scale = "Differences: dark blue where the two are equal, red where they differ as much as they can.";
  const std::string caption = "mean absolute difference, code values";
  const Image8 bar = metrics::colour_bar(280, caption);
  page.picture_bar = {caption, bar.width, bar.height, encode_png(bar)};
}

void add_lenses(const TuneReport& report, reports::TunePage& page) {
  const metrics::Score& score = *report.request.error.score;
  const std::vector<LensSpread> spreads = lens_spreads(report);
  page.lens_verdict = "At the same pixels per degree, " + lens_verdict(spreads);
  for (const LensSpread& spread : spreads) page.lens_lines.push_back(lens_text(report, spread));
  for (const TuneLensCheck& one : *report.lenses)
    page.lenses.push_back({std::to_string(one.lens.rows), fmt::format("{:g}", one.lens.fov_y_deg),
                           candidate_name(report, one.candidate), pixels(report.request.heights_px[one.bin]),
                           one.skipped ? kNone : score_of(score, one.tail),
                           one.skipped ? kNone : score_of(score, one.tuned_tail),
                           one.skipped ? kNone : fmt::format("{} of {}", one.worse, one.views),
                           one.skipped ? "too small a picture"
                           : one.holds ? "keeps the promise"
                                       : "does NOT keep it"});
}

std::string joined_names(const TuneReport& report) {
  std::string out;
  for (size_t s = 0; s < report.request.subjects.size(); ++s) out += (s > 0 ? ", " : "") + name_of(report, s);
  return out;
}

}  // namespace

std::string tune_page_of(const TuneReport& report) {
  const TuneAnswer& answer = report.result.together;
  const TuneRequest& request = report.request;
  const auto threshold = [](const TuneThreshold& of) { return fmt::format("{} {:g}", of.score->title, of.value); };
  reports::TunePage page;
  page.title = "Which representation from which distance on: " + joined_names(report);
  page.under = fmt::format(
      "{}; {}; pop: {}{}. {} x {} pixels, {:.1f} degrees. Times: {}. Display: {}.", joined_names(report),
      request.budget_ns > 0 ? fmt::format("a budget of {:g} ms", 1e-6 * request.budget_ns)
                            : "threshold: " + threshold(request.error),
      threshold(request.pop),
      request.fade > 0 ? fmt::format(" of a cross-fade of {} ticks", request.fade) : ", as a cut", request.cost.width,
      request.cost.height, glm::degrees(request.cost.fov_y), times_text(report), display_line(request.display));
  if (report.proof && !report.proof->holds())
    page.broken.push_back("What is promised below does NOT hold on what was not measured.");
  page.answer = answer_sentences(report, 0, answer);
  page.software = report.run.software;
  for (const TuneSwitch& one : answer.switches) page.switches.push_back(switch_of(report, 0, one));
  if (answer.plan) page.draws_as = tuned_representation(request, answer).text();
  add_pictures(report, page);
  for (size_t s = 0; s < request.subjects.size(); ++s) page.characters.push_back(character_of(report, s));
  add_rules(report, page);
  if (!answer.switches.empty()) add_engines(report, page);
  if (report.lenses) add_lenses(report, page);
  page.proof_lines = proof_lines(report);
  if (report.promise) add_seeds(report.promise->seeds, "promise", page.seeds);
  if (report.proof && !report.proof->other) add_seeds(report.proof->speed.seeds, "proof", page.seeds);
  if (report.others)
    for (const CharacterDrawn& one : report.others->left_out)
      add_seeds(one.times, one.character + " by the rule of the others", page.seeds);
  if (report.proof && report.proof->other)
    add_seeds(report.proof->other->drawn.times, "proof, " + report.proof->other->drawn.character, page.seeds);
  page.facts = {{"command", report.run.arguments},
                {"crowdbench", fmt::format("{} ({})", report.run.version, report.run.revision)},
                {"OpenGL", fmt::format("{}; {}", report.run.gl_renderer, report.run.gl_version)},
                {"processor", fmt::format("{}, {} hardware threads", report.run.cpu_model.value_or("unnamed"),
                                          report.run.cpu_threads)},
                {"scenario", fmt::format("{}, SHA-256 {}", report.run.scenario_name, report.run.scenario_hash)},
                {"seed", std::to_string(request.seed)},
                {"agents", std::to_string(report.crowd)}};
  return reports::tune_page(page);
}

}  // namespace crowdbench::bench
