#include <tenon/apps/common/progress.h>
#include <tenon/systems/framework/diagram/diagram.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

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

TEST(SignalDeathTest, EndsARunInsideACalculationThatDoesNotReturn) {
  DiagramBuilder builder;
  builder.AddFunction("endless", Sampled{Hz(10)}, Uses(builder.time), [](double t) {
    if (t < 0.5) return t;
    std::raise(SIGTERM);
    for (volatile bool on = true; on;) continue;
    return t;
  });
  Simulator simulator(builder.Build());
  EXPECT_EXIT(Observe(simulator, [&] { return simulator.AdvanceTo(1); }),
              ::testing::ExitedWithCode(128 + SIGTERM), "does not end");
}

TEST(SignalTest, EndsARunAfterTheStepThatItInterrupts) {
  DiagramBuilder builder;
  builder.AddFunction("signal", Sampled{Hz(10)}, Uses(builder.time), [](double t) {
    if (t == 0.5) std::raise(SIGTERM);
    return t;
  });
  Simulator simulator(builder.Build());
  const RunOutcome outcome = Advance(simulator, 10);
  EXPECT_EQ(outcome.exit_code, 128 + SIGTERM);
  EXPECT_LT(outcome.status.time, 1);
}

}  // namespace
}  // namespace tenon::apps
