#include "store/columns.h"

#include <optional>
#include <type_traits>

namespace crowdbench {
namespace {

template <typename T>
struct OptionalOf {
  static constexpr bool value = false;
  using Type = T;
};
template <typename T>
struct OptionalOf<std::optional<T>> {
  static constexpr bool value = true;
  using Type = T;
};

template <typename T>
Value value_of(const T& member) {
  if constexpr (OptionalOf<T>::value)
    return member ? value_of(*member) : Value();
  else if constexpr (std::is_same_v<T, Status>)
    return std::string(status_name(member));
  else if constexpr (std::is_integral_v<T> && std::is_signed_v<T>)
    return int64_t{member};
  else if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>)
    return uint64_t{member};
  else
    return member;
}

// A column of integers is read as int64_t, whatever the sign of its members.
template <typename T>
T member_of(Value value) {
  if constexpr (std::is_same_v<T, Status>)
    return status_of(std::get<std::string>(value));
  else if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>)
    return std::holds_alternative<uint64_t>(value) ? static_cast<T>(std::get<uint64_t>(value))
                                                   : static_cast<T>(std::get<int64_t>(value));
  else
    return std::get<T>(std::move(value));
}

template <typename T>
constexpr ColumnType type_of() {
  if constexpr (std::is_same_v<T, bool>)
    return ColumnType::boolean;
  else if constexpr (std::is_integral_v<T>)
    return ColumnType::integer;
  else if constexpr (std::is_floating_point_v<T>)
    return ColumnType::real;
  else if constexpr (std::is_same_v<T, std::vector<uint8_t>>)
    return ColumnType::bytes;
  else
    return ColumnType::text;
}

// A member, or a member of a member, which may lie in an optional: absent together.
template <auto First, auto... Rest>
struct Member;
template <typename Class, typename T, T Class::*First, auto... Rest>
struct Member<First, Rest...> {
  using Row = Class;
  using Plain = typename OptionalOf<T>::Type;

  static constexpr ColumnType type() {
    if constexpr (sizeof...(Rest) == 0)
      return type_of<Plain>();
    else
      return Member<Rest...>::type();
  }
  static constexpr bool optional() {
    if constexpr (sizeof...(Rest) == 0)
      return OptionalOf<T>::value;
    else
      return OptionalOf<T>::value || Member<Rest...>::optional();
  }
  static Value get(const Row& row) {
    if constexpr (sizeof...(Rest) == 0)
      return value_of(row.*First);
    else if constexpr (OptionalOf<T>::value)
      return row.*First ? Member<Rest...>::get(*(row.*First)) : Value();
    else
      return Member<Rest...>::get(row.*First);
  }
  static void set(Row& row, Value value) {
    if (std::holds_alternative<std::monostate>(value)) return;
    if constexpr (sizeof...(Rest) == 0) {
      row.*First = member_of<Plain>(std::move(value));
    } else if constexpr (OptionalOf<T>::value) {
      if (!(row.*First)) (row.*First).emplace();
      Member<Rest...>::set(*(row.*First), std::move(value));
    } else {
      Member<Rest...>::set(row.*First, std::move(value));
    }
  }
};

template <auto... Path>
using RowOf = typename Member<Path...>::Row;

template <auto... Path>
Field<RowOf<Path...>> field(Column column) {
  using M = Member<Path...>;
  if (column.type != ColumnType::seed) column.type = M::type();
  column.optional = M::optional();
  return {std::move(column), &M::get, &M::set};
}

template <auto... Path>
Field<RowOf<Path...>> id_field() {
  return field<Path...>({.name = "id", .meaning = "number of the row, given by the store", .key = true});
}

template <auto... Path>
Field<RowOf<Path...>> run_field() {
  return field<Path...>({.name = "run", .meaning = "the run that this belongs to", .references = "run"});
}

