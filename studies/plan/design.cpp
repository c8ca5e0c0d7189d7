// Based on: Williams, "Experimental designs balanced for the estimation of residual effects of treatments" (1949), for
// the order within a round (studies/analysis/designs.h).
#include "studies/plan/design.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/hash.h"
#include "core/random.h"
#include "scene/scenario/scenario_writer.h"
#include "studies/analysis/designs.h"

namespace crowdbench::studies {
namespace {

enum Draw : uint64_t { kNames = 0x6e616d65, kOrder = 0x6f726465, kSides = 0x73696465, kPlaces = 0x706c6163 };

std::vector<uint32_t> shuffled(uint32_t n, uint64_t seed, uint64_t purpose) {
  std::vector<uint32_t> out(n);
  std::iota(out.begin(), out.end(), 0U);
  std::sort(out.begin(), out.end(), [&](uint32_t a, uint32_t b) {
    return std::pair(random_bits(seed, a, purpose), a) < std::pair(random_bits(seed, b, purpose), b);
  });
  return out;
}

// What is ranked: the reference and the conditions' representations, each once.
std::vector<renderers::Spec> ranked(const StudyPlan& plan) {
  std::vector<renderers::Spec> out = {plan.reference};
  for (const StudyCondition& condition : plan.conditions)
    if (std::none_of(out.begin(), out.end(), [&](const auto& spec) { return spec.text() == condition.test.text(); }))
      out.push_back(condition.test);
  return out;
}

uint32_t rounds_of(const StudyPlan& plan) {
  if (plan.method.method == Method::constant) return plan.stimulus.crowds * plan.method.repeats;
  const uint32_t items = order_items(plan);
  return (plan.method.trials + items - 1) / items;
}

class Designer {
 public:
  explicit Designer(const StudyPlan& plan) : plan_(plan) {}

  StudyDesign run() {
    const uint32_t lists = plan_.participants.lists;
    for (uint32_t list = 0; list < lists; ++list) {
      std::vector<Trial> main = plan_.method.method == Method::active_pairs ? pairs_of(list) : rounds_of_list(list);
      put_catch_trials(list, main);
      std::vector<Trial> all = training_of(list);
      all.insert(all.end(), main.begin(), main.end());
      number_blocks(all);
      design_.lists.push_back(std::move(all));
    }
    add_all_choices();
    name_stimuli();
    return std::move(design_);
  }

 private:
  size_t half(size_t condition, const renderers::Spec& spec, uint32_t crowd) {
    const StudyCondition& c = plan_.conditions[condition];
    PlannedHalf made;
    made.condition = condition;
    made.scenario = c.scenario;
    made.scenario.seed += crowd;
    made.spec = spec;
    Sha256 digest;
    digest.text(scene::to_toml(made.scenario)).text(spec.text()).value(plan_.stimulus.fps);
    digest.value(static_cast<uint64_t>(plan_.frames())).value(plan_.stimulus.lead_in_seconds);
    digest.value(c.spacing_by_bodies).value(c.height_px.value_or(0)).value(c.pixels_per_texel.value_or(0));
    if (c.pixels_per_texel) digest.text(c.test.text());
    made.key = digest.hex().substr(0, 16);
    const auto [found, fresh] = by_key_.emplace(made.key, design_.halves.size());
    if (fresh) design_.halves.push_back(std::move(made));
    return found->second;
  }

  // The crowd that the reference shows beside crowd k of the test.
  uint32_t other_crowd(uint32_t crowd) const {
    if (plan_.stimulus.seeds == Seeds::same) return crowd;
    return plan_.stimulus.crowds > 1 ? (crowd + 1) % plan_.stimulus.crowds : crowd + 1;
  }

  size_t add(Stimulus stimulus) {
    // Catch trials of conditions that share a scene are one.
    const bool of_condition = stimulus.kind != StimulusKind::identical && stimulus.kind != StimulusKind::broken;
    const size_t condition = of_condition ? stimulus.condition : 0;
    const auto key = std::tuple(stimulus.kind, stimulus.upper, stimulus.lower, condition);
    const auto [found, fresh] = by_halves_.emplace(key, design_.stimuli.size());
    if (fresh) design_.stimuli.push_back(std::move(stimulus));
    return found->second;
  }

