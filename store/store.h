// The result store: one SQLite file (write-ahead log), one row a measurement, raw samples kept apart from aggregates.
//
// Every time is a column of its own with its unit in its name; what was not available is std::nullopt here and NULL
// there, never 0. A point that failed is a row with its status and the reason, never a hole. Each write_* call is one
// transaction, so that Ctrl-C or a full disk leaves a file that holds every point finished before, and no half of one.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace crowdbench {

// SQLite's application_id of our files ("crwd") and the version of the schema (its user_version).
inline constexpr int kStoreApplicationId = 0x63727764;
inline constexpr int kStoreSchemaVersion = 1;

// One invocation that measured: what was run, by what, on what.
struct RunRow {
  int64_t id = 0;             // given by the store
  std::string command;        // "bench", "demo", "ratio"
  std::string arguments;      // as typed, for people
  std::string started;        // UTC, ISO 8601; the only place where a clock's time of day is kept
  std::string version;        // of crowdbench
  std::string revision;       // git describe
  std::string scenario_name;  //
  std::string scenario;       // TOML, every key written
  std::string scenario_hash;  // SHA-256 of that text
  uint64_t seed = 0;
  std::string gl_vendor, gl_renderer, gl_version;
  bool software = false;     // a CPU pretends to be the GPU: times serve for ratios only
  std::string headline;      // "cpu" or "gpu" or "wall": which time ratios and charts are made of
  std::string cpu_model;     //
  int cpu_threads = 0;       // hardware threads the process may use
  std::string os;            // kernel name and release
  double timer_cost_ns = 0;  // median cost of reading the three clocks once around an empty frame
};

enum class Status : uint8_t {
  valid,        // timed, and a frame of the same run passed the image check
  invalid,      // timed, but the image check failed: the reason says how
  unreachable,  // not timed: the achieved occupancy is more than one percentage point off the requested
  skipped,      // not timed: the point makes no sense (the reason says why)
  stopped       // not timed: the curve ended before this point (the reason says where and why)
};
const char* status_name(Status status);
Status status_of(const std::string& name);  // throws Error on any other text

// What a point is: two rows of one scenario with equal keys measure the same thing.
struct PointKey {
  std::string representation;  // canonical text, options included ("flat:views=64")
  std::string character;       // sources joined by " + "
  uint32_t agents = 0;
  int width = 0;                   // pixels
  int height = 0;                  // pixels
  double requested_occupancy = 0;  // fraction of the picture, 0: the scenario's own camera
  auto operator<=>(const PointKey&) const = default;
};

// A median with a bootstrap 95 % interval and percentiles of the raw samples, nanoseconds.
struct TimeSummary {
  double median = 0;
  double low = 0, high = 0;  // interval of the median
  double p05 = 0, p95 = 0, p99 = 0;
};

// One timed frame. All of one round were drawn one after another, in the order of the variants.
struct SampleRow {
  int round = 0;
  uint64_t tick = 0;
  int64_t frame_ns = 0;     // wall clock, from a Frame in hand to finished colour and depth
  int64_t cpu_ns = 0;       // CPU time of the whole process
  int64_t main_cpu_ns = 0;  // CPU time of the drawing thread
  std::optional<int64_t> gpu_ns;
};

struct MeasurementRow {
  int64_t id = 0;
  int64_t run = 0;
  PointKey key;
  Status status = Status::valid;
  std::string reason;     // empty only when valid
  std::string reference;  // the representation that the others are measured against ("mesh")

  // What was on screen (id buffer of an untimed frame of the same state).
  std::optional<double> achieved_occupancy;  // of the reference, as the solver left it
  std::optional<uint64_t> covered_px;        // pixels with an agent id, this representation
  std::optional<uint64_t> reference_px;      // the same, of the reference at the same tick
  std::optional<uint64_t> moved_px;          // pixels that differ between the two ticks of the image check
  std::optional<uint64_t> touched_px;        // pixels that any fragment reached, alpha-tested away or not
  std::optional<uint32_t> agents_wholly, agents_partly, agents_off;  // on screen, by projected bounds
  std::optional<uint64_t> triangles_per_agent;

