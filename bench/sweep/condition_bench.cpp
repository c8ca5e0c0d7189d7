#include "bench/sweep/condition_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "bench/experiments/bench_run.h"
#include "bench/experiments/point_name.h"
#include "bench/experiments/point_rows.h"
#include "bench/experiments/score_rows.h"
#include "bench/stage/cast_name.h"
#include "bench/stage/scenario_display.h"
#include "bench/stage/stage.h"
#include "bench/stage/stage_facts.h"
#include "bench/timing/image_check.h"
#include "bench/timing/run_facts.h"
#include "bench/timing/timed_representation.h"
#include "core/command_line.h"
#include "core/error.h"
#include "core/image_io.h"
#include "core/json.h"
#include "core/progress.h"
#include "scene/cast/load_cast.h"

namespace crowdbench::bench::sweep {
namespace {

std::string settings_json(const std::vector<Setting>& settings) {
  Json all = Json::object();
  for (const Setting& setting : settings) all[setting.axis] = setting.text;
  return all.dump();
}

// What all points of the condition have in common.
std::vector<Setting> common_settings(const Condition& condition) {
  std::vector<Setting> common = condition.points.front().settings;
  for (const PlannedPoint& point : condition.points)
    std::erase_if(common, [&](const Setting& mine) {
      return mine.axis == "representation" ||
             std::none_of(point.settings.begin(), point.settings.end(),
                          [&](const Setting& its) { return its.axis == mine.axis && its.text == mine.text; });
    });
  return common;
}

// What draws one condition after the other, as long as the characters stay the same.
struct Scene {
  std::vector<scene::CharacterEntry> characters;
  double pose_rate = 0;
  scene::Cast cast;
  std::unique_ptr<Stage> stage;
  std::map<std::string, std::unique_ptr<TimedRepresentation>> drawn;  // by canonical text, all of one picture size
  int width = 0, height = 0;
  scene::Antialiasing antialiasing;
};

// A representation at the condition in hand.
struct Entry {
  renderers::Spec spec;
  std::string text;
  TimedRepresentation* drawn = nullptr;
  renderers::Capture picture;
  ImageCheck check;
  gl::PipelineCounts counts;
  uint64_t touched_px = 0;
  std::string fault;  // why it could not be drawn
  VariantTimes times;
};

}  // namespace

class ConditionBench::Impl {
 public:
  Impl(gl::Context& context, const TimingMethod& method, const Plan& plan, std::function<void(const std::string&)> note)
      : context_(context),
        method_(method),
        plan_(plan),
        note_(std::move(note)),
        gpu_(gpu_timer_of(context, method)),
        machine_(describe_run(context, method, scene::Scenario(), "sweep", command_line())) {}

  MeasuredCondition measure(size_t index, int repetition) {
    const double begun = now_s();
    condition_ = &plan_.conditions[index];
    repetition_ = repetition;
    MeasuredCondition out;
    out.run = run_row();
    std::vector<Entry> entries = planned_entries();
    std::string fault;
    try {
      draw_and_time(entries, out);
    } catch (const Error& error) {
      out.points.clear();
      fault = error.what();
    }
    if (!fault.empty()) all_are(out, "failed", fault);
    for (MeasuredPoint& point : out.points) {
      point.row.condition = static_cast<uint32_t>(index);
      point.row.repetition = static_cast<uint32_t>(repetition);
      point.row.seconds = now_s() - begun;
    }
    return out;
  }

 private:
  static double now_s() { return 1e-9 * static_cast<double>(system_clocks().wall()); }

  uint64_t order_seed() const { return kOrderSeed + static_cast<uint64_t>(repetition_); }

  RunRow run_row() const {
    RunRow run = machine_;
    run.scenario_name = condition_->scenario.name;
    run.scenario = condition_->scenario_text;
    run.scenario_hash = condition_->scenario_hash;
    run.seed = condition_->scenario.seed;
    run.order_seed = order_seed();
    return run;
  }

