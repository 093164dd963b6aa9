#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace armtrue {

/// Smallest unit of work of a thread whose blocks are rows of a campaign.
inline constexpr int kRowsPerBlock = 1024;

/// Whether this thread computes a block, of whatever call.
inline thread_local bool is_block_worker = false;

/// Asked for once: the answer comes from a file of the system.
inline int machine_threads() {
  static const int threads = std::max(1u, std::thread::hardware_concurrency());
  return threads;
}

/// Cuts [0, count) into blocks of `size`, computes `work(begin, end)` of each on the machine's
/// threads and hands the results to `join` in the order of the blocks. The cut is fixed, so the
/// joined result is the same on any number of threads, and so is the exception that is passed on:
/// that of the first block that throws one. Within a block the blocks of another call follow one
/// after another: its threads are busy.
template <typename Result, typename Work, typename Join>
void for_ordered_blocks(int count, int size, const Work& work, const Join& join) {
  const int blocks = (count + size - 1) / size;
  const auto run = [&](int block) {
    return work(block * size, std::min(count, (block + 1) * size));
  };
  const int threads = std::min(blocks, machine_threads());
  if (threads <= 1 || is_block_worker) {
    for (int block = 0; block < blocks; ++block) join(run(block));
    return;
  }
  std::vector<Result> results(blocks);
  std::atomic<int> next{0};
  int failed = blocks;
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto run_the_next = [&] {
    is_block_worker = true;
    for (int block = next++; block < blocks; block = next++) try {
        results[block] = run(block);
      } catch (...) {
        const std::lock_guard lock(failure_mutex);
        if (block < failed) failure = std::current_exception();
        failed = std::min(failed, block);
        next = blocks;  // those before it have begun
      }
    is_block_worker = false;
  };
  {
    std::vector<std::jthread> others;
    for (int t = 1; t < threads; ++t) others.emplace_back(run_the_next);
    run_the_next();
  }
  if (failure) std::rethrow_exception(failure);
  for (const Result& result : results) join(result);
}

}  // namespace armtrue
