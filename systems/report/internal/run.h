#pragma once

#include <tenon/systems/report/internal/run_log.h>
#include <tenon/systems/report/report.h>

#include <nlohmann/json.hpp>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tenon {

/// What is gathered of one run, and how it is put into a page. Shared by the reports that show it.
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

  /// One plot for neighbouring columns of one unit, called by what their names begin with.
  std::vector<Plot> DefaultPlots() const;
  /// As a page holds it, beside `num_runs - 1` others. What `plots` show is kept finer than the rest.
  Json ToJson(const std::vector<Plot>& plots, std::size_t num_runs) const;
  /// About what that takes [bytes], at most.
  std::size_t JsonBytes() const;
  /// What ToJson made, without the signals.
  static Run FromJson(const Json& json);

 private:
  Json Samples(const std::vector<Plot>& plots, std::size_t num_runs) const;
  Json Frames(std::size_t max_bytes) const;
  Json Events() const;
};

}  // namespace tenon
