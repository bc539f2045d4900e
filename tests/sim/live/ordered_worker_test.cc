#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

#include "sim/live/frame_pipeline.h"

namespace sim::live {
namespace {

class OrderedWorkers : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(WithAndWithoutAThread, OrderedWorkers, testing::Bool());

TEST_P(OrderedWorkers, WorkInTheOrderGivenOnOneThreadAndHandOverWhatIsReturnedAndThrown) {
  std::vector<int> done;
  std::vector<std::future<std::thread::id>> threads;
  OrderedWorker worker(GetParam());
  for (int i = 0; i < 5; ++i)
    threads.push_back(worker.do_next([&done, i] { return done.push_back(i), std::this_thread::get_id(); }));
  auto fault = worker.do_next([]() -> int { throw std::runtime_error("no"); });
  EXPECT_EQ(worker.do_next([] { return 8; }).get(), 8);
  EXPECT_THROW(fault.get(), std::runtime_error);
  EXPECT_EQ(done, (std::vector{0, 1, 2, 3, 4}));
  const std::thread::id first = threads[0].get();
  EXPECT_EQ(first != std::this_thread::get_id(), GetParam());
  for (std::size_t i = 1; i < threads.size(); ++i) EXPECT_EQ(threads[i].get(), first);
}

TEST(OrderedWorker, LeavesUndoneWhatHasNotBegunWhenItEnds) {
  std::promise<void> begun, go_on;
  std::atomic<bool> second = false;
  std::jthread later;
  {
    OrderedWorker worker(true);
    worker.do_next([&] { begun.set_value(), go_on.get_future().wait(); });
    begun.get_future().wait();
    worker.do_next([&] { second = true; });
    later =
        std::jthread([&] { std::this_thread::sleep_for(std::chrono::milliseconds(20)), go_on.set_value(); });
  }
  EXPECT_FALSE(second);
}

}  // namespace
}  // namespace sim::live
