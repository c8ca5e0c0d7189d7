// What sweeps are stored as.
#include "store/column_fields.h"

namespace crowdbench {

using namespace column_fields;

// clang-format off
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
// clang-format on

}  // namespace crowdbench
