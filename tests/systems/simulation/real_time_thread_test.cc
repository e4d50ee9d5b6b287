#include <tenon/systems/simulation/real_time_thread.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>

#include <thread>

namespace tenon::real_time_thread_test {

struct Scheduling {
  int policy = sched_getscheduler(0) & ~SCHED_RESET_ON_FORK;
  cpu_set_t processors = [] {
    cpu_set_t set;
    sched_getaffinity(0, sizeof set, &set);
    return set;
  }();
};
bool Equal(const Scheduling& a, const Scheduling& b) {
  return a.policy == b.policy && CPU_EQUAL(&a.processors, &b.processors);
}

// Where nothing is permitted, the thread stays as it is, and each reason has a remedy.
TEST(RealTimeThreadTest, HasAPriorityAndAProcessorThatLaterThreadsDoNotHave) {
  const Scheduling before;
  {
    const RealTimeThread real_time;
    const Scheduling own;
    Scheduling later;
    std::thread([&] { later = Scheduling(); }).join();
    EXPECT_EQ(later.policy, SCHED_OTHER);
    if (own.policy == SCHED_FIFO && CPU_COUNT(&before.processors) > 1) {
      EXPECT_EQ(CPU_COUNT(&own.processors), 1);
      cpu_set_t common;
      CPU_AND(&common, &own.processors, &later.processors);
      EXPECT_EQ(CPU_COUNT(&common), 0);
    } else {
      EXPECT_THAT(real_time.refused(), testing::Contains(testing::AnyOf(testing::HasSubstr("limits.d"),
                                                                        testing::HasSubstr("taskset"))));
    }
  }
  EXPECT_TRUE(Equal(Scheduling(), before));
  Scheduling later;
  std::thread([&] { later = Scheduling(); }).join();
  EXPECT_TRUE(Equal(later, before));
}

}  // namespace tenon::real_time_thread_test
