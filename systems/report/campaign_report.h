#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace tenon {

/// The results of many runs, as a page to look at: how many survived, with Wilson's interval, at each point
/// of what was varied; a heat map over two keys; the distribution of each figure; which key matters, by rank
/// correlation; parallel coordinates; failures by their causes; and the worst runs. One file that needs no
/// network.
struct CampaignReport {
  /// A key that took a few values, which multiplied the runs.
  struct Axis {
    std::string name;
    std::vector<std::string> labels;
  };
  struct Run {
    std::size_t index = 0;
    std::vector<std::size_t> at = {};  ///< of each axis, which label
    std::vector<double> drawn = {};    ///< of each drawn key
    std::vector<double> figures = {};  ///< of each figure; NaN for none
    bool survived = false;
    std::string reason = {};  ///< why not
  };
  /// A run that is worth a look.
  struct Pick {
    std::size_t index = 0;
    std::string why = {}, command = {};
    std::string link = {};  ///< to its own report; empty if there is none
  };
  /// What a search for a limit found, at a point.
  struct Limit {
    std::string point = {};
    double survives = 0, fails = 0;
  };

  std::string title = {}, description = {};
  std::vector<Axis> axes = {};
  std::vector<std::string> drawn = {};    ///< keys that took another value for each seed
  std::vector<std::string> figures = {};  ///< names with units
  std::vector<Run> runs = {};
  double confidence = 0.95;
  std::string limit_key = {};
  std::vector<Limit> limits = {};
  std::vector<Pick> picks = {};

  /// Failures with one cause: reasons that differ in numbers alone.
  struct Cause {
    std::string text = {};
    std::size_t count = 0;
    std::vector<std::size_t> first = {};  ///< runs, up to five
  };
  std::vector<Cause> Causes() const;  ///< the most frequent first

  /// As a whole, see WriteFile. Throws OutputError, and RunError if a part of the page is not installed.
  void Write(const std::filesystem::path& file) const;
};

}  // namespace tenon
