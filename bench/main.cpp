#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <new>

#include "bench/commands/command_line.h"
#include "bench/commands/commands.h"
#include "core/command_line.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/version.h"

int main(int argc, char** argv) {
  using namespace crowdbench;
  set_command_line(argc, argv);
  install_interrupt_handler();
  CLI::App app{"crowdbench: draws one seeded crowd in several ways and measures what each costs and gets wrong",
               "crowdbench"};
  app.set_version_flag("--version", fmt::format("crowdbench {} ({})", version(), git_revision()));
  app.require_subcommand(1);
  bench::Run run;
  bench::Command program(app);
  bench::add_all_commands(program, run);
  try {
    app.parse(argc, argv);
    return run ? run() : 0;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    fmt::print(stderr, "crowdbench: {}; see crowdbench --help\n", printable(error.what(), 500));
  } catch (const Error& error) {
    fmt::print(stderr, "crowdbench: {}\n", error.what());
  } catch (const Interrupted&) {
    fmt::print(stderr, "crowdbench: interrupted; nothing was left half-written\n");
    return 130;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "crowdbench: out of memory; use fewer agents, smaller pictures or a smaller character\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "crowdbench: {}\n", printable(error.what(), 500));
  }
  return 2;
}
