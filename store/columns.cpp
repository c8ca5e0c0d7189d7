// What runs and times are stored as.
#include "store/column_fields.h"

namespace crowdbench {

using namespace column_fields;

// clang-format off
template <>
const Table<RunRow>& table<RunRow>() {
  using R = RunRow;
  static const Table<R> made = make_table<R>(
      {.name = "run", .rows = "runs", .meaning = "One invocation that measured: what was run, by what, on what."},
      &StoreContents::runs,
      id_field<&R::id>(),
      field<&R::command>({.name = "command", .meaning = "the command of crowdbench: \"bench\", \"demo\", ..."}),
      field<&R::arguments>({.name = "arguments",
                            .meaning = "the whole command line, quoted for a shell (schema 1: without its options)"}),
      field<&R::started>({.name = "started",
                          .meaning = "UTC, ISO 8601; the only place where a clock's time of day is kept"}),
      field<&R::version>({.name = "version", .meaning = "version of crowdbench"}),
      field<&R::revision>({.name = "revision", .meaning = "git describe of its source"}),
      field<&R::scenario_name>({.name = "scenario_name", .meaning = "name in the scenario"}),
      field<&R::scenario>({.name = "scenario", .meaning = "the scenario as TOML, every key written", .bulky = true}),
      field<&R::scenario_hash>({.name = "scenario_hash", .meaning = "SHA-256 of that text"}),
      field<&R::seed>({.name = "seed", .meaning = "seed of the crowd", .type = ColumnType::seed}),
      field<&R::order_seed>({.name = "order_seed",
                             .meaning = "seed of the random order in which variants take turns in a round",
                             .since = 2,
                             .type = ColumnType::seed}),
      field<&R::gl_vendor>({.name = "gl_vendor", .meaning = "GL_VENDOR"}),
      field<&R::gl_renderer>({.name = "gl_renderer", .meaning = "GL_RENDERER"}),
      field<&R::gl_version>({.name = "gl_version", .meaning = "GL_VERSION"}),
      field<&R::software>({.name = "software",
                           .meaning = "a CPU stands in for the GPU: times serve for ratios only"}),
      field<&R::headline>({.name = "headline",
                           .meaning = "the time that ratios and charts are made of",
                           .values = {"cpu", "wall", "gpu"}}),
      field<&R::cpu_model>({.name = "cpu_model",
                            .meaning = "the processor as the kernel names it",
                            .changed = 2,
                            .before = "nullif(cpu_model, 'unknown processor')"}),
      field<&R::cpu_mhz>({.name = "cpu_mhz",
                          .unit = "MHz",
                          .meaning = "highest clock that the kernel permits the first processor; without frequency "
                                     "scaling the clock that it reports",
                          .since = 2}),
      field<&R::cpu_scaling_enabled>({.name = "cpu_scaling_enabled",
                                      .meaning = "the kernel may lower the clock while something is measured",
                                      .since = 2}),
      field<&R::cpu_threads>({.name = "cpu_threads",
                              .unit = "threads",
                              .meaning = "hardware threads that the process may use"}),
      field<&R::os>({.name = "os", .meaning = "name and release of the kernel"}),
      field<&R::timer_cost_ns>({.name = "timer_cost_ns",
                                .unit = "ns",
                                .meaning = "median cost of reading the three clocks once around an empty frame"}));
  return made;
}

template <>
const Table<MeasurementRow>& table<MeasurementRow>() {
  using R = MeasurementRow;
  std::vector<std::string> statuses;
  for (const Status status : kStatuses) statuses.emplace_back(status_name(status));
  static const Table<R> made = make_table<R>(
      {.name = "measurement",
       .rows = "measurements",
       .meaning = "One representation at one point: what was on screen and what it cost. A point that failed is a row "
                  "with its status and the reason.",
       .index = {"representation", "agents", "requested_occupancy"}},
      &StoreContents::measurements,
      id_field<&R::id>(),
      run_field<&R::run>(),
      point_fields<&R::key>(),
      field<&R::status>({.name = "status",
                         .meaning = "valid: timed, and a frame of the same run passed the image check; invalid: it "
                                    "failed; the others were not timed",
                         .values = statuses}),
      field<&R::reason>({.name = "reason",
                         .meaning = "why it is not valid; else empty",
                         .check = "status = 'valid' OR reason <> ''"}),
      field<&R::reference>({.name = "reference",
                            .meaning = "the representation that the others are measured against"}),
      // Of the id buffer of an untimed frame of the same state.
      field<&R::achieved_occupancy>({.name = "achieved_occupancy",
                                     .unit = "fraction",
                                     .meaning = "share of the picture that the reference covers, as solved"}),
      field<&R::covered_px>({.name = "covered_px", .unit = "px", .meaning = "pixels that show an agent"}),
      field<&R::reference_px>({.name = "reference_px",
                               .unit = "px",
                               .meaning = "the same, of the reference at the same tick"}),
      field<&R::moved_px>({.name = "moved_px",
                           .unit = "px",
                           .meaning = "pixels that differ between the two ticks of the image check"}),
      field<&R::touched_px>({.name = "touched_px",
                             .unit = "px",
                             .meaning = "pixels that any fragment reached, alpha-tested away or not"}),
      field<&R::agents_wholly>({.name = "agents_wholly",
                                .unit = "agents",
                                .meaning = "wholly on screen, by projected bounds"}),
      field<&R::agents_partly>({.name = "agents_partly", .unit = "agents", .meaning = "partly on screen"}),
      field<&R::agents_off>({.name = "agents_off", .unit = "agents", .meaning = "off screen"}),
      field<&R::triangles_per_agent>({.name = "triangles_per_agent",
                                      .unit = "triangles",
                                      .meaning = "most triangles that an agent is drawn with"}),
      field<&R::rounds>({.name = "rounds", .unit = "frames", .meaning = "timed frames"}),
      field<&R::warmup_frames>({.name = "warmup_frames", .unit = "frames", .meaning = "frames drawn before them"}),
      field<&R::settled>({.name = "settled",
                          .meaning = "the warm-up ended because the running median had settled, not at its limit"}),
      time_fields<&R::frame_ns>("frame_ns", "wall clock from a frame in hand to finished colour and depth"),
      time_fields<&R::cpu_ns>("cpu_ns", "CPU time of the whole process"),
      time_fields<&R::main_cpu_ns>("main_cpu_ns", "CPU time of the drawing thread"),
      time_fields<&R::gpu_ns>("gpu_ns", "GPU time"),
      field<&R::low_1_percent_fps>({.name = "low_1_percent_fps",
                                    .unit = "1/s",
                                    .meaning = "1e9 / mean of the slowest 1 % of frame_ns (at least one frame)"}),
      // Pipeline statistics of one untimed frame.
      field<&R::vertices_shaded>({.name = "vertices_shaded",
                                  .unit = "vertices",
                                  .meaning = "vertex shader invocations of a frame"}),
      field<&R::primitives>({.name = "primitives", .unit = "primitives", .meaning = "output by clipping in a frame"}),
      field<&R::fragments>({.name = "fragments",
                            .unit = "fragments",
                            .meaning = "fragment shader invocations of a frame"}),
      field<&R::samples_passed>({.name = "samples_passed",
                                 .unit = "samples",
                                 .meaning = "passed the depth test in a frame"}),
      field<&R::texture_bytes>({.name = "texture_bytes", .unit = "bytes", .meaning = "of textures on the GPU"}),
      field<&R::buffer_bytes>({.name = "buffer_bytes", .unit = "bytes", .meaning = "of buffers on the GPU"}),
      field<&R::upload_bytes_per_frame>({.name = "upload_bytes_per_frame",
                                         .unit = "bytes",
                                         .meaning = "sent to the GPU for each frame"}),
      field<&R::disk_bytes>({.name = "disk_bytes", .unit = "bytes", .meaning = "of the bake on disk"}),
      field<&R::shared_bytes>({.name = "shared_bytes",
                               .unit = "bytes",
                               .meaning = "on the GPU for all representations together: poses, textures of characters"}),
      field<&R::bake_seconds>({.name = "bake_seconds",
                               .unit = "s",
                               .meaning = "time that making the bake took, in this run or in the one that stored it",
                               .changed = 9,
                               .before = "CASE WHEN bake_cached = 0 THEN bake_seconds END"}),
      field<&R::bake_load_seconds>({.name = "bake_load_seconds",
                                    .unit = "s",
                                    .meaning = "time that reading it from the cache took, where it came from there",
                                    .since = 9,
                                    .changed = 9,
                                    .before = "CASE WHEN bake_cached = 1 THEN bake_seconds END"}),
      field<&R::bake_cached>({.name = "bake_cached", .meaning = "the bake came from the cache on disk"}));
  return made;
}

template <>
const Table<SampleRow>& table<SampleRow>() {
  using R = SampleRow;
  static const Table<R> made = make_table<R>(
      {.name = "sample",
       .rows = "samples",
       .meaning = "One timed frame. All of one round were drawn one after another.",
       .owner = "measurement",
       .within = "round"},
      nullptr,
      field<&R::round>({.name = "round", .meaning = "number of the turn, from 0"}),
      field<&R::tick>({.name = "tick", .unit = "ticks", .meaning = "moment of the animation"}),
      field<&R::frame_ns>({.name = "frame_ns",
                           .unit = "ns",
                           .meaning = "wall clock from a frame in hand to finished colour and depth"}),
      field<&R::cpu_ns>({.name = "cpu_ns", .unit = "ns", .meaning = "CPU time of the whole process"}),
      field<&R::main_cpu_ns>({.name = "main_cpu_ns", .unit = "ns", .meaning = "CPU time of the drawing thread"}),
      field<&R::gpu_ns>({.name = "gpu_ns", .unit = "ns", .meaning = "GPU time"}));
  return made;
}

template <>
const Table<RatioRow>& table<RatioRow>() {
  using R = RatioRow;
  static const Table<R> made = make_table<R>(
      {.name = "ratio",
       .rows = "ratios",
       .meaning = "The median of the paired ratios of two variants that were drawn in the same rounds."},
      &StoreContents::ratios,
      id_field<&R::id>(),
      run_field<&R::run>(),
      field<&R::kind>({.name = "kind",
                       .meaning = "speed: time of `to` over time of the point; floor: time of the point over that of "
                                  "the same draw with the work removed",
                       .values = {"speed", "floor"}}),
      point_fields<&R::of>(),
      field<&R::to>({.name = "to", .meaning = "canonical text of the other representation"}),
      field<&R::metric>({.name = "metric", .meaning = "which time", .values = {"cpu", "wall", "gpu"}}),
      field<&R::ratio>({.name = "ratio", .meaning = "median of the paired ratios"}),
      field<&R::low>({.name = "ratio_low", .meaning = "lower end of its bootstrap 95 % interval"}),
      field<&R::high>({.name = "ratio_high", .meaning = "upper end of that interval"}),
      field<&R::pairs>({.name = "pairs", .unit = "frames", .meaning = "pairs of frames"}));
  return made;
}

template <>
const Table<ControlRow>& table<ControlRow>() {
  using R = ControlRow;
  static const Table<R> made = make_table<R>(
      {.name = "control",
       .rows = "controls",
       .meaning = "A control (A/A): one representation timed twice in the same rounds, as if it were two. What a "
                  "comparison of two that do not differ says here.",
       .since = 4},
      &StoreContents::controls,
      id_field<&R::id>(),
      run_field<&R::run>(),
      point_fields<&R::of>(),
      field<&R::metric>({.name = "metric", .meaning = "which time", .values = {"cpu", "wall", "gpu"}}),
      field<&R::ratio>({.name = "ratio", .meaning = "median of the paired ratios of the second to the first"}),
      field<&R::low>({.name = "ratio_low", .meaning = "lower end of its bootstrap 95 % interval"}),
      field<&R::high>({.name = "ratio_high", .meaning = "upper end of that interval"}),
      field<&R::p>({.name = "p",
                    .meaning = "two-sided, of the signed rank test of the logarithms of the ratios: at most 0.05 in one "
                               "control of twenty where all is well"}),
      field<&R::detectable>({.name = "detectable",
                             .unit = "fraction",
                             .meaning = "the smallest change of a ratio that this many rounds with this noise find with "
                                        "80 % at a level of 5 %: 0.02 is 2 %"}),
      field<&R::pairs>({.name = "pairs", .unit = "frames", .meaning = "pairs of frames"}));
  return made;
}
// clang-format on

const char* type_name(ColumnType type) {
  switch (type) {
    case ColumnType::boolean: return "boolean";
    case ColumnType::integer: return "integer";
    case ColumnType::seed: return "64 bits";
    case ColumnType::real: return "real";
    case ColumnType::text: return "text";
    case ColumnType::bytes: return "bytes";
  }
  return "text";
}

bool has_bytes(const TableDescription& description) {
  for (const Column& column : description.columns)
    if (column.type == ColumnType::bytes) return true;
  return false;
}

}  // namespace crowdbench