template <auto Key>
std::vector<Field<RowOf<Key>>> point_fields() {
  return {
      field<Key, &PointKey::representation>(
          {.name = "representation", .meaning = "what was drawn: its canonical text, options included", .point = true}),
      field<Key, &PointKey::character>(
          {.name = "character", .meaning = "sources of the characters, joined by \" + \"", .point = true}),
      field<Key, &PointKey::agents>(
          {.name = "agents", .unit = "agents", .meaning = "size of the crowd", .point = true}),
      field<Key, &PointKey::width>(
          {.name = "width_px", .unit = "px", .meaning = "width of the picture", .point = true}),
      field<Key, &PointKey::height>(
          {.name = "height_px", .unit = "px", .meaning = "height of the picture", .point = true}),
      field<Key, &PointKey::requested_occupancy>(
          {.name = "requested_occupancy",
           .unit = "fraction",
           .meaning = "share of the picture that the reference shall cover; 0: the scenario's own camera",
           .point = true}),
  };
}

template <auto Time>
std::vector<Field<RowOf<Time>>> time_fields(const std::string& name, const std::string& what) {
  const auto column = [&](const char* suffix, const std::string& meaning) {
    return Column{.name = name + suffix, .unit = "ns", .meaning = meaning};
  };
  return {
      field<Time, &TimeSummary::median>(column("", what + ", median of the rounds")),
      field<Time, &TimeSummary::low>(column("_low", "lower end of the bootstrap 95 % interval of that median")),
      field<Time, &TimeSummary::high>(column("_high", "upper end of that interval")),
      field<Time, &TimeSummary::p05>(column("_p05", what + ", 5th percentile of the rounds")),
      field<Time, &TimeSummary::p95>(column("_p95", what + ", 95th percentile")),
      field<Time, &TimeSummary::p99>(column("_p99", what + ", 99th percentile")),
  };
}

template <typename Row>
void add(std::vector<Field<Row>>& all, Field<Row> one) {
  all.push_back(std::move(one));
}
template <typename Row>
void add(std::vector<Field<Row>>& all, std::vector<Field<Row>> several) {
  for (Field<Row>& one : several) all.push_back(std::move(one));
}

template <typename Row, typename... Parts>
Table<Row> make_table(TableDescription description, std::vector<Row> StoreContents::*rows, Parts... parts) {
  Table<Row> made{std::move(description), {}, rows};
  (add<Row>(made.fields, std::move(parts)), ...);
  for (const Field<Row>& one : made.fields) made.description.columns.push_back(one.column);
  return made;
}

}  // namespace

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
      field<&R::bake_seconds>({.name = "bake_seconds", .unit = "s", .meaning = "time that the bake took"}),
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