  // The half under test against the reference; expected says which answer is right.
  size_t against_reference(StimulusKind kind, size_t condition, const renderers::Spec& spec, uint32_t crowd,
                           bool on_top) {
    Stimulus s;
    s.kind = kind;
    s.condition = condition;
    s.crowd = crowd;
    const size_t test = half(condition, spec, crowd);
    const size_t reference = half(condition, plan_.reference, other_crowd(crowd));
    s.twin = half(condition, plan_.reference, crowd);
    s.test_on_top = on_top;
    s.upper = on_top ? test : reference;
    s.lower = on_top ? reference : test;
    s.item_upper = (on_top ? spec : plan_.reference).text();
    s.item_lower = (on_top ? plan_.reference : spec).text();
    if (plan_.task == Task::same_different)
      s.expected = "different";
    else
      s.expected = (plan_.question == Question::better) == on_top ? "lower" : "upper";
    return add(std::move(s));
  }

  // Reference against reference.
  size_t alike(size_t condition, uint32_t crowd, bool swapped) {
    Stimulus s;
    s.kind = StimulusKind::alike;
    s.condition = condition;
    s.crowd = crowd;
    s.upper = half(condition, plan_.reference, crowd);
    s.lower = half(condition, plan_.reference, other_crowd(crowd));
    if (swapped) std::swap(s.upper, s.lower);
    s.item_upper = s.item_lower = plan_.reference.text();
    s.expected = "same";
    return add(std::move(s));
  }

  size_t identical(size_t condition, uint32_t crowd) {
    Stimulus s;
    s.kind = StimulusKind::identical;
    s.condition = condition;
    s.crowd = crowd;
    s.upper = s.lower = half(condition, plan_.reference, crowd);
    s.item_upper = s.item_lower = plan_.reference.text();
    return add(std::move(s));
  }

  size_t pair(const renderers::Spec& first, const renderers::Spec& second, uint32_t crowd, bool first_on_top) {
    Stimulus s;
    s.kind = StimulusKind::pair;
    s.crowd = crowd;
    const size_t a = half(0, first, crowd);
    const size_t b = half(0, second, other_crowd(crowd));
    s.twin = half(0, second, crowd);
    s.test_on_top = first_on_top;
    s.upper = first_on_top ? a : b;
    s.lower = first_on_top ? b : a;
    s.item_upper = (first_on_top ? first : second).text();
    s.item_lower = (first_on_top ? second : first).text();
    return add(std::move(s));
  }

  // The k-th list's order of items in a round; over the lists of one Williams design each item stands at each place,
  // and directly after each other, equally often.
  std::vector<uint32_t> order(uint32_t list, uint32_t round) const {
    static thread_local std::map<uint32_t, std::vector<std::vector<uint32_t>>> designs;
    const uint32_t items = order_items(plan_);
    auto& design = designs[items];
    if (design.empty()) design = williams_design(items);
    const std::vector<uint32_t> names = shuffled(items, plan_.seed, kOrder);
    std::vector<uint32_t> out = design[(list + round) % design.size()];
    for (uint32_t& item : out) item = names[item];
    return out;
  }
  // Whether the side is the other one in this list: half of the lists that share an order.
  bool swapped(uint32_t list) const { return (list / (balanced_lists(plan_) / 2)) % 2 == 1; }

  std::vector<Trial> rounds_of_list(uint32_t list) {
    const uint32_t crowds = plan_.stimulus.crowds;
    const uint32_t rounds = rounds_of(plan_);
    const auto n = static_cast<uint32_t>(plan_.conditions.size());
    std::vector<Trial> out;
    for (uint32_t round = 0; round < rounds; ++round) {
      const uint32_t crowd = (round + list) % crowds;
      const uint32_t repeat = round / crowds;
      for (const uint32_t item : order(list, round)) {
        const bool drawn = (random_bits(plan_.seed, item, kSides) >> 63) != 0;
        const bool side = drawn != (((repeat + crowd) % 2 == 1) != swapped(list));
        const size_t stimulus =
            item < n ? against_reference(StimulusKind::test, item, plan_.conditions[item].test, crowd, side)
                     : alike(item - n, crowd, side);
        out.push_back({stimulus, 1, TrialKind::main});
      }
    }
    if (plan_.method.trials > 0) out.resize(std::min<size_t>(out.size(), plan_.method.trials));
    return out;
  }

