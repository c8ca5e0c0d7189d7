// Two builds of the program measured in turns: A B A B ..., each time a new process, so that what differs from process
// to process is part of the noise, and what differs from hour to hour is not part of the difference.
#pragma once
#include <string>
#include <vector>

#include "store/store.h"

namespace crowdbench::bench {

struct BuildRuns {
  std::vector<StoreContents> a, b;  // a file a run
};
// a, b: paths of crowdbench programs. arguments: of their `bench`, as a shell reads them; --out is added. runs: of
// each, at least 1. Files lie in a folder of their own until they are read. Throws Error where a program fails (exit
// status 1, a picture check that failed, is no failure: its rows say so) and Interrupted.
BuildRuns run_builds(const std::string& a, const std::string& b, const std::string& arguments, int runs);

}  // namespace crowdbench::bench