template <>
const Table<ComparisonRow>& table<ComparisonRow>() {
  using R = ComparisonRow;
  static const Table<R> made = make_table<R>(
      {.name = "comparison",
       .rows = "comparisons",
       .meaning = "Two pictures of the same view; what they differ by is in `score`."},
      &StoreContents::comparisons,
      id_field<&R::id>(),
      run_field<&R::run>(),
      field<&R::kind>({.name = "kind",
                       .meaning = "crowd: a whole frame; agent: one agent, as `quality` defines it; agent_in_crowd: one "
                                  "agent of a whole frame, as `distance` defines it",
                       .values = {"crowd", "agent", "agent_in_crowd"}}),
      field<&R::representation>({.name = "representation", .meaning = "canonical text of what is compared"}),
      field<&R::reference>({.name = "reference", .meaning = "canonical text of what it is compared with"}),
      field<&R::character>({.name = "character", .meaning = "sources of the characters, joined by \" + \""}),
      field<&R::agents>({.name = "agents", .unit = "agents", .meaning = "size of the crowd; agent: 0"}),
      field<&R::requested_occupancy>({.name = "requested_occupancy",
                                      .unit = "fraction",
                                      .meaning = "of the picture, as in `measurement`; agent: 0"}),
      field<&R::tick>({.name = "tick", .unit = "ticks", .meaning = "moment of the animation; agent: 0"}),
      field<&R::height_px>({.name = "height_px", .unit = "px", .meaning = "height of the agent in the picture"}),
      field<&R::azimuth_deg>({.name = "azimuth_deg", .unit = "degrees", .meaning = "of the camera about the agent"}),
      field<&R::elevation_deg>({.name = "elevation_deg", .unit = "degrees", .meaning = "of the camera"}),
      field<&R::clip>({.name = "clip", .meaning = "the agent's motion; crowd: empty"}),
      field<&R::time>({.name = "time_s", .unit = "s", .meaning = "moment within that clip"}),
      field<&R::agent>({.name = "agent", .meaning = "agent_in_crowd: its place in the crowd, from 0", .since = 3}),
      field<&R::distance>({.name = "distance_m",
                           .unit = "m",
                           .meaning = "agent_in_crowd: from the eye to the agent",
                           .since = 3}),
      field<&R::pixels_per_texel>({.name = "pixels_per_texel",
                                   .meaning = "agent_in_crowd: pixels that a texel of its map spans; absent where it "
                                              "has none",
                                   .since = 3}),
      field<&R::alone_px>({.name = "alone_px",
                           .unit = "px",
                           .meaning = "agent_in_crowd: pixels that the reference covers where it stands alone",
                           .since = 3}),
      field<&R::visible_px>({.name = "visible_px",
                             .unit = "px",
                             .meaning = "agent_in_crowd: of these, those that others leave visible",
                             .since = 3}),
      field<&R::state>({.name = "state",
                        .meaning = "agent_in_crowd: whether it counts in curves (counted), else why not: occluded, "
                                   "cut_off, no_pixel",
                        .since = 3}),
      field<&R::display>({.name = "display",
                          .meaning = "where the pictures are looked at, for scores that depend on it",
                          .since = 3}),
      field<&R::display_given>({.name = "display_given",
                                .meaning = "somebody chose that display; else scores with a default of their own kept "
                                           "to it (FLIP: 67.02 pixels/degree)",
                                .since = 3}));
  return made;
}

template <>
const Table<ScoreRow>& table<ScoreRow>() {
  using R = ScoreRow;
  static const Table<R> made = make_table<R>(
      {.name = "score",
       .rows = "scores",
       .meaning = "One score of a comparison: a new score is a new name, never a new column.",
       .owner = "comparison",
       .within = "name"},
      nullptr,
      field<&R::name>({.name = "name", .meaning = "\"ssim\", \"psnr\", ...; unit and direction are the score's"}),
      field<&R::value>({.name = "value", .meaning = "infinity where the score is infinite"}),
      field<&R::reason>({.name = "reason",
                         .meaning = "why there is no value; else empty",
                         .check = "value IS NOT NULL OR reason <> ''"}));
  return made;
}

template <>
const Table<SweepRow>& table<SweepRow>() {
  using R = SweepRow;
  static const Table<R> made = make_table<R>(
      {.name = "sweep",
       .rows = "sweeps",
       .meaning = "A plan of a sweep (`sweep`), as one shard of it was measured into this file; a merged file has one "
                  "of all shards.",
       .since = 4},
      &StoreContents::sweeps,
      id_field<&R::id>(),
      field<&R::plan_name>({.name = "plan_name", .meaning = "name in the plan"}),
      field<&R::plan_hash>({.name = "plan_hash",
                            .meaning = "of all that decides what its points show; comments do not"}),
      field<&R::plan>({.name = "plan", .meaning = "the plan as it was written, TOML", .bulky = true}),
      field<&R::conditions>({.name = "conditions", .meaning = "of the whole plan"}),
      field<&R::repetitions>({.name = "repetitions", .meaning = "of every condition"}),
      field<&R::points>({.name = "points", .meaning = "of the whole plan, repetitions counted"}),
      field<&R::shard>({.name = "shard", .meaning = "which of the shards, from 1"}),
      field<&R::shards>({.name = "shards",
                         .meaning = "how many the plan was cut into: shard I holds every condition whose number is I - 1 "
                                    "modulo this"}),
      field<&R::revision>({.name = "revision", .meaning = "git describe of the program's source"}),
      field<&R::gl_renderer>({.name = "gl_renderer", .meaning = "GL_RENDERER"}),
      field<&R::gl_version>({.name = "gl_version", .meaning = "GL_VERSION"}));
  return made;
}

