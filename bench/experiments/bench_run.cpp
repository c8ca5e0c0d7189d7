#include "bench/experiments/bench_run.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/utsname.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>

#include "bench/experiments/score_rows.h"
#include "core/error.h"
#include "core/hash.h"
#include "core/image_io.h"
#include "core/machine.h"
#include "core/progress.h"
#include "core/version.h"
#include "metrics/pseudocolour.h"
#include "scene/cast/cast.h"
#include "scene/scenario/scenario_writer.h"

namespace crowdbench::bench {
namespace {

constexpr uint64_t kBootstrapSeed = 1;
constexpr uint64_t kSecondTick = 15;

int usable_threads() {
  cpu_set_t set;
  CPU_ZERO(&set);
  return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
}

std::string agents_text(uint32_t agents) { return fmt::format("{} {}", agents, agents == 1 ? "agent" : "agents"); }

std::string percent(double fraction) { return fmt::format("{:.4g} %", 100 * fraction); }

std::string view_name(double occupancy) {
  return occupancy > 0 ? percent(occupancy) : std::string("the scenario's camera");
}

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

class Sweep {
 public:
  Sweep(gl::Context& context, const scene::Cast& cast, const TimingMethod& method, const RunRow& run,
        const SweepRequest& request, StoreWriter& store, const std::function<void(const std::string&)>& progress)
      : context_(context),
        method_(method),
        run_(run),
        request_(request),
        store_(store),
        progress_(progress),
        cast_(cast),
        stage_(context, cast),
        gpu_(gpu_timer_of(context, method)) {
    specs_.push_back(renderers::reference_spec());
    for (const renderers::Spec& spec : request.representations)
      if (std::none_of(specs_.begin(), specs_.end(), [&](const auto& s) { return s.text() == spec.text(); }))
        specs_.push_back(spec);
  }

  SweepSummary run() {
    for (const double occupancy : request_.occupancies) {
      curves_.assign(specs_.size(), {});
      const uint32_t shown = agents_to_show(occupancy);
      for (const uint32_t agents : request_.agents) point(agents, occupancy, agents == shown);
    }
    return summary_;
  }

 private:
  PointKey key(size_t spec, uint32_t agents, double occupancy) const {
    return {specs_[spec].text(),     cast_name(cast_),         agents,
            request_.scenario.width, request_.scenario.height, occupancy};
  }

  // Pictures are kept of the largest crowd up to picture_agents.
  uint32_t agents_to_show(double) const {
    uint32_t shown = request_.agents.front();
    for (const uint32_t agents : request_.agents)
      if (agents <= request_.picture_agents) shown = std::max(shown, agents);
    return shown;
  }

  void remark(const std::string& text) { summary_.remarks.push_back(text); }

  void end_curve(size_t spec, uint32_t agents, double occupancy, double frame_ns) {
    curves_[spec] = {true, fmt::format("at {} a frame took {:.0f} ms, over the budget of {:g} ms", agents_text(agents),
                                       frame_ns / 1e6, request_.budget_ms)};
    remark(fmt::format("{} at {}: stopped {}", specs_[spec].text(), view_name(occupancy), curves_[spec].reason));
  }

  void write_untimed(size_t spec, uint32_t agents, double occupancy, Status status, const std::string& reason,
                     const scene::Solved* solved) {
    MeasurementRow row;
    row.run = run_.id;
    row.key = key(spec, agents, occupancy);
    row.reference = specs_[0].text();
    row.status = status;
    row.reason = reason;
    if (solved != nullptr) put_solved(row, *solved);
    store_.write(row);
  }

  static void put_solved(MeasurementRow& row, const scene::Solved& solved) {
    row.achieved_occupancy = solved.achieved;
    row.agents_wholly = solved.agents_wholly;
    row.agents_partly = solved.agents_partly;
    row.agents_off = solved.agents_off;
  }

