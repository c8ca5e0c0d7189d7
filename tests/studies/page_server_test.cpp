// The server of a study: its rules over real sockets, what it keeps when it is killed, and the way of the answers into
// the tables that `study analyze` reads.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "core/error.h"
#include "core/hash.h"
#include "store/store.h"
#include "studies/analysis/analysis.h"
#include "studies/analysis/answers.h"
#include "studies/analysis/verdict_sentences.h"
#include "studies/server/answers_export.h"
#include "studies/server/serve.h"
#include "studies/server/study_folder.h"
#include "tests/support/driver.h"
#include "tests/support/http.h"
#include "tests/support/running_driver.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/study_page.h"

namespace crowdbench::studies {
namespace {
namespace fs = std::filesystem;
using support::http_post;
using support::http_request;
using support::HttpAnswer;

std::string participant(int number) { return sha256_hex("somebody " + std::to_string(number)); }
std::string start_body(int number) {
  return nlohmann::json{{"study", support::kStudyHash}, {"participant", participant(number)}}.dump();
}
nlohmann::json record(const std::string& trial, const std::string& answer) {
  struct Shown {
    const char* stimulus;
    const char* kind;
    int block;
  };
  static const std::map<std::string, Shown> trials = {{"t001", {"s001", "training", 0}},
                                                      {"t002", {"s002", "main", 1}},
                                                      {"t003", {"s001", "main", 1}},
                                                      {"t004", {"s002", "catch", 2}},
                                                      {"t005", {"s001", "main", 2}}};
  const Shown& shown = trials.at(trial);
  return {{"item", trial},        {"stimulus", shown.stimulus}, {"kind", shown.kind},
          {"block", shown.block}, {"answer", answer},           {"rt_ms", 812.5},
          {"replays", 1},         {"frames_dropped", 2},        {"hidden", 0},
          {"restarts", 1}};
}

class StudyServer : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
    support::write_study_folder(out_, {{"s001", nlohmann::json::object()}, {"s002", nlohmann::json::object()}});
    write_file(out_ / "page" / "index.html", std::string_view("<p>page</p>"));
    write_file(out_ / "page" / "clip.mp4", std::string_view("0123456789"));
  }
  // Starts the server, and learns its port.
  void serve(const std::string& port = "0") {
    server_.reset();
    server_ = std::make_unique<support::RunningDriver>(
        std::vector<std::string>{"study", "serve", out_.string(), "--port", port}, folder_.path(), folder_.path());
    ASSERT_TRUE(server_->wait_until_it_says("Ctrl-C ends", 20)) << server_->said();
    const std::string said = server_->said();
    port_ = std::stoi(said.substr(said.find("127.0.0.1:") + 10));
  }
  std::string start(int number) {
    const HttpAnswer answer = http_post(port_, "/api/start", start_body(number));
    EXPECT_EQ(answer.status, 200) << answer.body;
    return nlohmann::json::parse(answer.body).at("token");
  }
  int send(const std::string& token, const nlohmann::json& row) {
    return http_post(port_, "/api/answer", row.dump(), token).status;
  }
  StoreContents kept() const { return read_store(out_ / "answers.sqlite"); }

  support::ScratchFolder folder_;
  fs::path out_ = folder_ / "out";
  int port_ = 0;
  std::unique_ptr<support::RunningDriver> server_;
};

TEST_F(StudyServer, ServesThePageAndNothingElse) {
  fs::create_symlink(out_ / "sides.json", out_ / "page" / "link.json");
  serve();
  const HttpAnswer page = http_request(port_, "GET", "/");
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, "<p>page</p>");
  EXPECT_NE(page.head.find("nosniff"), std::string::npos);
  EXPECT_NE(page.head.find("Cache-Control: no-store"), std::string::npos);
  const HttpAnswer part = http_request(port_, "GET", "/clip.mp4", "Range: bytes=2-5\r\n");
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.body, "2345");
  const HttpAnswer parts = http_request(port_, "GET", "/clip.mp4", "Range: bytes=0-,0-,0-\r\n");
  EXPECT_EQ(parts.status, 416) << "a file many times over";
  EXPECT_EQ(parts.body, "");
  const HttpAnswer behind = http_request(port_, "GET", "/clip.mp4", "Range: bytes=99-\r\n");
  EXPECT_EQ(behind.status, 416) << "the library said 206, and a length of minus 89 as a whole number";
  EXPECT_NE(behind.head.find("Content-Range: bytes */10"), std::string::npos) << behind.head;
  const HttpAnswer over = http_request(port_, "GET", "/clip.mp4", "Range: bytes=7-99\r\n");
  EXPECT_EQ(over.body, "789");
  EXPECT_NE(over.head.find("Content-Range: bytes 7-9/10"), std::string::npos) << over.head;
  EXPECT_EQ(nlohmann::json::parse(http_request(port_, "GET", "/api/study").body).at("study"), support::kStudyHash);
  for (const char* path :
       {"/../sides.json", "/%2e%2e/sides.json", "/..%2fsides.json", "/clips/../../sides.json", "/link.json",
        "/answers.sqlite", "//etc/passwd", "/page/../../sides.json", "/%00", "/nothing"})
    EXPECT_NE(http_request(port_, "GET", path).status, 200) << path;
  EXPECT_EQ(http_request(port_, "DELETE", "/index.html").status, 405);
  EXPECT_EQ(http_request(port_, "POST", "/index.html", "Content-Type: application/json\r\n", "{}").status, 404);
}