template <>
const Table<SweepPointRow>& table<SweepPointRow>() {
  using R = SweepPointRow;
  static const Table<R> made = make_table<R>(
      {.name = "sweep_point",
       .rows = "sweep_points",
       .meaning = "One point of a sweep, the reference beside it, or the reference's A/A twin. All of a condition and "
                  "repetition came in one transaction; a point that failed is a row with its reason.",
       .index = {"sweep", "condition", "repetition"},
       .since = 4},
      &StoreContents::sweep_points,
      id_field<&R::id>(),
      field<&R::sweep>({.name = "sweep", .meaning = "the sweep that it is of", .references = "sweep"}),
      run_field<&R::run>(),
      field<&R::condition>({.name = "condition", .meaning = "number of the condition in the plan, from 0"}),
      field<&R::repetition>({.name = "repetition", .meaning = "from 0"}),
      field<&R::role>({.name = "role",
                       .meaning = "point: asked for by the plan; reference: drawn beside the points for ratios and "
                                  "scores, and not asked for; aa: the reference once more, as if it were another",
                       .values = {"point", "reference", "aa"}}),
      field<&R::point_key>({.name = "point_key",
                            .meaning = "hash of all that decides what the point shows and how it is measured"}),
      field<&R::representation>({.name = "representation", .meaning = "canonical text"}),
      field<&R::settings>({.name = "settings", .meaning = "the point's value on each axis, a JSON object of texts"}),
      field<&R::state>({.name = "state",
                        .meaning = "done; invalid: the image check failed; unreachable: the occupancy was missed; "
                                   "failed: it could not be drawn",
                        .values = {"done", "invalid", "unreachable", "failed"}}),
      field<&R::reason>({.name = "reason",
                         .meaning = "why it is not done; else empty",
                         .check = "state = 'done' OR reason <> ''"}),
      field<&R::measurement>({.name = "measurement", .meaning = "its times", .references = "measurement"}),
      field<&R::comparison>({.name = "comparison",
                             .meaning = "its scores against the reference",
                             .references = "comparison"}),
      field<&R::ratio>({.name = "ratio",
                        .meaning = "median of the paired ratios of the reference's headline time to its own: above 1 it "
                                   "is the faster"}),
      field<&R::ratio_low>({.name = "ratio_low", .meaning = "lower end of its bootstrap 95 % interval"}),
      field<&R::ratio_high>({.name = "ratio_high", .meaning = "upper end of that interval"}),
      field<&R::seconds>({.name = "condition_s",
                          .unit = "s",
                          .meaning = "wall time of the whole condition, loading and baking included"}));
  return made;
}

template <>
const Table<PictureRow>& table<PictureRow>() {
  using R = PictureRow;
  static const Table<R> made = make_table<R>(
      {.name = "picture", .rows = "pictures", .meaning = "A picture for the report."},
      &StoreContents::pictures,
      id_field<&R::id>(),
      run_field<&R::run>(),
      field<&R::comparison>({.name = "comparison",
                             .meaning = "the comparison that it belongs to",
                             .references = "comparison"}),
      field<&R::role>({.name = "role", .meaning = "\"reference\", \"test\", \"difference\", \"hero\"; \"legend\": the colour bar of a "
                                      "run's differences"}),
      field<&R::caption>({.name = "caption", .meaning = "for people"}),
      field<&R::width>({.name = "width_px", .unit = "px", .meaning = "width"}),
      field<&R::height>({.name = "height_px", .unit = "px", .meaning = "height"}),
      field<&R::png>({.name = "png", .meaning = "the PNG file"}));
  return made;
}

