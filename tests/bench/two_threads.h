#pragma once

#include <atomic>
#include <functional>
#include <future>

namespace armtrue_bench {

/// Calls work(0) ... work(count - 1) on two threads, in that order of start; the first exception
/// comes back.
inline void on_two_threads(int count, const std::function<void(int)>& work) {
  std::atomic<int> next{0};
  const auto take = [&] {
    for (int i = next++; i < count; i = next++) work(i);
  };
  std::future<void> other = std::async(std::launch::async, take);
  take();
  other.get();
}

}  // namespace armtrue_bench
