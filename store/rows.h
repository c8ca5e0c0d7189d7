// The rows of the result store as plain structs. What each field means, with its unit and its name in SQL and in every
// export, is said once, in store/columns*.cpp; `crowdbench schema --results` prints it. std::nullopt: not available.
#pragma once
#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace crowdbench {

// One invocation that measured: what was run, by what, on what.
struct RunRow {
  int64_t id = 0;  // given by the store, here and below
  std::string command;
  std::string arguments;
  std::string started;
  std::string version;
  std::string revision;
  std::string scenario_name;
  std::string scenario;
  std::string scenario_hash;
  uint64_t seed = 0;
  std::optional<uint64_t> order_seed;
  std::string gl_vendor, gl_renderer, gl_version;
  bool software = false;
  std::string headline;
  std::optional<std::string> cpu_model;
  std::optional<double> cpu_mhz;
  std::optional<bool> cpu_scaling_enabled;
  int cpu_threads = 0;
  std::string os;
  double timer_cost_ns = 0;
  bool operator==(const RunRow&) const = default;
};

enum class Status : uint8_t {
  valid,        // timed, and a frame of the same run passed the image check
  invalid,      // timed, but the image check failed: the reason says how
  unreachable,  // not timed: the achieved occupancy is more than one percentage point off the requested
  skipped,      // not timed: the point makes no sense (the reason says why)
  stopped       // not timed: the curve ended before this point (the reason says where and why)
};
inline constexpr Status kStatuses[] = {Status::valid, Status::invalid, Status::unreachable, Status::skipped,
                                       Status::stopped};
const char* status_name(Status status);
Status status_of(const std::string& name);  // throws Error on any other text

// What a point is: two rows of one scenario with equal keys measure the same thing.
struct PointKey {
  std::string representation;
  std::string character;
  uint32_t agents = 0;
  int width = 0;
  int height = 0;
  double requested_occupancy = 0;  // 0: the scenario's own camera
  auto operator<=>(const PointKey&) const = default;
};

// A median with a bootstrap 95 % interval and percentiles of the raw samples, nanoseconds.
struct TimeSummary {
  double median = 0;
  double low = 0, high = 0;  // interval of the median
  double p05 = 0, p95 = 0, p99 = 0;
  bool operator==(const TimeSummary&) const = default;
};

// One timed frame.
struct SampleRow {
  int round = 0;
  uint64_t tick = 0;
  int64_t frame_ns = 0;
  int64_t cpu_ns = 0;
  int64_t main_cpu_ns = 0;
  std::optional<int64_t> gpu_ns;
  bool operator==(const SampleRow&) const = default;
};

// One representation at one point: what was on screen, what it cost.
struct MeasurementRow {
  int64_t id = 0;
  int64_t run = 0;
  PointKey key;
  Status status = Status::valid;
  std::string reason;  // empty only when valid
  std::string reference;

  std::optional<double> achieved_occupancy;
  std::optional<uint64_t> covered_px, reference_px, moved_px, touched_px;
  std::optional<uint32_t> agents_wholly, agents_partly, agents_off;
  std::optional<uint64_t> triangles_per_agent;

  int rounds = 0;
  int warmup_frames = 0;
  bool settled = false;
  std::optional<TimeSummary> frame_ns, cpu_ns, main_cpu_ns, gpu_ns;
  std::optional<double> low_1_percent_fps;

  std::optional<uint64_t> vertices_shaded, primitives, fragments, samples_passed;
  std::optional<uint64_t> texture_bytes, buffer_bytes, upload_bytes_per_frame, disk_bytes, shared_bytes;
  std::optional<double> bake_seconds;
  std::optional<double> bake_load_seconds;
  std::optional<bool> bake_cached;

  std::vector<SampleRow> samples;  // filled on writing; on reading only when asked for
  bool operator==(const MeasurementRow&) const = default;
};

// The median of the paired ratios of two variants that were drawn in the same rounds.
struct RatioRow {
  int64_t id = 0;
  int64_t run = 0;
  std::string kind;  // "speed" or "floor"
  PointKey of;
  std::string to;
  std::string metric;  // "cpu", "wall" or "gpu"
  double ratio = 0;
  double low = 0, high = 0;
  int pairs = 0;
  bool operator==(const RatioRow&) const = default;
};

// A control (A/A): one representation twice in the same rounds, as if it were two.
struct ControlRow {
  int64_t id = 0;
  int64_t run = 0;
  PointKey of;
  std::string metric;  // "cpu", "wall" or "gpu"
  double ratio = 0;
  double low = 0, high = 0;
  double p = 1;
  double detectable = 0;
  int pairs = 0;
  bool operator==(const ControlRow&) const = default;
};

