#include <tenon/apps/common/blame.h>

#include <gtest/gtest.h>

namespace tenon::apps::blame_test {
namespace {

TEST(BlameTest, FindsTheKeyOfABlockAndOfWhatIsInIt) {
  constexpr KeyOfBlock kKeys[] = {{"walk", "walk.path"}, {"observer", "profile"}};
  EXPECT_EQ(KeyOfBlockAt("observer", kKeys), "profile");
  EXPECT_EQ(KeyOfBlockAt("loop.observer.leg_0", kKeys), "profile");
  EXPECT_EQ(KeyOfBlockAt("loop.observer.walk", kKeys), "walk.path") << "the first entry";
  EXPECT_EQ(KeyOfBlockAt("loop.observers", kKeys), "");
  EXPECT_EQ(KeyOfBlockAt("", kKeys), "");
}

TEST(BlameTest, ErrorsOfBlocksGetTheirKey) {
  constexpr KeyOfBlock kKeys[] = {{"pd", "gains"}};
  const auto key_of = [&](const std::string& block) {
    try {
      BlameBlocks(kKeys, [&] { throw ParameterError("block 'pd': kp = -1", block); });
    } catch (const KeyError& error) {
      return error.key();
    }
    return std::string("no error");
  };
  EXPECT_EQ(key_of("loop.pd"), "gains");
  EXPECT_EQ(key_of(""), "") << "the text is not searched";
}

}  // namespace
}  // namespace tenon::apps::blame_test
