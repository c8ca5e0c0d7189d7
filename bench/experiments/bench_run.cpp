#include "bench/experiments/bench_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <utility>

#include "bench/experiments/point_name.h"
#include "bench/experiments/point_rows.h"
#include "bench/experiments/score_rows.h"
#include "bench/experiments/time_budget.h"
#include "bench/stage/cast_name.h"
#include "bench/stage/stage.h"
#include "bench/timing/control.h"
#include "bench/timing/image_check.h"
#include "bench/timing/round_limit.h"
#include "bench/timing/timed_representation.h"
#include "core/image_io.h"
#include "core/progress.h"
#include "metrics/pseudocolour.h"

namespace crowdbench::bench {
namespace {

// Frames of every variant at a point, at least: pictures, counts, warm-up and timed rounds.
constexpr double kLeastTurns = 16;
// The fewest rounds that are kept: of six, the smallest and the largest hold the median between them 97 times of 100
// (of five, 94 times), so that an interval of 95 % exists.
constexpr int kFewestRounds = 6;
// A floor takes this much of its representation's time, roughly: for forecasts from a file, which has no times of it.
constexpr double kFloorPart = 0.5;

// Of `reason`s of rows that were stopped: the budget follows.
constexpr std::string_view kOverBudget = "over the budget of ";

// Whether a stored row still says that its curve had ended: by a budget no smaller than this one.
bool still_stopped(const MeasurementRow& row, double budget_ms) {
  if (row.status != Status::stopped) return false;
  const size_t at = row.reason.rfind(kOverBudget);
  if (at == std::string::npos) return false;
  const std::string number = row.reason.substr(at + kOverBudget.size());
  // As it was written: with six digits.
  const double asked = std::strtod(fmt::format("{:g}", budget_ms).c_str(), nullptr);
  return std::strtod(number.c_str(), nullptr) >= asked;
}

// The time of the whole run is over in the midst of a point.
struct OutOfTime {};

// A curve: one representation at one occupancy. Once it has ended, every later point says so.
struct Curve {
  bool ended = false;
  std::string reason;
};

// Three channels: what scores and pictures are made of.
Image8 without_alpha(const Image8& rgba) {
  Image8 rgb(rgba.width, rgba.height, 3);
  for (size_t i = 0; i < rgba.pixels(); ++i)
    for (size_t c = 0; c < 3; ++c) rgb.data[3 * i + c] = rgba.data[4 * i + c];
  return rgb;
}

class BenchRun {
 public:
  BenchRun(gl::Context& context, const scene::Cast& cast, const TimingMethod& method, const RunRow& run,
           const BenchRequest& request, StoreWriter& store, const std::function<void(const std::string&)>& progress)
      : context_(context),
        method_(method),
        run_(run),
        request_(request),
        store_(store),
        progress_(progress),
        cast_(cast),
        stage_(context, cast),
        gpu_(gpu_timer_of(context, method)),
        budget_(request.total_time_s, request.agents.size() * request.occupancies.size()) {
    specs_.push_back(renderers::reference_spec());
    for (const renderers::Spec& spec : request.representations)
      if (std::none_of(specs_.begin(), specs_.end(), [&](const auto& s) { return s.text() == spec.text(); }))
        specs_.push_back(spec);
  }

  BenchSummary run() {
    size_t done = 0;
    for (const double occupancy : request_.occupancies) {
      curves_.assign(specs_.size(), {});
      if (!turns_.empty()) turns_before_ = std::exchange(turns_, {});
      const uint32_t shown = agents_to_show();
      for (const uint32_t agents : request_.agents) {
        measure({agents, occupancy}, agents == shown, kLeastTurns * expected_turn_s(turns_, turns_before_, agents));
        budget_.point_done();
        if (request_.after_point) request_.after_point(++done, budget_.left());
      }
    }
    return summary_;
  }

 private:
  // A place on the axes.
  struct Point {
    uint32_t agents = 0;
    double occupancy = 0;
    std::string name() const { return fmt::format("{} at {}", agents_text(agents), view_name(occupancy)); }
  };
  // What was seen of a representation at a point before it was timed.
  struct Look {
    size_t spec = 0;
    renderers::Capture picture;
    ImageCheck check;
    gl::PipelineCounts counts;
    uint64_t touched_px = 0;
  };
  // Times of a point: of every look, in the same order, and of the floors that there are.
  struct Times {
    std::vector<VariantTimes> looks;
    std::map<size_t, VariantTimes> floors;  // by place among the looks
    size_t controlled = 0;                  // the look that was timed once more
    VariantTimes control;
  };