// One score of a comparison. A new score is a new name, never a new column.
struct ScoreRow {
  std::string name;
  std::optional<double> value;  // +inf is kept; absent with a reason
  std::string reason;
  bool operator==(const ScoreRow&) const = default;
};

// Two pictures of the same view and what they differ by.
struct ComparisonRow {
  int64_t id = 0;
  int64_t run = 0;
  std::string kind;  // "crowd", "agent" or "agent_in_crowd"
  std::string representation;
  std::string reference;
  std::string character;
  // kinds "crowd" and "agent_in_crowd"
  uint32_t agents = 0;
  double requested_occupancy = 0;
  uint64_t tick = 0;
  // kind "agent"
  std::optional<double> height_px, azimuth_deg, elevation_deg;
  std::string clip;
  std::optional<double> time;
  // kind "agent_in_crowd", which has height_px too
  std::optional<uint32_t> agent;
  std::optional<double> distance, pixels_per_texel;
  std::optional<uint64_t> alone_px, visible_px;
  std::optional<std::string> state;
  // any kind
  std::optional<std::string> display;
  std::optional<bool> display_given;
  std::vector<ScoreRow> scores;
  bool operator==(const ComparisonRow&) const = default;
};

// A plan of a sweep, as one shard of it was measured into this file.
struct SweepRow {
  int64_t id = 0;
  std::string plan_name;
  std::string plan_hash;
  std::string plan;
  uint32_t conditions = 0;
  uint32_t repetitions = 1;
  uint64_t points = 0;
  uint32_t shard = 1;
  uint32_t shards = 1;
  std::string revision;
  std::string gl_renderer, gl_version;
  bool operator==(const SweepRow&) const = default;
};

// One representation at one condition of a sweep, or what stands beside it: the reference, its A/A twin.
struct SweepPointRow {
  int64_t id = 0;
  int64_t sweep = 0;
  int64_t run = 0;
  uint32_t condition = 0;
  uint32_t repetition = 0;
  std::string role;  // "point", "reference" or "aa"
  std::string point_key;
  std::string representation;
  std::string settings;
  std::string state;  // "done", "invalid", "unreachable" or "failed"
  std::string reason;
  std::optional<int64_t> measurement, comparison;
  std::optional<double> ratio, ratio_low, ratio_high;
  double seconds = 0;
  bool operator==(const SweepPointRow&) const = default;
};

// A PNG.
struct PictureRow {
  int64_t id = 0;
  int64_t run = 0;
  std::optional<int64_t> comparison;
  std::string role;  // "reference", "test", "difference", "hero", ...
  std::string caption;
  int width = 0, height = 0;
  std::vector<uint8_t> png;
  bool operator==(const PictureRow&) const = default;
};

// One bin of a curve.
struct CurveBinRow {
  int bin = 0;
  double from = 0, to = 0, x = 0;
  double median = 0, low = 0, high = 0;  // may be infinite
  uint64_t points = 0;
  uint32_t agents = 0;
  bool operator==(const CurveBinRow&) const = default;
};

// A score of the agents of a crowd against how far away they are.
struct CurveRow {
  int64_t id = 0;
  int64_t run = 0;
  std::string representation;
  std::string reference;
  std::string character;
  std::string score;
  std::string against;  // "distance_m", "height_px" or "pixels_per_texel"
  uint64_t points = 0;
  uint32_t agents = 0;
  std::optional<double> rank_correlation;
  std::string display;
  bool display_given = false;
  std::vector<CurveBinRow> bins;
  bool operator==(const CurveRow&) const = default;
};

// From where on a curve is good enough.
struct ThresholdRow {
  int64_t id = 0;
  int64_t run = 0;
  int64_t curve = 0;
  double value = 0;
  std::string status;
  std::optional<double> at, low, high;
  bool operator==(const ThresholdRow&) const = default;
};

// How much of a range of heights' squared error one cause has.
struct CauseShareRow {
  std::string cause;
  std::string title;
  double share = 0;  // below 0: it undoes error of a cause before it
  bool operator==(const CauseShareRow&) const = default;
};

// What the error of figures of one range of heights comes from.
struct CauseRangeRow {
  int64_t id = 0;
  int64_t run = 0;
  std::string representation;
  std::string reference;
  std::string character;
  std::string unit;                     // "view" or "agent"
  double from = 0;                      // pixels
  std::optional<double> below;          // absent: no end
  uint64_t units = 0;                   // that are of such a height
  uint64_t total = 0;                   // code values squared
  double residue = 0;                   // its share
  std::optional<std::string> dominant;  // a cause; absent: not distinguishable
  std::optional<double> share_low, share_high;
  std::string words;
  std::vector<CauseShareRow> shares;
  bool operator==(const CauseRangeRow&) const = default;
};

