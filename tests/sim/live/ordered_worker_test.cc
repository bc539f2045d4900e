#include <gmock/gmock.h>

#include <atomic>
#include <stdexcept>
#include <vector>

#include "sim/live/frame_pipeline.h"

namespace sim::live {
namespace {

using testing::ElementsAre;

class OrderedWorkers : public testing::TestWithParam<bool> {};

TEST_P(OrderedWorkers, WorkInTheOrderGivenOnOneThread) {
  std::vector<int> done;
  std::vector<std::thread::id> threads;
  {
    OrderedWorker worker(GetParam());
    std::future<void> last;
    for (int i = 0; i < 5; ++i)
      last = worker.do_next([&, i] { done.push_back(i), threads.push_back(std::this_thread::get_id()); });
    last.get();
  }
  EXPECT_THAT(done, ElementsAre(0, 1, 2, 3, 4));
  for (const std::thread::id id : threads) {
    EXPECT_EQ(id, threads.front());
    EXPECT_EQ(id != std::this_thread::get_id(), GetParam());
  }
}

TEST_P(OrderedWorkers, HandOverWhatIsReturnedAndThrown) {
  OrderedWorker worker(GetParam());
  auto number = worker.do_next([] { return 7; });
  auto fault = worker.do_next([]() -> int { throw std::runtime_error("no"); });
  auto after = worker.do_next([] { return 8; });
  EXPECT_EQ(number.get(), 7);
  EXPECT_THROW(fault.get(), std::runtime_error);
  EXPECT_EQ(after.get(), 8);
}

INSTANTIATE_TEST_SUITE_P(WithAndWithoutAThread, OrderedWorkers, testing::Bool());

TEST(OrderedWorker, LeavesUndoneWhatHasNotBegunWhenItEnds) {
  std::promise<void> begun, go_on;
  std::atomic<bool> second = false;
  std::future<void> first;
  std::thread later;
  {
    OrderedWorker worker(true);
    first = worker.do_next([&] { begun.set_value(), go_on.get_future().wait(); });
    begun.get_future().wait();
    worker.do_next([&] { second = true; });
    later =
        std::thread([&] { std::this_thread::sleep_for(std::chrono::milliseconds(20)), go_on.set_value(); });
  }
  later.join();
  first.get();
  EXPECT_FALSE(second);
}

}  // namespace
}  // namespace sim::live
