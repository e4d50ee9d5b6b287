#include <tenon/systems/report/internal/run_log.h>

namespace tenon {

namespace {

constexpr std::string_view kNorm = "norm:", kRate = "rate:", kPath = "xy:";

}  // namespace

std::string_view LoggedName(std::string_view name) {
  for (const std::string_view prefix : {kNorm, kRate, kPath})
    if (name.starts_with(prefix)) return name.substr(prefix.size());
  return name;
}

namespace internal {

bool IsPath(std::string_view name) {
  return name.starts_with(kPath);
}

namespace {

std::string RateUnit(const std::string& unit) {
  if (unit.ends_with("/s")) return unit + "^2";
  if (unit.ends_with("/s^2")) return unit.substr(0, unit.size() - 1) + "3";
  return unit.empty() ? "1/s" : unit + "/s";
}

class DerivedLog final : public LogSink {
 public:
  DerivedLog(std::vector<std::string> derived, std::shared_ptr<LogSink> sink)
      : derived_(std::move(derived)), sink_(std::move(sink)) {}

  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override {
    std::vector<std::string> all = names, all_units = units;
    columns_.clear();
    const auto add = [&](std::string name, std::string unit, std::vector<std::size_t> from, bool rate) {
      if (std::ranges::count(all, name) > 0) return;
      columns_.push_back({std::move(from), rate});
      all.push_back(std::move(name));
      all_units.push_back(std::move(unit));
    };
    for (const std::string& name : derived_) {
      const std::vector<std::size_t> from = FindColumns(names, std::string(LoggedName(name)));
      if (name.starts_with(kNorm) && !from.empty()) add(name, units[from.front()], from, false);
      if (!name.starts_with(kRate)) continue;
      for (const std::size_t column : from)
        add(std::string(kRate) + names[column], RateUnit(units[column]), {column}, true);
    }
    last_.clear();
    row_.reserve(all.size());
    last_.reserve(names.size());
    sink_->Begin(all, all_units);
  }

  void Row(std::span<const double> row) override {
    row_.assign(row.begin(), row.end());
    for (const Column& column : columns_) {
      double value = 0;
      if (column.rate) {
        const std::size_t i = column.from.front();
        value = last_.empty() ? std::numeric_limits<double>::quiet_NaN()
                              : (row[i] - last_[i]) / (row[0] - last_[0]);
      } else {
        for (const std::size_t i : column.from) value = std::hypot(value, row[i]);
      }
      row_.push_back(value);
    }
    last_.assign(row.begin(), row.end());
    sink_->Row(row_);
  }

  void Flush() override { sink_->Flush(); }
  void DropFrom(double time, bool after) override {
    last_.clear();
    sink_->DropFrom(time, after);
  }

 private:
  struct Column {
    std::vector<std::size_t> from;
    bool rate;
  };
  std::vector<std::string> derived_;
  std::shared_ptr<LogSink> sink_;
  std::vector<Column> columns_;
  std::vector<double> row_, last_;
};

}  // namespace

std::shared_ptr<LogSink> WithDerived(const std::vector<Plot>& plots, std::shared_ptr<LogSink> sink) {
  std::vector<std::string> derived;
  for (const Plot& plot : plots)
    for (const auto* names : {&plot.signals, &plot.references})
      for (const std::string& name : *names)
        if ((name.starts_with(kNorm) || name.starts_with(kRate)) && std::ranges::count(derived, name) == 0)
          derived.push_back(name);
  if (derived.empty()) return sink;
  return std::make_shared<DerivedLog>(std::move(derived), std::move(sink));
}

}  // namespace internal
}  // namespace tenon