TEST_F(StudyServer, TakesHeaderFieldsUpToABound) {
  serve();
  std::string fields;
  for (int i = 0; i < 200; ++i) fields += "X-" + std::to_string(i) + ": " + std::string(40, 'x') + "\r\n";
  EXPECT_EQ(http_request(port_, "GET", "/", fields).status, 200) << "more than any browser says";
  while (fields.size() < (1 << 20)) fields += "X-More: " + std::string(4000, 'x') + "\r\n";
  EXPECT_NE(http_request(port_, "GET", "/", fields).status, 200) << "they stay in memory";
  EXPECT_EQ(http_request(port_, "GET", "/").status, 200);
}

TEST_F(StudyServer, RefusesWhatIsNotOfItsPage) {
  serve();
  const std::string good = start_body(1);
  const std::string type = "Content-Type: application/json\r\n";
  for (const nlohmann::json& list : {nlohmann::json(3), nlohmann::json(true), nlohmann::json("9")}) {
    nlohmann::json asked = nlohmann::json::parse(good);
    asked["list"] = list;
    EXPECT_EQ(http_post(port_, "/api/start", asked.dump()).status, 400) << list;
  }
  const auto status = [&](const std::string& headers, const std::string& body) {
    return http_request(port_, "POST", "/api/start", headers, body).status;
  };
  // Other sites, however they come.
  EXPECT_EQ(status(type + "Origin: https://elsewhere.example\r\n", good), 403);
  EXPECT_EQ(status(type + "Origin: null\r\n", good), 403);
  EXPECT_EQ(status(type + "Sec-Fetch-Site: cross-site\r\n", good), 403);
  EXPECT_EQ(status(type + "Sec-Fetch-Site: same-site\r\n", good), 403);
  EXPECT_EQ(status("Content-Type: text/plain\r\n", good), 415);
  EXPECT_EQ(status("Content-Type: application/x-www-form-urlencoded\r\n", good), 415);
  EXPECT_EQ(status(type + "Host: rebound.example:" + std::to_string(port_) + "\r\n", good), 421);
  EXPECT_EQ(http_request(port_, "GET", "/", "Host: rebound.example\r\n").status, 421);
  // Too long, of no stated length, of a false one.
  EXPECT_EQ(status(type, std::string((64 << 10) + 1, ' ')), 413);
  EXPECT_EQ(status(type + "Content-Length: 99999999999999999999\r\n", good), 413);
  EXPECT_EQ(status(type + "Content-Length: -1\r\n", good), 413);
  EXPECT_EQ(status(type + "Transfer-Encoding: chunked\r\n", "5\r\nhello\r\n0\r\n\r\n"), 411);
  EXPECT_EQ(status(type, ""), 411) << "no length, and nothing to wait for";
  EXPECT_EQ(status(type + "Content-Length: 0\r\n", ""), 411);
  // What is no start.
  for (const char* body : {"{", "[]", "\"\"", "{}", "\xff", R"({"study": "b"})", R"({"study": 1, "participant": 2})"})
    EXPECT_EQ(status(type, body), 400) << body;
  EXPECT_EQ(status(type, nlohmann::json{{"study", support::kStudyHash}, {"participant", "me@example.org"}}.dump()),
            400);
  EXPECT_EQ(
      status(type,
             nlohmann::json{{"study", support::kStudyHash}, {"participant", participant(1)}, {"list", "9"}}.dump()),
      400);
  EXPECT_TRUE(kept().participants.empty());
  // And its own page is let in.
  EXPECT_EQ(
      status(type + "Sec-Fetch-Site: same-origin\r\nOrigin: http://127.0.0.1:" + std::to_string(port_) + "\r\n", good),
      200);
}

// Connections that begin a request and say no more hold a thread each until their time is up: of so many as one page's
// attacker opens with ease, nobody else takes notice.
TEST_F(StudyServer, AnswersBesideConnectionsThatAreLeftHalfSaid) {
  serve();
  std::vector<support::OpenConnection> half(80);
  for (support::OpenConnection& each : half) ASSERT_TRUE(each.open(port_, "GET / HT"));
  const auto from = std::chrono::steady_clock::now();
  EXPECT_EQ(http_request(port_, "GET", "/").status, 200);
  EXPECT_LT(std::chrono::steady_clock::now() - from, std::chrono::seconds(2)) << "it waited for theirs to end";
}

