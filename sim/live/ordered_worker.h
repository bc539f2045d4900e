// Runs functions in order, on a separate thread or on the caller's.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

namespace sim::live {

/// Calls functions one after another, in the order of do_next(), all on one thread: its own, or the caller's
/// within do_next(). Objects that belong to one thread, as OpenGL's contexts do, are made, used and destroyed
/// by such functions. Functions that have not started when the worker is destroyed are dropped.
class OrderedWorker {
 public:
  explicit OrderedWorker(bool own_thread);
  ~OrderedWorker();
  OrderedWorker(const OrderedWorker&) = delete;
  OrderedWorker& operator=(const OrderedWorker&) = delete;

  /// The future has the function's result or exception.
  template <typename Function>
  auto do_next(Function function) {
    // Shared, since std::function copies.
    auto task = std::make_shared<std::packaged_task<std::invoke_result_t<Function>()>>(std::move(function));
    auto result = task->get_future();
    add([task] { (*task)(); });
    return result;
  }

 private:
  void add(std::function<void()> task);
  void work();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> waiting_;
  bool stopping_ = false;
  std::thread thread_;  // last: it uses the members above
};

}  // namespace sim::live
