#include <tenon/systems/live/internal/live_run.h>
#include <tenon/tests/systems/live/live_diagram.h>
#include <tenon/tests/testing/temporary_path.h>

namespace tenon::live_server_test {

using ::testing::HasSubstr;
using Json = nlohmann::json;

/// Runs without pacing and with commands at simulated times: nothing depends on the clock.
class LiveServerTest : public testing::Test {
 protected:
  ~LiveServerTest() override { std::filesystem::remove_all(directory_); }

  /// Calls `act(step)` when the run first comes to times[step].
  RunStatus Run(const std::vector<double>& times, const std::function<void(std::size_t step)>& act,
                double duration, const std::string& name = "live", std::uint64_t seed = 7) {
    std::filesystem::create_directory(directory_);
    std::size_t step = 0;
    LiveServer server({.port = 0, .frame = frame_, .rate = 0, .recording = directory_ / (name + ".jsonl")});
    server.options().stop = [&] {
      if (step < times.size() && server.status().time >= times[step] - 1e-9) act(step++);
      return false;
    };
    server_ = &server;
    Simulator simulator(*cart_.diagram, {.seed = seed});
    simulator_ = &simulator;
    simulator.AddLog(Hz(100), cart_.view.signals, {std::make_shared<CsvLog>(directory_ / (name + ".csv"))});
    const RunStatus status = server.Run(simulator, cart_.view, duration);
    reset_ = server.reset_seed();
    return status;
  }
  Json Command(const Json& command) { return Json::parse(server_->Command("test", command.dump())); }
  void Take() { EXPECT_EQ(Command({{"command", "take"}}), Json({{"ok", true}})); }
  std::string Csv(const std::string& name) const { return ReadText(directory_ / (name + ".csv")); }
  std::string ReplayedCsv(const std::string& name) {
    const LiveRecording recording = LiveRecording::Read(directory_ / (name + ".jsonl"));
    Simulator simulator(*cart_.diagram, {.seed = recording.seed});
    simulator.AddLog(Hz(100), cart_.view.signals, {std::make_shared<CsvLog>(directory_ / "again.csv")});
    Replay(simulator, recording);
    return Csv("again");
  }

