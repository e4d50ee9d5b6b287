#include <tenon/apps/quadruped/quadruped_run.h>
#include <tenon/systems/files/input_file.h>

#include <fmt/core.h>
#include <fmt/format.h>

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
    file_.Append({reinterpret_cast<const char*>(row.data()), row.size_bytes()});
  }

 private:
  GrowingFile file_;
};

}  // namespace

WireRows ReadWire(const std::filesystem::path& directory, std::size_t columns) {
  const std::filesystem::path path = directory / "wire.bin";
  const std::string text = ReadText(path);
  const std::size_t end = text.find('\n');
  if (!text.starts_with(kMagic) || end == text.npos)
    throw ParameterError(fmt::format("{} is no recording of a wire", path.string()));
  const auto names = static_cast<std::size_t>(std::count(text.begin(), text.begin() + end, ',')) + 1;
  if (names != columns && names != columns + 1)
    throw ParameterError(
        fmt::format("{} has {} columns, but this version of the robot has {}: replay it with "
                    "the version that recorded it",
                    path.string(), names, columns));
  WireRows rows{names, names != columns};
  const std::size_t row = names * sizeof(double), whole = (text.size() - end - 1) / row;
  if (whole == 0) throw ParameterError(fmt::format("{} has no whole row", path.string()));
  rows.numbers.resize(whole * names);
  std::memcpy(rows.numbers.data(), text.data() + end + 1, whole * row);
  return rows;
}

/// Compares the checksums of the messages that are sent with the recorded ones.
class WireRecorder::Check final : public LogSink {
 public:
  explicit Check(const WireRows& recorded) : recorded_(recorded) {}
  void Row(std::span<const double> row) override {
    if (next_ >= recorded_.rows()) return;
    const double* recorded = recorded_.row(next_++);
    if (row[0] == recorded[0] && row.back() == recorded[recorded_.columns - 1]) {
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

Recording<double> WireRecorder::Durations(Rate rate) const {
  Recording<double> durations;
  for (std::size_t i = 0; recorded_.ages && i < recorded_.rows(); ++i) {
    const double now = recorded_.row(i)[0], age = recorded_.row(i)[recorded_.columns - 2];
    const double ticks = std::fmin(std::fmax(std::round(age * rate.hz()), 0), static_cast<double>(i));
    const double start = recorded_.row(i - static_cast<std::size_t>(ticks))[0];
    if (durations.empty() || durations.back().time != start) durations.push_back({start, now - start});
  }
  return durations;
}

void WireRecorder::AddTo(Simulator& simulator, Rate rate, const std::vector<const Source*>& signals) {
  if (!wire_.replay.empty()) {
    check_ = std::make_shared<Check>(recorded_);
    simulator.AddLog(rate, signals, {check_});
  } else if (!out_.empty()) {
    const OutputDirectory directory(out_);
    simulator.AddLog(rate, signals, {InBackground(std::make_shared<WireLog>(out_ / "wire.bin"))});
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
