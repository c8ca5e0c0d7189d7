#include "bench/experiments/study_simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "core/error.h"
#include "core/files.h"
#include "core/probability.h"
#include "core/progress.h"
#include "core/random.h"
#include "store/store.h"
#include "studies/plan/adaptive.h"
#include "studies/server/study_folder.h"

namespace crowdbench::bench {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;
using studies::GivenAnswer;

enum Draw : uint64_t { kThreshold = 1, kSlope, kClip, kObserver, kSee, kGuess, kTell, kSlip, kChoose, kTime };

// ---- what is asked

struct Asked {
  studies::StudyFolder folder;
  std::map<std::string, studies::ShownStimulus> stimuli;
  std::vector<std::vector<studies::StudyTrial>> lists;  // in the order of the folder's, each in its order
  std::optional<studies::AdaptiveRule> rule;
  bool same_different = false;
  bool may_not_tell = false;
  bool has_levels = false;
};

Asked read_asked(const fs::path& out) {
  Asked asked{.folder = studies::read_study_folder(out), .stimuli = {}, .lists = {}, .rule = {}};
  asked.stimuli = studies::read_sides(out, asked.folder.study);
  const studies::StudyFolder& folder = asked.folder;
  asked.same_different = folder.task == "same-different";
  asked.may_not_tell = std::find(folder.answers.begin(), folder.answers.end(), "cannot-tell") != folder.answers.end();
  if (!folder.adaptive.empty())
    asked.rule = studies::parse_adaptive(folder.adaptive, (out / "page" / "trials.json").string());
  for (const auto& [id, stimulus] : asked.stimuli)
    asked.has_levels |= stimulus.kind == "test" && !stimulus.level.empty();
  std::set<std::string> shown = folder.choices;
  for (const std::string& list : folder.lists) {
    std::vector<studies::StudyTrial>& trials = asked.lists.emplace_back(folder.trials.at(list).size());
    for (const auto& [id, trial] : folder.trials.at(list)) {
      if (!trial.stimulus.empty()) shown.insert(trial.stimulus);
      trials[trial.turn] = trial;
    }
  }
  for (const std::string& stimulus : shown)
    if (!asked.stimuli.contains(stimulus))
      throw Error((out / "sides.json").string(), fmt::format("does not know the stimulus '{}'", stimulus),
                  "name a folder that `crowdbench study export` made");
  return asked;
}

// Of a field; `otherwise` where it is no number.
template <typename Number>
Number number_of(const std::string& field, Number otherwise) {
  std::from_chars(field.data(), field.data() + field.size(), otherwise);
  return otherwise;
}

void require_items(const Asked& asked, const SimulatedStudy& simulated, const fs::path& out) {
  std::set<std::string> items;
  for (const auto& [id, stimulus] : asked.stimuli) items.insert({stimulus.upper, stimulus.lower});
  std::vector<std::string> names;
  for (const std::string& item : items)
    if (!item.empty()) names.push_back(item);
  for (const auto& [item, worth] : simulated.log_worth) {
    if (items.contains(item)) continue;
    const std::string near = nearest_name(item, names);
    throw Error("--worth", fmt::format("{} compares nothing called '{}'", out.string(), printable(item, 60)),
                near.empty() ? "sides.json says what is compared" : fmt::format("did you mean '{}'?", near));
  }
}

// ---- who answers

class Observer {
 public:
  Observer(const Asked& asked, const SimulatedStudy& simulated, uint32_t number)
      : asked_(asked),
        simulated_(simulated),
        own_(random_bits(simulated.seed, number, kObserver)),
        threshold_(simulated.who.threshold + simulated.who.threshold_sd * studies::random_normal(own_, 0, kThreshold)),
        slope_(simulated.who.slope * std::exp(simulated.who.slope_log_sd * studies::random_normal(own_, 0, kSlope))) {}

  // turn: of the list's trials; done: the share of them that was answered before.
  std::string answer(const studies::ShownStimulus& s, uint64_t turn, double done) const {
    if (s.kind == "broken") return seen(s, turn);
    if (s.kind == "alike" || (asked_.same_different && s.kind == "identical")) return same_or_different(turn);
    if (s.kind == "test" && asked_.has_levels)
      return chance(kSee, turn) < logistic_cdf(eta(s, done)) ? seen(s, turn) : not_seen(s, turn);
    return compared(s, turn);
  }
  double rt_ms(uint64_t turn) const { return 1500 * std::exp(0.35 * studies::random_normal(own_, turn, kTime)); }

 private:
  double chance(Draw purpose, uint64_t turn) const { return random_unit(own_, turn, purpose); }
  double guess() const { return simulated_.guess.value_or(asked_.same_different ? 0.1 : 0.5); }

