#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/quadruped/wire_recorder.h>
#include <tenon/systems/files/input_file.h>

#include <fmt/core.h>
#include <fmt/format.h>

#include <cstdio>
#include <sstream>

namespace tenon::apps {
namespace {

constexpr std::string_view kMagic = "tenon wire 1: ";

/// Writes rows of doubles behind a line of names.
class WireLog final : public LogSink {
 public:
  explicit WireLog(std::filesystem::path file) : file_(std::move(file)) {}
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override {
    file_.Append(fmt::format("{}{}\n", kMagic, fmt::join(names, ",")));
  }
  void Row(std::span<const double> row) override {
    buffer_.append(reinterpret_cast<const char*>(row.data()), row.size_bytes());
    if (Clock::now() - flushed_ > std::chrono::milliseconds(500)) Flush();
  }
  void Flush() override {
    flushed_ = Clock::now();
    file_.Append(std::exchange(buffer_, {}));
  }

 private:
  using Clock = std::chrono::steady_clock;
  GrowingFile file_;
  std::string buffer_;
  Clock::time_point flushed_ = Clock::now();
};

}  // namespace

WireRows ReadWire(const std::filesystem::path& directory, std::size_t columns) {
  const std::filesystem::path path = directory / "wire.bin";
  const std::string text = ReadText(path);
  const std::size_t end = text.find('\n');
  if (!text.starts_with(kMagic) || end == text.npos)
    throw ParameterError(fmt::format("{} is no recording of a wire", path.string()));
  const auto names = static_cast<std::size_t>(std::count(text.begin(), text.begin() + end, ',')) + 1;
  if (names != columns)
    throw ParameterError(
        fmt::format("{} has {} columns, but this version of the robot has {}: replay it with "
                    "the version that recorded it",
                    path.string(), names, columns));
  WireRows rows{columns};
  const std::size_t row = columns * sizeof(double), whole = (text.size() - end - 1) / row;
  if (whole == 0) throw ParameterError(fmt::format("{} has no whole row", path.string()));
  rows.numbers.resize(whole * columns);
  std::memcpy(rows.numbers.data(), text.data() + end + 1, whole * row);
  return rows;
}

void WriteDurations(const std::filesystem::path& directory, const Recording<double>& durations) {
  if (directory.empty()) return;
  std::string text = "time [s],duration [s]\n";
  for (const auto& [time, duration] : durations) text += fmt::format("{},{}\n", time, duration);
  WriteFile(directory / "durations.csv", text);
}

Recording<double> ReadDurations(const std::filesystem::path& directory) {
  Recording<double> durations;
  std::istringstream in(directory.empty() ? "" : ReadText(directory / "durations.csv"));
  std::string line;
  std::getline(in, line);
  for (double time = 0, duration = 0; std::getline(in, line);)
    if (std::sscanf(line.c_str(), "%lf,%lf", &time, &duration) == 2) durations.push_back({time, duration});
  return durations;
}

/// Compares the checksums of the messages that are sent with the recorded ones.
class WireRecorder::Check final : public LogSink {
 public:
  explicit Check(const WireRows& recorded) : recorded_(recorded) {}
  void Begin(const std::vector<std::string>&, const std::vector<std::string>&) override {}
  void Row(std::span<const double> row) override {
    if (next_ >= recorded_.rows()) return;
    const double* recorded = recorded_.row(next_++);
    if (row[0] == recorded[0] && row.back() == recorded[row.size() - 1]) {
      ++equal;
    } else if (other++ == 0) {
      first = row[0];
    }
  }
  long equal = 0, other = 0;
  std::optional<double> first;  ///< time of the first one that differs [s]

 private:
  const WireRows& recorded_;
  std::size_t next_ = 0;
};

WireRecorder::WireRecorder(Wire wire, std::filesystem::path out)
    : wire_(std::move(wire)), out_(std::move(out)) {}

void WireRecorder::AddTo(Simulator& simulator, Rate rate, const Source& received, const Source& checksum) {
  if (!wire_.replay.empty()) {
    check_ = std::make_shared<Check>(recorded_);
    simulator.AddLog(rate, {&received, &checksum}, {check_});
  } else if (!out_.empty()) {
    const OutputDirectory directory(out_);
    simulator.AddLog(rate, {&received, &checksum},
                     {InBackground(std::make_shared<WireLog>(out_ / "wire.bin"))});
  }
}

void WireRecorder::AddTo(Summary& summary) const {
  if (!check_) return;
  summary.Set("messages_equal", static_cast<double>(check_->equal));
  summary.Set("messages_different", static_cast<double>(check_->other));
  summary.Set("first_different_s", check_->first);
  if (!wire_.changed) summary.Limit("messages_different", {.high = 0});
}

}  // namespace tenon::apps
