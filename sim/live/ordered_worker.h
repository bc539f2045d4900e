// A worker that calls functions in order on one thread.
#pragma once

#include <condition_variable>
#include <deque>
#include <future>
#include <mutex>
#include <thread>
#include <utility>

namespace sim::live {

/// Calls functions one after another, in the order of do_next(), all on one thread: its own, or the caller's
/// within do_next(). Objects that belong to one thread, as OpenGL's contexts do, are made, used and destroyed
/// by such functions. Functions that have not started when the worker is destroyed are dropped.
class OrderedWorker {
 public:
  explicit OrderedWorker(bool own_thread) {
    if (own_thread) thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
  }
  /// The future has the function's result or exception.
  template <typename Function>
  auto do_next(Function function) {
    std::packaged_task<std::invoke_result_t<Function>()> task(std::move(function));
    auto result = task.get_future();
    if (thread_.joinable()) {
      const std::lock_guard lock(mutex_);
      waiting_.emplace_back(std::move(task));
      changed_.notify_one();
    } else {
      task();
    }
    return result;
  }

 private:
  void work(const std::stop_token& stop) {
    for (std::unique_lock lock(mutex_);;) {
      changed_.wait(lock, stop, [this] { return !waiting_.empty(); });
      if (stop.stop_requested()) return;
      std::packaged_task<void()> task = std::move(waiting_.front());
      waiting_.pop_front();
      lock.unlock();
      task();
      lock.lock();
    }
  }

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<std::packaged_task<void()>> waiting_;
  std::jthread thread_;  // last: it uses the members above
};

}  // namespace sim::live
