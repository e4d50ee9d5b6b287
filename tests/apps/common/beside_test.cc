#include <tenon/apps/common/beside.h>

#include <gtest/gtest.h>

namespace tenon::apps::beside_test {
namespace {

using Texts = std::pair<std::string, std::string>;

TEST(BesideTest, TakesEnoughDigitsToDiffer) {
  EXPECT_EQ(Beside(7.1234, 5), Texts("7.12", "5"));
  EXPECT_EQ(Beside(5.0004, 5), Texts("5.0004", "5"));
  EXPECT_EQ(Beside(4.9999996, 5, 4), Texts("4.9999996", "5"));
  EXPECT_EQ(Beside(1 + 1e-15, 1), Texts("1.000000000000001", "1"));
}

TEST(BesideTest, EqualOnesAreShort) {
  EXPECT_EQ(Beside(0.005, 0.005), Texts("0.005", "0.005"));
  EXPECT_EQ(Beside(1.0 / 3, 1.0 / 3), Texts("0.333", "0.333"));
}

}  // namespace
}  // namespace tenon::apps::beside_test
