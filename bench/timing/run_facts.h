// What is known of a run before anything is measured: the program, the scenario, the driver and the machine.
#pragma once
#include <string>

#include "bench/timing/timing_method.h"
#include "scene/scenario/scenario.h"
#include "store/store.h"

namespace crowdbench::bench {

// The row that a command writes first. arguments: as typed. order_seed: of the rounds (TimingPlan). What the machine
// does not tell is left absent. The only place where the time of day is read.
RunRow describe_run(gl::Context& context, const TimingMethod& method, const scene::Scenario& scenario,
                    const std::string& command, const std::string& arguments, uint64_t order_seed = kOrderSeed);

}  // namespace crowdbench::bench
