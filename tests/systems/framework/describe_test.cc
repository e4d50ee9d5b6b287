#include <tenon/tests/systems/framework/test_blocks.h>

#include <string>

namespace tenon::describe_test {

std::string Describe() {
  PdLoop loop;
  loop.builder.Add<Counter>("counter", Sampled{Hz(10), 0.05});
  return loop.builder.Build()->Describe();
}

bool Has(const std::string& line) {
  const std::string text = Describe();
  return text.find(line) != std::string::npos ? true : (ADD_FAILURE() << text, false);
}

TEST(DescribeTest, NamesBlocksPortsUnitsAndRates) {
  EXPECT_TRUE(Has("cart: Cart\n"));
  EXPECT_TRUE(Has("input force: double [N] <- pd.u\n"));
  EXPECT_TRUE(Has("continuous state x: Vec<2> [m, m/s]\n"));
  EXPECT_TRUE(Has("output u: double [N], every 1 ms\n"));
  EXPECT_TRUE(Has("input ref: double [m], has a default\n"));
  EXPECT_TRUE(Has("update next n: int, every 100 ms from 50 ms\n"));
}

TEST(DescribeTest, TellsTheOrderAtEachTick) {
  EXPECT_TRUE(Has("every 1 ms, restarts the integrator\n    computes: pd.u\n"));
  EXPECT_TRUE(Has("every 100 ms from 50 ms, does not restart the integrator\n    updates: counter.next n\n"));
  EXPECT_TRUE(Has("all together\n    computes: pd.u\n"));
}

TEST(DescribeTest, TellsWhatTheIntegratorDoes) {
  EXPECT_TRUE(Has("Integration of 2 states\n"));
  EXPECT_TRUE(Has("at each stage: cart.d/dt x\n"));
  EXPECT_TRUE(Has("restarts after: pd.u\n"));
}

}  // namespace tenon::describe_test
