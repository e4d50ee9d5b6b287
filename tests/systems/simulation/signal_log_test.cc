#include <tenon/systems/simulation/background_log.h>
#include <tenon/tests/systems/framework/test_blocks.h>
#include <tenon/tests/testing/temporary_path.h>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <future>

namespace tenon::signal_log_test {

using ::testing::ElementsAre, ::testing::EndsWith;

struct Tension {
  double force = 0;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  bool slack = false;
  static FieldList Fields() {
    return {{"force", &Tension::force, "N"}, {"point", &Tension::point, "m"}, {"slack", &Tension::slack}};
  }
};

struct SignalLogTest : testing::Test {
  void SetUp() override {
    cart_ = &builder_.Add<Cart>("cart");
    cable_ = &builder_.AddFunction("cable", Uses(builder_.time), [](double t) {
      return Tension{.force = 100 * t, .point = {t, 2, 3}, .slack = t > 0.15};
    });
    list_ = &builder_.AddFunction({"list", "m"}, Sampled{Hz(10)}, Uses(builder_.time), [](double t) {
      return Eigen::VectorXd(Eigen::VectorXd::Constant(t < 0.45 ? 2 : 3, t));
    });
    diagram_ = builder_.BuildWithOpenInputs();
    simulator_ = std::make_unique<Simulator>(*diagram_);
    simulator_->context().Set(cart_->force, 4.0);
  }
  DiagramBuilder builder_;
  Cart* cart_;
  OutputPort<Tension>* cable_;
  OutputPort<Eigen::VectorXd>* list_;
  std::shared_ptr<const Diagram> diagram_;
  std::unique_ptr<Simulator> simulator_;
};

TEST_F(SignalLogTest, ColumnsHaveNamesAndUnits) {
  const auto log = simulator_->AddLog(Hz(10), {&cart_->state, &cart_->force, cable_});
  simulator_->RunTo(0.2);
  EXPECT_THAT(log->names(), ElementsAre("time", "cart.x.position", "cart.x.velocity", "cart.force",
                                        "cable.output.force", "cable.output.point.x", "cable.output.point.y",
                                        "cable.output.point.z", "cable.output.slack"));
  EXPECT_THAT(log->units(), ElementsAre("s", "m", "m/s", "N", "N", "m", "m", "m", ""));
  ASSERT_EQ(log->rows(), 3);
  const auto near = [](double x) { return testing::DoubleNear(x, 1e-9); };
  EXPECT_THAT(log->row(2), ElementsAre(0.2, near(0.04), near(0.4), 4, 20, 0.2, 2, 3, 1));
  EXPECT_THAT(log->column("cable.output.slack"), ElementsAre(0, 0, 1));
}

TEST_F(SignalLogTest, UnknownColumnSuggestsTheNearest) {
  const auto log = simulator_->AddLog(Hz(10), {&cart_->state});
  simulator_->Initialize();
  EXPECT_TRUE(Throws<Error>([&] { log->column("cart.x.positon"); }, "'cart.x.positon'", "'cart.x.position'"));
}

TEST_F(SignalLogTest, SizesKnownAtRunTimeShow) {
  const auto log = simulator_->AddLog(Hz(10), {list_});
  simulator_->RunTo(0.3);
  EXPECT_THAT(log->names(), ElementsAre("time", "list.output.0", "list.output.1"));
  EXPECT_THAT(log->units(), ElementsAre("s", "m", "m"));
  EXPECT_THAT(log->row(3), ElementsAre(0.3, 0.3, 0.3));
}

TEST_F(SignalLogTest, SignalThatChangesItsSizeIsAnError) {
  simulator_->AddLog(Hz(10), {list_});
  EXPECT_TRUE(Throws<RunError>([&] { simulator_->RunTo(1); }, "'list.output'", "t = 0.5 s"));
}

TEST_F(SignalLogTest, SignalThatChangesItsShapeIsAnError) {
  DiagramBuilder builder;
  const auto& matrix = builder.AddFunction("matrix", Sampled{Hz(10)}, Uses(builder.time), [](double t) {
    return Eigen::MatrixXd(Eigen::MatrixXd::Constant(t < 0.45 ? 2 : 3, t < 0.45 ? 3 : 2, t));
  });
  Simulator simulator(builder.Build());
  simulator.AddLog(Hz(10), {&matrix});
  EXPECT_TRUE(Throws<RunError>([&] { simulator.RunTo(1); }, "'matrix.output'", "t = 0.5 s"));
}

TEST_F(SignalLogTest, RowsShowSamplesOfTheirTickAndStatesBeforeItsUpdates) {
  DiagramBuilder builder;
  auto& counter = builder.Add<Counter>("counter", Sampled{Hz(10)});
  auto& sample =
      builder.AddFunction("sample", Sampled{Hz(10)}, Uses(builder.time), [](double t) { return t; });
  auto& read = builder.AddFunction("read", Sampled{Hz(10)}, Uses(counter.count), [](int n) { return n; });
  Simulator simulator(builder.Build());
  const auto log = simulator.AddLog(Hz(5), {&sample, &counter.n, &read});
  simulator.RunTo(0.45);
  EXPECT_THAT(log->column("sample.output"), ElementsAre(0, 0.2, 0.4));
  EXPECT_THAT(log->column("counter.n"), ElementsAre(0, 2, 4));
  EXPECT_THAT(log->column("read.output"), ElementsAre(0, 2, 4));
}

TEST_F(SignalLogTest, CsvHasOneHeaderRowWithUnits) {
  const auto file = test::TemporaryPath("tenon_signal_log_test.csv");
  simulator_->AddLog(Hz(10), {&cart_->force, cable_}, {std::make_shared<CsvLog>(file)});
  simulator_->RunTo(0.2);  // readable while the run pauses
  EXPECT_EQ(
      ReadText(file),
      "time [s],cart.force [N],cable.output.force [N],cable.output.point.x [m],cable.output.point.y [m],"
      "cable.output.point.z [m],cable.output.slack\n"
      "0,4,0,0,2,3,0\n"
      "0.1,4,10,0.1,2,3,0\n"
      "0.2,4,20,0.2,2,3,1\n");
  std::filesystem::remove(file);
}

TEST_F(SignalLogTest, CsvHoldsExtremeNumbers) {
  const auto file = test::TemporaryPath("tenon_signal_log_extremes.csv");
  {
    CsvLog log(file);
    log.Begin({"time", "a", "b"}, {"s", "", "m"});
    log.Row(std::vector<double>{1234.56789012345, -1.234567890123e-300, -HUGE_VAL});
    log.Row(std::vector<double>{0.1 + 0.2, 1.0 / 3, std::nan("")});
  }
  EXPECT_EQ(ReadText(file),
            "time [s],a,b [m]\n1234.56789012345,-1.23456789e-300,-inf\n0.3,0.333333333,nan\n");
  std::filesystem::remove(file);
}

TEST_F(SignalLogTest, FileThatCannotBeWrittenIsNamed) {
  EXPECT_TRUE(Throws<OutputError>([] { CsvLog("/nonexistent/log.csv"); }, "'/nonexistent/log.csv'"));
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full on this machine";
  CsvLog full("/dev/full");
  EXPECT_TRUE(Throws<OutputError>([&] { full.Begin({"time"}, {"s"}); }, "'/dev/full'"));
}

struct Pile {
  std::map<int, double> content;
};

TEST(LoggedTypesTest, WhatHasNoNumbersIsRefused) {
  DiagramBuilder builder;
  auto& text = builder.AddFunction("text", Uses(), [] { return std::string("words"); });
  auto& pile = builder.AddFunction("pile", Uses(), [] { return Pile(); });
  Simulator simulator(builder.Build());
  EXPECT_TRUE(Throws<ParameterError>([&] { simulator.AddLog(Hz(1), {&text}); }, "Publish"));
  EXPECT_TRUE(Throws<ParameterError>([&] { simulator.AddLog(Hz(1), {&pile}); }, "Fields()"));
}

// A run that is set back: rows of the discarded part are in no log.
TEST_F(SignalLogTest, HeldRowsOfWhatDidNotHappenAreGone) {
  const auto log = simulator_->AddLog(Hz(10), {&cart_->state, &cart_->force});
  simulator_->HoldLogs(0.95);
  const auto later = simulator_->AddLog(Hz(10), {&cart_->force});
  simulator_->RunTo(0.5);
  EXPECT_EQ(log->rows(), 0U);
  EXPECT_EQ(later->rows(), 6U);  // it was not there to be held
  const auto moment = simulator_->context().Save();
  simulator_->context().Set(cart_->force, -8.0);
  simulator_->RunTo(1.2);
  EXPECT_EQ(log->rows(), 3U);  // 0, 0.1 and 0.2 s
  simulator_->context().Restore(moment);
  simulator_->RunTo(1.3);
  simulator_->ReleaseLogs();
  const std::vector<double> times = log->column("time"), force = log->column("cart.force");
  ASSERT_EQ(times.size(), 14U);
  for (std::size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(times[i], 0.1 * static_cast<double>(i), 1e-12);
  for (const double f : force) EXPECT_EQ(f, 4);
  simulator_->RunTo(1.4);
  EXPECT_EQ(log->rows(), 15U);
}

TEST_F(SignalLogTest, AreHeldForAPositiveTime) {
  simulator_->AddLog(Hz(10), {&cart_->force});
  for (const double seconds : {0.0, -1.0, static_cast<double>(NAN), static_cast<double>(INFINITY)})
    EXPECT_TRUE(Throws<ParameterError>([&] { simulator_->HoldLogs(seconds); }, "ReleaseLogs"));
}

struct Restored : SignalLogTest {
  /// Runs to 1 s, goes back to 0.5 s, and on to 0.8 s with another force.
  void RunAndSetBack() {
    simulator_->RunTo(0.5);
    const auto moment = simulator_->context().Save();
    simulator_->RunTo(1);
    simulator_->context().Restore(moment);
    simulator_->context().Set(cart_->force, -8.0);
    simulator_->RunTo(0.8);
  }
};

constexpr std::array kTimes{0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8};
constexpr std::array kForces{4, 4, 4, 4, 4, 4, -8, -8, -8};

TEST_F(Restored, MemoryDropsWhatThenDidNotHappen) {
  const auto log = simulator_->AddLog(Hz(10), {&cart_->force});
  const auto behind = std::make_shared<MemoryLog>();
  simulator_->AddLog(Hz(10), {&cart_->force},
                     {std::make_shared<BackgroundLog>(std::vector<std::shared_ptr<LogSink>>{behind})});
  RunAndSetBack();
  for (const auto& each : {log, behind}) {
    EXPECT_THAT(each->column("time"), testing::Pointwise(testing::DoubleNear(1e-12), kTimes));
    EXPECT_THAT(each->column("cart.force"), testing::ElementsAreArray(kForces));
  }
}

TEST_F(Restored, FilesAreCut) {
  const auto file = test::TemporaryPath("tenon_signal_log_restored.csv");
  simulator_->AddLog(Hz(10), {&cart_->force}, {std::make_shared<CsvLog>(file)});
  RunAndSetBack();
  std::ostringstream expected;
  expected << "time [s],cart.force [N]\n";
  for (std::size_t i = 0; i < kTimes.size(); ++i) expected << kTimes[i] << ',' << kForces[i] << '\n';
  EXPECT_EQ(ReadText(file), expected.str());
  std::filesystem::remove(file);
}

TEST_F(Restored, ATickThatHasYetToHappenIsLoggedAnew) {
  const auto log = simulator_->AddLog(Hz(10), {&cart_->force});
  ASSERT_FALSE(simulator_->AdvanceToBefore(0.5).ended);
  const auto before = simulator_->context().Save();
  simulator_->RunTo(0.7);
  simulator_->context().Restore(before);
  simulator_->context().Set(cart_->force, -8.0);
  simulator_->RunTo(0.5);
  EXPECT_THAT(log->column("cart.force"), ElementsAre(4, 4, 4, 4, 4, -8));
}

TEST_F(Restored, TheStartClearsALog) {
  const auto file = test::TemporaryPath("tenon_signal_log_restarted.csv");
  const auto log = std::make_shared<MemoryLog>();
  simulator_->AddLog(Hz(10), {&cart_->force}, {log, std::make_shared<CsvLog>(file)});
  const auto start = simulator_->context().Save();
  simulator_->RunTo(1);
  simulator_->context().Restore(start);
  simulator_->RunTo(0.1);
  EXPECT_EQ(log->rows(), 2U);
  EXPECT_EQ(ReadText(file), "time [s],cart.force [N]\n0,4\n0.1,4\n");
  std::filesystem::remove(file);
}

TEST_F(Restored, AnyRowOfAFileIsFound) {
  const auto file = test::TemporaryPath("tenon_csv_log_rows.csv");
  for (const int rows : {0, 1, 2, 3, 7, 40}) {
    for (int kept = 0; kept <= rows; ++kept) {
      {
        CsvLog log(file);
        log.Begin({"time", "a"}, {"s", ""});
        for (int i = 0; i < rows; ++i) log.Row(std::vector<double>{i / 3.0, std::pow(10.0, i % 7)});
        log.DropFrom(kept / 3.0, false);
        if (kept > 0) log.DropFrom((kept - 1) / 3.0, true);  // there is nothing behind it
        log.Row(std::vector<double>{100, 0});
      }
      std::ifstream text(file);
      std::string line, last;
      int lines = 0;
      for (; std::getline(text, line); ++lines) last = line;
      ASSERT_EQ(lines, kept + 2) << rows;
      ASSERT_EQ(last, "100,0");
    }
  }
  std::filesystem::remove(file);
}

TEST_F(SignalLogTest, AFileThatCannotBeCutIsNamed) {
  if (!std::filesystem::exists("/dev/null")) GTEST_SKIP() << "no /dev/null on this machine";
  CsvLog log("/dev/null");
  log.Begin({"time"}, {"s"});
  log.Row(std::vector<double>{1});
  EXPECT_TRUE(Throws<OutputError>([&] { log.DropFrom(0, false); }, "'/dev/null'"));
}

// ---- Columns of the same name ----

TEST_F(SignalLogTest, ColumnsOfTheSameNameAreRefused) {
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        simulator_->AddLog(Hz(10), {cable_, &cart_->force, cable_});
      },
      "'cable.output.force'", "'cable.output'"));
  // An output that shows a state under its name.
  struct Shown final : LeafSystem<void> {
    ContinuousState<double> x{this, "x"};
    OutputPort<double> y{this, x};
    TimeDerivative<double> dx{x, Uses(x), [](double x) { return -x; }};
  };
  DiagramBuilder builder;
  auto& shown = builder.Add<Shown>("shown");
  Simulator simulator(builder.Build());
  EXPECT_TRUE(Throws<ParameterError>([&] { simulator.AddLog(Hz(10), {&shown.x, &shown.y}); }, "'shown.x'"));
}

