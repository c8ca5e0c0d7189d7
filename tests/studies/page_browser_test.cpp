// The study's page in real browsers, headless, under its server: a simulated observer (tools/study_observer.mjs) takes
// the whole study, and what the server keeps is what it chose.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/command_line.h"
#include "core/screen_calibration.h"
#include "store/store.h"
#include "studies/analysis/analysis.h"
#include "studies/analysis/analysis_output.h"
#include "studies/page/page.h"
#include "studies/plan/adaptive.h"
#include "studies/server/answers_export.h"
#include "test_paths.h"
#include "tests/support/driver.h"
#include "tests/support/running_driver.h"
#include "tests/support/sanitized.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/study_page.h"

namespace crowdbench::studies {
namespace {
namespace fs = std::filesystem;

class StudyBrowserSlow : public ::testing::Test {
 protected:
  void SetUp() override {
    CROWDBENCH_SKIP_SANITIZED("StudyServer and StudyFolder: browsers execute nothing of ours");
    if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
    if (support::run_shell("command -v node >/dev/null").status != 0) GTEST_SKIP() << "node is not installed (nodejs)";
    if (!fs::exists(fs::path(CROWDBENCH_SOURCE_DIR) / "node_modules/puppeteer-core"))
      GTEST_SKIP() << "puppeteer-core is not installed (npm ci)";
  }
  static bool has(const char* program) {
    return support::run_shell(std::string("command -v ") + program + " >/dev/null").status == 0;
  }
  void serve(bool adaptive = false) {
    support::write_study(out_);
    if (adaptive) support::let_the_page_choose(out_);
    listen("0");
  }
  void listen(const std::string& port) {
    server_ = std::make_unique<support::RunningDriver>(
        std::vector<std::string>{"study", "serve", out_.string(), "--port", port}, folder_.path(), folder_.path());
    ASSERT_TRUE(server_->wait_until_it_says("Ctrl-C ends", 20)) << server_->said();
    const std::string said = server_->said();
    url_ = said.substr(0, said.find('\n'));
  }
  // What the observer says of itself; it comes to an end.
  nlohmann::json observe(const std::string& options) const {
    const support::Outcome outcome = support::run_shell(
        "node " + shell_quoted((fs::path(CROWDBENCH_SOURCE_DIR) / "tools/study_observer.mjs").string()) + " " + url_ +
        " " + options + " 2>" + shell_quoted((folder_ / "observer.txt").string()));
    EXPECT_EQ(outcome.status, 0) << outcome.text << read_text(folder_ / "observer.txt");
    nlohmann::json said = nlohmann::json::parse(outcome.text, nullptr, false);
    EXPECT_TRUE(said.is_object()) << outcome.text;
    EXPECT_EQ(said.value("errors", nlohmann::json()), nlohmann::json::array()) << outcome.text;
    EXPECT_EQ(said.value("requests_elsewhere", nlohmann::json()), nlohmann::json::array())
        << "asked for from elsewhere";
    return said;
  }
  // Every record, every row of the table, and the report that is made of them.
  void expect_said_to_be_simulated() const {
    for (const StudyAnswerRow& row : kept().answers)
      EXPECT_EQ(nlohmann::json::parse(row.data).value("observers", ""), "simulated") << row.item;
    const StudyAnswers answers = read_study_answers({out_ / "answers.sqlite"}, support::kStudyHash);
    const Table table = parse_table(answers_csv(answers, out_), "answers");
    Answers rows;
    add_answers(rows, table, columns_by_name(table));
    const Analysis found = analyse(std::move(rows), {.resamples = 0});
    EXPECT_EQ(found.simulated_rows, found.rows);
    EXPECT_TRUE(analysis_markdown(found).starts_with("# What simulated observers answered\n\nSIMULATED: "));
  }
  StoreContents kept() const { return read_store(out_ / "answers.sqlite"); }