  // Whether the file holds the point for every representation that still runs; it then learns from it where curves end.
  bool take_from_store(uint32_t agents, double occupancy) {
    std::vector<std::optional<MeasurementRow>> rows;
    for (size_t s = 0; s < specs_.size(); ++s) {
      rows.push_back(store_.find(run_, key(s, agents, occupancy)));
      const bool held = rows[s] && (rows[s]->status != Status::stopped || curves_[s].ended);
      if (!held && !curves_[s].ended) return false;
    }
    bool any = false;
    for (size_t s = 0; s < specs_.size(); ++s) {
      if (!rows[s]) {
        write_untimed(s, agents, occupancy, Status::stopped, curves_[s].reason, nullptr);
        continue;
      }
      any = any || rows[s]->frame_ns.has_value();
      if (rows[s]->frame_ns && rows[s]->frame_ns->median > request_.budget_ms * 1e6 && !curves_[s].ended)
        end_curve(s, agents, occupancy, rows[s]->frame_ns->median);
    }
    if (any) ++summary_.held;
    return true;
  }

  void point(uint32_t agents, double occupancy, bool keep_pictures) {
    const std::string where = fmt::format("{} at {}", agents_text(agents), view_name(occupancy));
    if (take_from_store(agents, occupancy)) return;

    progress_(where + ": solving for the view");
    scene::Scenario scenario = request_.scenario;
    scenario.crowd.agents = agents;
    scenario.occupancy = occupancy > 0 ? std::optional(occupancy) : std::nullopt;
    const scene::Solved solved = solve_scene(context_, scenario, cast_);
    throw_if_interrupted();
    if (solved.unreachable) {
      const std::string reason = fmt::format("{} cover {} at most, {} were asked for", agents_text(agents),
                                             percent(solved.achieved), percent(occupancy));
      store_.begin();
      for (size_t s = 0; s < specs_.size(); ++s)
        write_untimed(s, agents, occupancy, Status::unreachable, reason, &solved);
      store_.commit();
      remark(where + ": skipped: " + reason);
      return;
    }
    stage_.show(solved.scenario, solved.crowd, solved.camera);

    // The reference is looked at even where its curve has ended.
    progress_(where + ": looking at the pictures");
    const renderers::Capture reference = timed(0).capture(0);
    const ImageCheck reference_check = check_pictures(reference, timed(0).capture(kSecondTick), false, std::nullopt);
    struct Entry {
      size_t spec = 0;
      ImageCheck check;
      renderers::Capture picture;
      std::optional<size_t> floor;  // place among the variants
      gl::PipelineCounts counts;
      uint64_t touched_px = 0;
    };
    std::vector<Entry> entries;
    std::vector<Variant> variants;
    for (size_t s = 0; s < specs_.size(); ++s) {
      if (curves_[s].ended) continue;
      Entry entry;
      entry.spec = s;
      entry.picture = s == 0 ? reference : timed(s).capture(0);
      entry.check =
          s == 0 ? reference_check
                 : check_pictures(entry.picture, timed(s).capture(kSecondTick), timed(s).is_floor(), reference_check);
      entry.counts = timed(s).count(0);
      entry.touched_px = timed(s).touched_px(0);
      variants.push_back(timed(s).variant());
      entries.push_back(std::move(entry));
      throw_if_interrupted();
    }
    if (request_.floors)
      for (Entry& entry : entries)
        if (TimedRepresentation* floor = floor_of(entry.spec); floor != nullptr) {
          entry.floor = variants.size();
          variants.push_back(floor->variant());
        }

    TimingPlan plan;
    plan.rounds = request_.rounds;
    plan.least_rounds = std::min(request_.least_rounds, request_.rounds);
    plan.metric = method_.headline;
    plan.time_limit_ns = static_cast<int64_t>(request_.time_limit_s * 1e9);
    plan.drop_above_ns = static_cast<int64_t>(2 * request_.budget_ms * 1e6);
    int round = 0;
    const auto results = time_interleaved(variants, plan, clocks_, gpu_, [&] {
      progress_(fmt::format("{}: turn {}", where, ++round));
      throw_if_interrupted();
    });

    store_.begin();
    for (size_t s = 0; s < specs_.size(); ++s)
      if (curves_[s].ended) write_untimed(s, agents, occupancy, Status::stopped, curves_[s].reason, &solved);
    for (size_t e = 0; e < entries.size(); ++e) {
      const Entry& entry = entries[e];
      if (results[e].dropped) {
        end_curve(entry.spec, agents, occupancy, static_cast<double>(results[e].warmup_frame_ns));
        write_untimed(entry.spec, agents, occupancy, Status::stopped, curves_[entry.spec].reason, &solved);
        continue;
      }
      MeasurementRow row;
      row.run = run_.id;
      row.key = key(entry.spec, agents, occupancy);
      row.reference = specs_[0].text();
      put_solved(row, solved);
      put_times(row, results[e], kBootstrapSeed);
      row.covered_px = entry.check.covered_px;
      row.touched_px = entry.touched_px;
      row.moved_px = entry.check.moved_px;
      row.reference_px = reference_check.covered_px;
      if (!entry.check.fault.empty()) {
        row.status = Status::invalid;
        row.reason = entry.check.fault;
        ++summary_.invalid;
        remark(fmt::format("{}: {}: invalid: {}", where, row.key.representation, row.reason));
      }
      put_footprint(row, timed(entry.spec));
      row.vertices_shaded = entry.counts.vertex_invocations;
      row.primitives = entry.counts.clipping_output;
      row.fragments = entry.counts.fragment_invocations;
      row.samples_passed = entry.counts.samples_passed;
      store_.write(row);
      write_ratios(row.key, results[e], entry.spec == 0 ? nullptr : reference_times(entries, results),
                   entry.floor ? &results[*entry.floor] : nullptr);
      if (entry.spec != 0) write_comparison(row.key, reference, entry.picture, keep_pictures);
      if (row.frame_ns->median > request_.budget_ms * 1e6)
        end_curve(entry.spec, agents, occupancy, row.frame_ns->median);
    }
    store_.commit();
    ++summary_.measured;
  }

