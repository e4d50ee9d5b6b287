#pragma once

#include <tenon/systems/report/internal/run_log.h>

#include <nlohmann/json.hpp>

namespace tenon {

/// The data of one run and their conversion to a page. Reports that show the run share this object.
struct Report::Run {
  using Json = nlohmann::ordered_json;
  struct Figure {
    std::string name;
    Json value;
    Limits limits{};
  };

  std::vector<std::string> event_signals;
  std::vector<Band> bands;
  std::vector<SignalLimits> limits;
  std::shared_ptr<internal::ColumnLog> signals, frames;
  std::shared_ptr<Geometry> shapes = std::make_shared<Geometry>();
  std::vector<Figure> figures;
  std::vector<std::pair<double, std::string>> events;
  std::optional<bool> good;
  std::string verdict;

  /// Makes one plot for adjacent columns with the same unit, titled by the common beginning of their names.
  std::vector<Plot> DefaultPlots() const;
  /// Converts the run to the data of a page with `num_runs` runs. Signals in `plots` have a finer resolution.
  Json ToJson(const std::vector<Plot>& plots, std::size_t num_runs) const;
  /// Returns an upper estimate of the size of these data [bytes].
  std::size_t JsonBytes() const;
  /// Reads the data of ToJson, without the signals.
  static Run FromJson(const Json& json);

 private:
  Json Samples(const std::vector<Plot>& plots, std::size_t num_runs) const;
  Json Frames(std::size_t max_bytes) const;
  Json Events() const;
};

}  // namespace tenon