  std::vector<Trial> pairs_of(uint32_t list) {
    const std::vector<renderers::Spec> items = ranked(plan_);
    const std::vector<uint32_t> names = shuffled(static_cast<uint32_t>(items.size()), plan_.seed, kOrder);
    const std::vector<Pairs> rounds = round_robin(static_cast<uint32_t>(items.size()));
    std::vector<Trial> out;
    for (uint32_t round = 0; out.size() < plan_.method.trials; ++round) {
      const auto turn = static_cast<uint32_t>(round / rounds.size());
      for (const auto& [first, second] : rounds[(round + list) % rounds.size()]) {
        if (out.size() == plan_.method.trials) break;
        const size_t a = std::min(names[first], names[second]);
        const size_t b = std::max(names[first], names[second]);
        const bool first_on_top = (names[first] < names[second]) != (swapped(list) != (turn % 2 == 1));
        out.push_back({pair(items[a], items[b], turn % plan_.stimulus.crowds, first_on_top), 1, TrialKind::main});
      }
    }
    return out;
  }

  // Spread over the list, one in each of equal lengths, at a place and in an order of the list's own.
  void put_catch_trials(uint32_t list, std::vector<Trial>& main) {
    const CatchSettings& c = plan_.catch_trials;
    const uint32_t count = c.identical + c.broken;
    const auto length = static_cast<uint32_t>(main.size());
    const std::vector<uint32_t> order = shuffled(count, plan_.seed + list + 1, kPlaces);
    std::vector<Trial> out;
    size_t next = 0;
    for (uint32_t k = 0; k < count; ++k) {
      const uint32_t from = k * length / count;
      const uint32_t to = std::max(from + 1, (k + 1) * length / count);
      const auto at = from + static_cast<uint32_t>(random_below(plan_.seed + list + 1, k, kPlaces + 1, to - from));
      while (next < main.size() && next < at) out.push_back(main[next++]);
      const uint32_t which = order[k];
      const size_t stimulus = which < c.identical ? identical(spread(which, c.identical), crowd_of(which))
                                                  : broken(which - c.identical, list);
      out.push_back({stimulus, 1, TrialKind::catch_trial});
    }
    out.insert(out.end(), main.begin() + static_cast<ptrdiff_t>(next), main.end());
    main = std::move(out);
  }

  // Catch trials show all conditions' scenes in turn.
  size_t spread(uint32_t which, uint32_t of) const {
    return plan_.method.method == Method::active_pairs ? 0 : which * plan_.conditions.size() / of;
  }
  uint32_t crowd_of(uint32_t which) const { return which % plan_.stimulus.crowds; }
  size_t broken(uint32_t which, uint32_t list) {
    return against_reference(StimulusKind::broken, spread(which, std::max(1U, plan_.catch_trials.broken)),
                             plan_.catch_trials.broken_by, crowd_of(which), (which + list) % 2 == 0);
  }

  // Easy ones and real ones in turn.
  std::vector<Trial> training_of(uint32_t list) {
    std::vector<Trial> out;
    for (uint32_t k = 0; k < plan_.training; ++k) {
      const size_t condition = shuffled(static_cast<uint32_t>(plan_.conditions.size()), plan_.seed, kOrder)[0];
      const bool side = (k / 2 + list) % 2 == 0;
      const bool easy = k % 2 == 0;
      const size_t stimulus =
          easy ? broken(k % std::max(1U, plan_.catch_trials.broken), list + k / 2)
          : plan_.method.method == Method::active_pairs
              ? pair(plan_.reference, ranked(plan_).back(), 0, side)
              : against_reference(StimulusKind::test, condition, plan_.conditions[condition].test, 0, side);
      out.push_back({stimulus, 0, TrialKind::training});
    }
    return out;
  }

  void number_blocks(std::vector<Trial>& list) const {
    const std::vector<uint64_t> breaks = breaks_of(plan_);
    for (size_t k = plan_.training; k < list.size(); ++k)
      list[k].block =
          1 + static_cast<uint32_t>(std::count_if(breaks.begin(), breaks.end(), [&](uint64_t at) { return at <= k; }));
  }

