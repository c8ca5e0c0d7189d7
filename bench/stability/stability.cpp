#include "bench/stability/stability.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <set>

#include "bench/stability/fixture.h"
#include "core/error.h"
#include "core/progress.h"
#include "renderers/gl/context.h"

namespace crowdbench::bench {
namespace {

// Every type by itself, the reference first: what goes wrong there is seen before others are held against it.
std::vector<renderers::Spec> every_representation() {
  std::vector<renderers::Spec> out = {renderers::reference_spec()};
  for (const renderers::RepresentationType& type : renderers::representation_types())
    if (!type.reference) out.push_back(renderers::parse_spec(renderers::example_spec(type)));
  return out;
}

StabilityRow measure_row(const StabilityCase& one, Fixture& fixture) {
  StabilityRow row;
  row.asked = one;
  if (!one.once) row.representation = fixture.asked().text();
  const auto start = std::chrono::steady_clock::now();
  try {
    row.found = one.measure(fixture);
  } catch (const Error& error) {
    row.error = error.what();
  }
  row.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return row;
}

}  // namespace

std::vector<StabilityCase> stability_cases() {
  std::vector<StabilityCase> cases;
  // One a line, so that two additions do not meet.
  add_world_cases(cases);
  add_time_cases(cases);
  add_eye_cases(cases);
  add_path_cases(cases);
  add_size_cases(cases);
  add_character_cases(cases);
  add_number_cases(cases);
  add_statistics_cases(cases);
  add_truth_cases(cases);
  add_depth_cases(cases);
  return cases;
}

std::vector<StabilityCase> chosen_cases(const StabilityRequest& request) {
  const std::vector<StabilityCase> all = stability_cases();
  // A case by its own name is run in any form.
  const auto shown = [&](const StabilityCase& one) {
    return (request.full || !one.full) && (!request.small || one.small);
  };
  std::set<std::string> wanted;
  for (const std::string& name : request.cases) {
    std::vector<std::string> known;
    bool found = false;
    for (const StabilityCase& one : all) {
      known.emplace_back(one.name);
      if (std::find(known.begin(), known.end(), one.group) == known.end()) known.emplace_back(one.group);
      if (one.name != name && one.group != name) continue;
      found = true;
      if (one.name == name || shown(one)) wanted.emplace(one.name);
    }
    if (found) continue;
    const std::string near = nearest_name(name, known);
    throw Error("--case", fmt::format("'{}' is neither a case nor a group of cases", printable(name)),
                near.empty() ? "--list shows them" : fmt::format("did you mean '{}'? --list shows all", near));
  }
  std::vector<StabilityCase> out;
  for (const StabilityCase& one : all) {
    const bool named = wanted.contains(std::string(one.name));
    if (request.cases.empty() ? shown(one) : named) out.push_back(one);
  }
  return out;
}

std::vector<StabilityRow> run_stability(gl::Context& context, const StabilityRequest& request,
                                        const std::vector<StabilityCase>& cases) {
  const std::vector<renderers::Spec> representations =
      request.representations.empty() ? every_representation() : request.representations;
  size_t total = 0;
  for (const StabilityCase& one : cases) total += one.once ? 1 : representations.size();
  Progress progress("stability", total);
  Fixture fixture(context, request.small, request.full, request.use_cache);
  std::vector<StabilityRow> rows;
  const auto run = [&](const StabilityCase& one) {
    progress.note(one.once ? std::string(one.name) : fmt::format("{} of {}", one.name, fixture.asked().text()));
    rows.push_back(measure_row(one, fixture));
    progress.advance();
  };
  for (const StabilityCase& one : cases)
    if (one.once) run(one);
  for (const renderers::Spec& spec : representations) {
    fixture.ask(spec);
    for (const StabilityCase& one : cases)
      if (!one.once) run(one);
  }
  return rows;
}

}  // namespace crowdbench::bench
