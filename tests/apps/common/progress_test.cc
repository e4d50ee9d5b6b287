#include <tenon/apps/common/progress.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tenon::apps {
namespace {

std::string Said(const std::string& text) {
  ::testing::internal::CaptureStderr();
  Say(text);
  return ::testing::internal::GetCapturedStderr();
}

TEST(SayTest, ControlCharactersDoNotReachATerminal) {
  EXPECT_EQ(Said("warning: na\xc3\xafve\n"), "warning: na\xc3\xafve\n");
  EXPECT_EQ(Said("\033[31mred\r\n"), "\\x1b[31mred\\x0d\n");
  EXPECT_EQ(Said("\xc2\x9b"
                 "31m"),
            "\\x9b31m")
      << "the same in one character of two bytes";
  EXPECT_EQ(Said("caf\xe9 \xff"), "caf\\xe9 \\xff") << "not UTF-8";
  EXPECT_EQ(Said("cut \xe2\x80"), "cut \\xe2\\x80") << "a character without its end";
}

TEST(SayTest, DrawnLinesKeepControlSequences) {
  ::testing::internal::CaptureStderr();
  Draw("\r\033[K");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "\r\033[K");
}

}  // namespace
}  // namespace tenon::apps