template <>
const Table<CurveRow>& table<CurveRow>() {
  using R = CurveRow;
  static const Table<R> made = make_table<R>(
      {.name = "curve",
       .rows = "curves",
       .meaning = "A score of the agents of a crowd against how far away they are (`distance`): medians of bins of "
                  "equally many, in `curve_bin`.",
       .since = 3},
      &StoreContents::curves,
      id_field<&R::id>(),
      run_field<&R::run>(),
      field<&R::representation>({.name = "representation", .meaning = "canonical text of what is compared"}),
      field<&R::reference>({.name = "reference", .meaning = "canonical text of what it is compared with"}),
      field<&R::character>({.name = "character", .meaning = "sources of the characters, joined by \" + \""}),
      field<&R::score>({.name = "score", .meaning = "name of the score"}),
      field<&R::against>({.name = "against",
                          .meaning = "what is x: distance in metres, height in pixels, or pixels that a texel spans",
                          .values = {"distance_m", "height_px", "pixels_per_texel"}}),
      field<&R::points>({.name = "points", .meaning = "agents in frames that count and have the score"}),
      field<&R::agents>({.name = "agents", .unit = "agents", .meaning = "different ones among them"}),
      field<&R::rank_correlation>({.name = "rank_correlation",
                                   .meaning = "Spearman's, of the value with how far away; absent where either never "
                                              "changes"}),
      field<&R::display>({.name = "display", .meaning = "where the pictures are looked at, as in `comparison`"}),
      field<&R::display_given>({.name = "display_given", .meaning = "somebody chose that display"}));
  return made;
}

template <>
const Table<CurveBinRow>& table<CurveBinRow>() {
  using R = CurveBinRow;
  static const Table<R> made = make_table<R>(
      {.name = "curve_bin",
       .rows = "bins",
       .meaning = "One bin of a curve.",
       .owner = "curve",
       .within = "bin",
       .since = 3},
      nullptr,
      field<&R::bin>({.name = "bin", .meaning = "its number from near to far, from 0"}),
      field<&R::from>({.name = "x_from", .meaning = "x of its nearest point"}),
      field<&R::to>({.name = "x_to", .meaning = "x of its farthest point"}),
      field<&R::x>({.name = "x", .meaning = "median of x"}),
      field<&R::median>({.name = "median", .meaning = "median of the score"}),
      field<&R::low>({.name = "median_low", .meaning = "lower end of its 95 % interval, whole agents drawn anew"}),
      field<&R::high>({.name = "median_high", .meaning = "upper end of that interval"}),
      field<&R::points>({.name = "points", .meaning = "agents in frames"}),
      field<&R::agents>({.name = "agents", .unit = "agents", .meaning = "different ones among them"}));
  return made;
}

template <>
const Table<ThresholdRow>& table<ThresholdRow>() {
  using R = ThresholdRow;
  static const Table<R> made = make_table<R>(
      {.name = "threshold",
       .rows = "thresholds",
       .meaning = "From where on, going away, the median of a curve is as good as a value or better.",
       .since = 3},
      &StoreContents::thresholds,
      id_field<&R::id>(),
      run_field<&R::run>(),
      field<&R::curve>({.name = "curve", .meaning = "the curve that it is of", .references = "curve"}),
      field<&R::value>({.name = "value", .meaning = "of the score"}),
      field<&R::status>({.name = "status",
                         .meaning = "whether the curve comes to it",
                         .values = {"reached", "everywhere", "not_reached", "not_distinguishable"}}),
      field<&R::at>({.name = "x", .meaning = "from where on; absent: everywhere or nowhere"}),
      field<&R::low>({.name = "x_low", .meaning = "nearer end of its 95 % interval; absent: open at that end"}),
      field<&R::high>({.name = "x_high", .meaning = "farther end of it"}));
  return made;
}

