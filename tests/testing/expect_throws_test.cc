#include <tenon/systems/framework/types/errors.h>
#include <tenon/tests/testing/expect_throws.h>

#include <gmock/gmock.h>
#include <gtest/gtest-spi.h>

namespace tenon::expect_throws_test {

using ::testing::EndsWith;
using ::testing::HasSubstr;

TEST(ThrowsTest, AcceptsTypeAndParts) {
  EXPECT_TRUE(Throws<ParameterError>([] { throw ParameterError("mass must be positive"); }));
  EXPECT_TRUE(
      Throws<ParameterError>([] { throw ParameterError("mass must be positive"); }, "positive", "mass"));
  EXPECT_TRUE(Throws<Error>([] { throw ParameterError("mass must be positive"); }, std::string("must")));
}

TEST(ThrowsTest, RefusesAMissingPart) {
  const auto result = Throws<ParameterError>([] { throw ParameterError("mass must be positive"); }, "mass",
                                             "finite", "small");
  EXPECT_FALSE(result);
  EXPECT_THAT(result.message(), HasSubstr("'finite', 'small'"));
  EXPECT_THAT(result.message(), EndsWith(": mass must be positive"));
}

TEST(ThrowsTest, RefusesAnotherType) {
  const auto result = Throws<ParameterError>([] { throw BuildError("a loop"); }, "loop");
  EXPECT_FALSE(result);
  EXPECT_THAT(result.message(), EndsWith(": a loop"));
  EXPECT_FALSE(Throws<ParameterError>([] { throw Error("mass"); }, "mass")) << "a base is not enough";
}

TEST(ThrowsTest, RefusesWhatIsNoException) {
  const auto result = Throws<Error>([] { throw 1; });
  EXPECT_FALSE(result);
  EXPECT_THAT(result.message(), HasSubstr("std::exception"));
}

TEST(ThrowsTest, RefusesSilence) {
  const auto result = Throws<Error>([] {});
  EXPECT_FALSE(result);
  EXPECT_STREQ(result.message(), "nothing is thrown");
}

TEST(ThrowsTest, FailsTheTestWithTheActualText) {
  EXPECT_NONFATAL_FAILURE(EXPECT_TRUE(Throws<Error>([] { throw Error("actual text"); }, "expected text")),
                          "it reads: actual text");
}

}  // namespace tenon::expect_throws_test