  PointKey key(size_t spec, const Point& at) const {
    return {specs_[spec].text(),     cast_name(cast_),         at.agents,
            request_.scenario.width, request_.scenario.height, at.occupancy};
  }

  // Pictures are kept of the largest crowd up to picture_agents.
  uint32_t agents_to_show() const {
    uint32_t shown = request_.agents.front();
    for (const uint32_t agents : request_.agents)
      if (agents <= request_.picture_agents) shown = std::max(shown, agents);
    return shown;
  }

  // Whether a point that is expected to take this long still fits.
  bool in_time(const Point& at, double expected_s) {
    if (budget_.allows(expected_s)) return true;
    if (budget_.over())
      leave(at);
    else
      remark(fmt::format("{}: left for another run of the same command: it takes about {}, and {} are left", at.name(),
                         duration_text(expected_s), duration_text(budget_.left())));
    return false;
  }
  void leave(const Point& at) { remark(at.name() + ": left for another run of the same command: the time was over"); }
  // Between two things that take long.
  void pause() const {
    throw_if_interrupted();
    if (budget_.over()) throw OutOfTime{};
  }

  void remark(const std::string& text) { summary_.remarks.push_back(text); }

  void end_curve(size_t spec, const Point& at, double frame_ns) {
    end_curve(spec, at,
              fmt::format("at {} a frame took {:.0f} ms, {}{:g} ms", agents_text(at.agents), frame_ns / 1e6,
                          kOverBudget, request_.budget_ms));
  }
  void end_curve(size_t spec, const Point& at, const std::string& reason) {
    curves_[spec] = {true, reason};
    remark(fmt::format("{} at {}: stopped: {}", specs_[spec].text(), view_name(at.occupancy), reason));
  }

  MeasurementRow row_of(size_t spec, const Point& at, const StageFacts* facts) const {
    MeasurementRow row;
    row.run = run_.id;
    row.key = key(spec, at);
    row.reference = specs_[0].text();
    if (facts != nullptr) put_stage(row, *facts);
    return row;
  }

  void write_untimed(size_t spec, const Point& at, Status status, const std::string& reason, const StageFacts* facts) {
    MeasurementRow row = row_of(spec, at, facts);
    row.status = status;
    row.reason = reason;
    store_.write(row);
  }

  // Whether the file holds the point for every representation that still runs; it then learns from it where curves end
  // and what a turn takes.
  bool take_from_store(const Point& at) {
    std::vector<std::optional<MeasurementRow>> rows;
    for (size_t s = 0; s < specs_.size(); ++s) {
      rows.push_back(store_.find(run_, key(s, at)));
      const bool held = rows[s] && (rows[s]->status != Status::stopped || still_stopped(*rows[s], request_.budget_ms));
      if (!held && !curves_[s].ended) return false;
    }
    bool any = false;
    for (size_t s = 0; s < specs_.size(); ++s) {
      if (!rows[s]) {
        write_untimed(s, at, Status::stopped, curves_[s].reason, nullptr);
        continue;
      }
      if (curves_[s].ended) continue;
      any = any || rows[s]->status != Status::unreachable;
      if (rows[s]->status == Status::stopped)
        end_curve(s, at, rows[s]->reason);
      else if (rows[s]->frame_ns && rows[s]->frame_ns->median > request_.budget_ms * 1e6)
        end_curve(s, at, rows[s]->frame_ns->median);
    }
    if (any) ++summary_.held;
    learn_turn(at, rows);
    return true;
  }
  void learn_turn(const Point& at, const std::vector<std::optional<MeasurementRow>>& rows) {
    Turn turn{at.agents};
    for (size_t s = 0; s < rows.size(); ++s)
      if (rows[s] && rows[s]->frame_ns) {
        const bool has_floor = request_.floors && specs_[s].components.empty() && !is_floor(specs_[s]);
        turn.seconds += 1e-9 * rows[s]->frame_ns->median * (1 + (s == 0 ? 1 : 0) + (has_floor ? kFloorPart : 0));
      }
    if (turn.seconds > 0) turns_.push_back(turn);
  }