  // What the two pilot methods may choose, whether a list shows it or not.
  void add_all_choices() {
    if (plan_.method.method == Method::constant) return;
    const bool pairs = plan_.method.method == Method::active_pairs;
    const std::vector<renderers::Spec> items = ranked(plan_);
    for (uint32_t crowd = 0; crowd < plan_.stimulus.crowds; ++crowd)
      for (const bool on_top : {true, false}) {
        for (size_t a = 0; pairs && a < items.size(); ++a)
          for (size_t b = a + 1; b < items.size(); ++b) pair(items[a], items[b], crowd, on_top);
        for (size_t c = 0; !pairs && c < plan_.conditions.size(); ++c) {
          against_reference(StimulusKind::test, c, plan_.conditions[c].test, crowd, on_top);
          if (plan_.task == Task::same_different) alike(c, crowd, on_top);
        }
      }
  }

  // A permutation of all stimuli names them.
  void name_stimuli() {
    const auto count = static_cast<uint32_t>(design_.stimuli.size());
    const std::vector<uint32_t> order = shuffled(count, plan_.seed, kNames);
    std::vector<Stimulus> named(count);
    std::vector<size_t> place(count);
    for (uint32_t k = 0; k < count; ++k) {
      named[k] = std::move(design_.stimuli[order[k]]);
      named[k].id = fmt::format("s{:03}", k + 1);
      place[order[k]] = k;
    }
    design_.stimuli = std::move(named);
    for (std::vector<Trial>& list : design_.lists)
      for (Trial& trial : list) trial.stimulus = place[trial.stimulus];
  }

  const StudyPlan& plan_;
  StudyDesign design_;
  std::map<std::string, size_t> by_key_;
  std::map<std::tuple<StimulusKind, size_t, size_t, size_t>, size_t> by_halves_;
};

}  // namespace

const char* stimulus_word(StimulusKind kind) {
  switch (kind) {
    case StimulusKind::test: return "test";
    case StimulusKind::alike: return "alike";
    case StimulusKind::identical: return "identical";
    case StimulusKind::broken: return "broken";
    case StimulusKind::pair: return "pair";
  }
  return "";
}

const char* trial_word(TrialKind kind) {
  switch (kind) {
    case TrialKind::training: return "training";
    case TrialKind::main: return "main";
    case TrialKind::catch_trial: return "catch";
  }
  return "";
}

uint32_t order_items(const StudyPlan& plan) {
  if (plan.method.method == Method::active_pairs) return static_cast<uint32_t>(ranked(plan).size());
  const auto n = static_cast<uint32_t>(plan.conditions.size());
  return plan.task == Task::same_different ? 2 * n : n;
}

uint32_t balanced_lists(const StudyPlan& plan) {
  const uint32_t items = order_items(plan);
  if (plan.method.method == Method::active_pairs) return 2 * static_cast<uint32_t>(round_robin(items).size());
  return 2 * static_cast<uint32_t>(williams_design(items).size());
}

uint64_t main_trials(const StudyPlan& plan) {
  return plan.method.method == Method::constant ? uint64_t{rounds_of(plan)} * order_items(plan)
                                                : uint64_t{plan.method.trials};
}

uint64_t trials_of_participant(const StudyPlan& plan) {
  return main_trials(plan) + plan.catch_trials.identical + plan.catch_trials.broken + plan.training;
}

std::vector<uint64_t> breaks_of(const StudyPlan& plan) {
  const uint64_t shown = trials_of_participant(plan) - plan.training;
  std::vector<uint64_t> out;
  for (uint32_t block = 1; block < plan.method.blocks; ++block)
    out.push_back(plan.training + block * shown / plan.method.blocks);
  return out;
}

std::vector<AnswerChoice> answer_choices(Task task) {
  if (task == Task::same_different) return {{"same", "The same", "s"}, {"different", "Different", "d"}};
  std::vector<AnswerChoice> out = {{"upper", "Upper", "u"}, {"lower", "Lower", "l"}};
  if (task == Task::preference) out.push_back({"cannot-tell", "Cannot tell", "c"});
  return out;
}

StudyDesign make_design(const StudyPlan& plan) { return Designer(plan).run(); }

}  // namespace crowdbench::studies
