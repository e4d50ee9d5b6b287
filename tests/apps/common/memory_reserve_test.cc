#include <tenon/apps/common/memory_reserve.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <new>

namespace tenon::apps {
namespace {

constexpr rlim_t kLimit = 96 << 20;  // of address space [bytes]

/// Address space of this process [bytes]; terabytes under a sanitizer.
rlim_t Addresses() {
  rlim_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
}

/// Like operator new without memory.
void FindNoMemory() {
  std::get_new_handler()();
}

/// Nested lists, whose destructor needs memory for each element.
void FillMemory(nlohmann::json& lists) {
  for (;;) {
    lists.push_back(nlohmann::json::array());
    for (int i = 0; i < 1000; ++i) lists.back().push_back(i);
  }
}

TEST(MemoryReserveTest, TheReserveIsGivenOnce) {
  const MemoryReserve reserve;
  EXPECT_FALSE(MemoryReserve::given());
  EXPECT_NO_THROW(FindNoMemory());
  EXPECT_TRUE(MemoryReserve::given());
  EXPECT_THROW(FindNoMemory(), std::bad_alloc);
  MemoryReserve::Refill();
  EXPECT_FALSE(MemoryReserve::given());
  EXPECT_NO_THROW(FindNoMemory());
}

TEST(MemoryReserveTest, TheHandlerBeforeIsBackAtTheEnd) {
  const std::new_handler before = std::get_new_handler();
  {
    const MemoryReserve reserve;
    FindNoMemory();
  }
  EXPECT_EQ(std::get_new_handler(), before);
  EXPECT_FALSE(MemoryReserve::given());
}

TEST(MemoryReserveTest, AJsonDocumentThatTakesAllMemoryIsThrownAway) {
  if (Addresses() > kLimit) GTEST_SKIP() << "a sanitizer takes more addresses than there is memory";
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto fill = [] {
    const MemoryReserve reserve;
    const rlimit limit{kLimit, kLimit};
    setrlimit(RLIMIT_AS, &limit);
    try {
      nlohmann::json lists;
      FillMemory(lists);
    } catch (const std::bad_alloc&) {
      std::_Exit(MemoryReserve::given() ? 0 : 1);
    }
  };
  EXPECT_EXIT(fill(), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace tenon::apps
