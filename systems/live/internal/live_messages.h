#pragma once

#include <tenon/systems/live/live_server.h>
#include <tenon/systems/report/internal/report_json.h>

namespace tenon::internal {

using Json = nlohmann::ordered_json;

/// Returns the data of the page for report.js: a report without samples, and the token of the run.
std::string PageData(const LiveView& view, const std::string& token);

/// Returns the description of the run, which a page needs before the samples.
Json Hello(const LiveView& view, const Geometry& shapes, Context& context,
           const std::vector<const ParameterSource*>& parameters, double history);

/// Returns the Parameters that consist of a fixed number of numbers.
std::vector<const ParameterSource*> Tunable(const Diagram& diagram);

/// Returns the value of a Parameter as a number or a list of numbers.
Json ParameterValue(const ParameterSource& parameter, Context& context);

/// Returns median and 99 % quantile of times in us, and how many are below each of several limits.
Json TimesJson(const TimeQuantiles& times);

/// Collects the rows of a log between two messages.
class LiveRows final : public LogSink {
 public:
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override;
  void Row(std::span<const double> row) override;
  /// While this is set, rows are skipped because they were already sent.
  bool muted = false;
  void Clear() { data_.clear(); }
  bool empty() const { return data_.empty(); }
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<std::string>& units() const { return units_; }

  /// Removes the rows and returns them as "time":[…],"KEY":[[…],…] with a list for each column. With
  /// `constants`, a constant column is a single number.
  std::string Take(const char* key, bool constants);

 private:
  std::vector<std::string> names_, units_;
  std::vector<double> data_;
};

}  // namespace tenon::internal