  // The reference first, whether the plan asks for it or not.
  std::vector<Entry> planned_entries() const {
    std::vector<Entry> entries(1);
    entries[0].spec = plan_.measures.reference;
    entries[0].text = entries[0].spec.text();
    for (const PlannedPoint& point : condition_->points)
      if (point.representation != entries[0].text) {
        entries.emplace_back();
        entries.back().spec = point.spec;
        entries.back().text = point.representation;
      }
    return entries;
  }

  SweepPointRow row_of(const std::string& role, const std::string& representation) const {
    SweepPointRow row;
    row.role = role;
    row.representation = representation;
    row.state = "done";
    for (const PlannedPoint& point : condition_->points)
      if (role == "point" && point.representation == representation) {
        row.settings = settings_json(point.settings);
        row.point_key = plan_.key(*condition_, point, repetition_);
        return row;
      }
    row.settings = settings_json(common_settings(*condition_));
    PlannedPoint beside;
    beside.representation = role + " " + representation;
    row.point_key = plan_.key(*condition_, beside, repetition_);
    return row;
  }
  bool is_planned(const std::string& representation) const {
    return std::any_of(condition_->points.begin(), condition_->points.end(),
                       [&](const PlannedPoint& point) { return point.representation == representation; });
  }

  void all_are(MeasuredCondition& out, const std::string& state, const std::string& reason) const {
    for (const PlannedPoint& point : condition_->points) {
      MeasuredPoint made;
      made.row = row_of("point", point.representation);
      made.row.state = state;
      made.row.reason = reason;
      out.points.push_back(std::move(made));
    }
  }

  void load() {
    const scene::Scenario& scenario = condition_->scenario;
    if (!scene_ || scene_->characters != scenario.characters || scene_->pose_rate != scenario.pose_rate) {
      scene_.reset();
      note_("loading characters");
      auto made = std::make_unique<Scene>();
      made->characters = scenario.characters;
      made->pose_rate = scenario.pose_rate;
      made->cast = scene::load_cast(scenario, plan_.folder);
      made->stage = std::make_unique<Stage>(context_, made->cast);
      scene_ = std::move(made);
    }
    const bool same_size = scene_->width == scenario.width && scene_->height == scenario.height &&
                           scene_->antialiasing == scenario.antialiasing;
    if (!same_size) scene_->drawn.clear();
    scene_->width = scenario.width;
    scene_->height = scenario.height;
    scene_->antialiasing = scenario.antialiasing;
  }

  // Keeps what this condition draws too; what has a history begins anew, or pictures would depend on what was measured
  // before.
  void forget_others(const std::vector<Entry>& entries) {
    std::erase_if(scene_->drawn, [&](const auto& kept) {
      return kept.second->representation().has_history() ||
             std::none_of(entries.begin(), entries.end(), [&](const Entry& e) { return e.text == kept.first; });
    });
  }

  void draw_and_time(std::vector<Entry>& entries, MeasuredCondition& out) {
    display_ = display_of_scenario(condition_->scenario, plan_.folder, {});
    load();
    forget_others(entries);
    note_("solving for the view");
    staged_ = stage_scenario(condition_->scenario, scene_->cast, context_);
    facts_ = measure_stage(staged_, scene_->cast, context_);
    throw_if_interrupted();
    if (facts_.unreachable) {
      all_are(out, "unreachable",
              fmt::format("{} cover {} at most, {} were asked for", agents_text(condition_->scenario.crowd.agents),
                          percent_text(facts_.coverage.occupancy), percent_text(*condition_->scenario.occupancy)));
      return;
    }
    scene_->stage->show(staged_);
    for (Entry& entry : entries) look(entry, entries[0]);
    if (!entries[0].fault.empty()) throw Error("reference " + entries[0].text, entries[0].fault);
    VariantTimes twin;
    if (plan_.measures.times) twin = time(entries);
    make_rows(entries, twin, out);
  }

