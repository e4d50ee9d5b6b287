#pragma once

#include <tenon/systems/live/live_server.h>

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace tenon::internal {

using Json = nlohmann::ordered_json;

/// JSON as text, whatever bytes the strings hold.
std::string Dump(const Json& json);

/// The data of the page, as report.js reads them: a report without samples, and how to reach the run.
std::string PageData(const LiveView& view, const std::string& token);

/// What a page needs to know before samples come.
Json Hello(const LiveView& view, const Geometry& shapes, Context& context,
           const std::vector<const ParameterSource*>& parameters, double history);

/// Those that can be set as numbers, of a size that does not change.
std::vector<const ParameterSource*> Tunable(const Diagram& diagram);

/// The value of a Parameter: a number, or a list of them.
Json ParameterValue(const ParameterSource& parameter, Context& context);

/// Rows of a log between two messages.
class LiveRows final : public LogSink {
 public:
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override;
  void Row(std::span<const double> row) override;
  /// Rows are left away while this is set: they have been sent before.
  bool muted = false;
  void Clear() { data_.clear(); }
  bool empty() const { return data_.empty(); }
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<std::string>& units() const { return units_; }

  /// "time":[…],"KEY":[[…],…]: a list for each column. One that stays the same is one number, if `constants`.
  /// Empties itself.
  std::string Take(const char* key, bool constants);

 private:
  std::vector<std::string> names_, units_;
  std::vector<double> data_;
};

}  // namespace tenon::internal