TEST_F(SignalLogTest, ColumnsWhoseNumberIsKnownAtRunTimeAreComparedAtTheFirstRow) {
  simulator_->AddLog(Hz(10), {list_, list_});
  EXPECT_TRUE(Throws<ParameterError>([&] { simulator_->RunTo(0.1); }, "'list.output.0'", "'list.output'"));
}

struct SinkOnAFullDisk final : LogSink {
  void Row(std::span<const double>) override { throw OutputError("the disk is full"); }
};

TEST_F(SignalLogTest, WhatWasHeldComesToAllOtherLogsWhereOneCannotBeWritten) {
  simulator_->AddLog(Hz(10), {&cart_->force}, {std::make_shared<SinkOnAFullDisk>()});
  const auto gathered = std::make_shared<MemoryLog>();
  simulator_->AddLog(Hz(10), {&cart_->force},
                     {std::make_shared<BackgroundLog>(std::vector<std::shared_ptr<LogSink>>{gathered})});
  simulator_->HoldLogs(2);
  simulator_->RunTo(1);
  EXPECT_EQ(gathered->rows(), 0U);
  EXPECT_TRUE(Throws<OutputError>([&] { simulator_->ReleaseLogs(); }, "the disk is full"));
  EXPECT_EQ(gathered->rows(), 11U);
}

