#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace tenon {

/// A page with the results of many runs: survival at each point with Wilson's interval, a heat map over two
/// keys, the distribution of each figure, rank correlations of keys and figures, parallel coordinates, a
/// scatter plot of any two columns, failures by cause, and the worst runs. The page is one file that needs no
/// network.
struct CampaignReport {
  /// A key with a few values, one factor of the product of points.
  struct Axis {
    std::string name;
    std::vector<std::string> labels;
  };
  struct Run {
    std::size_t index = 0;
    std::uint64_t seed = 0;
    std::vector<std::size_t> at = {};  ///< index of the label of each axis
    std::vector<double> drawn = {};    ///< value of each drawn key
    std::vector<double> figures = {};  ///< value of each figure; NaN without value
    bool survived = false;
    std::string reason = {};  ///< reason of a failure
  };
  /// A run to inspect.
  struct Pick {
    std::size_t index = 0;
    std::string why = {}, command = {};
    std::string link = {};  ///< link to the report of the run; may be empty
  };
  /// The result of a search for a limit at a point.
  struct Limit {
    std::string point = {};
    double survives = 0, fails = 0;
  };

  std::string title = {}, description = {};
  std::string command = {};  ///< repeats a run if "--replay INDEX" is added
  std::vector<Axis> axes = {};
  std::vector<std::string> drawn = {};    ///< keys with a different value for each seed
  std::vector<std::string> figures = {};  ///< names with units
  std::vector<Run> runs = {};
  double confidence = 0.95;
  std::string limit_key = {};
  std::vector<Limit> limits = {};
  std::vector<Pick> picks = {};

  /// Failures with one cause, whose reasons differ only in numbers.
  struct Cause {
    std::string text = {};
    std::size_t count = 0;
    std::vector<std::size_t> first = {};  ///< indices of up to five runs
  };
  std::vector<Cause> Causes() const;  ///< sorted by descending frequency

  /// Writes the page by WriteFile. Throws ParameterError for a run whose values do not match `axes`, `drawn`
  /// or `figures`, OutputError, and RunError if a library of the page is not installed.
  void Write(const std::filesystem::path& file) const;
};

}  // namespace tenon