  void look(Entry& entry, const Entry& reference) {
    try {
      auto& place = scene_->drawn[entry.text];
      if (!place) {
        note_("baking " + entry.text);
        place = std::make_unique<TimedRepresentation>(*scene_->stage, entry.spec, condition_->scenario,
                                                      plan_.measures.bake_budget);
      }
      note_("looking at " + entry.text);
      entry.drawn = place.get();
      entry.picture = place->capture(0);
      entry.check = check_pictures(entry.picture, place->capture(kSecondTick), place->is_floor(),
                                   &entry == &reference ? std::nullopt : std::optional(reference.check));
      entry.counts = place->count(0);
      entry.touched_px = place->touched_px(0);
    } catch (const Error& error) {
      entry.fault = error.what();
      entry.drawn = nullptr;
      scene_->drawn.erase(entry.text);
    }
    throw_if_interrupted();
  }

  // Returns the times of the twin.
  VariantTimes time(std::vector<Entry>& entries) {
    std::vector<Variant> variants;
    std::vector<Entry*> of;
    for (Entry& entry : entries)
      if (entry.drawn != nullptr) {
        variants.push_back(entry.drawn->variant());
        of.push_back(&entry);
      }
    if (plan_.measures.aa) variants.push_back(entries[0].drawn->variant());
    TimingPlan timing;
    timing.rounds = plan_.measures.rounds;
    timing.least_rounds = kLeastRounds;
    timing.metric = method_.headline;
    timing.time_limit_ns = static_cast<int64_t>(plan_.measures.time_limit_s * 1e9);
    timing.order_seed = order_seed();
    int round = 0;
    std::vector<VariantTimes> times = time_interleaved(variants, timing, clocks_, gpu_, [&] {
      note_(fmt::format("round {}", ++round));
      throw_if_interrupted();
    });
    for (size_t i = 0; i < of.size(); ++i) of[i]->times = std::move(times[i]);
    return plan_.measures.aa ? std::move(times.back()) : VariantTimes{};
  }

  void put_ratio(SweepPointRow& row, const VariantTimes& reference, const VariantTimes& its) const {
    if (const auto ratio = paired_ratio(reference.samples, its.samples, method_.headline, kBootstrapSeed)) {
      row.ratio = ratio->median;
      row.ratio_low = ratio->interval.low;
      row.ratio_high = ratio->interval.high;
    }
  }

  void make_rows(const std::vector<Entry>& entries, const VariantTimes& twin, MeasuredCondition& out) const {
    const auto add = [&](const std::string& role, const std::string& representation) {
      const auto entry =
          std::find_if(entries.begin(), entries.end(), [&](const Entry& e) { return e.text == representation; });
      out.points.push_back(made_of(role, *entry, entries[0]));
    };
    for (const PlannedPoint& point : condition_->points) add("point", point.representation);
    if (!is_planned(entries[0].text)) add("reference", entries[0].text);
    if (!plan_.measures.times || !plan_.measures.aa) return;
    MeasuredPoint made;
    made.row = row_of("aa", entries[0].text);
    put_ratio(made.row, entries[0].times, twin);
    out.points.push_back(std::move(made));
  }

  MeasuredPoint made_of(const std::string& role, const Entry& entry, const Entry& reference) const {
    MeasuredPoint made;
    made.row = row_of(role, entry.text);
    if (!entry.fault.empty()) {
      made.row.state = "failed";
      made.row.reason = entry.fault;
      return made;
    }
    made.measurement = measurement_of(entry, reference);
    if (made.measurement->status == Status::invalid) {
      made.row.state = "invalid";
      made.row.reason = made.measurement->reason;
    }
    const bool itself = &entry == &reference;
    if (plan_.measures.times) {
      if (!itself) put_ratio(made.row, reference.times, entry.times);
      made.ratios = ratio_rows(0, made.measurement->key, entry.times, reference.text,
                               itself ? nullptr : &reference.times, nullptr);
    }
    if (!itself && !plan_.measures.scores.empty()) compare(made, entry, reference);
    return made;
  }

