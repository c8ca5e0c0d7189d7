#include "studies/plan/export.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "core/error.h"
#include "core/files.h"
#include "core/hash.h"
#include "core/progress.h"
#include "studies/page/page.h"
#include "studies/plan/compose.h"
#include "studies/plan/page_files.h"
#include "studies/plan/records.h"
#include "studies/plan/staging.h"
#include "studies/plan/time_left.h"
#include "studies/stimuli/clip.h"
#include "studies/stimuli/crowd_clip.h"

namespace crowdbench::studies {
namespace {

namespace fs = std::filesystem;

constexpr int kProofVersion = 1;  // raised when stimuli are to be made and proven anew
// Microseconds and bytes a pixel, measured with 60 mannequins on llvmpipe and two cores.
constexpr double kSampleMicros = 0.1, kWriteMicros = 0.1, kStackMicros = 0.25, kWebmMicros = 1.5;
constexpr double kHalfBytes = 0.2, kClipBytes = 0.045;
constexpr double kAnswerSeconds = 4;
// Of a character for a representation: from about 10 (flat) to 90 (the slowest) of the shared characters.
constexpr double kBakeSeconds = 30;

// About what a half takes: drawn and written once.
double seconds_of(const StudyPlan& plan, const PlannedHalf& half) {
  const scene::Scenario& scenario = half.scenario;
  const double samples = scenario.antialiasing.supersample * scenario.antialiasing.supersample;
  return static_cast<double>(plan.frames()) * scenario.width * scenario.height *
         (kSampleMicros * samples + kWriteMicros) / 1e6;
}

double pixels_of(const StudyPlan& plan, const Stimulus& stimulus) {
  const scene::Scenario& scenario = plan.conditions[stimulus.condition].scenario;
  return static_cast<double>(plan.frames()) * scenario.width * (2.0 * scenario.height + plan.stimulus.bar_px);
}

// About what a stimulus takes: written, encoded, read and compared.
double seconds_of(const StudyPlan& plan, const Stimulus& stimulus, bool webm) {
  return pixels_of(plan, stimulus) * (kStackMicros + (webm ? kWebmMicros : 0)) / 1e6;
}

// What a half bakes, a name each: every component but the reference for every character. A bake is made once for all
// halves that name it.
std::set<std::string> bakes_of(const renderers::Spec& spec, const scene::Scenario& scenario) {
  std::set<std::string> out;
  for (const renderers::Spec& component : spec.components) out.merge(bakes_of(component, scenario));
  if (!spec.components.empty() || renderers::representation_type(spec.name).reference) return out;
  for (const scene::CharacterEntry& entry : scenario.characters)
    out.insert(fmt::format("{}\n{}\n{}", spec.text(), entry.source, fmt::join(entry.clips, ",")));
  return out;
}
std::set<std::string> bakes_of(const PlannedHalf& half) { return bakes_of(half.spec, half.scenario); }

// Tells the progress what is left as steps end.
class StepsLeft {
 public:
  // to_bake: how many bakes are to come.
  StepsLeft(Progress& progress, const ExportEstimate& estimate, size_t to_bake)
      : progress_(progress), left_(estimate.seconds - estimate.bake_seconds, kBakeSeconds) {
    left_.set_bakes(to_bake);
    progress_.expect(left_.seconds());
  }
  // A step is over; made: it was not kept from before. bakes of it took bake_seconds; to_bake are to come.
  void end(double seconds, bool made, size_t bakes = 0, double bake_seconds = 0, size_t to_bake = 0) {
    const auto now = Clock::now();
    const double spent = std::chrono::duration<double>(now - begun_).count();
    begun_ = now;
    left_.baked(bakes, bake_seconds);
    left_.step(seconds, made, std::max(0.0, spent - bake_seconds));
    left_.set_bakes(to_bake);
    progress_.expect(left_.seconds());
    progress_.advance();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Progress& progress_;
  Clock::time_point begun_ = Clock::now();
  TimeLeft left_;
};

// One export under way.
class Exporter {
 public:
  Exporter(gl::Context& context, const StudyPlan& plan, const FrozenPlan& frozen, fs::path out,
           const ExportSettings& settings)
      : context_(context),
        plan_(plan),
        frozen_(frozen),
        out_(std::move(out)),
        settings_(settings),
        design_(make_design(plan)),
        staging_(context, plan) {}