  support::ScratchFolder folder_;
  fs::path out_ = folder_ / "out";
  std::string url_;
  std::unique_ptr<support::RunningDriver> server_;
};

// Each trial once, as it was chosen, in the order of the list.
void expect_as_chosen(const StoreContents& all, const nlohmann::json& said) {
  std::vector<StudyAnswerRow> trials;
  for (const StudyAnswerRow& row : all.answers)
    if (row.kind != "page") trials.push_back(row);
  ASSERT_EQ(said.at("chosen").size(), 5U) << said.dump(1);
  ASSERT_EQ(trials.size(), 5U);
  for (size_t i = 0; i < trials.size(); ++i) {
    const nlohmann::json& chosen = said.at("chosen")[i];
    EXPECT_EQ(trials[i].item, chosen.at("trial"));
    EXPECT_EQ(trials[i].stimulus, chosen.at("stimulus").get<std::string>());
    EXPECT_EQ(trials[i].kind, chosen.at("kind"));
    EXPECT_EQ(trials[i].answer, chosen.at("answer").get<std::string>());
    EXPECT_EQ(nlohmann::json::parse(trials[i].data).at("answered_by"), chosen.at("by"));
  }
}
nlohmann::json page_record(const StoreContents& all, const std::string& item) {
  for (const StudyAnswerRow& row : all.answers)
    if (row.item == item) return nlohmann::json::parse(row.data);
  ADD_FAILURE() << "no record of " << item;
  return nlohmann::json::object();
}
const StudyAnswerRow& trial(const StoreContents& all, const std::string& item) {
  for (const StudyAnswerRow& row : all.answers)
    if (row.item == item) return row;
  static const StudyAnswerRow none;
  ADD_FAILURE() << "no record of " << item;
  return none;
}

TEST_F(StudyBrowserSlow, AWholeStudyInChromium) {
  if (!has("chromium")) GTEST_SKIP() << "chromium is not installed (chromium)";
  serve();
  const nlohmann::json said =
      observe("--browser chromium --participant 5f00aa --full-screen --reload 2 --hide 3 --lost 4");
  EXPECT_EQ(said.at("state"), "finished");
  EXPECT_EQ(said.at("address"), url_) << "the participant's id stays in no address";
  const StoreContents all = kept();
  ASSERT_EQ(all.participants.size(), 1U);
  const StudyParticipantRow& who = all.participants[0];
  EXPECT_EQ(who.state, "finished");
  EXPECT_EQ(who.participant, sha256_hex(support::kStudyHash + "/5f00aa"));
  expect_as_chosen(all, said);
  EXPECT_EQ(trial(all, "t001").restarts, 0U);
  EXPECT_EQ(trial(all, "t002").restarts, 1U) << "reloaded in its middle";
  EXPECT_GE(trial(all, "t003").hidden.value_or(0), 1U) << "another tab was in front";
  EXPECT_EQ(trial(all, "t005").hidden, 0U);
  EXPECT_TRUE(trial(all, "t001").frames_dropped.has_value());
  const nlohmann::json calibration = page_record(all, "calibration");
  EXPECT_EQ(calibration.at("card_px"), (nlohmann::json{320, 320, 320}));
  EXPECT_EQ(calibration.at("blind_spot_px").size(), 5U);
  // 320 pixels are 85.6 mm; a degree is 2 tan(0.5 deg) of the spot's distance over tan(13.5 deg).
  EXPECT_NEAR(calibration.at("px_per_mm").get<double>(), 320 / 85.6, 1e-9);
  double spot = 0;
  for (const nlohmann::json& each : calibration.at("blind_spot_px")) spot += each.get<double>() / 5;
  EXPECT_NEAR(who.pixels_per_degree.value_or(0), spot * 0.0727003, spot * 1e-5);
  EXPECT_GT(who.pixels_per_degree_se.value_or(0), 0.08 * *who.pixels_per_degree) << "eyes differ";
  const nlohmann::json browser = page_record(all, "browser-1");
  EXPECT_LE(browser.at("tried")[0].at("worst_difference").get<double>(), 16.0);
  EXPECT_EQ(browser.at("clip_type"), "video/mp4; codecs=\"avc1.F4000A\"");
  expect_said_to_be_simulated();
  EXPECT_EQ(page_record(all, "vision").at("plates").size(), 5U);
  EXPECT_EQ(page_record(all, "demographics").at("response").at("question-1"), "simulated");
  for (const char* screen : {"consent", "card", "spot", "plate", "clip", "answer", "break", "comments", "finished"})
    EXPECT_NE(std::find(said.at("screens").begin(), said.at("screens").end(), screen), said.at("screens").end())
        << screen;
}

TEST_F(StudyBrowserSlow, AWholeStudyInFirefoxByTheKeyboardAlone) {
  if (!has("firefox-esr")) GTEST_SKIP() << "firefox-esr is not installed (firefox-esr)";
  serve();
  const nlohmann::json said = observe(
      "--browser firefox --participant 5f00ab --keyboard --no-calibration --reload 2 --hide 3 --width 390 --height "
      "800");
  EXPECT_EQ(said.at("state"), "finished");
  const StoreContents all = kept();
  ASSERT_EQ(all.participants.size(), 1U);
  EXPECT_EQ(all.participants[0].pixels_per_degree, std::nullopt);
  expect_as_chosen(all, said);
  EXPECT_EQ(trial(all, "t002").restarts, 1U);
  expect_said_to_be_simulated();
  EXPECT_EQ(page_record(all, "screen-1").at("full_screen"), "not wanted");
}

// What support::let_the_page_choose() gives the page.
AdaptiveRule two_level_rule() {
  AdaptiveRule rule;
  rule.threshold = {8, 11, 14, 17, 20, 23};
  rule.slope = {0.5, 2};
  rule.guess = {0.5};
  rule.lapse = {0.02};
  rule.choices = {{10, 0, 0, {"s001"}}, {20, 0, 0, {"s002"}}};
  rule.yes = {{"s001", "upper"}, {"s002", "lower"}};
  return rule;
}

TEST_F(StudyBrowserSlow, AnAdaptiveStudyChoosesAsTheRuleDoesThroughReloadAndCrash) {
  if (!has("chromium")) GTEST_SKIP() << "chromium is not installed (chromium)";
  ASSERT_EQ(nlohmann::json::parse(adaptive_json(two_level_rule()).dump()), support::two_level_rule());
  serve(true);
  // So few trials may all show one level; Adaptive.PageChoosesTheSame holds the page's choice between many to the rule.
  const std::string second = has("firefox-esr") ? "firefox --reload 3" : "chromium --reload 3";
  for (const std::string& browser : {std::string("chromium --reload 3 --crash 5 --seed 1 --participant 5f00b1"),
                                     second + " --seed 2 --participant 5f00b2"}) {
    const nlohmann::json said = observe("--no-calibration --browser " + browser);
    EXPECT_EQ(said.at("state"), "finished");
    std::vector<GivenAnswer> before;
    const StoreContents all = kept();
    const StudyParticipantRow& who = all.participants.back();
    size_t trials = 0;
    for (const StudyAnswerRow& row : all.answers) {
      if (row.participant != who.id || row.kind == "page") continue;
      EXPECT_EQ(row.stimulus, said.at("chosen").at(trials++).at("stimulus").get<std::string>()) << row.item;
      if (row.kind != "main") continue;
      EXPECT_EQ(row.stimulus, chosen_stimulus(two_level_rule(), support::kStudyHash, who.list, row.item, before))
          << row.item;
      before.push_back({row.stimulus.value_or(""), row.answer.value_or("")});
    }
    EXPECT_EQ(trials, 5U);
  }
}

// In the middle of a trial the server is killed, started again and the page reloaded; in the middle of another the
// participant goes on in a browser that knows nothing of the first.
TEST_F(StudyBrowserSlow, RestartsAreCountedThroughAKillOfTheServerAndInAnotherBrowser) {
  if (!has("chromium")) GTEST_SKIP() << "chromium is not installed (chromium)";
  serve();
  const fs::path again = folder_ / "again";
  std::thread killer([&] {
    const auto begun = [&] {
      const StoreContents all = kept();
      return !all.participants.empty() && all.participants[0].begun.value_or("").find("t002") != std::string::npos;
    };
    for (int waits = 0; !begun() && waits < 600; ++waits) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    server_->send(SIGKILL);
    server_->wait_for_end(5);
    const size_t colon = url_.rfind(':') + 1;
    listen(url_.substr(colon, url_.rfind('/') - colon));
    write_file(again, std::string_view("now"));
  });
  const nlohmann::json said =
      observe("--browser chromium --participant 5f00ad --no-calibration --another 4 --wait 2 --until " +
              shell_quoted(again.string()));
  killer.join();
  EXPECT_EQ(said.at("state"), "finished");
  const StoreContents all = kept();
  expect_as_chosen(all, said);
  ASSERT_EQ(all.participants.size(), 1U);
  const std::map<std::string, uint32_t> restarts = {{"t001", 0}, {"t002", 1}, {"t003", 0}, {"t004", 1}, {"t005", 0}};
  for (const auto& [item, count] : restarts) EXPECT_EQ(trial(all, item).restarts, count) << item;
}

// Of H.264 4:4:4 Debian packages no decoder but libavcodec's (VP9 has vpxdec, in clip_test.cpp): what is told apart
// here are the browsers' own readers of the file and their clocks.
TEST_F(StudyBrowserSlow, BrowsersFindEveryFrameAtItsTime) {
  serve();
  size_t tried = 0;
  for (const auto& [browser, program] : {std::pair{"chromium", "chromium"}, {"firefox", "firefox-esr"}}) {
    if (!has(program)) continue;
    ++tried;
    const support::Outcome outcome = support::run_shell(
        "node " + shell_quoted((fs::path(CROWDBENCH_SOURCE_DIR) / "tests/studies/frame_check.mjs").string()) + " " +
        url_ + " clips/s001.mp4 30 --browser " + browser + " 2>" + shell_quoted((folder_ / "frames.txt").string()));
    ASSERT_EQ(outcome.status, 0) << read_text(folder_ / "frames.txt");
    const nlohmann::json said = nlohmann::json::parse(outcome.text, nullptr, false);
    EXPECT_EQ(said.value("frames", 0), 15) << browser << outcome.text;
    EXPECT_EQ(said.value("different", 0), 15) << browser << " shows a frame twice, or not: " << outcome.text;
    EXPECT_NEAR(said.value("duration", 0.0), 0.5, 1e-6) << browser;
  }
  if (tried == 0) GTEST_SKIP() << "neither chromium nor firefox-esr is installed";
}

TEST_F(StudyBrowserSlow, WhoWithdrawsLeavesNothing) {
  if (!has("chromium")) GTEST_SKIP() << "chromium is not installed (chromium)";
  serve();
  const nlohmann::json said = observe("--browser chromium --participant 5f00ac --no-calibration --withdraw 1");
  EXPECT_EQ(said.at("state"), "withdrawn");
  const StoreContents all = kept();
  EXPECT_TRUE(all.answers.empty());
  ASSERT_EQ(all.participants.size(), 1U);
  EXPECT_EQ(all.participants[0].state, "withdrawn");
}

TEST(StudyPage, AnswersSurviveWhatStandsBetween) {
  if (support::run_shell("command -v node >/dev/null").status != 0) GTEST_SKIP() << "node is not installed (nodejs)";
  const fs::path sources = CROWDBENCH_SOURCE_DIR;
  const support::Outcome outcome =
      support::run_shell("node " + shell_quoted((sources / "tests/studies/session_check.mjs").string()) + " " +
                         shell_quoted((sources / "studies/page").string()) + " 2>&1");
  EXPECT_EQ(outcome.status, 0) << outcome.text;
}

TEST(StudyPage, CalibratesWithinTheBoundsThatTheServerTakes) {
  const support::ScratchFolder folder;
  write_page(folder.path());
  const std::string screen = read_text(folder / "screen.js");
  EXPECT_NE(screen.find(fmt::format("const kLeastPixelsPerDegree = {}\n", kLeastPixelsPerDegree)), std::string::npos);
  EXPECT_NE(screen.find(fmt::format("const kMostPixelsPerDegree = {}\n", kMostPixelsPerDegree)), std::string::npos);
}

TEST(StudyPage, IsWholeAndAsksForNothingElsewhere) {
  const support::ScratchFolder folder;
  write_page(folder.path());
  const std::string index = read_text(folder / "index.html");
  for (const std::string file :
       {"vendor/jspsych.js", "vendor/plugin-html-button-response.js", "vendor/plugin-survey-html-form.js", "text.js",
        "adaptive.js", "session.js", "clips.js", "screen.js", "vision.js", "trial.js", "page.js"}) {
    EXPECT_NE(index.find("src=\"" + file + "\""), std::string::npos) << file;
    EXPECT_EQ(read_text(folder / file).find("sourceMappingURL"), std::string::npos) << file;
  }
  EXPECT_NE(index.find("href=\"page.css\""), std::string::npos);
  EXPECT_EQ(read_text(folder / "page.css").find("url("), std::string::npos);
  EXPECT_NE(read_text(folder / "LICENCES.txt").find("Joshua R. de Leeuw"), std::string::npos);
  EXPECT_NO_THROW(write_page(folder.path())) << "over the one before";
}

}  // namespace
}  // namespace crowdbench::studies
