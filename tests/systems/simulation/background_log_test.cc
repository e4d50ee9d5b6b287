#include <tenon/systems/simulation/background_log.h>
#include <tenon/systems/simulation/simulator.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/temporary_path.h>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>
#include <sstream>
#include <thread>

namespace tenon::background_log_test {

using ::testing::EndsWith;

TEST(BackgroundLogTest, SinksGetWhatTheyWouldGetWithoutIt) {
  DiagramBuilder builder;
  const auto& clock = builder.AddFunction("clock", Uses(builder.time), [](double t) { return 2 * t; });
  const auto diagram = builder.Build();
  Simulator simulator(*diagram);
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

class BrokenSink final : public LogSink {
 public:
  void Begin(const std::vector<std::string>&, const std::vector<std::string>&) override {}
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

}  // namespace tenon::background_log_test