  Exported run() {
    make_folders();
    Progress progress("study export", design_.halves.size() + design_.stimuli.size());
    StepsLeft left(progress, estimate_export(plan_, design_, settings_.webm), bakes_from(0).size());
    for (size_t i = 0; i < design_.halves.size(); ++i) {
      const PlannedHalf& half = design_.halves[i];
      const size_t drawn = result_.drawn;
      const size_t baked = baked_.size();
      const double bake_seconds = bake_seconds_ + staging_.bake_seconds();
      draw(half);
      left.end(seconds_of(plan_, half), result_.drawn > drawn, baked_.size() - baked,
               bake_seconds_ + staging_.bake_seconds() - bake_seconds, bakes_from(i + 1).size());
    }
    remove_strangers();
    for (const Stimulus& stimulus : design_.stimuli) {
      const size_t before = result_.stacked;
      compose(stimulus);
      left.end(seconds_of(plan_, stimulus, settings_.webm), result_.stacked > before);
    }
    progress.end();
    write_outputs();
    return std::move(result_);
  }

 private:
  void make_folders() const {
    require_page();
    make_folder(out_);
    const std::string before = exported_hash(out_);
    if (!before.empty() && before != frozen_.current_hash())
      throw Error(out_.string(), "holds the export of another plan", "choose another folder, or remove this one");
    for (const char* const name : {"work", "page", "page/clips"}) make_folder(out_ / name);
  }

  // What the halves from `first` on still bake, were none of them kept.
  std::set<std::string> bakes_from(size_t first) const {
    std::set<std::string> out;
    for (size_t i = first; i < design_.halves.size(); ++i)
      for (const std::string& bake : bakes_of(design_.halves[i]))
        if (!baked_.contains(bake)) out.insert(bake);
    return out;
  }

  fs::path half_file(const PlannedHalf& half) { return out_ / "work" / (keys_.at(half.key) + ".mp4"); }

  void draw(const PlannedHalf& half) {
    const std::string key = staging_.key(half);
    keys_[half.key] = key;
    const fs::path record = out_ / "work" / (key + ".json");
    const scene::Scenario scenario = staging_.scenario(half);
    std::optional<Json> facts = read_record(record, key, out_);
    if (facts) {
      ++result_.kept_halves;
    } else {
      CrowdClipRequest request;
      request.name = fmt::format("{}: {} by {}, seed {}", plan_.where, plan_.conditions[half.condition].name,
                                 half.spec.text(), scenario.seed);
      request.scenario = scenario;
      request.spec = half.spec;
      request.frames = plan_.frames();
      request.fps = plan_.stimulus.fps;
      request.lead_in_seconds = plan_.stimulus.lead_in_seconds;
      request.largest_px = plan_.stimulus.largest_px;
      request.intersect = plan_.stimulus.intersect;
      const CrowdClip clip =
          draw_crowd_clip(context_, staging_.cast(plan_.conditions[half.condition]), request, half_file(half));
      facts = crowd_clip_json(clip);
      const std::string name = "work/" + key + ".mp4";
      write_record(record, key, {{name, file_sha256(out_ / name)}}, *facts);
      ++result_.drawn;
      baked_.merge(bakes_of(half));
      bake_seconds_ += clip.bake_seconds;
    }
    note_alike(half, *facts);
    Json entry = half_json(half, scenario);
    entry["file"] = "work/" + key + ".mp4";
    entry.update(*facts);
    halves_.push_back(std::move(entry));
  }

