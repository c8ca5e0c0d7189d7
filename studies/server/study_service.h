// What the server of a study answers to each request: the rules, apart from sockets.
//
//   GET  /...           a file of the page; "/" is index.html
//   GET  /api/study     {"crowdbench": 1, "study": HASH}: the page is served by this program, not by a static server
//   POST /api/start     {"study", "participant", "list"?} -> {"token", "list", "state", "items": [answered so far],
//                       "given": {TRIAL: {"stimulus", "answer"}}}, from which the page chooses on where it adapts,
//                       "begun": {TRIAL: how often it was begun}
//   POST /api/answer    the page's record of one item; header X-Study-Token -> {"kept": true} once it is on the disk;
//                       {"item": TRIAL, "kind": "begin", "begun": COUNT}: it is about to be shown, the COUNT-th time
//   POST /api/finish    {} -> {"state": "finished"}
//   POST /api/withdraw  {} -> {"state": "withdrawn"}: what was sent is deleted
//
// Errors are {"error": one line}: 400 malformed or not of this study, 401 no such token (taken over by another window,
// or withdrawn), 403 from another site, 404, 405, 409 another answer to that item is kept, or (finish) trials are not
// answered yet, 411 no length or one of 0, 413 too long, 415 not JSON, 421 another host's name. A calibration beyond 5
// to 500 pixels a degree is malformed, and so is a member that stands in a record twice. The same record sent twice is
// acknowledged twice and kept once.
#pragma once
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "store/answer_store.h"
#include "studies/server/http_server.h"
#include "studies/server/study_folder.h"

namespace crowdbench::studies {

// Longer posts are refused; a record of a trial has about 2 KiB.
inline constexpr size_t kMostRecordBytes = 64 << 10;

class StudyService {
 public:
  // hosts: what the header Host may be ("127.0.0.1:8080"); origins: what the header Origin may be
  // ("https://study.example.org"). now: UTC, ISO 8601. All outlive the service.
  StudyService(const StudyFolder& folder, AnswerStore& store, std::set<std::string> hosts,
               std::set<std::string> origins, std::function<std::string()> now);

  // Before the body is read.
  std::optional<HttpReply> refuse(const HttpRequest& request) const;
  HttpReply handle(const HttpRequest& request);

 private:
  HttpReply file(const HttpRequest& request) const;
  HttpReply start(const HttpRequest& request);
  HttpReply answer(const HttpRequest& request, const StudyParticipantRow& who);
  HttpReply finish(const StudyParticipantRow& who);
  HttpReply withdraw(const StudyParticipantRow& who);

  const StudyFolder& folder_;
  AnswerStore& store_;
  std::set<std::string> hosts_, origins_;
  std::function<std::string()> now_;
};

}  // namespace crowdbench::studies
