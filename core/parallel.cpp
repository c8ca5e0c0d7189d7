#include "core/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace crowdbench {

void parallel_for(size_t count, unsigned threads, const std::function<void(size_t)>& work,
                  const std::function<void(size_t)>& advanced) {
  if (threads == 0) threads = std::clamp(std::thread::hardware_concurrency(), 1U, 8U);
  std::atomic<size_t> next = 0;
  std::atomic<size_t> done = 0;
  std::mutex mutex;
  std::exception_ptr fault;
  const auto run = [&](bool reports) {
    for (size_t i = next++; i < count; i = next++) {
      try {
        work(i);
        ++done;
        if (reports && advanced) advanced(done);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!fault) fault = std::current_exception();
        next = count;
      }
    }
  };
  std::vector<std::thread> others;
  for (unsigned t = 1; t < threads; ++t) others.emplace_back(run, false);
  run(true);
  for (std::thread& t : others) t.join();
  if (fault) std::rethrow_exception(fault);
}

}  // namespace crowdbench