  // Conditions under test that are drawn alike are one: a switch at 10 m where nobody is nearer is one at 0 m.
  void note_alike(const PlannedHalf& half, const Json& facts) {
    if (half.spec.text() != plan_.conditions[half.condition].test.text()) return;
    const auto [found, fresh] = drawn_.emplace(facts.at("frame_sha256").dump(), half.condition);
    const std::pair<size_t, size_t> both = std::minmax(found->second, half.condition);
    if (fresh || both.first == both.second || !alike_.insert(both).second) return;
    result_.warnings.push_back(fmt::format("{} and {} are drawn alike, frame by frame: nobody can tell them apart",
                                           plan_.conditions[both.first].name, plan_.conditions[both.second].name));
  }

  // Clips of an earlier export that this one does not have, as after another `--browsers`.
  void remove_strangers() const {
    std::set<std::string> ours;
    for (const Stimulus& stimulus : design_.stimuli) {
      ours.insert(stimulus.id + ".mp4");
      if (settings_.webm) ours.insert(stimulus.id + ".webm");
    }
    for (const auto& entry : fs::directory_iterator(out_ / "page" / "clips"))
      if (!ours.contains(entry.path().filename().string())) fs::remove_all(entry.path());
  }

  std::string stimulus_key(const Stimulus& stimulus) const {
    Sha256 digest;
    digest.value(kProofVersion).value(settings_.webm);
    digest.text(keys_.at(design_.halves[stimulus.upper].key)).text(keys_.at(design_.halves[stimulus.lower].key));
    digest.text(stimulus.twin ? keys_.at(design_.halves[*stimulus.twin].key) : std::string());
    digest.value(stimulus.test_on_top.value_or(true)).value(plan_.stimulus.bar_px);
    digest.value(plan_.stimulus.least_psnr).value(plan_.stimulus.artefact_share);
    digest.text(plan_.conditions[stimulus.condition].name);
    return digest.hex().substr(0, 16);
  }

  void compose(const Stimulus& stimulus) {
    const std::string key = stimulus_key(stimulus);
    const fs::path record = out_ / "work" / (stimulus.id + ".json");
    std::optional<Json> facts = read_record(record, key, out_);
    if (facts) {
      ++result_.kept_stimuli;
    } else {
      const ComposeRequest request = {plan_,
                                      stimulus,
                                      half_file(design_.halves[stimulus.upper]),
                                      half_file(design_.halves[stimulus.lower]),
                                      stimulus.twin ? half_file(design_.halves[*stimulus.twin]) : fs::path(),
                                      out_,
                                      settings_.webm};
      const Composed composed = compose_stimulus(request);
      write_record(record, key, composed.files, composed.facts);
      facts = composed.facts;
      ++result_.stacked;
    }
    note(stimulus, *facts);
    Json entry = stimulus_json(plan_, design_, stimulus);
    entry["upper"]["half"] = keys_.at(design_.halves[stimulus.upper].key);
    entry["lower"]["half"] = keys_.at(design_.halves[stimulus.lower].key);
    entry.update(*facts);
    entry["scores"] = scores(stimulus);
    stimuli_.push_back(std::move(entry));
  }

  // What is worth a line to whoever exports.
  void note(const Stimulus& stimulus, const Json& facts) {
    for (const char* const codec : {"h264", "vp9"}) {
      if (codec == std::string("vp9") && !settings_.webm) continue;
      const Json& share = facts.at("proof").at(codec).at("share");
      if (!share.is_null()) result_.worst_share = std::max(result_.worst_share, share.number());
    }
    const bool tested = stimulus.kind == StimulusKind::test || stimulus.kind == StimulusKind::pair;
    const bool one = stimulus.item_upper == stimulus.item_lower;
    if (tested && !one && facts.at("proof").at("h264").at("artefact_pixels").integer() == 0 &&
        warned_.insert(stimulus.condition).second)
      result_.warnings.push_back(
          fmt::format("{}: no pixel under test differs from the reference's by more than a few "
                      "code values: nobody can see it",
                      plan_.conditions[stimulus.condition].name));
  }