  MeasurementRow measurement_of(const Entry& entry, const Entry& reference) const {
    const scene::Scenario& scenario = condition_->scenario;
    MeasurementRow row;
    row.key = {entry.text,     cast_name(scene_->cast), scenario.crowd.agents,
               scenario.width, scenario.height,         scenario.occupancy.value_or(0)};
    row.reference = reference.text;
    put_stage(row, facts_);
    if (plan_.measures.times) {
      put_times(row, entry.times, kBootstrapSeed);
    } else {
      row.status = Status::skipped;
      row.reason = "the plan asks for no times";
    }
    row.covered_px = entry.check.covered_px;
    row.moved_px = entry.check.moved_px;
    row.touched_px = entry.touched_px;
    row.reference_px = reference.check.covered_px;
    if (!entry.check.fault.empty()) {
      row.status = Status::invalid;
      row.reason = entry.check.fault;
    }
    entry.drawn->put_footprint(row);
    row.vertices_shaded = entry.counts.vertex_invocations;
    row.primitives = entry.counts.clipping_output;
    row.fragments = entry.counts.fragment_invocations;
    row.samples_passed = entry.counts.samples_passed;
    return row;
  }

  void compare(MeasuredPoint& made, const Entry& entry, const Entry& reference) const {
    const PointKey& key = made.measurement->key;
    ComparisonRow row;
    row.kind = "crowd";
    row.representation = key.representation;
    row.reference = reference.text;
    row.character = key.character;
    row.agents = key.agents;
    row.requested_occupancy = key.requested_occupancy;
    row.scores = score_crowd(plan_.measures.scores, display_, reference.picture, entry.picture);
    put_display(row, display_);
    made.comparison = std::move(row);
    if (plan_.measures.pictures)
      made.pictures = comparison_pictures(reference.picture.colour, entry.picture.colour, reference.text, entry.text);
  }

  gl::Context& context_;
  const TimingMethod& method_;
  const Plan& plan_;
  std::function<void(const std::string&)> note_;
  std::optional<GpuTimer> gpu_;
  RunRow machine_;
  Clocks clocks_ = system_clocks();
  const Condition* condition_ = nullptr;
  int repetition_ = 0;
  metrics::ChosenDisplay display_;
  Staged staged_;
  StageFacts facts_;
  std::unique_ptr<Scene> scene_;
};

ConditionBench::ConditionBench(gl::Context& context, const TimingMethod& method, const Plan& plan,
                               std::function<void(const std::string&)> note)
    : impl_(new Impl(context, method, plan, std::move(note))) {}
ConditionBench::~ConditionBench() = default;

MeasuredCondition ConditionBench::measure(size_t condition, int repetition) {
  return impl_->measure(condition, repetition);
}

void write_condition(StoreWriter& store, int64_t sweep, const MeasuredCondition& measured) {
  store.begin();
  const int64_t run = store.write(measured.run);
  for (MeasuredPoint point : measured.points) {
    point.row.sweep = sweep;
    point.row.run = run;
    if (point.measurement) {
      point.measurement->run = run;
      point.row.measurement = store.write(*point.measurement);
    }
    for (RatioRow& ratio : point.ratios) {
      ratio.run = run;
      store.write(ratio);
    }
    if (point.comparison) {
      point.comparison->run = run;
      point.row.comparison = store.write(*point.comparison);
      for (PictureRow& picture : point.pictures) {
        picture.run = run;
        picture.comparison = point.row.comparison;
        store.write(picture);
      }
    }
    store.write(point.row);
  }
  store.commit();
}

}  // namespace crowdbench::bench::sweep