template <>
const Table<CauseRangeRow>& table<CauseRangeRow>() {
  using R = CauseRangeRow;
  static const Table<R> made = make_table<R>(
      {.name = "cause_range",
       .rows = "cause_ranges",
       .meaning = "What the squared error of figures of one range of heights comes from (`quality --causes`, `distance "
                  "--causes`); the shares of the causes in `cause_share`.",
       .since = 4},
      &StoreContents::cause_ranges,
      id_field<&R::id>(),
      run_field<&R::run>(),
      field<&R::representation>({.name = "representation", .meaning = "canonical text of what is compared"}),
      field<&R::reference>({.name = "reference", .meaning = "canonical text of what it is compared with"}),
      field<&R::character>({.name = "character", .meaning = "sources of the characters, joined by \" + \""}),
      field<&R::unit>({.name = "unit", .meaning = "what is drawn anew for the interval", .values = {"view", "agent"}}),
      field<&R::from>({.name = "from_px", .unit = "px", .meaning = "least height of the figures"}),
      field<&R::below>({.name = "below_px", .unit = "px", .meaning = "their heights are below this; absent: no end"}),
      field<&R::units>({.name = "units", .meaning = "views or agents of such a height"}),
      field<&R::total>({.name = "total", .meaning = "squared error, code values squared, summed over R, G and B"}),
      field<&R::residue>({.name = "residue", .unit = "fraction", .meaning = "share of it that no cause explains"}),
      field<&R::dominant>({.name = "dominant",
                           .meaning = "the cause that has most of it; absent: not distinguishable"}),
      field<&R::share_low>({.name = "share_low",
                            .unit = "fraction",
                            .meaning = "lower end of the 95 % interval of its share"}),
      field<&R::share_high>({.name = "share_high", .unit = "fraction", .meaning = "upper end of that interval"}),
      field<&R::words>({.name = "words", .meaning = "the same for people"}));
  return made;
}

template <>
const Table<CauseShareRow>& table<CauseShareRow>() {
  using R = CauseShareRow;
  static const Table<R> made = make_table<R>(
      {.name = "cause_share",
       .rows = "shares",
       .meaning = "The share that one cause has of the squared error of a range of heights.",
       .owner = "cause_range",
       .within = "cause",
       .since = 4},
      nullptr,
      field<&R::cause>({.name = "cause", .meaning = "its name: \"view\", \"silhouette\", ..."}),
      field<&R::title>({.name = "title", .meaning = "the same for people"}),
      field<&R::share>({.name = "share",
                        .unit = "fraction",
                        .meaning = "below 0: it undoes error of a cause before it"}));
  return made;
}

template <>
const Table<PopRow>& table<PopRow>() {
  using R = PopRow;
  static const Table<R> made = make_table<R>(
      {.name = "pop",
       .rows = "pops",
       .meaning = "A switch of an agent in a sequence of frames (`popping`), by how visible it is: its scores are in "
                  "`pop_score`.",
       .since = 4},
      &StoreContents::pops,
      id_field<&R::id>(),
      run_field<&R::run>(),
      field<&R::representation>({.name = "representation", .meaning = "canonical text of what is drawn"}),
      field<&R::character>({.name = "character", .meaning = "sources of the characters, joined by \" + \""}),
      field<&R::from>({.name = "from", .meaning = "what drew the agent before"}),
      field<&R::to>({.name = "to", .meaning = "what draws it after"}),
      field<&R::agent>({.name = "agent", .meaning = "its place in the crowd, from 0"}),
      field<&R::tick>({.name = "tick", .meaning = "the first frame that shows the switch"}),
      field<&R::frames>({.name = "frames", .meaning = "over which it goes"}),
      field<&R::complete>({.name = "complete", .meaning = "it ended within the sequence"}),
      field<&R::distance>({.name = "distance_m", .unit = "m", .meaning = "from the eye to the agent"}),
      field<&R::pixels>({.name = "pixels_px",
                         .unit = "px",
                         .meaning = "of the most visible step; 0: nothing of the agent is seen"}),
      field<&R::worst_tick>({.name = "worst_tick", .meaning = "frame of the most visible step"}),
      field<&R::display>({.name = "display", .meaning = "where the pictures are looked at, as in `comparison`"}));
  return made;
}

template <>
const Table<PopScoreRow>& table<PopScoreRow>() {
  using R = PopScoreRow;
  static const Table<R> made = make_table<R>(
      {.name = "pop_score",
       .rows = "pop_scores",
       .meaning = "One score of a switch: the worst of its steps.",
       .owner = "pop",
       .within = "name",
       .since = 4},
      nullptr,
      field<&R::name>({.name = "name", .meaning = "as `schema --scores` lists those of switches"}),
      field<&R::value>({.name = "value", .meaning = "absent: nothing of the agent is seen, or it does not exist"}));
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