TEST_F(SignalLogTest, ASinkBelongsToOneLog) {
  const auto sink = std::make_shared<MemoryLog>();
  simulator_->AddLog(Hz(10), {&cart_->force}, {sink});
  for (const Rate rate : {Hz(10), Hz(20)})
    EXPECT_TRUE(Throws<ParameterError>([&] { simulator_->AddLog(rate, {&cart_->force}, {sink}); }, "AddLog",
                                       "another log"));
  EXPECT_TRUE(Throws<ParameterError>([&] { BackgroundLog log({sink}); }, "BackgroundLog", "another log"));
  EXPECT_TRUE(Throws<ParameterError>([&] { BackgroundLog log({nullptr}); }, "BackgroundLog", "null"));
  simulator_->RunTo(1);
  EXPECT_EQ(sink->rows(), 11U);
}

TEST(BackgroundLogTest, SinksGetWhatTheyWouldGetWithoutIt) {
  DiagramBuilder builder;
  const auto& clock = builder.AddFunction("clock", Uses(builder.time), [](double t) { return 2 * t; });
  Simulator simulator(builder.Build());
  const auto plain = simulator.AddLog(Hz(1000), {&clock});
  const auto first = std::make_shared<MemoryLog>(), second = std::make_shared<MemoryLog>();
  simulator.AddLog(Hz(1000), {&clock},
                   {std::make_shared<BackgroundLog>(std::vector<std::shared_ptr<LogSink>>{first, second})});
  for (const double end : {0.5, 20.0}) {
    simulator.RunTo(end);
    for (const auto& log : {first, second}) {
      EXPECT_EQ(log->names(), plain->names());
      EXPECT_EQ(log->units(), plain->units());
      EXPECT_EQ(log->column("time"), plain->column("time"));
      EXPECT_EQ(log->column("clock.output"), plain->column("clock.output"));
    }
  }
}

