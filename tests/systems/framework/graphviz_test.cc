#include <tenon/tests/systems/framework/test_blocks.h>
#include <tenon/tests/testing/temporary_path.h>

namespace tenon::graphviz_test {

using ::testing::HasSubstr, ::testing::Not;

struct Controller final : Subdiagram {
  Controller() {
    auto& pd = Add<Pd>("pd", PdParams{.rate = Hz(100)});
    auto& limit = Add<SampledMap>("limit", SampledMapParams{[](double u) { return u; }, {Hz(1000)}});
    Connect(state, pd.x);
    Connect(pd.u, limit.u);
    Connect(limit.y, force);
  }
  InputPort<Vec<2>> state{this, "state"};
  OutputPort<double> force{this, "force"};
};

std::string Draw() {
  DiagramBuilder builder;
  auto& cart = builder.Add<Cart>("cart");
  auto& controller = builder.Add<Controller>("controller");
  builder.Connect(cart.state, controller.state);
  builder.Connect(controller.force, cart.force);
  builder.Add<Counter>("lonely", Sampled{Hz(100)});
  builder.AddFunction("one", Uses(), [] { return 1.0; });
  return builder.Build()->Graphviz();
}

TEST(GraphvizTest, ShowsBlocksPortsAndConnections) {
  const std::string dot = Draw();
  EXPECT_THAT(dot, HasSubstrs("\"cart\" [label=<", "<b>cart</b>", "port=\"force\"",
                              "\"controller.pd\":\"u\":e -> \"controller.limit\":\"u\":w;"));
}

TEST(GraphvizTest, NestedDiagramsAreClustersWithTheirPorts) {
  const std::string dot = Draw();
  EXPECT_THAT(
      dot, HasSubstrs("subgraph \"cluster_controller\"", "\"controller.state\" [shape=cds, label=\"state\"",
                      "\"cart\":\"x\":e -> \"controller.state\";",
                      "\"controller.state\" -> \"controller.pd\":\"x\":w;",
                      "\"controller.limit\":\"y\":e -> \"controller.force\";",
                      "\"controller.force\" -> \"cart\":\"force\":w;"));
}

TEST(GraphvizTest, SampleTimesHaveColoursAndALegend) {
  const std::string dot = Draw();
  EXPECT_THAT(dot, HasSubstr("<td port=\"y\" align=\"right\" bgcolor=\"#f4b6b6\">"));  // 1 ms, the fastest
  EXPECT_THAT(dot, HasSubstr("<td port=\"u\" align=\"right\" bgcolor=\"#f7d9a8\">"));  // 10 ms
  EXPECT_THAT(dot, HasSubstrs("<td bgcolor=\"#f4b6b6\">1 ms</td>", "<td bgcolor=\"#f7d9a8\">10 ms</td>"));
  DiagramBuilder builder;
  builder.Add<Oscillator>("plant");
  EXPECT_THAT(builder.Build()->Graphviz(), Not(HasSubstr("legend")));
}

/// A diagram that is nested to a depth.
struct Nested final : Subdiagram {
  explicit Nested(int depth) {
    if (depth > 0) Add<Nested>("n", depth - 1);
  }
};

TEST(GraphvizTest, DiagramsThatAreNestedTooDeeplyAreRefused) {
  DiagramBuilder builder;
  builder.Add<Nested>("n", 200);
  EXPECT_TRUE(Throws<Error>([&] { static_cast<void>(builder.Build()->Graphviz()); }, "nested more than 100"));
}

TEST(GraphvizTest, DotAcceptsIt) {
  if (std::system("dot -V 2> /dev/null") != 0) GTEST_SKIP() << "Graphviz is not installed";
  const auto file = test::TemporaryPath("tenon_graphviz_test.dot");
  std::ofstream(file) << Draw();
  const auto messages = file.string() + ".txt";
  EXPECT_EQ(std::system(("dot -Tsvg -o /dev/null " + file.string() + " 2> " + messages).c_str()), 0);
  EXPECT_EQ(std::filesystem::file_size(messages), 0);  // no warnings
  std::filesystem::remove(file);
  std::filesystem::remove(messages);
}

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

}  // namespace tenon::graphviz_test