  template <typename Entries>
  static const VariantTimes* reference_times(const Entries& entries, const std::vector<VariantTimes>& results) {
    return entries.front().spec == 0 && !results.front().dropped ? &results.front() : nullptr;
  }

  void write_ratios(const PointKey& of, const VariantTimes& times, const VariantTimes* reference,
                    const VariantTimes* floor) {
    for (const Metric metric : {Metric::cpu, Metric::wall, Metric::gpu}) {
      const auto write = [&](const char* kind, const std::string& to, const std::optional<MedianRatio>& ratio) {
        if (ratio)
          store_.write(RatioRow{0, run_.id, kind, of, to, metric_name(metric), ratio->median, ratio->interval.low,
                                ratio->interval.high, static_cast<int>(ratio->pairs)});
      };
      if (reference != nullptr)
        write("speed", specs_[0].text(), paired_ratio(reference->samples, times.samples, metric, kBootstrapSeed));
      if (floor != nullptr && !floor->dropped)
        write("floor", "floor=1", paired_ratio(times.samples, floor->samples, metric, kBootstrapSeed));
    }
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
    row.scores = score_crowd(request_.table, reference, test);
    const int64_t id = store_.write(row);
    if (keep_pictures)
      write_pictures(store_, run_.id, id, reference.colour, test.colour, row.reference, row.representation);
  }