  double eta(const studies::ShownStimulus& s, double done) const {
    const studies::SimulatedObservers& who = simulated_.who;
    const double level = number_of(s.level, std::numeric_limits<double>::infinity());
    return slope_ * (level - threshold_) +
           who.clip_sd * studies::random_normal(simulated_.seed, number_of(s.clip, uint64_t{0}), kClip) +
           who.learning * (done - 0.5) + bias(s);
  }
  double bias(const studies::ShownStimulus& s) const {
    const double side = simulated_.who.side_bias;
    return s.expected == "upper" ? side : s.expected == "lower" ? -side : 0;
  }
  std::string same_or_different(uint64_t turn) const { return chance(kGuess, turn) < guess() ? "different" : "same"; }
  static std::string wrong(const std::string& right) {
    if (right == "upper") return "lower";
    if (right == "lower") return "upper";
    return right == "different" ? "same" : "different";
  }
  std::string seen(const studies::ShownStimulus& s, uint64_t turn) const {
    return chance(kSlip, turn) < simulated_.who.lapse ? wrong(s.expected) : s.expected;
  }
  std::string not_seen(const studies::ShownStimulus& s, uint64_t turn) const {
    if (asked_.same_different) return same_or_different(turn);
    if (asked_.may_not_tell && chance(kTell, turn) < simulated_.cannot_tell) return "cannot-tell";
    return chance(kGuess, turn) < studies::biased_guess(guess(), 0, bias(s)) ? s.expected : wrong(s.expected);
  }
  // A picture shown twice is worth as much as itself.
  std::string compared(const studies::ShownStimulus& s, uint64_t turn) const {
    const auto worth = [&](const std::string& item) {
      const auto found = simulated_.log_worth.find(item);
      return s.kind == "identical" || found == simulated_.log_worth.end() ? 0 : found->second;
    };
    const double upper = worth(s.upper) + simulated_.who.side_bias;
    const double lower = worth(s.lower);
    const double tie = simulated_.log_nu + (worth(s.upper) + lower) / 2;
    const double top = std::max({upper, lower, tie});
    const double wins_upper = std::exp(upper - top);
    const double wins_lower = std::exp(lower - top);
    const double ties = asked_.may_not_tell ? std::exp(tie - top) : 0;
    const double at = chance(kChoose, turn) * (wins_upper + wins_lower + ties);
    return at < wins_upper ? "upper" : at < wins_upper + wins_lower ? "lower" : "cannot-tell";
  }

  const Asked& asked_;
  const SimulatedStudy& simulated_;
  uint64_t own_;
  double threshold_, slope_;
};

// As the page records a trial, as far as a simulated observer has it.
StudyAnswerRow row_of(const Asked& asked, const studies::StudyTrial& trial, const std::string& stimulus,
                      const std::string& answer, double rt_ms) {
  StudyAnswerRow row;
  row.item = trial.trial;
  row.kind = trial.kind;
  row.stimulus = stimulus;
  row.block = trial.block;
  row.answer = answer;
  row.rt = std::round(rt_ms);
  row.replays = row.frames_dropped = row.hidden = row.restarts = 0U;
  row.data = json{{"item", row.item},
                  {"kind", row.kind},
                  {"stimulus", stimulus},
                  {"block", trial.block},
                  {"answer", answer},
                  {"rt_ms", *row.rt},
                  {"replays", 0},
                  {"frames", asked.folder.frames},
                  {"frames_total", asked.folder.frames},
                  {"frames_dropped", 0},
                  {"hidden", 0},
                  {"restarts", 0},
                  {"observers", "simulated"}}
                 .dump();
  return row;
}

void add_answers_of(const Observer& observer, const Asked& asked, size_t list, int64_t participant,
                    std::vector<StudyAnswerRow>& to) {
  std::vector<GivenAnswer> before;
  const std::vector<studies::StudyTrial>& trials = asked.lists[list];
  for (const studies::StudyTrial& trial : trials) {
    const size_t t = trial.turn;
    const std::string stimulus =
        trial.stimulus.empty()
            ? studies::chosen_stimulus(*asked.rule, asked.folder.study, asked.folder.lists[list], trial.trial, before)
            : trial.stimulus;
    const double done = (static_cast<double>(t) + 0.5) / static_cast<double>(trials.size());
    const std::string answer = observer.answer(asked.stimuli.at(stimulus), t, done);
    if (trial.kind == "main") before.push_back({stimulus, answer});
    to.push_back(row_of(asked, trial, stimulus, answer, observer.rt_ms(t)));
    to.back().participant = participant;
  }
}

}  // namespace

studies::StudyAnswers simulate_study(const fs::path& out, const SimulatedStudy& simulated) {
  const Asked asked = read_asked(out);
  require_items(asked, simulated, out);
  studies::StudyAnswers answers{.study = asked.folder.study, .participants = {}, .answers = {}};
  Progress progress("simulating observers", simulated.observers);
  for (uint32_t k = 0; k < simulated.observers; ++k) {
    const size_t list = k % asked.lists.size();
    StudyParticipantRow who;
    who.id = k + 1;
    who.study = asked.folder.study;
    who.participant = fmt::format("simulated-{}", k + 1);
    who.list = asked.folder.lists[list];
    who.state = "finished";
    add_answers_of(Observer(asked, simulated, k), asked, list, who.id, answers.answers);
    answers.participants.push_back(std::move(who));
    progress.advance();
  }
  return answers;
}

void write_simulated(const studies::StudyAnswers& answers, const fs::path& file) {
  if (fs::exists(file))
    throw Error(file.string(), "is there already, and simulated answers are not added to others",
                "name a new file, or remove that one");
  PendingFile pending(file);
  {
    StoreWriter writer(pending.path());
    writer.begin();
    std::map<int64_t, int64_t> ids;
    for (const StudyParticipantRow& who : answers.participants) ids[who.id] = writer.write(who);
    for (StudyAnswerRow row : answers.answers) {
      row.participant = ids.at(row.participant);
      writer.write(row);
    }
    writer.commit();
  }
  pending.commit();
}

}  // namespace crowdbench::bench