TEST_F(StudyServer, KeepsEachAnswerOnceAndDeletesThemOnWithdrawal) {
  serve();
  const std::string token = start(1);
  const nlohmann::json row = record("t002", "upper");
  EXPECT_EQ(send(token, row), 200);
  EXPECT_EQ(send(token, row), 200) << "an acknowledgement that got lost";
  EXPECT_EQ(send(token, record("t002", "lower")), 409);
  EXPECT_EQ(send("", row), 401);
  EXPECT_EQ(send(std::string(32, '0'), row), 401);
  const std::vector<std::pair<const char*, nlohmann::json>> wrong = {{"answer", "left"},
                                                                     {"stimulus", "s002"},
                                                                     {"kind", "catch"},
                                                                     {"item", "t009"},
                                                                     {"item", 3},
                                                                     {"rt_ms", -1},
                                                                     {"rt_ms", "fast"},
                                                                     {"hidden", -2},
                                                                     {"replays", 1.5},
                                                                     {"restarts", nullptr},
                                                                     {"frames_dropped", -1},
                                                                     {"frames_dropped", "2"},
                                                                     {"frames_total", -30},
                                                                     {"frames_total", 1},
                                                                     {"frames", 1.5},
                                                                     {"css_px_per_clip_px", 0},
                                                                     {"css_px_per_clip_px", "1"},
                                                                     {"list", "9"},
                                                                     {"study", "another"},
                                                                     {"participant", participant(2)}};
  for (const auto& [name, value] : wrong) {
    nlohmann::json changed = record("t003", "upper");
    changed[name] = value;
    EXPECT_EQ(send(token, changed), 400) << name << " " << value;
  }
  const HttpAnswer twice =
      http_post(port_, "/api/answer", R"({"answer":"lower",)" + record("t003", "upper").dump().substr(1), token);
  EXPECT_EQ(twice.status, 400);
  EXPECT_NE(twice.body.find("a member stands there twice"), std::string::npos) << twice.body;
  const std::string deep = R"({"item":)" + std::string(30000, '[') + std::string(30000, ']') + "}";
  EXPECT_EQ(http_post(port_, "/api/answer", deep, token).status, 400);
  for (const auto& [pixels, spread] : std::vector<std::pair<nlohmann::json, nlohmann::json>>{
           {1e300, 1}, {4.9, 1}, {501, 1}, {-40, 1}, {40, -1}, {40, 41}, {40, nullptr}, {nullptr, 3}, {"40", 3}})
    EXPECT_EQ(send(token, {{"item", "calibration"},
                           {"kind", "page"},
                           {"pixels_per_degree", pixels},
                           {"pixels_per_degree_se", spread}}),
              400)
        << pixels << " " << spread;
  for (const char* page : {"diary", "screen-", "screen-0", "screen-05", "screen-31", "screen-100", "screen-x"})
    EXPECT_EQ(send(token, {{"item", page}, {"kind", "page"}}), 400) << page;
  EXPECT_EQ(
      send(token,
           {{"item", "calibration"}, {"kind", "page"}, {"pixels_per_degree", 36.5}, {"pixels_per_degree_se", 3.25}}),
      200);
  {
    const StoreContents all = kept();
    ASSERT_EQ(all.answers.size(), 2U);
    EXPECT_EQ(all.answers[0].answer, "upper");
    EXPECT_EQ(all.answers[0].rt, 812.5);
    EXPECT_EQ(all.answers[0].block, 1U);
    EXPECT_EQ(all.answers[0].restarts, 1U);
    EXPECT_EQ(all.answers[0].data, row.dump());
    ASSERT_EQ(all.participants.size(), 1U);
    EXPECT_EQ(all.participants[0].pixels_per_degree, 36.5);
    EXPECT_EQ(all.participants[0].pixels_per_degree_se, 3.25);
  }
  // Another window takes over, and goes on where the first stopped.
  const nlohmann::json again = nlohmann::json::parse(http_post(port_, "/api/start", start_body(1)).body);
  EXPECT_EQ(again.at("items"), (nlohmann::json{"t002", "calibration"}));
  EXPECT_EQ(again.at("resumed"), true);
  EXPECT_EQ(send(token, record("t003", "lower")), 401);
  const std::string second = again.at("token");
  EXPECT_EQ(send(second, record("t003", "lower")), 200);
  const HttpAnswer early = http_post(port_, "/api/finish", "{}", second);
  EXPECT_EQ(early.status, 409);
  EXPECT_NE(early.body.find("3 of 5 trials are not answered"), std::string::npos) << early.body;
  EXPECT_EQ(kept().participants.at(0).state, "started");
  nlohmann::json unknown = record("t001", "upper");
  unknown["frames_dropped"] = unknown["frames_total"] = nullptr;
  EXPECT_EQ(send(second, unknown), 200) << "a browser that does not count";
  for (const char* trial : {"t004", "t005"}) EXPECT_EQ(send(second, record(trial, "lower")), 200);
  EXPECT_EQ(http_post(port_, "/api/finish", "{}", second).status, 200);
  EXPECT_EQ(http_post(port_, "/api/finish", "{}", second).status, 200) << "an acknowledgement that got lost";
  EXPECT_EQ(send(second, record("t003", "lower")), 200);
  EXPECT_EQ(send(second, {{"item", "comments"}, {"kind", "page"}}), 409) << "finished";
  EXPECT_EQ(kept().participants.at(0).state, "finished");
  // Withdrawal.
  EXPECT_EQ(http_post(port_, "/api/withdraw", "{}", second).status, 200);
  EXPECT_EQ(send(second, record("t005", "lower")), 401);
  const StoreContents all = kept();
  EXPECT_TRUE(all.answers.empty());
  ASSERT_EQ(all.participants.size(), 1U);
  EXPECT_EQ(all.participants[0].state, "withdrawn");
  EXPECT_EQ(all.participants[0].participant, "");
  EXPECT_EQ(all.participants[0].pixels_per_degree, std::nullopt);
  for (const char* end : {"", "-wal"}) {
    const fs::path file = (out_ / "answers.sqlite").string() + end;
    const auto bytes = read_file(file);
    const std::string text(bytes.begin(), bytes.end());
    EXPECT_EQ(text.find(participant(1)), std::string::npos) << file;
    EXPECT_EQ(text.find("rt_ms\":812.5"), std::string::npos) << file;
  }
}