  static void put_footprint(MeasurementRow& row, TimedRepresentation& timed) {
    const renderers::Footprint footprint = timed.representation().footprint();
    row.texture_bytes = footprint.texture_bytes;
    row.buffer_bytes = footprint.buffer_bytes;
    row.upload_bytes_per_frame = footprint.upload_bytes_per_frame;
    const renderers::BakeInfo bake = timed.representation().bake_info();
    if (!bake.cache_key.empty()) {
      row.disk_bytes = footprint.disk_bytes;
      row.bake_seconds = bake.seconds;
      row.bake_cached = bake.cached;
    }
    row.shared_bytes = timed.stage().renderer().shared_bytes();
    uint64_t triangles = 0;
    for (size_t c = 0; c < timed.stage().cast().characters.size(); ++c)
      triangles = std::max(triangles, timed.representation().triangles(c));
    row.triangles_per_agent = triangles;
  }

  // Baked at first use and kept for the whole sweep.
  TimedRepresentation& timed(size_t spec) {
    auto& place = timed_[spec];
    if (!place) {
      progress_("baking " + specs_[spec].text());
      place = std::make_unique<TimedRepresentation>(stage_, specs_[spec], request_.scenario.width,
                                                    request_.scenario.height, request_.bake_budget);
    }
    return *place;
  }
  // nullptr for a representation that is a floor itself, or has parts.
  TimedRepresentation* floor_of(size_t spec) {
    if (!specs_[spec].components.empty() || timed(spec).is_floor()) return nullptr;
    const renderers::Spec floor = with_floor(specs_[spec]);
    auto& place = floors_[spec];
    if (!place) {
      progress_("baking " + floor.text());
      place = std::make_unique<TimedRepresentation>(stage_, floor, request_.scenario.width, request_.scenario.height,
                                                    request_.bake_budget);
    }
    return place.get();
  }

  gl::Context& context_;
  const TimingMethod& method_;
  const RunRow& run_;
  const SweepRequest& request_;
  StoreWriter& store_;
  const std::function<void(const std::string&)>& progress_;
  const scene::Cast& cast_;
  Stage stage_;
  std::optional<GpuTimer> gpu_;
  Clocks clocks_ = system_clocks();
  std::vector<renderers::Spec> specs_;  // the reference first
  std::vector<Curve> curves_;
  std::map<size_t, std::unique_ptr<TimedRepresentation>> timed_;
  std::map<size_t, std::unique_ptr<TimedRepresentation>> floors_;
  SweepSummary summary_;
};

std::string interval_text(const std::optional<TimeSummary>& time) {
  return time ? fmt::format("{:.3f} [{:.3f}, {:.3f}]", time->median / 1e6, time->low / 1e6, time->high / 1e6) : "-";
}

}  // namespace

std::vector<renderers::Spec> parse_specs(const std::string& text) {
  std::vector<std::string> pieces(1);
  int depth = 0;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    depth += c == '(' ? 1 : c == ')' ? -1 : 0;
    if (c == ',' && depth == 0) {
      const size_t mark = text.find_first_of("=:(,", i + 1);
      if (mark == std::string::npos || text[mark] != '=') {
        pieces.emplace_back();
        continue;
      }
    }
    pieces.back() += c;
  }
  std::vector<renderers::Spec> specs;
  specs.reserve(pieces.size());
  for (const std::string& piece : pieces) specs.push_back(renderers::parse_spec(piece));
  return specs;
}

RunRow describe_run(gl::Context& context, const TimingMethod& method, const scene::Scenario& scenario,
                    const std::string& command, const std::string& arguments) {
  RunRow run;
  run.command = command;
  run.arguments = arguments;
  const std::time_t now = std::time(nullptr);
  run.started = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(now));
  run.version = version();
  run.revision = git_revision();
  run.scenario_name = scenario.name;
  run.scenario = scene::to_toml(scenario);
  run.scenario_hash = sha256_hex(run.scenario);
  run.seed = scenario.seed;
  run.gl_vendor = context.vendor();
  run.gl_renderer = context.renderer();
  run.gl_version = context.version();
  run.software = context.is_software();
  run.headline = metric_name(method.headline);
  const Machine machine = read_machine();
  run.cpu_model = machine.cpu_model;
  run.cpu_mhz = machine.cpu_mhz;
  run.cpu_scaling_enabled = machine.cpu_scaling_enabled;
  run.cpu_threads = usable_threads();
  utsname names{};
  if (uname(&names) == 0) run.os = fmt::format("{} {}", names.sysname, names.release);
  run.timer_cost_ns = timer_cost_ns(system_clocks());
  return run;
}