  int rounds = 0;
  int warmup_frames = 0;
  bool settled = false;  // the warm-up ended because the running median had settled, not at its limit
  std::optional<TimeSummary> frame_ns, cpu_ns, main_cpu_ns, gpu_ns;
  std::optional<double> low_1_percent_fps;  // 1e9 / mean of the slowest 1 % of frame_ns (at least one frame)

  // Pipeline statistics of one untimed frame.
  std::optional<uint64_t> vertices_shaded, primitives, fragments, samples_passed;

  // Bytes, exactly.
  std::optional<uint64_t> texture_bytes, buffer_bytes, upload_bytes_per_frame, disk_bytes, shared_bytes;
  std::optional<double> bake_seconds;
  std::optional<bool> bake_cached;

  std::vector<SampleRow> samples;  // filled on writing; on reading only when asked for
};

// The median of the paired ratios of two variants that were drawn in the same rounds.
struct RatioRow {
  int64_t id = 0;
  int64_t run = 0;
  std::string kind;    // "speed" (of against the reference) or "floor" (time over the same draw with the work removed)
  PointKey of;         // the point measured
  std::string to;      // the other representation's canonical text
  std::string metric;  // "cpu", "wall" or "gpu"
  double ratio = 0;    // median of t(to) / t(of) for "speed"; of t(of) / t(of's floor) for "floor"
  double low = 0, high = 0;  // bootstrap 95 % interval
  int pairs = 0;
};

struct ScoreRow {
  std::string name;             // "ssim", "psnr", "mae", "silhouette_iou", ...
  std::optional<double> value;  // +inf is kept; absent with a reason
  std::string reason;
};

// Two pictures of the same view and what they differ by.
struct ComparisonRow {
  int64_t id = 0;
  int64_t run = 0;
  std::string kind;            // "crowd" (a whole frame) or "agent" (one agent, as `quality` defines it)
  std::string representation;  // compared with `reference`
  std::string reference;
  std::string character;
  // kind "crowd"
  uint32_t agents = 0;
  double requested_occupancy = 0;
  uint64_t tick = 0;
  // kind "agent"
  std::optional<double> height_px, azimuth_deg, elevation_deg;
  std::string clip;
  std::optional<double> time;
  std::vector<ScoreRow> scores;
};

// A PNG. role: "hero", "reference", "test", "difference", "clip-frame", ...
struct PictureRow {
  int64_t id = 0;
  int64_t run = 0;
  std::optional<int64_t> comparison;  // the comparison that it belongs to
  std::string role;
  std::string caption;
  int width = 0, height = 0;
  std::vector<uint8_t> png;
};

struct StoreContents {
  std::vector<RunRow> runs;
  std::vector<MeasurementRow> measurements;
  std::vector<RatioRow> ratios;
  std::vector<ComparisonRow> comparisons;
  std::vector<PictureRow> pictures;
};

// A file that measurements are added to; made when it does not exist, continued when it does.
class StoreWriter {
 public:
  // Throws Error: not a SQLite file, another program's, a newer schema, read-only, locked by another writer, disk full.
  explicit StoreWriter(const std::filesystem::path& path);
  ~StoreWriter();
  StoreWriter(const StoreWriter&) = delete;
  StoreWriter& operator=(const StoreWriter&) = delete;

  // Each returns the new row's id and is one transaction. Throws Error; the file then holds what it held before.
  int64_t write(const RunRow& run);
  int64_t write(const MeasurementRow& measurement);
  int64_t write(const RatioRow& ratio);
  int64_t write(const ComparisonRow& comparison);
  int64_t write(const PictureRow& picture);

  // All writes between begin and commit are one transaction (one point of a sweep). Without commit the next begin, or
  // the destructor, takes them back.
  void begin();
  void commit();
  void rollback();

  // The latest row with this key (without samples) under a run of the same scenario, program revision and GL renderer:
  // what `bench` skips, and learns where a curve ended from, when it continues a file.
  std::optional<MeasurementRow> find(const RunRow& run, const PointKey& key) const;

  // The file may grow to this many pages of 4 KiB; beyond, a write fails as on a full disk.
  void limit_pages(int pages);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Reads a whole file; never writes to it (a file on a read-only medium is fine). Throws Error: missing, not ours,
// newer.
StoreContents read_store(const std::filesystem::path& path, bool with_samples = false, bool with_pictures = true);

}  // namespace crowdbench
