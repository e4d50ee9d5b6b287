#include <tenon/apps/common/live_terminal.h>
#include <tenon/tests/systems/live/live_diagram.h>

#include <gmock/gmock.h>

namespace tenon::apps::live_terminal_test {
namespace {

using ::testing::HasSubstr;

// The cart of live_diagram.h gets 5 N per 1 m/s; it cannot move sideways or turn.
TEST(LiveTerminalTest, KeysSteerTheRun) {
  test::LiveCart cart;
  Simulator simulator(*cart.diagram);
  LiveTerminal terminal;
  LiveServer server({.port = 0, .rate = 0});
  const auto force = [&] { return simulator.context().Eval(cart.engine->force); };
  bool done = false;
  server.options().stop = [&] {
    if (done || server.status().time < 0.5) return false;
    done = true;
    terminal.Press('w', server);
    EXPECT_EQ(force(), 0.5);
    terminal.Press('w', server);
    terminal.Press('s', server);
    EXPECT_EQ(force(), 0.5);
    EXPECT_THAT(terminal.Line(server.status()), HasSubstr("+0.1"));
    terminal.Press('a', server);
    EXPECT_EQ(force(), 0.5);
    EXPECT_THAT(terminal.Line(server.status()), HasSubstr("velocity[1]"));  // refused
    terminal.Press(' ', server);
    EXPECT_EQ(force(), 0);
    terminal.Press('p', server);
    EXPECT_EQ(server.status().state, "paused");
    const double before = server.status().time;
    terminal.Press('.', server);
    EXPECT_NEAR(server.status().time, before + 0.01, 1e-9);
    terminal.Press('b', server);
    EXPECT_EQ(server.status().time, 0);
    terminal.Press('p', server);
    EXPECT_EQ(server.status().state, "running");
    terminal.Press('x', server);
    return false;
  };
  EXPECT_FALSE(server.Run(simulator, cart.view, 0.7).ended);
  EXPECT_TRUE(done);
}

}  // namespace
}  // namespace tenon::apps::live_terminal_test