/// The lines of a text; checks that the last line is complete.
std::vector<std::string> Lines(std::istream& text) {
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) {
    EXPECT_FALSE(text.eof()) << "no end of line behind " << line;
    lines.push_back(line);
  }
  return lines;
}

TEST(BackgroundLogTest, RowsComeInOrderHoweverManyThereAre) {
  const auto file = test::TemporaryPath("tenon_csv_log_many.csv");
  constexpr int kRows = 200000;
  {
    BackgroundLog log({std::make_shared<CsvLog>(file)});
    log.Begin({"time", "a"}, {"s", ""});
    for (int i = 0; i < kRows; ++i) {
      log.Row(std::vector<double>{1.0 * i, 0.5 * i});
      if (i % 50000 != 0) continue;
      log.Flush();
      std::ifstream text(file);
      EXPECT_EQ(Lines(text).size(), i + 2) << "flushed";
    }
  }
  std::ifstream text(file);
  const std::vector<std::string> lines = Lines(text);
  ASSERT_EQ(lines.size(), kRows + 1);
  for (int i = 0; i < kRows; ++i) ASSERT_EQ(lines[i + 1], fmt::format("{},{}", i, 0.5 * i));
  std::filesystem::remove(file);
}

TEST(BackgroundLogTest, RunGoesOnWhileTheDiskIsBusy) {
  // A pipe without a reader takes 64 KiB and then blocks the writer.
  const auto file = test::TemporaryPath("tenon_csv_log.pipe");
  ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  const int reader = open(file.c_str(), O_RDONLY | O_NONBLOCK);
  constexpr int kRows = 10000;
  std::promise<void> all_rows;
  bool went_on = false;
  std::string text;
  std::thread emptied([&] {
    went_on = all_rows.get_future().wait_for(std::chrono::seconds(10)) == std::future_status::ready;
    fcntl(reader, F_SETFL, 0);
    std::array<char, 4096> part;
    for (ssize_t size = 0; (size = read(reader, part.data(), part.size())) > 0;)
      text.append(part.data(), static_cast<std::size_t>(size));
  });
  {
    BackgroundLog log({std::make_shared<CsvLog>(file)});
    log.Begin({"time", "a"}, {"s", ""});
    for (int i = 0; i < kRows; ++i) log.Row(std::vector<double>{1.0 * i, 1.0 / 3});
    all_rows.set_value();
  }
  emptied.join();
  close(reader);
  EXPECT_TRUE(went_on) << "rows waited for the pipe to be read";
  std::istringstream lines(text);
  EXPECT_EQ(Lines(lines).size(), kRows + 1);
  EXPECT_THAT(text, EndsWith("\n9999,0.333333333\n"));
  std::filesystem::remove(file);
}

