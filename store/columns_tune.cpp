// What tuned rules are stored as.
#include "store/column_fields.h"

namespace crowdbench {

using namespace column_fields;

// clang-format off
template <>
const Table<TuningRow>& table<TuningRow>() {
  using R = TuningRow;
  static const Table<R> made = make_table<R>(
      {.name = "tuning",
       .rows = "tunings",
       .meaning = "Which representation to draw from which height on (`tune`); its switches are in `tuned_switch`. One "
                  "of all characters of the run, and where there are several one of each by itself.",
       .since = 6},
      &StoreContents::tunings,
      id_field<&R::id>(),
      run_field<&R::run>(),
      field<&R::character>({.name = "character", .meaning = "sources of the characters, joined by \" + \""}),
      field<&R::score>({.name = "score", .meaning = "name of the score that an allowed error is of"}),
      field<&R::threshold>({.name = "threshold", .meaning = "how good the score must be"}),
      field<&R::pop_score>({.name = "pop_score", .meaning = "name of the score that an allowed pop is of"}),
      field<&R::pop_threshold>({.name = "pop_threshold", .meaning = "how good it must be"}),
      field<&R::budget_ns>({.name = "budget_ns",
                            .unit = "ns",
                            .meaning = "what a frame may take: the least error within it, whatever the threshold; absent: "
                                       "the least time within the threshold"}),
      field<&R::representation>({.name = "representation",
                                 .meaning = "canonical text of what draws so; absent: there is no such rule"}),
      field<&R::reason>({.name = "reason", .meaning = "why there is none; empty where there is one"}),
      field<&R::agents>({.name = "agents", .unit = "agents", .meaning = "in the view that costs are weighed by"}),
      field<&R::saving>({.name = "reference_over_plan",
                         .meaning = "what these agents add to a frame as the reference over what they add so; absent: "
                                    "none is in view"}),
      field<&R::saving_low>({.name = "reference_over_plan_low", .meaning = "lower end of its 95 % interval"}),
      field<&R::saving_high>({.name = "reference_over_plan_high", .meaning = "upper end of it"}),
      field<&R::promised>({.name = "promised",
                           .meaning = "the reference's whole frame over the rule's, geometric mean over a few seeds; "
                                      "absent: none was timed"}),
      field<&R::promised_low>({.name = "promised_low",
                               .meaning = "lower end of the 95 % prediction interval for another seed"}),
      field<&R::promised_high>({.name = "promised_high", .meaning = "upper end of it"}),
      field<&R::lenses_hold>({.name = "lenses_hold",
                              .meaning = "the rule in pixels held in other pictures and through other lenses; absent: not "
                                         "checked"}),
      field<&R::proof_holds>({.name = "proof_holds",
                              .meaning = "the promise held on unseen crowds and figures; absent: not tried"}),
      field<&R::display>({.name = "display", .meaning = "where the pictures are looked at, as in `comparison`"}),
      field<&R::display_given>({.name = "display_given", .meaning = "somebody chose that display"}));
  return made;
}

template <>
const Table<TunedSwitchRow>& table<TunedSwitchRow>() {
  using R = TunedSwitchRow;
  static const Table<R> made = make_table<R>(
      {.name = "tuned_switch",
       .rows = "tuned_switches",
       .meaning = "One change of representation of a tuned rule.",
       .owner = "tuning",
       .within = "place",
       .since = 6},
      nullptr,
      field<&R::place>({.name = "place", .meaning = "its number from near to far, from 0"}),
      field<&R::from>({.name = "from", .meaning = "what draws nearer"}),
      field<&R::to>({.name = "to", .meaning = "what draws from here on"}),
      field<&R::height_px>({.name = "height_px", .unit = "px", .meaning = "the tallest figure that `to` draws"}),
      field<&R::low_px>({.name = "height_low_px",
                         .unit = "px",
                         .meaning = "lower end of its 95 % interval over resampled measurements; absent: none of them "
                                    "makes this change"}),
      field<&R::high_px>({.name = "height_high_px", .unit = "px", .meaning = "upper end of it"}),
      field<&R::share>({.name = "share", .unit = "fraction", .meaning = "of the resamples that make this change"}),
      field<&R::decided>({.name = "decided", .meaning = "at least 95 % of them do"}),
      field<&R::depth>({.name = "depth_m",
                        .unit = "m",
                        .meaning = "of such a figure along the view axis, through the run's lens; of several characters "
                                   "the first"}),
      field<&R::pixels_per_texel>({.name = "pixels_per_texel",
                                   .meaning = "that a texel of `to` spans there; absent: it has none"}),
      field<&R::pixels_per_error>({.name = "pixels_per_error",
                                   .meaning = "that the largest distance of the mesh of `to` from the character's spans "
                                              "there; absent: it is not a coarser mesh"}),
      field<&R::hysteresis>({.name = "hysteresis",
                             .meaning = "a figure changes only where its height is beyond by this fraction"}),
      field<&R::pop>({.name = "pop", .meaning = "what the change shows, the bad end's 5 % of the pop score"}));
  return made;
}
// clang-format on

}  // namespace crowdbench