  // expected_s: what it takes with as few rounds as there may be, as the points before let expect.
  void measure(const Point& at, bool keep_pictures, double expected_s) {
    if (take_from_store(at) || !in_time(at, expected_s)) return;
    progress_(at.name() + ": solving for the view");
    scene::Scenario scenario = request_.scenario;
    scenario.crowd.agents = at.agents;
    scenario.occupancy = at.occupancy > 0 ? std::optional(at.occupancy) : std::nullopt;
    staged_ = stage_scenario(scenario, cast_, context_);
    const StageFacts facts = measure_stage(staged_, cast_, context_);
    summary_.stages.push_back({at.agents, at.occupancy, facts});
    throw_if_interrupted();
    if (facts.unreachable) {
      write_unreachable(at, facts);
      return;
    }
    stage_.show(staged_);
    try {
      const std::vector<Look> looks = look(at);
      const Times times = time(at, looks);
      write_point(at, facts, looks, times, keep_pictures);
      ++summary_.measured;
    } catch (const OutOfTime&) {
      leave(at);
    }
  }

  void write_unreachable(const Point& at, const StageFacts& facts) {
    const std::string reason =
        fmt::format("{} {} {} at most, {} were asked for", agents_text(at.agents), at.agents == 1 ? "covers" : "cover",
                    percent_text(facts.coverage.occupancy), percent_text(at.occupancy));
    store_.begin();
    for (size_t s = 0; s < specs_.size(); ++s) write_untimed(s, at, Status::unreachable, reason, &facts);
    store_.commit();
    remark(at.name() + ": skipped: " + reason);
  }

  // The reference first, and even where its curve has ended: the others are held against it.
  std::vector<Look> look(const Point& at) {
    progress_(at.name() + ": looking at the pictures");
    std::vector<Look> looks;
    for (size_t s = 0; s < specs_.size(); ++s) {
      if (s != 0 && curves_[s].ended) continue;
      Look seen;
      seen.spec = s;
      seen.picture = timed(s).capture(0);
      seen.check = check_pictures(seen.picture, timed(s).capture(kSecondTick), timed(s).is_floor(),
                                  s == 0 ? std::nullopt : std::optional(looks.front().check));
      if (!curves_[s].ended) {
        seen.counts = timed(s).count(0);
        seen.touched_px = timed(s).touched_px(0);
      }
      looks.push_back(std::move(seen));
      pause();
    }
    return looks;
  }

  // Everything whose curve goes on, and its floor, in rounds.
  Times time(const Point& at, const std::vector<Look>& looks) {
    std::vector<Variant> variants;
    std::vector<size_t> of;  // place among the looks; the floors follow
    for (size_t l = 0; l < looks.size(); ++l) {
      if (curves_[looks[l].spec].ended) continue;
      variants.push_back(timed(looks[l].spec).variant());
      of.push_back(l);
    }
    const size_t without_floors = variants.size();
    for (size_t v = 0; request_.floors && v < without_floors; ++v)
      if (TimedRepresentation* floor = floor_of(looks[of[v]].spec); floor != nullptr) {
        variants.push_back(floor->variant());
        of.push_back(of[v]);
        pause();
      }

    // The first that goes on, once more: the control.
    if (!of.empty()) {
      variants.push_back(control_of(looks[of.front()].spec).variant());
      of.push_back(of.front());
    }

    std::vector<VariantTimes> results = time_rounds(at, variants);
    Times times;
    times.looks.resize(looks.size());
    if (!of.empty()) {
      times.controlled = of.back();
      times.control = std::move(results.back());
      of.pop_back();
    }
    for (size_t v = 0; v < of.size(); ++v)
      (v < without_floors ? times.looks[of[v]] : times.floors[of[v]]) = std::move(results[v]);
    return times;
  }

  // Throws OutOfTime where there was no time for enough rounds; what a turn takes is then known as well.
  std::vector<VariantTimes> time_rounds(const Point& at, const std::vector<Variant>& variants) {
    TimingPlan plan;
    plan.rounds = request_.rounds;
    plan.least_rounds = std::min(request_.least_rounds, request_.rounds);
    plan.metric = method_.headline;
    plan.time_limit_ns = static_cast<int64_t>(budget_.share(request_.time_limit_s) * 1e9);
    plan.drop_above_ns = static_cast<int64_t>(2 * request_.budget_ms * 1e6);
    plan.order_seed = request_.order_seed;
    RoundLimit limit;
    limit.fewest = std::min(kFewestRounds, plan.least_rounds);
    limit.fits = [&](int64_t ns) { return budget_.allows(1e-9 * static_cast<double>(ns)); };
    int round = 0;
    std::vector<VariantTimes> results = time_interleaved(variants, plan, limit, clocks_, gpu_, [&] {
      progress_(fmt::format("{}: round {}", at.name(), ++round));
      throw_if_interrupted();
    });
    Turn& turn = turns_.emplace_back(Turn{at.agents});
    bool enough = true;
    for (const VariantTimes& one : results) {
      enough = enough && (one.dropped || one.samples.size() >= static_cast<size_t>(limit.fewest));
      turn.seconds += 1e-9 * (one.samples.empty() ? static_cast<double>(one.warmup_frame_ns)
                                                  : median(values_of(one.samples, Metric::wall)));
    }
    if (!enough) throw OutOfTime{};
    return results;
  }