  Json scores(const Stimulus& stimulus) {
    if (!stimulus.twin || settings_.score_every_seconds <= 0) return Json::array();
    const size_t test = stimulus.test_on_top.value_or(true) ? stimulus.upper : stimulus.lower;
    if (test == *stimulus.twin) return Json::array();
    const auto every =
        static_cast<size_t>(std::max(1.0, std::round(settings_.score_every_seconds * plan_.stimulus.fps)));
    const fs::path a = half_file(design_.halves[test]);
    const fs::path b = half_file(design_.halves[*stimulus.twin]);
    const std::string key = Sha256()
                                .text(a.stem().string())
                                .text(b.stem().string())
                                .text(display_text(settings_.display.display))
                                .value(every)
                                .hex()
                                .substr(0, 16);
    const fs::path record = out_ / "work" / ("scores-" + key + ".json");
    std::optional<Json> found = read_record(record, key, out_);
    if (!found) {
      found = score_halves(a, b, every, settings_.display);
      write_record(record, key, {}, *found);
    }
    return *found;
  }

  void write_outputs() {
    const ExportFacts facts = {
        plan_, frozen_, design_, halves_, stimuli_, settings_, context_.renderer(), context_.version()};
    write_page(out_ / "page");
    write_page_files(facts, out_ / "page");  // last: it gives all of them one date
    write_file(out_ / "sides.json", sides_json(facts).dump(2) + "\n");
    write_file(out_ / "study.json", study_json(facts).dump(2) + "\n");
  }

  gl::Context& context_;
  const StudyPlan& plan_;
  const FrozenPlan& frozen_;
  fs::path out_;
  const ExportSettings& settings_;
  StudyDesign design_;
  Staging staging_;
  std::map<std::string, std::string> keys_;  // of halves: planned to drawn
  std::set<std::string> baked_;              // bakes_of() the halves that were drawn
  double bake_seconds_ = 0;                  // of these
  Json halves_ = Json::array();
  Json stimuli_ = Json::array();
  std::set<size_t> warned_;
  std::map<std::string, size_t> drawn_;        // conditions of halves under test, by the hashes of their frames
  std::set<std::pair<size_t, size_t>> alike_;  // conditions that were said to be
  Exported result_;
};

}  // namespace

ExportEstimate estimate_export(const StudyPlan& plan, const StudyDesign& design, bool webm) {
  ExportEstimate out;
  out.halves = design.halves.size();
  out.stimuli = design.stimuli.size();
  out.lists = design.lists.size();
  out.trials = trials_of_participant(plan);
  out.minutes_a_participant = static_cast<double>(out.trials) * (plan.stimulus.seconds + kAnswerSeconds) / 60;
  const auto frames = static_cast<double>(plan.frames());
  std::set<std::string> bakes;
  for (const PlannedHalf& half : design.halves) {
    bakes.merge(bakes_of(half));
    out.seconds += seconds_of(plan, half);
    out.work_bytes += frames * half.scenario.width * half.scenario.height * kHalfBytes;
  }
  for (const Stimulus& stimulus : design.stimuli) {
    out.seconds += seconds_of(plan, stimulus, webm);
    out.page_bytes += pixels_of(plan, stimulus) * kClipBytes * (webm ? 2 : 1);
  }
  out.bakes = bakes.size();
  out.bake_seconds = kBakeSeconds * static_cast<double>(out.bakes);
  out.seconds += out.bake_seconds;
  return out;
}

Exported export_study(gl::Context& context, const StudyPlan& plan, const FrozenPlan& frozen, const fs::path& out,
                      const ExportSettings& settings) {
  say_when_interrupted("what is finished stays in " + (out / "work").string() + ": the same command goes on there");
  return Exporter(context, plan, frozen, out, settings).run();
}

}  // namespace crowdbench::studies
