#include <tenon/apps/common/blame.h>
#include <tenon/tests/testing/expect_throws.h>

#include <gtest/gtest.h>

namespace tenon::apps::blame_test {
namespace {

TEST(BlameTest, ErrorsOfBlocksHaveThePlaceOfTheKeyOfTheirName) {
  const auto scenario = YamlDocument::Parse("mass: 3\nwalk:\n  pd: {kp: 1}\n", "cart.yaml");
  const auto blames = [&](const std::string& block, const std::string& place) {
    return Throws<ParameterError>(
        [&] { RunBlaming(scenario, [&] { Blame("", [&] { throw ParameterError("too weak", block); }); }); },
        place + ": too weak");
  };
  EXPECT_TRUE(blames("loop.pd", "cart.yaml:3:7: walk.pd"));
  EXPECT_TRUE(blames("loop.walk.joint_0", "cart.yaml:3:3: walk")) << "the diagram around it";
  EXPECT_TRUE(blames("loop.masses", "cart.yaml"));
  EXPECT_TRUE(blames("", "cart.yaml"));
}

}  // namespace
}  // namespace tenon::apps::blame_test