  // One transaction: a row for every representation, its ratios and its comparison.
  void write_point(const Point& at, const StageFacts& facts, const std::vector<Look>& looks, const Times& times,
                   bool keep_pictures) {
    store_.begin();
    for (size_t s = 0; s < specs_.size(); ++s)
      if (curves_[s].ended) write_untimed(s, at, Status::stopped, curves_[s].reason, &facts);
    const bool reference_timed = !curves_[0].ended && !times.looks.front().dropped;
    for (size_t l = 0; l < looks.size(); ++l) {
      const Look& seen = looks[l];
      const size_t spec = seen.spec;
      if (curves_[spec].ended) continue;
      if (times.looks[l].dropped) {
        end_curve(spec, at, static_cast<double>(times.looks[l].warmup_frame_ns));
        write_untimed(spec, at, Status::stopped, curves_[spec].reason, &facts);
        continue;
      }
      const MeasurementRow row = measured_row(at, facts, seen, looks.front(), times.looks[l]);
      store_.write(row);
      const auto floor = times.floors.find(l);
      for (const RatioRow& ratio : ratio_rows(run_.id, row.key, times.looks[l], row.reference,
                                              spec != 0 && reference_timed ? &times.looks.front() : nullptr,
                                              floor == times.floors.end() ? nullptr : &floor->second))
        store_.write(ratio);
      if (l == times.controlled && !times.control.dropped)
        for (const ControlRow& control : control_rows(run_.id, row.key, times.looks[l].samples, times.control.samples))
          store_.write(control);
      if (spec != 0) write_comparison(row.key, looks.front().picture, seen.picture, keep_pictures);
      if (row.frame_ns->median > request_.budget_ms * 1e6) end_curve(spec, at, row.frame_ns->median);
    }
    store_.commit();
  }

  MeasurementRow measured_row(const Point& at, const StageFacts& facts, const Look& seen, const Look& reference,
                              const VariantTimes& times) {
    MeasurementRow row = row_of(seen.spec, at, &facts);
    put_times(row, times, kBootstrapSeed);
    row.covered_px = seen.check.covered_px;
    row.touched_px = seen.touched_px;
    row.moved_px = seen.check.moved_px;
    row.reference_px = reference.check.covered_px;
    if (!seen.check.fault.empty()) {
      row.status = Status::invalid;
      row.reason = seen.check.fault;
      ++summary_.invalid;
      remark(fmt::format("{}: {}: invalid: {}", at.name(), row.key.representation, row.reason));
    }
    timed(seen.spec).put_footprint(row);
    row.vertices_shaded = seen.counts.vertex_invocations;
    row.primitives = seen.counts.clipping_output;
    row.fragments = seen.counts.fragment_invocations;
    row.samples_passed = seen.counts.samples_passed;
    return row;
  }

  void write_comparison(const PointKey& point, const renderers::Capture& reference, const renderers::Capture& test,
                        bool keep_pictures) {
    ComparisonRow row;
    row.run = run_.id;
    row.kind = "crowd";
    row.representation = point.representation;
    row.reference = specs_[0].text();
    row.character = point.character;
    row.agents = point.agents;
    row.requested_occupancy = point.requested_occupancy;
    row.scores = score_crowd(request_.table, request_.display, reference, test);
    put_display(row, request_.display);
    const int64_t id = store_.write(row);
    if (keep_pictures)
      write_pictures(store_, run_.id, id, reference.colour, test.colour, row.reference, row.representation);
  }

