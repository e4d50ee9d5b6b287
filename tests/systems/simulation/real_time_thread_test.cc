#include <tenon/systems/simulation/real_time_thread.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>

#include <thread>

namespace tenon::real_time_thread_test {

/// Policy and processors of the calling thread.
std::pair<int, int> Scheduling() {
  cpu_set_t processors;
  sched_getaffinity(0, sizeof processors, &processors);
  return {sched_getscheduler(0) & ~SCHED_RESET_ON_FORK, CPU_COUNT(&processors)};
}
std::pair<int, int> SchedulingOfALaterThread() {
  std::pair<int, int> later;
  std::thread([&] { later = Scheduling(); }).join();
  return later;
}

// Where nothing is permitted, the thread stays as it is, and each reason has a remedy.
TEST(RealTimeThreadTest, HasAPriorityAndAProcessorThatLaterThreadsDoNotHave) {
  const auto before = Scheduling();
  {
    const RealTimeThread real_time;
    if (Scheduling().first == SCHED_FIFO && before.second > 1) {
      EXPECT_EQ(Scheduling().second, 1);
      EXPECT_EQ(SchedulingOfALaterThread(), std::pair(SCHED_OTHER, before.second - 1));
    } else {
      EXPECT_THAT(real_time.refused(), testing::Contains(testing::AnyOf(testing::HasSubstr("limits.d"),
                                                                        testing::HasSubstr("taskset"))));
    }
  }
  EXPECT_EQ(Scheduling(), before);
  EXPECT_EQ(SchedulingOfALaterThread(), before);
}

}  // namespace tenon::real_time_thread_test
