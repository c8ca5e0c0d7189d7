// The plan of a study: one TOML file that fixes, before the first answer, what is asked, what is shown, to whom in
// which order, who is left out and how the answers are analysed. studies/plan/README.md documents every key.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/json.h"
#include "renderers/representation.h"
#include "scene/scenario/scenario.h"
#include "studies/analysis/analysis.h"

namespace crowdbench::studies {

enum class Question : uint8_t { better, differs, pop };
// forced_choice: upper or lower. preference: upper, lower, or "cannot tell". same_different: are the halves alike?
enum class Task : uint8_t { forced_choice, preference, same_different };
// constant: constant stimuli. quest_plus: a pilot whose next level is chosen by QUEST+. active_pairs: pairs of all
// conditions, for scaling, the next ones chosen by the answers so far.
enum class Method : uint8_t { constant, quest_plus, active_pairs };
// same: both halves show one crowd. independent: two crowds of one scenario, so that nobody compares pixels.
enum class Seeds : uint8_t { same, independent };

struct FactorLevel {
  std::string text;              // as tables say it
  std::optional<double> number;  // where it is one; may be infinite
};
struct Factor {
  std::string name;  // "switch_m", "height_px", "representation", "crowd.agents", "flat.views", ...
  std::vector<FactorLevel> levels;
};

// One combination of the factors' levels: the half under test against the reference.
struct StudyCondition {
  std::string id;                   // "c01", "c02", ... in the order of the factors, the last changing fastest
  std::string name;                 // the levels, joined: "switch_m=10"
  std::vector<FactorLevel> levels;  // one a factor
  std::optional<double> level;      // of the factor that the psychometric function is over
  renderers::Spec test;             // what draws the half under test
  scene::Scenario scenario;         // of both halves; its seed is the first crowd's
  bool spacing_by_bodies = true;    // neighbours as far apart as the characters' bodies need; else as the scenario says
  // The eye moves along its line to the target until a character there is so many pixels tall, or a texel of `test` is
  // so many pixels wide; at most one of them.
  std::optional<double> height_px, pixels_per_texel;
};

struct StimulusSettings {
  double seconds = 10;
  int fps = 30;
  double lead_in_seconds = 2;  // simulated before the first frame: fades and hysteresis are under way
  Seeds seeds = Seeds::independent;
  uint32_t crowds = 2;           // different crowds a condition is shown with
  double largest_px = 120;       // no figure may be taller in any frame
  bool intersect = false;        // bodies may stand in each other
  int bar_px = 16;               // even
  uint32_t replays = 0;          // that a participant may ask for
  double least_psnr = 40;        // dB, of the worst decoded frame
  double artefact_share = 0.25;  // the decoded error may be so much of the difference under test, at its pixels
};

struct MethodSettings {
  Method method = Method::constant;
  uint32_t repeats = 2;  // of every condition with every crowd, by a participant
  uint32_t blocks = 1;
  uint32_t trials = 0;  // quest_plus and active_pairs: how many a participant answers
};

struct CatchSettings {
  uint32_t identical = 2;  // trials a participant whose halves are the same picture
  uint32_t broken = 2;     // whose wrong half anybody sees
  renderers::Spec broken_by;
};

struct ParticipantSettings {
  uint32_t planned = 0;  // how many are to take part
  uint32_t lists = 0;    // different orders; participant k gets list k modulo lists
  bool calibration = true;
  std::vector<std::string> demographics;  // what is asked, in words
};

struct ExclusionRules {
  double catch_least = 0.75;   // share of broken catch trials that must be right
  double shortest_rt_ms = 0;   // faster answers are left out
  double most_dropped = 0.05;  // share of a trial's frames: with more it is left out
  bool hidden = true;          // leave out trials during which the page was hidden
};

struct PlannedAnalysis {
  AnalysisSettings settings;
  std::string level;  // the factor that the psychometric function is over; empty: none
};

struct StudyPlan {
  std::string name, title;
  std::filesystem::path folder;  // that paths are relative to
  std::string where;             // the file's name, for errors
  uint64_t seed = 1;             // of orders, sides and names of stimuli
  Question question = Question::better;
  Task task = Task::preference;
  std::string question_text;
  std::string consent, instructions, debrief;  // Markdown: the files' text, or what is shipped
  renderers::Spec reference;
  std::vector<Factor> factors;
  std::vector<StudyCondition> conditions;  // 1 to kMostConditions
  StimulusSettings stimulus;
  MethodSettings method;
  CatchSettings catch_trials;
  uint32_t training = 2;  // trials before the first block
  ParticipantSettings participants;
  ExclusionRules exclude;
  PlannedAnalysis analysis;

  size_t frames() const;
  // All that decides what is shown, asked and computed, resolved: comments, order of keys and defaults that are spelt
  // out change nothing.
  Json meaning() const;
  // SHA-256 of meaning(), 64 hexadecimal digits.
  std::string hash() const;
};
inline constexpr size_t kMostConditions = 64;

// Throws Error naming file and line: what is unknown (with the nearest name), out of range, or makes no sense together.
StudyPlan read_study_plan(const std::filesystem::path& file);
// where: the plan's name in errors; folder: what its paths are relative to.
StudyPlan parse_study_plan(const std::string& toml, const std::string& where, const std::filesystem::path& folder);

// Their words in plans and in what is exported.
const std::vector<std::string>& question_words();
const std::vector<std::string>& task_words();
const std::vector<std::string>& method_words();
const std::vector<std::string>& seeds_words();

// The planned analysis as the frozen file, study.json and meaning() hold it.
Json analysis_plan_json(const PlannedAnalysis& analysis);

}  // namespace crowdbench::studies