  // Baked at first use and kept for the whole run.
  TimedRepresentation& timed(size_t spec) {
    auto& place = timed_[spec];
    if (!place) {
      progress_("baking " + specs_[spec].text());
      place = std::make_unique<TimedRepresentation>(stage_, specs_[spec], request_.scenario, request_.bake_budget);
      if (auto levels = place->representation().bake_info().levels; !levels.empty())
        summary_.levels.push_back({place->name(), std::move(levels)});
    }
    return *place;
  }
  // A second one of its own, with buffers of its own.
  TimedRepresentation& control_of(size_t spec) {
    auto& place = controls_[spec];
    if (!place)
      place = std::make_unique<TimedRepresentation>(stage_, specs_[spec], request_.scenario, request_.bake_budget);
    return *place;
  }
  // nullptr for a representation that is a floor itself, or has components.
  TimedRepresentation* floor_of(size_t spec) {
    if (!specs_[spec].components.empty() || timed(spec).is_floor()) return nullptr;
    const renderers::Spec floor = with_floor(specs_[spec]);
    auto& place = floors_[spec];
    if (!place) {
      progress_("baking " + floor.text());
      place = std::make_unique<TimedRepresentation>(stage_, floor, request_.scenario, request_.bake_budget);
    }
    return place.get();
  }

  gl::Context& context_;
  const TimingMethod& method_;
  const RunRow& run_;
  const BenchRequest& request_;
  StoreWriter& store_;
  const std::function<void(const std::string&)>& progress_;
  const scene::Cast& cast_;
  Staged staged_;  // of the point at hand
  Stage stage_;
  std::optional<GpuTimer> gpu_;
  Clocks clocks_ = system_clocks();
  std::vector<renderers::Spec> specs_;  // the reference first
  std::vector<Curve> curves_;
  std::map<size_t, std::unique_ptr<TimedRepresentation>> timed_;
  std::map<size_t, std::unique_ptr<TimedRepresentation>> floors_;
  std::map<size_t, std::unique_ptr<TimedRepresentation>> controls_;
  BenchSummary summary_;
  TimeBudget budget_;
  std::vector<Turn> turns_;         // of the points at this occupancy that were timed, now or in the file
  std::vector<Turn> turns_before_;  // of the occupancy before
};

}  // namespace

std::vector<uint32_t> full_agents() { return {1, 10, 100, 250, 500, 1000, 2000, 5000, 10000}; }

BenchSummary run_bench(gl::Context& context, const scene::Cast& cast, const TimingMethod& method, const RunRow& run,
                       const BenchRequest& request, StoreWriter& store,
                       const std::function<void(const std::string&)>& progress) {
  return BenchRun(context, cast, method, run, request, store, progress).run();
}

std::vector<ScoreRow> score_crowd(metrics::ScoreTable table, const metrics::ChosenDisplay& display,
                                  const renderers::Capture& reference, const renderers::Capture& test) {
  metrics::ScoreInput input{buffers_of(reference), buffers_of(test)};
  metrics::look_at(display, input);
  metrics::Shared shared;
  return score_rows(metrics::score_pictures(table, input, shared));
}

namespace {
constexpr const char* kDifferenceCaption = "mean absolute difference of R, G and B (code values)";
}  // namespace

void write_legend(StoreWriter& store, int64_t run) {
  const Image8 bar = metrics::colour_bar(360, kDifferenceCaption);
  store.write(PictureRow{0, run, std::nullopt, "legend", kDifferenceCaption, bar.width, bar.height, encode_png(bar)});
}

std::vector<PictureRow> comparison_pictures(const Image8& reference, const Image8& test,
                                            const std::string& reference_name, const std::string& test_name, bool bar) {
  std::vector<PictureRow> rows;
  const auto add = [&](const char* role, const std::string& caption, const Image8& image) {
    rows.push_back(PictureRow{0, 0, std::nullopt, role, caption, image.width, image.height, encode_png(image)});
  };
  add("reference", reference_name, without_alpha(reference));
  add("test", test_name, without_alpha(test));
  const Image8 difference = metrics::pseudocolour(metrics::error_levels(reference, test));
  add("difference", fmt::format("absolute difference of {} and {}", reference_name, test_name),
      bar ? metrics::with_colour_bar(difference, kDifferenceCaption) : difference);
  return rows;
}

void write_pictures(StoreWriter& store, int64_t run, int64_t comparison, const Image8& reference, const Image8& test,
                    const std::string& reference_name, const std::string& test_name, bool bar) {
  for (PictureRow row : comparison_pictures(reference, test, reference_name, test_name, bar)) {
    row.run = run;
    row.comparison = comparison;
    store.write(row);
  }
}

}  // namespace crowdbench::bench
