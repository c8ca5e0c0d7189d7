#include "studies/server/study_service.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>

#include "core/error.h"
#include "core/hash.h"
#include "core/json.h"
#include "core/screen_calibration.h"

namespace crowdbench::studies {
namespace {
using nlohmann::json;

HttpReply reply(const Json& body, int status = 200) { return {.status = status, .body = body.dump() + "\n"}; }
HttpReply error(int status, const std::string& what) { return reply(Json{{"error", what}}, status); }

// 128 bits from the kernel, as hexadecimal digits.
std::string new_token() {
  std::array<uint8_t, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw Error("getrandom", "gives no random bytes");
  std::string text;
  for (const uint8_t each : bytes) text += fmt::format("{:02x}", each);
  return text;
}

bool is_hash(const std::string& text) {
  return text.size() == 64 &&
         std::all_of(text.begin(), text.end(), [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

// Whoever has the link may write: what a participant can fill is bounded, 7 pages x 31 records x 64 KiB.
constexpr int kMostOfAPage = 30;

// Pages that send a record, with a number where one is shown more than once ("screen-2").
bool is_page(const std::string& item) {
  static const std::set<std::string> pages = {"consent", "demographics", "calibration", "vision",
                                              "browser", "screen",       "comments"};
  const size_t dash = item.find('-');
  if (!pages.contains(item.substr(0, dash))) return false;
  if (dash == std::string::npos) return true;
  const std::string number = item.substr(dash + 1);
  return !number.empty() && number.size() <= 2 && number[0] != '0' &&
         number.find_first_not_of("0123456789") == std::string::npos && std::stoi(number) <= kMostOfAPage;
}

// A member that is a text, or nothing.
std::optional<std::string> text_of(const json& of, const char* name) {
  const auto found = of.find(name);
  return found != of.end() && found->is_string() ? std::optional(found->get<std::string>()) : std::nullopt;
}
std::optional<double> number_of(const json& of, const char* name) {
  const auto found = of.find(name);
  return found != of.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
}
std::optional<uint32_t> count_of(const json& of, const char* name) {
  const auto found = of.find(name);
  if (found == of.end() || !found->is_number_unsigned() || found->get<uint64_t>() > UINT32_MAX) return std::nullopt;
  return found->get<uint32_t>();
}

// A body that is an object, in which nothing is said twice: of two members of one name readers take different ones.
// What cannot be taken says why in `wrong`.
json object_of(std::string_view body, std::string& wrong) {
  std::vector<std::set<std::string>> open;
  bool twice = false;
  const json out = json::parse(
      body,
      [&](int, json::parse_event_t event, json& parsed) {
        if (event == json::parse_event_t::object_start) open.emplace_back();
        if (event == json::parse_event_t::object_end) open.pop_back();
        if (event == json::parse_event_t::key) twice = !open.back().insert(parsed.get<std::string>()).second || twice;
        return true;
      },
      false);
  if (!out.is_object()) wrong = "not a JSON object";
  if (twice) wrong = "a member stands there twice";
  return out;
}

// Members that a record may leave out, or leave empty, and what they are else.
std::string fault_of_optional(const json& record) {
  for (const char* name : {"frames_dropped", "frames_total", "frames"}) {
    const auto found = record.find(name);
    if (found != record.end() && !found->is_null() && !count_of(record, name))
      return fmt::format("{} is not a count", name);
  }
  const auto dropped = count_of(record, "frames_dropped");
  const auto total = count_of(record, "frames_total");
  if (dropped && total && *dropped > *total) return "more frames are dropped than there were";
  const auto size = record.find("css_px_per_clip_px");
  if (size == record.end() || size->is_null()) return {};
  const auto number = number_of(record, "css_px_per_clip_px");
  return number && *number > 0 && *number <= 1000 ? "" : "css_px_per_clip_px is not a size";
}

// What a record says of whose it is must be what the server knows.
std::string fault_of_owner(const StudyFolder& folder, const StudyParticipantRow& who, const json& record) {
  const std::array<std::pair<const char*, const std::string*>, 3> owners = {
      {{"study", &folder.study}, {"participant", &who.participant}, {"list", &who.list}}};
  for (const auto& [name, known] : owners)
    if (const auto found = record.find(name); found != record.end() && *found != json(*known))
      return fmt::format("of another {}", name);
  return {};
}

bool is_calibration(const std::string& page) { return page.starts_with("calibration"); }

// What a calibration found, or that it found nothing; empty where that can be.
std::string fault_of_calibration(const json& record) {
  const auto pixels = record.find("pixels_per_degree");
  const auto spread = record.find("pixels_per_degree_se");
  const auto none = [&](const auto& found) { return found == record.end() || found->is_null(); };
  if (none(pixels) && none(spread)) return {};
  const auto p = number_of(record, "pixels_per_degree");
  const auto se = number_of(record, "pixels_per_degree_se");
  if (p && se && is_screen_calibration(*p, *se)) return {};
  return fmt::format("no calibration: {} to {} pixels a degree, with a standard error", kLeastPixelsPerDegree,
                     kMostPixelsPerDegree);
}

// What a record of a trial says; empty where all is right.
std::string fill_trial(const StudyFolder& folder, const std::string& list, const json& record, StudyAnswerRow& row) {
  const auto& trials = folder.trials.at(list);
  const auto found = trials.find(row.item);
  if (found == trials.end()) return "there is no such trial in this list";
  const StudyTrial& trial = found->second;
  row.stimulus = text_of(record, "stimulus");
  row.answer = text_of(record, "answer");
  row.rt = number_of(record, "rt_ms");
  row.block = trial.block;
  row.replays = count_of(record, "replays");
  row.frames_dropped = count_of(record, "frames_dropped");
  row.hidden = count_of(record, "hidden");
  row.restarts = count_of(record, "restarts");
  const bool shown =
      trial.stimulus.empty() ? row.stimulus && folder.choices.contains(*row.stimulus) : row.stimulus == trial.stimulus;
  if (row.kind != trial.kind || !shown) return "the trial is another one";
  if (!row.answer || std::find(folder.answers.begin(), folder.answers.end(), *row.answer) == folder.answers.end())
    return "there is no such answer";
  if (!row.rt || !(*row.rt >= 0 && *row.rt <= 1e9)) return "rt_ms is not a time";
  if (!row.replays || !row.hidden || !row.restarts) return "a count is missing";
  return fault_of_optional(record);
}

}  // namespace

StudyService::StudyService(const StudyFolder& folder, AnswerStore& store, std::set<std::string> hosts,
                           std::set<std::string> origins, std::function<std::string()> now)
    : folder_(folder), store_(store), hosts_(std::move(hosts)), origins_(std::move(origins)), now_(std::move(now)) {}

std::optional<HttpReply> StudyService::refuse(const HttpRequest& r) const {
  // A page of another name that resolves to this machine is another site's (DNS rebinding).
  if (!hosts_.contains(std::string(r.host))) return error(421, "this server has another name");
  if (r.method == "GET" || r.method == "HEAD") return std::nullopt;
  if (r.method != "POST") return error(405, "only GET, HEAD and POST are answered");
  if (!r.origin.empty() && !origins_.contains(std::string(r.origin))) return error(403, "from another site");
  if (!r.fetch_site.empty() && r.fetch_site != "same-origin") return error(403, "from another site");
  // A type that forms of other sites cannot send without asking first, which is never granted.
  if (r.content_type.substr(0, r.content_type.find(';')) != "application/json")
    return error(415, "only application/json is taken");
  // What has no length would be waited for; nothing that is taken is empty.
  if (!r.transfer_encoding.empty() || r.announced == 0) return error(411, "the length must be said beforehand");
  if (r.announced > kMostRecordBytes) return error(413, "too long");
  return std::nullopt;
}

HttpReply StudyService::handle(const HttpRequest& r) {
  if (r.method != "POST") {
    if (r.path == "/api/study") return reply({{"crowdbench", 1}, {"study", folder_.study}});
    return file(r);
  }
  if (r.path == "/api/start") return start(r);
  if (r.path != "/api/answer" && r.path != "/api/finish" && r.path != "/api/withdraw")
    return error(404, "there is nothing here");
  const auto who =
      r.token.empty() ? std::nullopt : store_.by_token(folder_.study, sha256_hex(std::string_view(r.token)));
  if (!who) return error(401, "this window may not answer: continued in another one, or withdrawn");
  if (r.path == "/api/answer") return answer(r, *who);
  if (r.path == "/api/withdraw") return withdraw(*who);
  return finish(*who);
}

HttpReply StudyService::file(const HttpRequest& r) const {
  const auto found = folder_.files.find(r.path == "/" ? "/index.html" : std::string(r.path));
  if (found == folder_.files.end()) return error(404, "there is nothing here");
  const StudyFile& file = found->second;
  std::error_code failed;
  const auto bytes = std::filesystem::file_size(file.path, failed);
  if (failed) return error(404, "there is nothing here");
  return {.content_type = file.type, .file = file.path, .file_bytes = bytes, .keep = file.type.starts_with("video/")};
}

HttpReply StudyService::start(const HttpRequest& r) {
  std::string wrong;
  const json body = object_of(r.body, wrong);
  if (!wrong.empty()) return error(400, wrong);
  if (text_of(body, "study") != folder_.study) return error(400, "the page is of another study; reload it");
  const auto participant = text_of(body, "participant");
  if (!participant || !is_hash(*participant)) return error(400, "participant is not a SHA-256");
  const auto wanted = text_of(body, "list");
  if (const auto list = body.find("list"); !wanted && list != body.end() && !list->is_null())
    return error(400, "list is not a text");
  if (wanted && !folder_.trials.contains(*wanted)) return error(400, "there is no such list");
  const std::string token = new_token();
  const AnswerStore::Start started =
      store_.start(folder_.study, *participant, sha256_hex(token), folder_.lists, wanted, now_());
  const Json begun = started.row.begun ? Json::parse(*started.row.begun) : Json::object();
  Json items = Json::array();
  Json given = Json::object();
  for (const StudyAnswerRow& row : store_.answers(started.row.id)) {
    items.push_back(row.item);
    if (row.stimulus && row.answer) given[row.item] = {{"stimulus", *row.stimulus}, {"answer", *row.answer}};
  }
  return reply({{"token", token},
                {"list", started.row.list},
                {"state", started.row.state},
                {"resumed", started.resumed},
                {"items", items},
                {"given", given},
                {"begun", begun}});
}

HttpReply StudyService::answer(const HttpRequest& r, const StudyParticipantRow& who) {
  std::string wrong;
  const json record = object_of(r.body, wrong);
  if (wrong.empty()) wrong = fault_of_owner(folder_, who, record);
  if (!wrong.empty()) return error(400, wrong);
  StudyAnswerRow row;
  row.participant = who.id;
  row.item = text_of(record, "item").value_or("");
  row.kind = text_of(record, "kind").value_or("");
  if (row.kind == "begin") {
    const auto count = count_of(record, "begun");
    if (!folder_.trials.at(who.list).contains(row.item)) return error(400, "there is no such trial in this list");
    if (count.value_or(0) == 0) return error(400, "a count is missing");
    store_.begin(who.id, row.item, *count);
    return reply({{"kept", true}});
  }
  row.received = now_();
  row.data = r.body;
  if (row.kind == "page") {
    if (!is_page(row.item)) return error(400, "there is no such page");
    if (is_calibration(row.item)) wrong = fault_of_calibration(record);
  } else {
    wrong = fill_trial(folder_, who.list, record, row);
  }
  if (!wrong.empty()) return error(400, wrong);
  switch (store_.add(row)) {
    case AnswerStore::Kept::different: return error(409, "another answer is kept");
    case AnswerStore::Kept::closed: return error(409, "this participant has finished");
    case AnswerStore::Kept::added:
    case AnswerStore::Kept::same: break;
  }
  const auto pixels = number_of(record, "pixels_per_degree");
  const auto spread = number_of(record, "pixels_per_degree_se");
  if (row.kind == "page" && is_calibration(row.item) && pixels && spread) store_.calibrate(who.id, *pixels, *spread);
  return reply({{"kept", true}});
}

HttpReply StudyService::finish(const StudyParticipantRow& who) {
  if (who.state == "started") {
    std::set<std::string> given;
    for (const StudyAnswerRow& row : store_.answers(who.id)) given.insert(row.item);
    const auto& trials = folder_.trials.at(who.list);
    const auto left =
        std::count_if(trials.begin(), trials.end(), [&](const auto& trial) { return !given.contains(trial.first); });
    if (left > 0) return error(409, fmt::format("{} of {} trials are not answered", left, trials.size()));
    store_.finish(who.id, now_());
  }
  return reply({{"state", "finished"}});
}

HttpReply StudyService::withdraw(const StudyParticipantRow& who) {
  store_.withdraw(who.id, now_().substr(0, 10));
  return reply({{"state", "withdrawn"}});
}

}  // namespace crowdbench::studies
