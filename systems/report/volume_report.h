#pragma once

#include <tenon/systems/geometry.h>

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tenon {

/// What holds where in boxes of three coordinates, as a page to look at: a table of figures, the surface of
/// where it holds, in 3-D among shapes, and slices that can be moved, coloured by a quantity. One file that
/// needs no network.
struct VolumeReport {
  enum class State { kFails, kUndecided, kHolds };

  /// `size` cells from `first` on, all of one state.
  struct Part {
    std::array<int, 3> first{}, size{};
    State state = State::kFails;
    std::vector<double> values = {};  ///< of each quantity; NaN for none
  };
  struct Map {
    std::string title = {};
    std::array<std::string, 3> coordinates = {};  ///< names with units: "x_m"
    Vec<3> low = Vec<3>::Zero(), high = Vec<3>::Zero();
    std::array<int, 3> cells{1, 1, 1};
    std::vector<std::string> quantities = {};  ///< names with units; the first colours the page at first
    std::vector<Part> parts = {};              ///< do not overlap and fill the box
    Geometry shapes = {};                      ///< stand in the same coordinates
  };

  std::string title = {}, description = {};
  std::vector<std::pair<std::string, std::optional<double>>> figures = {};  ///< names with units
  std::vector<Map> maps = {};

  /// As a whole, see WriteFile. Throws ParameterError for a part with another number of values than there are
  /// quantities, OutputError, and RunError if a part of the page is not installed.
  void Write(const std::filesystem::path& file) const;
};

}  // namespace tenon