TEST_F(StudyServer, RemembersWhatWasBegunThroughAKillAndForAnotherBrowser) {
  serve();
  const std::string token = start(1);
  const auto begin = [&](const char* trial, const nlohmann::json& count) {
    return send(token, {{"item", trial}, {"kind", "begin"}, {"begun", count}});
  };
  EXPECT_EQ(begin("t001", 1), 200);
  EXPECT_EQ(begin("t002", 2), 200);
  EXPECT_EQ(begin("t002", 1), 200) << "sent late, or twice";
  for (const char* trial : {"t009", "consent", "", "t001\", 1); --"}) EXPECT_EQ(begin(trial, 1), 400) << trial;
  for (const nlohmann::json& count : {nlohmann::json(0), nlohmann::json(-1), nlohmann::json(1.5), nlohmann::json("2"),
                                      nlohmann::json(), nlohmann::json(5e9)})
    EXPECT_EQ(begin("t003", count), 400) << count;
  server_->send(SIGKILL);
  server_->wait_for_end(5);
  serve();
  const nlohmann::json again = nlohmann::json::parse(http_post(port_, "/api/start", start_body(1)).body);
  EXPECT_EQ(again.at("begun"), (nlohmann::json{{"t001", 1}, {"t002", 2}}));
  EXPECT_EQ(again.at("items"), nlohmann::json::array()) << "nothing was answered";
  EXPECT_TRUE(kept().answers.empty());
  EXPECT_EQ(send(again.at("token"), record("t002", "upper")), 200);
  const nlohmann::json other = nlohmann::json::parse(http_post(port_, "/api/start", start_body(2)).body);
  EXPECT_EQ(other.at("begun"), nlohmann::json::object());
}

TEST_F(StudyServer, TakesWhatThePageChoseAndTellsItAfterAReload) {
  support::let_the_page_choose(out_);
  serve();
  const std::string token = start(1);
  nlohmann::json row = record("t002", "upper");
  row["stimulus"] = "s009";
  EXPECT_EQ(send(token, row), 400) << "none of what may be chosen";
  row["stimulus"] = nullptr;
  EXPECT_EQ(send(token, row), 400);
  row["stimulus"] = "s001";  // whatever else the list of another method would have
  EXPECT_EQ(send(token, row), 200);
  row = record("t004", "lower");
  row["stimulus"] = "s001";
  EXPECT_EQ(send(token, row), 400) << "catch trials are of the list";
  EXPECT_EQ(send(token, record("t004", "lower")), 200);
  const nlohmann::json again = nlohmann::json::parse(http_post(port_, "/api/start", start_body(1)).body);
  EXPECT_EQ(again.at("given"), (nlohmann::json{{"t002", {{"stimulus", "s001"}, {"answer", "upper"}}},
                                               {"t004", {{"stimulus", "s002"}, {"answer", "lower"}}}}));
}