  const std::filesystem::path directory_ = test::TemporaryPath("live_server");
  double frame_ = 0.01;  // [s]
  test::LiveCart cart_;
  LiveServer* server_ = nullptr;
  Simulator* simulator_ = nullptr;
  std::optional<std::uint64_t> reset_;
};

TEST_F(LiveServerTest, RunsLikeAnyOther) {
  EXPECT_FALSE(Run({}, {}, 1).ended);
  Simulator simulator(*cart_.diagram, {.seed = 7});
  simulator.AddLog(Hz(100), cart_.view.signals, {std::make_shared<CsvLog>(directory_ / "plain.csv")});
  simulator.RunTo(1);
  EXPECT_EQ(Csv("live"), Csv("plain"));
}

TEST_F(LiveServerTest, CommandsAreReplayedBitForBit) {
  const auto act = [&](std::size_t step) {
    if (step == 0) Take();
    Json answer{{"ok", true}};
    if (step == 1) answer = Command({{"command", "drive"}, {"velocity", {1, 0, 0}}});
    if (step == 2) answer = Command({{"command", "load"}, {"mass_kg", 1.5}});
    if (step == 3) answer = Command({{"command", "parameter"}, {"path", "engine.force"}, {"value", -2}});
    EXPECT_EQ(answer, Json({{"ok", true}}));
  };
  Run({0, 0.205, 0.51, 0.512}, act, 1);
  const std::string csv = Csv("live");
  EXPECT_EQ(ReplayedCsv("live"), csv);
  Run({}, {}, 1, "still");
  EXPECT_NE(Csv("still"), csv);
}

TEST_F(LiveServerTest, GoesBackAndBranches) {
  double came = 0;
  const auto act = [&](std::size_t step) {
    if (step == 0) Take();
    if (step == 1) Command({{"command", "drive"}, {"velocity", {1, 0, 0}}});
    if (step == 2) Command({{"command", "drive"}, {"velocity", {-1, 0, 0}}});
    if (step == 3) {
      EXPECT_TRUE(Command({{"command", "back"}, {"to_s", 0.7}}).contains("ok"));
      came = simulator_->context().time();
      EXPECT_EQ(simulator_->context().Eval(cart_.engine->force), 5);
    }
  };
  Run({0, 0.25, 0.8, 1.25}, act, 2, "branch");
  EXPECT_NEAR(came, 0.7, 1e-9);
  const std::string csv = Csv("branch");
  EXPECT_EQ(ReplayedCsv("branch"), csv);
  // The branch is the run in which the second command never came.
  Run(
      {0, 0.25}, [&](std::size_t step) { act(step); }, 2, "straight");
  EXPECT_EQ(Csv("straight"), csv);
}

TEST_F(LiveServerTest, GoingBackIntoAPullLetsGo) {
  std::vector<bool> first_calls;
  LiveControls::Pull pull;
  pull.bodies[0] = "cart";
  pull.set = [&](Context&, std::size_t, const Vec<3>&, const Vec<3>& target_W, bool first) {
    first_calls.push_back(first);
    return LiveSets{{"engine.force", {target_W[0]}}};
  };
  pull.release = [] { return LiveSets{{"engine.force", {0}}}; };
  cart_.view.controls.pull = std::move(pull);
  const auto force = [&] { return simulator_->context().Eval(cart_.engine->force); };
  const auto act = [&](std::size_t step) {
    const Json pulls{{"command", "pull"}, {"shape", 0}, {"point_W", {0, 0, 0}}, {"target_W", {3, 0, 0}}};
    if (step == 0) Take();
    if (step == 1) Command(pulls);
    if (step == 2) Command({{"command", "release"}});
    if (step == 3) {
      EXPECT_TRUE(Command({{"command", "back"}, {"to_s", 0.3}}).contains("ok"));
      EXPECT_EQ(force(), 0);
    }
    if (step == 4) {
      EXPECT_EQ(force(), 0);
      Command(pulls);
    }
  };
  Run({0, 0.2, 0.4, 0.6, 0.65}, act, 1);
  EXPECT_EQ(first_calls, (std::vector<bool>{true, true}));
  EXPECT_EQ(LiveRecording::Read(directory_ / "live.jsonl").entries.size(), 3U);
  EXPECT_EQ(ReplayedCsv("live"), Csv("live"));
}

TEST_F(LiveServerTest, WhoLeavesAfterGoingBackLetsGo) {
  const auto force = [&] { return simulator_->context().Eval(cart_.engine->force); };
  const auto act = [&](std::size_t step) {
    if (step != 1) Take();
    if (step == 1) Command({{"command", "drive"}, {"velocity", {1, 0, 0}}});
    if (step == 2) {
      EXPECT_EQ(force(), 5);
      Command({{"command", "leave"}});
      EXPECT_EQ(force(), 0);
    }
    if (step == 3) {
      Command({{"command", "back"}, {"to_s", 0.3}});
      EXPECT_EQ(force(), 5);
      Command({{"command", "leave"}});
      EXPECT_EQ(force(), 0);
    }
  };
  Run({0, 0.2, 0.4, 0.6}, act, 1);
  EXPECT_EQ(ReplayedCsv("live"), Csv("live"));
}

// The tick is no frame of the page; it is half a second after the start, where a run can be set back to.
TEST_F(LiveServerTest, GoesBackToBeforeATickThatWasDoneAlone) {
  frame_ = 0.495;
  const auto act = [&](std::size_t step) {
    if (step == 0) return Take();
    EXPECT_TRUE(Command({{"command", "tick"}}).contains("ok"));
    EXPECT_NEAR(simulator_->context().time(), 0.51, 1e-9);
    EXPECT_EQ(server_->status().state, "paused");
    EXPECT_TRUE(Command({{"command", "back"}, {"to_s", 0.5}}).contains("ok"));
    EXPECT_TRUE(Command({{"command", "drive"}, {"velocity", {1, 0, 0}}}).contains("ok"));
    Command({{"command", "resume"}});
    EXPECT_EQ(server_->status().state, "running");
  };
  Run({0, 0.495}, act, 1);
  EXPECT_EQ(ReplayedCsv("live"), Csv("live"));
}

TEST_F(LiveServerTest, GoesBackNoFurtherThanItRemembers) {
  Run(
      {0, 1},
      [&](std::size_t step) {
        if (step == 0) return Take();
        EXPECT_THAT(Command({{"command", "back"}, {"to_s", 5}})["error"], HasSubstr("can only go back"));
        EXPECT_THAT(Command({{"command", "back"}, {"to_s", -1}})["error"], HasSubstr("at most to 0 s"));
      },
      1.1);
}

/// Remembers something that no snapshot can contain.
struct Opaque {
  int number = 0;
};
class Secretive final : public LeafSystem<void> {
 public:
  Scratch<Opaque> memory{this, "memory"};
  OutputPort<double> y{this, "y", Sampled{Hz(10)}, Uses(memory), [](Opaque& o) { return 1.0 * ++o.number; }};
};

TEST(LiveServerAloneTest, ARunThatCannotBeSavedRunsAndSaysThatItCannotGoBack) {
  DiagramBuilder builder;
  auto& secretive = builder.Add<Secretive>("secretive");
  Simulator simulator(builder.Build());
  const LiveView view{.signals = {&secretive.y}};
  LiveServer server({.port = 0, .rate = 0});
  const auto command = [&](const Json& json) { return Json::parse(server.Command("test", json.dump())); };
  bool asked = false;
  server.options().stop = [&] {
    if (asked || server.status().time < 0.5) return false;
    asked = true;
    command({{"command", "take"}});
    for (const Json& json :
         {Json{{"command", "back"}, {"to_s", 0.2}}, Json{{"command", "reset"}, {"seed", 8}}})
      EXPECT_THAT(command(json)["error"], HasSubstrs("cannot go back", "'secretive.memory'"));
    return false;
  };
  EXPECT_EQ(server.Run(simulator, view, 1).time, 1);
  EXPECT_TRUE(asked);
  EXPECT_EQ(simulator.context().Eval(secretive.y), 11);
}

TEST_F(LiveServerTest, ResetsToAnotherSeed) {
  Run(
      {0, 0.4},
      [&](std::size_t step) {
        if (step == 0) return Take();
        EXPECT_TRUE(Command({{"command", "reset"}, {"seed", 8}}).contains("ok"));
        EXPECT_EQ(simulator_->context().time(), 0);
      },
      1, "reset");
  Run({}, {}, 1, "fresh", 8);
  EXPECT_EQ(Csv("reset"), Csv("fresh"));
  EXPECT_EQ(ReplayedCsv("reset"), Csv("fresh"));
}

/// A block with a Parameter whose size is known at run time only.
class Weights final : public LeafSystem<void> {
 public:
  Parameter<Eigen::VectorXd> weights{this, {"weights"}, Eigen::VectorXd::Zero(2)};
  OutputPort<double> sum{this, {"sum"}, Uses(weights), [](const Eigen::VectorXd& w) { return w.sum(); }};
};

TEST(LiveResetTest, BeginsWithWhatTheRunBeganWith) {
  DiagramBuilder builder;
  auto& cart = builder.Add<Cart>("cart");
  auto& weights = builder.Add<Weights>("weights");
  Simulator simulator(builder.BuildWithOpenInputs());
  simulator.context().Set(cart.force, 2);
  simulator.context().Set(cart.x, {1, 0});
  simulator.context().Set(weights.weights, Vec<2>(3, 4));
  LiveServer server({.port = 0, .rate = 0});
  bool reset = false;
  server.options().stop = [&] {
    if (reset || server.status().time < 0.5) return false;
    reset = true;
    server.Command("test", R"({"command":"take"})");
    EXPECT_EQ(server.Command("test", R"({"command":"reset","seed":8})"), R"({"ok":true})");
    EXPECT_EQ(simulator.context().time(), 0);
    EXPECT_EQ(simulator.context().Eval(cart.x), Vec<2>(1, 0));
    return false;
  };
  const LiveView view{.signals = {&cart.state}};
  server.Run(simulator, view, 1);
  EXPECT_TRUE(reset);
  EXPECT_NEAR(simulator.context().Eval(cart.x)[0], 1 + 0.5 * 2 / CartParams().mass, 1e-9);
  EXPECT_EQ(simulator.context().Eval(weights.sum), 7);
}

TEST_F(LiveServerTest, ACommandSetsAllOrNothing) {
  cart_.view.controls.gaits = {{"hop"}, [](std::size_t) {
                                 return LiveSets{{"engine.tilt", {1, 0}}, {"engine.force", {11}}};
                               }};
  const auto act = [&](std::size_t step) {
    if (step == 0) return Take();
    EXPECT_THAT(Command({{"command", "gait"}, {"name", "hop"}}).value("error", ""),
                HasSubstr("from -10 to 10 N"));
    EXPECT_EQ(simulator_->context().Eval(cart_.engine->tilt), Vec<2>(0, 0));
  };
  Run({0, 0.1}, act, 0.2);
}

TEST_F(LiveServerTest, RefusesWhatCannotBeAndSaysWhy) {
  const auto refused = [&](const Json& command, const char* why) {
    EXPECT_THAT(Command(command).value("error", "nothing"), HasSubstr(why));
  };
  Run(
      {0, 0.1},
      [&](std::size_t step) {
        if (step == 0) {
          refused({{"command", "pause"}}, "nobody drives");
          Take();
          EXPECT_THAT(server_->Command("other", R"({"command":"pause"})"), HasSubstr("'test' drives"));
          EXPECT_THAT(server_->Command("other", R"({"command":"take"})"), HasSubstr("'test' drives"));
          return;
        }
        refused({{"command", "drve"}}, "no command 'drve'; did you mean 'drive'?");
        refused({{"command", "gait"}, {"name", "trot"}}, "'gait'");
        refused({{"command", "drive"}, {"velocity", {2, 0, 0}}}, "give -1 to 1");
        refused({{"command", "drive"}, {"velocity", {0, 0}}}, "three numbers");
        refused({{"command", "drive"}}, "'drive'");
        refused({{"command", "load"}, {"mass_kg", 3}}, "give 1 to 2");
        refused({{"command", "parameter"}, {"path", "engine.force"}, {"value", 11}}, "from -10 to 10 N");
        refused({{"command", "parameter"}, {"path", "engine.farce"}, {"value", 1}}, "'engine.force'");
        refused({{"command", "parameter"}, {"path", "engine.tilt"}, {"value", {1, 2, 3}}}, "has 2 elements");
        refused({{"command", "parameter"}, {"path", "engine.gear"}, {"value", 9}}, "'engine.gear'");
        refused({{"command", "rate"}, {"value", 0}}, "give 0.001 to 1000");
        for (const Json& seed : {Json("x"), Json(-1), Json(1.5), Json(1e300), Json()})
          refused({{"command", "reset"}, {"seed", seed}}, "a seed must be");
        refused({{"command", "save"}}, "has no scenario");
        refused({"command"}, "a command must be an object");
        EXPECT_EQ(simulator_->context().Eval(cart_.engine->force), 0);
      },
      0.2);
}

TEST_F(LiveServerTest, TheWheelIsTakenByForceAlone) {
  Run(
      {0},
      [&](std::size_t) {
        Take();
        EXPECT_THAT(server_->Command("other", R"({"command":"take","force":true})"),
                    HasSubstr(R"("ok":true)"));
        EXPECT_THAT(Command({{"command", "pause"}}).value("error", ""), HasSubstr("'other' drives"));
      },
      0.1);
}

TEST_F(LiveServerTest, WhoseEventsEndLetsGo) {
  Simulator simulator(*cart_.diagram, {.seed = 7});
  internal::LiveChannel channel(30);
  auto events = std::make_optional<internal::LiveChannel::Reader>(channel, "test");
  internal::LiveRun* running = nullptr;
  int step = 0;
  LiveOptions options{.rate = 0};
  options.stop = [&] {
    const double force = simulator.context().Eval(cart_.engine->force);
    if (step == 0 && simulator.context().time() >= 0.1) {
      ++step;
      running->Execute("test", R"({"command":"take"})");
      running->Execute("test", R"({"command":"drive","velocity":[1,0,0]})");
    } else if (step == 1 && simulator.context().time() >= 0.2) {
      ++step;
      EXPECT_EQ(force, 5);
      events.reset();
    } else if (step == 2 && simulator.context().time() >= 0.3) {
      ++step;
      EXPECT_EQ(force, 0);
    }
    return false;
  };
  internal::LiveRun run(simulator, cart_.view, options, channel);
  running = &run;
  run.Run(0.5);
  EXPECT_EQ(step, 3);
}

TEST_F(LiveServerTest, KeepsNoRowsAfterTheRun) {
  Simulator simulator(*cart_.diagram);
  internal::LiveChannel channel(30);
  const LiveOptions options{.rate = 0};
  internal::LiveRun(simulator, cart_.view, options, channel).Run(0.1);
  simulator.RunTo(0.2);
  EXPECT_EQ(AllocationsOf([&] { simulator.RunTo(10); }), 0);
}

TEST_F(LiveServerTest, SaysWhatAParameterMayBe) {
  const auto context = cart_.diagram->CreateContext();
  const auto parameters =
      internal::Hello(cart_.view, {}, *context, internal::Tunable(*cart_.diagram), 30)["parameters"];
  ASSERT_EQ(parameters[0]["path"], "engine.force");
  EXPECT_EQ(internal::Dump(parameters[0]["ranges"]),
            R"([{"low":-10.0,"high":10.0,"above":false,"below":false,"text":"from -10 to 10 N"}])");
  ASSERT_EQ(parameters[1]["ranges"].size(), 2U);
  EXPECT_EQ(internal::Dump(parameters[1]["ranges"][1]["low"]), "null");
}

TEST_F(LiveServerTest, StopsAndTellsTheEnd) {
  const RunStatus status = Run(
      {0, 0.3},
      [&](std::size_t step) {
        if (step == 0) return Take();
        Command({{"command", "stop"}});
      },
      1);
  EXPECT_TRUE(status.ended);
  EXPECT_NEAR(status.time, 0.3, 1e-9);
  const LiveRecording recording = LiveRecording::Read(directory_ / "live.jsonl");
  EXPECT_EQ(recording.end, status.time);
  EXPECT_EQ(ReplayedCsv("live"), Csv("live"));
}

class LiveRecordingTest : public testing::Test {
 protected:
  ~LiveRecordingTest() override { std::filesystem::remove(file_); }
  LiveRecording Read(const std::string& text) {
    std::ofstream(file_) << text;
    return LiveRecording::Read(file_);
  }
  const std::filesystem::path file_ = test::TemporaryPath("recording.jsonl");
};

TEST_F(LiveRecordingTest, ReadsWhatWasWritten) {
  internal::LiveFile file(file_, 18446744073709551615U);
  file.Add({0.1, {{"a.b", {0.1 + 0.2, -1e-300}}, {"a.c", {3}}}});
  file.Add({0.1, {{"a.b", {5}}}});
  file.Add({0.7, {{"a.b", {6}}}});
  file.DropFrom(0.5);
  file.End(0.9, true);
  const LiveRecording read = LiveRecording::Read(file_);
  EXPECT_EQ(read.seed, 18446744073709551615U);
  ASSERT_EQ(read.entries.size(), 2U);
  EXPECT_EQ(read.entries[0].time, 0.1);
  EXPECT_EQ(read.entries[0].sets[0].values, (std::vector<double>{0.1 + 0.2, -1e-300}));
  EXPECT_EQ(read.entries[0].sets[1].path, "a.c");
  EXPECT_EQ(read.end, 0.9);
  EXPECT_TRUE(read.end_tick);
}

TEST_F(LiveRecordingTest, WrongLinesAreNamed) {
  const std::string head = "{\"tenon_live\": 1, \"seed\": 1}\n";
  EXPECT_TRUE(Throws<ParameterError>(
      [&] { Read(head + "{\"time\": 1, \"set\": {\"a\": [1]}}\n{\"time\": 0, \"set\": {}}\nx\n"); },
      "recording.jsonl:3:", "live.jsonl"));
  EXPECT_TRUE(
      Throws<ParameterError>([&] { Read("{\"tenon_live\": 9, \"seed\": 1}\n"); }, "recording.jsonl:1:"));
  for (const char* seed : {"-1", "1.5", "1e300", "1.0", "\"1\"", "null"})
    EXPECT_TRUE(Throws<ParameterError>(
        [&] { Read("{\"tenon_live\": 1, \"seed\": " + std::string(seed) + "}\n"); }, "recording.jsonl:1:"))
        << seed;
  EXPECT_TRUE(Throws<ParameterError>([&] { Read(head + "{\"end\": 1e308, \"tick\": true}\n"); }, ":2:"));
  EXPECT_EQ(Read("\xEF\xBB\xBF" + head).seed, 1U) << "a byte-order mark";
  EXPECT_TRUE(Throws<ParameterError>([&] { Read(""); }, ":1: the recording is empty"));
  EXPECT_TRUE(Throws<ParameterError>([&] { LiveRecording::Read("nowhere.jsonl"); }, "'nowhere.jsonl'"));
  // A killed run may leave an incomplete line.
  EXPECT_EQ(Read(head + "{\"time\": 1, \"set\": {\"a\": [1]}}\n{\"time\": 2, \"se").entries.size(), 1U);
}

TEST_F(LiveRecordingTest, AnotherDiagramIsRefused) {
  test::LiveCart cart;
  Simulator simulator(*cart.diagram);
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        Replay(simulator, {0, {{0.5, {{"engine.farce", {1}}}}}, 1, true});
      },
      "t = 0.5 s", "engine.force"));
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        Replay(simulator, {0, {{0.5, {{"engine.gear", {0.5}}}}}, 1, true});
      },
      "'engine.gear'", "t = 0.5 s"));
  Simulator other(*cart.diagram);
  EXPECT_TRUE(Throws<ParameterError>([&] { Replay(other, {0, {}, {}, false}); }, "recording", "end"));
}

}  // namespace tenon::live_server_test