/// Limits the size of files during its lifetime, like a full disk.
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit small{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
  }
  ~SmallDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int);
};

struct BrokenSink final : LogSink {
  void Row(std::span<const double> row) override {
    if (row[0] == 3) throw OutputError("this sink is broken");
  }
};

TEST(BackgroundLogTest, AfterAFailureNoSinkGetsMoreRowsAndEveryFlushTells) {
  const auto memory = std::make_shared<MemoryLog>();
  BackgroundLog log({memory, std::make_shared<BrokenSink>()});
  log.Begin({"time"}, {"s"});
  for (double t = 0; t < 9; ++t) log.Row(std::vector<double>{t});
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(Throws<OutputError>([&] { log.Flush(); }, "this sink is broken"));
  EXPECT_EQ(memory->rows(), 4U);
}

TEST(BackgroundLogTest, EndOfTheDiskEndsTheRunBehindAWholeRow) {
  const auto file = test::TemporaryPath("tenon_csv_log_full.csv");
  {
    const SmallDisk disk(300000);
    BackgroundLog log({std::make_shared<CsvLog>(file)});
    log.Begin({"time", "a"}, {"s", ""});
    int rows = 0;
    EXPECT_TRUE(Throws<OutputError>(
        [&] {
          for (; rows < 1000000; ++rows) log.Row(std::vector<double>{1.0 * rows, 1.0 / 3});
        },
        "tenon_csv_log_full.csv'"));
    EXPECT_GT(rows, 10000);
    EXPECT_LT(rows, 100000);
    EXPECT_THROW(log.Flush(), OutputError) << "it stays so";
  }
  std::ifstream text(file);
  const std::vector<std::string> lines = Lines(text);
  EXPECT_GT(lines.size(), 5000);
  EXPECT_THAT(lines.back(), EndsWith(",0.333333333"));
  std::filesystem::remove(file);
}

}  // namespace tenon::signal_log_test
