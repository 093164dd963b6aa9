#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace armtrue {

/// Cuts [0, count) into blocks of `size`, computes `work(begin, end)` of each on the machine's
/// threads and hands the results to `join` in the order of the blocks. The cut is fixed, so the
/// joined result is the same on any number of threads.
template <typename Result, typename Work, typename Join>
void for_ordered_blocks(int count, int size, const Work& work, const Join& join) {
  const int blocks = (count + size - 1) / size;
  const auto run = [&](int block) {
    return work(block * size, std::min(count, (block + 1) * size));
  };
  const int threads =
      std::min(blocks, static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  if (threads <= 1) {
    for (int block = 0; block < blocks; ++block) join(run(block));
    return;
  }
  std::vector<Result> results(blocks);
  std::atomic<int> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  {
    std::vector<std::jthread> workers;
    for (int t = 0; t < threads; ++t)
      workers.emplace_back([&] {
        try {
          for (int block = next++; block < blocks; block = next++) results[block] = run(block);
        } catch (...) {
          const std::lock_guard lock(failure_mutex);
          failure = std::current_exception();
        }
      });
  }
  if (failure) std::rethrow_exception(failure);
  for (const Result& result : results) join(result);
}

}  // namespace armtrue