// One score of a switch.
struct PopScoreRow {
  std::string name;
  std::optional<double> value;
  bool operator==(const PopScoreRow&) const = default;
};

// A switch of an agent in a sequence of frames.
struct PopRow {
  int64_t id = 0;
  int64_t run = 0;
  std::string representation;
  std::string character;
  std::string from, to;
  uint32_t agent = 0;
  uint64_t tick = 0;
  uint64_t frames = 0;
  bool complete = true;
  double distance = 0;
  uint64_t pixels = 0;
  uint64_t worst_tick = 0;
  std::string display;
  std::vector<PopScoreRow> scores;
  bool operator==(const PopRow&) const = default;
};

// A change of representation in a tuned rule.
struct TunedSwitchRow {
  int place = 0;
  std::string from, to;
  double height_px = 0;
  std::optional<double> low_px, high_px;
  double share = 0;
  bool decided = false;
  double depth = 0;
  std::optional<double> pixels_per_texel, pixels_per_error;
  double hysteresis = 0;
  std::optional<double> pop;
  bool operator==(const TunedSwitchRow&) const = default;
};

// Which representation to draw from which height on, as `tune` found it.
struct TuningRow {
  int64_t id = 0;
  int64_t run = 0;
  std::string character;
  std::string score;
  double threshold = 0;
  std::string pop_score;
  double pop_threshold = 0;
  std::optional<double> budget_ns;
  std::optional<std::string> representation;  // absent: there is none, and the reason says why
  std::string reason;
  double agents = 0;
  std::optional<double> saving, saving_low, saving_high;
  std::optional<double> promised, promised_low, promised_high;
  std::optional<bool> lenses_hold, proof_holds;
  std::string display;
  bool display_given = false;
  std::vector<TunedSwitchRow> switches;
  bool operator==(const TuningRow&) const = default;
};

// One case of the stability battery, asked of one representation or once.
struct StabilityCaseRow {
  int64_t id = 0;
  int64_t run = 0;
  std::string name;
  std::string group;
  std::optional<std::string> representation;  // absent: asked once
  std::optional<double> measured, bound;
  std::string unit;
  bool pass = false;
  bool bound_seen = false;
  bool small = false;
  std::string place, expected, got;
  std::string note;
  std::string error;
  bool operator==(const StabilityCaseRow&) const = default;
};

// Somebody who takes part in a study.
struct StudyParticipantRow {
  int64_t id = 0;
  std::string study;        // hash of the plan
  std::string participant;  // a hash; empty: withdrawn
  std::string list;
  std::string state;  // "started", "finished" or "withdrawn"
  std::string token;  // a hash; empty: nobody may add to it
  std::string started;
  std::optional<std::string> ended;
  std::optional<double> pixels_per_degree, pixels_per_degree_se;
  std::optional<std::string> begun;  // JSON: of every trial how often it was begun
  bool operator==(const StudyParticipantRow&) const = default;
};

// One thing that a participant answered: a trial, or a page before or after them.
struct StudyAnswerRow {
  int64_t id = 0;
  int64_t participant = 0;
  std::string item;  // "t001", "consent", "calibration", ...
  std::string kind;  // "training", "main", "catch" or "page"
  std::optional<std::string> stimulus;
  std::optional<uint32_t> block;
  std::optional<std::string> answer;
  std::optional<double> rt;  // milliseconds
  std::optional<uint32_t> replays, frames_dropped, hidden, restarts;
  std::string received;
  std::string data;  // the page's whole record, JSON
  bool operator==(const StudyAnswerRow&) const = default;
};

// What a file holds; samples, scores, bins, shares and switches lie in the rows that they belong to.
struct StoreContents {
  std::vector<RunRow> runs;
  std::vector<MeasurementRow> measurements;
  std::vector<RatioRow> ratios;
  std::vector<ControlRow> controls;
  std::vector<ComparisonRow> comparisons;
  std::vector<SweepRow> sweeps;
  std::vector<SweepPointRow> sweep_points;
  std::vector<PictureRow> pictures;
  std::vector<CurveRow> curves;
  std::vector<ThresholdRow> thresholds;
  std::vector<CauseRangeRow> cause_ranges;
  std::vector<PopRow> pops;
  std::vector<TuningRow> tunings;
  std::vector<StabilityCaseRow> stability_cases;
  std::vector<StudyParticipantRow> participants;
  std::vector<StudyAnswerRow> answers;
  std::map<int64_t, std::string> sources;  // by run the file that it is from, where several were joined; else empty
};

}  // namespace crowdbench
