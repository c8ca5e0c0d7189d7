#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "bench/commands/command_line.h"
#include "bench/commands/study.h"
#include "core/error.h"
#include "studies/server/serve.h"

namespace crowdbench::bench {
namespace {

struct StudyServeOptions {
  std::string out, answers, origin;
  std::string address = "127.0.0.1";
  int port = 8000;
};

int run_serve(const StudyServeOptions& o) {
  studies::ServeSettings settings;
  settings.out = o.out;
  settings.answers =
      o.answers.empty() ? std::filesystem::path(o.out) / "answers.sqlite" : std::filesystem::path(o.answers);
  settings.address = o.address;
  settings.port = o.port;
  if (!o.origin.empty()) settings.origin = o.origin;
  studies::serve_study(settings, [&](const std::string& url) {
    fmt::print("{}\n", url);
    // Nobody would learn where it serves.
    if (std::fflush(stdout) != 0) throw Error("standard output", "cannot be written", "choose another place");
    fmt::print(stderr, "answers are kept in {}; Ctrl-C ends\n", settings.answers.string());
  });
  return 0;
}

}  // namespace

void add_study_serve(Command& study, Run& run) {
  Command* command = study.add_subcommand("serve", "Shows an exported study to participants and keeps their answers");
  command->footer(
      "Prints the page's URL. Participants of a recruiting platform come with "
      "?PROLIFIC_PID=...&STUDY_ID=...&SESSION_ID=...\n"
      "(or ?participant=...); &list=... gives a list by hand, else a new participant gets the list that fewest have.\n"
      "The page sends a hash in place of the participant's id, and the server writes no log. Each answer is on the "
      "disk\n"
      "before it is acknowledged. Beyond this machine a proxy (nginx, Caddy, Apache) does TLS in front of it, and "
      "passes\n"
      "the header Host on; say its address with --origin.\n\n"
      "Examples:\n  crowdbench study serve study-out --port 8000\n"
      "  crowdbench study serve study-out --answers answers.sqlite --origin https://study.example.org");
  auto options = std::make_shared<StudyServeOptions>();
  StudyServeOptions& o = *options;
  command->add_option("OUT", o.out, "folder that `study export` made")->required()->type_name("FOLDER");
  command->add_option("--answers", o.answers, "result file that answers are kept in; OUT/answers.sqlite without it")
      ->type_name("FILE.sqlite")
      ->output_file();
  command->add_option("--port", o.port, "to listen on; 0: a free one")->capture_default_str()->whole_number(0, 65535);
  command->add_option("--address", o.address, "to listen on; beyond this machine with --origin only")
      ->type_name("ADDRESS")
      ->capture_default_str();
  command->add_option("--origin", o.origin, "under which participants reach the page, where that is another address")
      ->type_name("URL");
  command->callback([options, &run] { run = [options] { return run_serve(*options); }; });
}

}  // namespace crowdbench::bench
