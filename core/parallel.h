// Independent work items on several threads.
#pragma once
#include <cstddef>
#include <functional>

namespace crowdbench {

// Runs work(i) for every i below `count`. threads: how many, the caller's among them; 0: as many as the machine has,
// eight at most. advanced(done) is called from the caller's thread alone, after each item that it did itself; done:
// items that all have finished. The first exception of either ends the work and is thrown here.
void parallel_for(size_t count, unsigned threads, const std::function<void(size_t i)>& work,
                  const std::function<void(size_t done)>& advanced = {});

}  // namespace crowdbench
