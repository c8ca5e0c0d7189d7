// What the stability battery found is stored as.
#include "store/column_fields.h"

namespace crowdbench {

using namespace column_fields;

// clang-format off
template <>
const Table<StabilityCaseRow>& table<StabilityCaseRow>() {
  using R = StabilityCaseRow;
  static const Table<R> made = make_table<R>(
      {.name = "stability_case",
       .rows = "stability_cases",
       .meaning = "What one case of the battery (`stability`) came to; `stability --list` says what each asks and where its "
                  "bound comes from. Of what was drawn by its run's OpenGL driver.",
       .index = {"name", "representation"},
       .since = 7},
      &StoreContents::stability_cases,
      id_field<&R::id>(),
      run_field<&R::run>(),
      field<&R::name>({.name = "name", .meaning = "of the case"}),
      field<&R::group>({.name = "case_group", .meaning = "of cases that it is one of"}),
      field<&R::representation>({.name = "representation",
                                 .meaning = "canonical text of what was drawn; absent: the case is asked once, of numbers "
                                            "or statistics"}),
      field<&R::measured>({.name = "measured", .meaning = "at worst, in `unit`; absent: infinite, or nothing could be measured"}),
      field<&R::bound>({.name = "bound", .meaning = "the most that holds, in `unit`; absent: there is none, or no end to it"}),
      field<&R::unit>({.name = "unit", .meaning = "of both"}),
      field<&R::pass>({.name = "pass", .meaning = "it was measured and is not above its bound"}),
      field<&R::bound_seen>({.name = "bound_seen", .meaning = "the bound was set after seeing what is reached"}),
      field<&R::small>({.name = "small", .meaning = "in the battery's small form: fewer and smaller pictures"}),
      field<&R::place>({.name = "place", .meaning = "of the worst; empty where nothing is off"}),
      field<&R::expected>({.name = "expected", .meaning = "what should be there, for people"}),
      field<&R::got>({.name = "got", .meaning = "what is there, for people"}),
      field<&R::note>({.name = "note", .meaning = "what was left out, how much was looked at"}),
      field<&R::error>({.name = "error", .meaning = "why it could not be measured; empty where it was"}));
  return made;
}
// clang-format on

}  // namespace crowdbench
