#include <tenon/tests/testing/allocation_guard.h>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include <cerrno>
#include <cstdlib>
#include <functional>
#include <memory>
#include <new>
#include <thread>
#include <vector>

namespace tenon::allocation_guard_test {

/// A place that the compiler must believe to be read, so that it cannot leave out the allocation.
void* volatile sink;

long AllocationsOf(const std::function<void*()>& allocate) {
  const AllocationGuard guard;
  sink = allocate();
  const long count = guard.count();
  std::free(sink);
  return count;
}

struct AllocationGuardTest : ::testing::Test {
  void SetUp() override {
    if (!AllocationGuard::Available()) GTEST_SKIP() << "allocations are not counted in this build";
  }
};

TEST_F(AllocationGuardTest, CountsNew) {
  const AllocationGuard guard;
  const std::unique_ptr<int> one = std::make_unique<int>(1);
  sink = one.get();
  EXPECT_EQ(guard.count(), 1);
  std::vector<double> many;
  for (int i = 0; i < 3; ++i) {
    many.resize(many.capacity() + 1);
    sink = many.data();
  }
  EXPECT_EQ(guard.count(), 4);
  struct alignas(64) Aligned {
    double values[8];
  };
  const auto aligned = std::make_unique<Aligned>();
  sink = aligned.get();
  EXPECT_EQ(guard.count(), 5);
}

TEST_F(AllocationGuardTest, CountsMalloc) {
  EXPECT_EQ(AllocationsOf([] { return std::malloc(10); }), 1);
  EXPECT_EQ(AllocationsOf([] { return std::calloc(10, 8); }), 1);
  EXPECT_EQ(AllocationsOf([] { return std::realloc(std::malloc(10), 100); }), 2);
  EXPECT_EQ(AllocationsOf([] { return std::aligned_alloc(64, 128); }), 1);
  EXPECT_EQ(AllocationsOf([] {
              void* memory = nullptr;
              return posix_memalign(&memory, 32, 10) == 0 ? memory : nullptr;
            }),
            1);
}

TEST_F(AllocationGuardTest, LeavesAllocationAsItIs) {
  void* memory = nullptr;
  EXPECT_EQ(posix_memalign(&memory, 3, 10), EINVAL);
  ASSERT_EQ(posix_memalign(&memory, 256, 10), 0);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(memory) % 256, 0u);
  std::free(memory);
  auto* zeros = static_cast<unsigned char*>(std::calloc(1000, 1));
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(zeros[i], 0);
  std::free(zeros);
}

TEST_F(AllocationGuardTest, CountsFromItsOwnBeginning) {
  const AllocationGuard outer;
  const auto first = std::make_unique<int>(1);
  sink = first.get();
  const AllocationGuard inner;
  const auto second = std::make_unique<int>(1);
  sink = second.get();
  EXPECT_EQ(outer.count(), 2);
  EXPECT_EQ(inner.count(), 1);
}

TEST_F(AllocationGuardTest, LeavesOtherThreadsOut) {
  std::thread other([] {
    const AllocationGuard inside;
    for (int i = 0; i < 1000; ++i) {
      const auto one = std::make_unique<int>(1);
      sink = one.get();
    }
    EXPECT_EQ(inside.count(), 1000);
  });
  const AllocationGuard guard;
  other.join();
  EXPECT_EQ(guard.count(), 0);
}

TEST(AllocationGuardWithoutCountingTest, CountsZero) {
  if (AllocationGuard::Available()) GTEST_SKIP() << "allocations are counted in this build";
  const AllocationGuard guard;
  const auto one = std::make_unique<int>(1);
  sink = one.get();
  EXPECT_EQ(guard.count(), 0);
}

}  // namespace tenon::allocation_guard_test