TEST_F(StudyServer, GivesEveryListToAsManyUnderConcurrentStarts) {
  serve();
  constexpr int kClients = 24;
  std::vector<std::thread> clients;
  std::vector<std::string> lists(2 * kClients);
  for (int i = 0; i < 2 * kClients; ++i)  // each participant starts twice at once
    clients.emplace_back([&, i] {
      const HttpAnswer answer = http_post(port_, "/api/start", start_body(i / 2));
      if (answer.status == 200) lists[static_cast<size_t>(i)] = nlohmann::json::parse(answer.body).at("list");
    });
  for (std::thread& each : clients) each.join();
  std::map<std::string, int> started;
  for (size_t i = 0; i < lists.size(); i += 2) {
    EXPECT_EQ(lists[i], lists[i + 1]);
    ++started[lists[i]];
  }
  EXPECT_EQ(started, (std::map<std::string, int>{{"1", 8}, {"2", 8}, {"3", 8}}));
  EXPECT_EQ(kept().participants.size(), static_cast<size_t>(kClients));
  // By hand where the address says so.
  const nlohmann::json body = {{"study", support::kStudyHash}, {"participant", participant(99)}, {"list", "3"}};
  EXPECT_EQ(nlohmann::json::parse(http_post(port_, "/api/start", body.dump()).body).at("list"), "3");
}

// SIGKILL at random moments under clients that do nothing but answer: what was acknowledged is there.
TEST_F(StudyServer, LosesNothingAcknowledgedWhenItIsKilled) {
  constexpr int kKills = 10;
  constexpr int kClients = 4;
  const char* const trials[] = {"t001", "t002", "t003", "t004", "t005"};
  std::atomic<int> acknowledged{0};
  std::set<std::string> expected[kClients];
  for (int kill = 0; kill < kKills; ++kill) {
    serve();
    if (HasFatalFailure()) return;
    std::atomic<bool> down{false};
    std::vector<std::thread> clients;
    for (int c = 0; c < kClients; ++c)
      clients.emplace_back([&, c] {
        for (int number = 0; !down; ++number) {
          const int who = 1000 * kill + 100 * c + number % 100;
          const HttpAnswer started = http_post(port_, "/api/start", start_body(who));
          if (started.status != 200) continue;
          const std::string token = nlohmann::json::parse(started.body).at("token");
          for (const char* trial : trials) {
            if (send(token, record(trial, "lower")) != 200) continue;
            expected[c].insert(participant(who) + trial);
            ++acknowledged;
          }
        }
      });
    // After some answers, however fast the machine is.
    const int enough = acknowledged + 1 + (kill * 7) % 13;
    for (int waits = 0; acknowledged < enough && waits < 20000; ++waits)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    server_->send(SIGKILL);
    server_->wait_for_end(5);
    down = true;
    for (std::thread& each : clients) each.join();
  }
  const StoreContents all = kept();
  std::map<int64_t, std::string> who;
  for (const StudyParticipantRow& row : all.participants) who[row.id] = row.participant;
  std::set<std::string> there;
  for (const StudyAnswerRow& row : all.answers) EXPECT_TRUE(there.insert(who.at(row.participant) + row.item).second);
  EXPECT_GT(acknowledged, kKills);
  for (const auto& each : expected) EXPECT_TRUE(std::includes(there.begin(), there.end(), each.begin(), each.end()));
}