SweepSummary run_sweep(gl::Context& context, const scene::Cast& cast, const TimingMethod& method, const RunRow& run,
                       const SweepRequest& request, StoreWriter& store,
                       const std::function<void(const std::string&)>& progress) {
  return Sweep(context, cast, method, run, request, store, progress).run();
}

std::vector<ScoreRow> score_crowd(metrics::ScoreTable table, const renderers::Capture& reference,
                                  const renderers::Capture& test) {
  metrics::Shared shared;
  return score_rows(metrics::score_pictures(table, {buffers_of(reference), buffers_of(test)}, shared));
}

void write_pictures(StoreWriter& store, int64_t run, int64_t comparison, const Image8& reference, const Image8& test,
                    const std::string& reference_name, const std::string& test_name, bool bar) {
  const auto write = [&](const char* role, const std::string& caption, const Image8& image) {
    store.write(PictureRow{0, run, comparison, role, caption, image.width, image.height, encode_png(image)});
  };
  write("reference", reference_name, without_alpha(reference));
  write("test", test_name, without_alpha(test));
  const Image8 difference = metrics::pseudocolour(metrics::error_levels(reference, test));
  write("difference", fmt::format("absolute difference of {} and {}", reference_name, test_name),
        bar ? metrics::with_colour_bar(difference, "mean absolute difference, code values") : difference);
}

std::string sweep_table(const StoreContents& contents, const RunRow& run) {
  std::map<int64_t, const RunRow*> runs;
  for (const RunRow& row : contents.runs) runs[row.id] = &row;
  std::map<std::tuple<double, std::string, uint32_t>, const MeasurementRow*> rows;
  for (const MeasurementRow& row : contents.measurements) {
    const auto of = runs.find(row.run);
    if (of == runs.end() || of->second->scenario_hash != run.scenario_hash || of->second->revision != run.revision ||
        of->second->gl_renderer != run.gl_renderer)
      continue;
    rows[{row.key.requested_occupancy, row.key.representation, row.key.agents}] = &row;
  }
  std::string out =
      fmt::format("{:<10} {:<28} {:>7}  {:>28}  {:>28}  {:>22}  {:>8}\n", "occupancy", "representation", "agents",
                  "CPU ms [95 %]", "wall ms [95 %]", "times as fast (" + run.headline + ")", "covered");
  for (const auto& [place, row] : rows) {
    std::string speed = "-";
    for (const RatioRow& ratio : contents.ratios)
      if (ratio.kind == "speed" && ratio.of == row->key && ratio.metric == run.headline)
        speed = fmt::format("{:.2f} [{:.2f}, {:.2f}]", ratio.ratio, ratio.low, ratio.high);
    const std::string name = row->key.representation;
    out += fmt::format("{:<10} {:<28} {:>7}  ", view_name(row->key.requested_occupancy).substr(0, 10), name,
                       row->key.agents);
    if (!row->frame_ns) {
      out += fmt::format("{}: {}\n", status_name(row->status), row->reason);
      continue;
    }
    const double pixels = static_cast<double>(row->key.width) * row->key.height;
    out +=
        fmt::format("{:>28}  {:>28}  {:>22}  {:>8}{}\n", interval_text(row->cpu_ns), interval_text(row->frame_ns),
                    speed, row->covered_px ? percent(static_cast<double>(*row->covered_px) / pixels) : "-",
                    row->status == Status::valid ? "" : fmt::format("  {}: {}", status_name(row->status), row->reason));
  }
  return out;
}

}  // namespace crowdbench::bench