TEST_F(StudyServer, EndsAtASignalAndRefusesATakenPort) {
  serve();
  const support::Outcome second =
      support::run_driver("", "study serve '" + out_.string() + "' --port " + std::to_string(port_));
  EXPECT_EQ(second.status, 2);
  EXPECT_NE(second.text.find("cannot be listened on (Address already in use); choose another --port"),
            std::string::npos)
      << second.text;
  server_->send(SIGTERM);
  EXPECT_LT(server_->wait_for_end(10), 3.0);
  EXPECT_EQ(server_->status(), 143);
  EXPECT_NE(server_->said().find("interrupted; every answer that was acknowledged is in"), std::string::npos);
  // What cannot be served is said before anything listens.
  const auto says = [](const ServeSettings& settings) -> std::string {
    try {
      serve_study(settings, [](const std::string&) {});
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  const fs::path answers = folder_ / "other.sqlite";
  EXPECT_NE(says({out_, answers, "0.0.0.0", 0, std::nullopt}).find("is reached from other machines"),
            std::string::npos);
  EXPECT_NE(says({out_, answers, "127.0.0.1", 0, "study.example.org"}).find("is not an origin"), std::string::npos);
  EXPECT_NE(says({folder_.path(), answers, "127.0.0.1", 0, std::nullopt}).find("has no page/trials.json"),
            std::string::npos);
  EXPECT_NE(says({out_, answers, "192.0.2.1", 0, "https://study.example.org"}).find("cannot be listened on"),
            std::string::npos);
}

TEST_F(StudyServer, AnswersBecomeTablesThatAnalyzeReads) {
  serve();
  const std::string token = start(1);
  for (const char* trial : {"t001", "t002", "t003", "t004"}) EXPECT_EQ(send(token, record(trial, "upper")), 200);
  EXPECT_EQ(send(token, record("t005", "cannot-tell")), 200);
  server_.reset();
  const StudyAnswers answers = read_study_answers({out_ / "answers.sqlite"}, support::kStudyHash);
  Answers table;
  const Table parsed = parse_table(answers_csv(answers, out_), "answers.csv");
  add_answers(table, parsed, columns_by_name(parsed));
  ASSERT_EQ(table.rows.size(), 4U) << "training is left out";
  EXPECT_EQ(parsed.columns.back(), "state");
  EXPECT_EQ(parsed.rows[0].fields.back(), "started");
  const auto upper = std::find(parsed.columns.begin(), parsed.columns.end(), "upper") - parsed.columns.begin();
  EXPECT_EQ(parsed.rows[0].fields.at(static_cast<size_t>(upper)), "flat, near");
  EXPECT_EQ(table.rows[0].yes_first, false) << "the lower one was expected";
  EXPECT_EQ(table.conditions, (std::vector<std::string>{"switch_m=20", "switch_m=10"}));
  EXPECT_EQ(table.rows[0].level, 20.0);
  EXPECT_EQ(table.rows[0].rt_ms, 812.5);
  EXPECT_EQ(table.rows[0].no, 1U) << "upper, and the lower one was expected";
  EXPECT_EQ(table.rows[1].yes, 1U);
  EXPECT_EQ(table.rows[2].catch_kind, "broken");
  EXPECT_EQ(table.rows[3].ties, 1U);
  // A calibration is in CSS pixels, a level in the clip's: how large these were shown stands beside it.
  StudyAnswers sized = answers;
  sized.participants.at(0).pixels_per_degree = 40;
  sized.participants.at(0).pixels_per_degree_se = 4;
  for (StudyAnswerRow& row : sized.answers) {
    nlohmann::json data = nlohmann::json::parse(row.data);
    data["css_px_per_clip_px"] = 0.5;
    row.data = data.dump();
  }
  Answers seen;
  const Table sizes = parse_table(answers_csv(sized, out_), "sizes.csv");
  add_answers(seen, sizes, columns_by_name(sizes));
  EXPECT_EQ(seen.rows.at(0).css_px_per_clip_px, 0.5);
  EXPECT_EQ(seen.rows[0].pixels_per_degree, 40.0);
  EXPECT_EQ(seen.rows[0].pixels_per_degree_se, 4.0);
  // What the level says is not said by the condition again.
  nlohmann::json sides = nlohmann::json::parse(read_text(out_ / "sides.json"));
  for (nlohmann::json& each : sides["stimuli"]) each["series"] = "crowd.agents=9";
  write_file(out_ / "sides.json", std::string_view(sides.dump()));
  EXPECT_EQ(parse_table(answers_csv(answers, out_), "series.csv").rows[0].fields[3], "crowd.agents=9");
  // A level that is infinite is no axis: `level` is left out, or the trial.
  sides["stimuli"]["s001"]["level"] = nullptr;
  write_file(out_ / "sides.json", std::string_view(sides.dump()));
  EXPECT_EQ(answers_csv(answers, out_).find(",level,"), std::string::npos);
  EXPECT_EQ(parse_table(answers_csv(answers, out_), "conditions.csv").rows[0].fields[3], "switch_m=20");
  const Table levels = parse_table(answers_csv(answers, out_, true), "levels.csv");
  EXPECT_EQ(levels.columns[5], "level");
  EXPECT_EQ(levels.rows.size(), 2U);
  // Of another study, or of a format to come.
  for (const auto& [key, value] : {std::pair<const char*, nlohmann::json>{"study", "0f0f"}, {"format", 2}}) {
    nlohmann::json other = sides;
    other[key] = value;
    write_file(out_ / "sides.json", std::string_view(other.dump()));
    try {
      answers_csv(answers, out_);
      ADD_FAILURE() << key;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(std::string("is of another ") + key), std::string::npos) << error.what();
    }
  }
  // Two that are ranked: one pair, whichever stands above.
  for (nlohmann::json& each : sides["stimuli"]) each["kind"] = "pair";
  write_file(out_ / "sides.json", std::string_view(sides.dump()));
  Answers ranked;
  const Table pairs = parse_table(answers_csv(answers, out_), "pairs.csv");
  add_answers(ranked, pairs, columns_by_name(pairs));
  EXPECT_EQ(ranked.items, (std::vector<std::string>{"flat, near", "mesh"}));
  EXPECT_EQ(ranked.rows[0].shown_first_is_a, true);
  EXPECT_EQ(ranked.rows[0].yes, 1U) << "the flat one stood above and was chosen";
  EXPECT_EQ(ranked.rows[1].shown_first_is_a, false);
  EXPECT_EQ(ranked.rows[1].no, 1U);
  EXPECT_TRUE(ranked.conditions.empty()) << "the items are all that varies, whatever condition the first is of";
  const Analysis compared = analyse(ranked, {.resamples = 0});
  EXPECT_EQ(compared.tasks.at(0).conditions.at(0).name, "flat, near over mesh");
  EXPECT_EQ(verdict_sentences(compared.tasks[0], compared.settings).at(0).find("switch_m"), std::string::npos);
  const nlohmann::json records = nlohmann::json::parse(jspsych_json(answers));
  ASSERT_EQ(records.size(), 5U);
  EXPECT_EQ(records[1].at("participant"), participant(1));
  EXPECT_EQ(records[1].at("answer"), "upper");
  // What the page saves where no server of ours is comes to the same table.
  write_file(folder_ / "saved.json", std::string_view(records.dump()));
  StudyAnswers saved = read_study_answers({folder_ / "saved.json"}, support::kStudyHash);
  saved.participants[0].state = answers.participants[0].state;  // the page saves at the end
  EXPECT_EQ(answers_csv(saved, out_), answers_csv(answers, out_));
  EXPECT_THROW(read_study_answers({folder_ / "saved.json", folder_ / "saved.json"}, support::kStudyHash), Error);
  EXPECT_THROW(read_study_answers({folder_ / "saved.json"}, std::string(64, 'b')), Error);
}

// Answers of one participant in a row of trials: what the page saves, with `more` members each.
std::string saved_answers(const std::vector<nlohmann::json>& more) {
  nlohmann::json all = nlohmann::json::array();
  for (const nlohmann::json& each : more) {
    nlohmann::json row = record("t003", "lower");
    row["item"] = "t" + std::to_string(100 + all.size());
    row["study"] = support::kStudyHash;
    row["participant"] = participant(1);
    row["list"] = "1";
    row.update(each);
    all.push_back(row);
  }
  return all.dump();
}

TEST(StudyAnswerTables, TrialsWithTooManyDroppedFramesAreLeftOutByThePlan) {
  if (!support::driver_is_built()) GTEST_SKIP() << "the driver is not built";
  const support::ScratchFolder folder;
  support::write_study_folder(folder / "out", {{"s001", nlohmann::json::object()}, {"s002", nlohmann::json::object()}});
  write_file(folder / "out/page/index.html", std::string_view(" "));
  // Of 150 frames 123 may be missing, whatever 0.82 * 150 is in binary; those of two showings are halved.
  write_file(folder / "study.toml",
             std::string_view("[conditions]\ntest = \"flat\"\n[stimulus]\nseconds = 5\nfps = 30\n[exclude]\n"
                              "most_dropped = 0.82\n"));
  write_file(
      folder / "saved.json",
      std::string_view(saved_answers({{{"frames", 150}, {"frames_total", 150}, {"frames_dropped", 123}},
                                      {{"frames", 150}, {"frames_total", 300}, {"frames_dropped", 246}},
                                      {{"frames", 150}, {"frames_total", 300}, {"frames_dropped", 248}},
                                      {{"frames", 150}, {"frames_total", nullptr}, {"frames_dropped", nullptr}}})));
  const support::Outcome table = support::run_driver("cd '" + folder.path().string() + "' && ",
                                                     "study answers saved.json --study out --csv t.csv");
  ASSERT_EQ(table.status, 0) << table.text;
  const support::Outcome analysed =
      support::run_driver("cd '" + folder.path().string() + "' && ",
                          "study analyze t.csv --plan study.toml --random none --resamples 0 --json");
  const nlohmann::json said = nlohmann::json::parse(analysed.text, nullptr, false);
  ASSERT_TRUE(said.is_object()) << analysed.text;
  EXPECT_EQ(said.at("left_out").at("dropped"), 1) << analysed.text;
  EXPECT_EQ(said.at("rows"), 3);
}

TEST(StudyAnswerTables, OfSameOrDifferentHitsAndFalseAlarmsAreTold) {
  const support::ScratchFolder folder;
  support::write_study_folder(folder.path(), nlohmann::json::object());
  nlohmann::json sides = nlohmann::json::parse(read_text(folder / "sides.json"));
  nlohmann::json& stimuli = sides["stimuli"];
  stimuli["s001"]["expected"] = "different";
  stimuli["s002"] = stimuli["s001"];
  stimuli["s002"]["kind"] = "alike";
  stimuli["s002"]["expected"] = "same";
  write_file(folder / "sides.json", std::string_view(sides.dump()));
  std::vector<nlohmann::json> given;
  for (int i = 0; i < 40; ++i)  // 15 of 20 hits, 5 of 20 false alarms
    given.push_back(
        {{"stimulus", i < 20 ? "s001" : "s002"}, {"answer", i % 20 < (i < 20 ? 15 : 5) ? "different" : "same"}});
  write_file(folder / "saved.json", std::string_view(saved_answers(given)));
  const Table table = parse_table(
      answers_csv(read_study_answers({folder / "saved.json"}, support::kStudyHash), folder.path()), "t.csv");
  Answers answers;
  add_answers(answers, table, columns_by_name(table));
  const Analysis a = analyse(std::move(answers), {.random = RandomEffects::none, .resamples = 0});
  const ConditionResult& c = a.tasks.at(0).conditions.at(0);
  ASSERT_TRUE(c.detection.has_value());
  EXPECT_EQ(c.yes, 20U) << "said different";
  EXPECT_NEAR(c.detection->d_prime, 2 * 0.6744898, 1e-6) << "z(3/4) - z(1/4)";
  EXPECT_FALSE(c.is_tested()) << "against no chance level";
  ASSERT_EQ(a.tasks[0].curves.size(), 1U);
}

TEST(StudyServerNames, AreThoseThatBrowsersSay) {
  const auto names = [](const char* address, int port, std::optional<std::string> origin) {
    return served_names({"out", "answers.sqlite", address, port, std::move(origin)}, port);
  };
  const ServedNames own = names("127.0.0.1", 80, std::nullopt);
  for (const char* host : {"127.0.0.1", "127.0.0.1:80", "localhost", "[::1]"})
    EXPECT_TRUE(own.hosts.contains(host)) << host;
  EXPECT_TRUE(own.origins.contains("http://localhost"));
  EXPECT_FALSE(names("127.0.0.1", 8000, std::nullopt).hosts.contains("localhost"));
  const ServedNames far = names("127.0.0.1", 8000, "https://Study.Example.org:443");
  EXPECT_TRUE(far.hosts.contains("study.example.org"));
  EXPECT_TRUE(far.hosts.contains("study.example.org:443"));
  EXPECT_TRUE(far.origins.contains("https://study.example.org"));
  EXPECT_FALSE(names("127.0.0.1", 8000, "https://study.example.org:80").origins.contains("https://study.example.org"))
      << "80 is not the port of https";
}

TEST(StudyFolder, SaysWhereATrialsFileIsWrong) {
  const support::ScratchFolder folder;
  support::write_study_folder(folder.path(), {{"s001", nlohmann::json::object()}, {"s002", nlohmann::json::object()}});
  write_file(folder / "page/index.html", std::string_view(" "));
  const nlohmann::json good = nlohmann::json::parse(read_text(folder / "page/trials.json"));
  EXPECT_EQ(read_study_folder(folder.path()).trials.at("2").at("t004").kind, "catch");
  const std::vector<std::pair<std::string, nlohmann::json>> wrong = {{"/format", 2},
                                                                     {"/study", "a b"},
                                                                     {"/answers", nlohmann::json::array()},
                                                                     {"/lists", nlohmann::json::array()},
                                                                     {"/lists/1/id", "1"},
                                                                     {"/lists/0/trials/2/stimulus", "s009"},
                                                                     {"/lists/0/trials/2/kind", "odd"},
                                                                     {"/lists/0/trials/2/block", -1},
                                                                     {"/stimuli", 3},
                                                                     {"/lists/0/trials/1/trial", "t001"}};
  for (const auto& [where, value] : wrong) {
    nlohmann::json changed = good;
    changed[nlohmann::json::json_pointer(where)] = value;
    write_file(folder / "page/trials.json", std::string_view(changed.dump()));
    EXPECT_THROW(read_study_folder(folder.path()), Error) << where;
  }
}

TEST(StudyFolder, SaysWhatAnAdaptiveOneLacks) {
  const support::ScratchFolder folder;
  support::write_study_folder(folder.path(), {{"s001", nlohmann::json::object()}, {"s002", nlohmann::json::object()}});
  write_file(folder / "page/index.html", std::string_view(" "));
  support::let_the_page_choose(folder.path());
  const nlohmann::json good = nlohmann::json::parse(read_text(folder / "page/trials.json"));
  const StudyFolder read = read_study_folder(folder.path());
  EXPECT_EQ(read.choices, (std::set<std::string>{"s001", "s002"}));
  EXPECT_EQ(read.trials.at("1").at("t002").stimulus, "");
  EXPECT_EQ(read.trials.at("1").at("t004").stimulus, "s002");
  const std::vector<std::pair<std::string, nlohmann::json>> wrong = {{"/adaptive", 3},
                                                                     {"/adaptive/choices", nlohmann::json::array()},
                                                                     {"/adaptive/choices/0/stimuli/0", "s009"},
                                                                     {"/adaptive/choices/0/stimuli/0", 1},
                                                                     {"/adaptive/yes", {{"s001", "upper"}}},
                                                                     {"/lists/0/trials/3/stimulus", nullptr}};
  for (const auto& [where, value] : wrong) {
    nlohmann::json changed = good;
    changed[nlohmann::json::json_pointer(where)] = value;
    write_file(folder / "page/trials.json", std::string_view(changed.dump()));
    EXPECT_THROW(read_study_folder(folder.path()), Error) << where << " " << value;
  }
  nlohmann::json constant = good;
  constant.erase("adaptive");
  write_file(folder / "page/trials.json", std::string_view(constant.dump()));
  EXPECT_THROW(read_study_folder(folder.path()), Error) << "trials of no stimulus, and nothing to choose by";
}

}  // namespace
}  // namespace crowdbench::studies
