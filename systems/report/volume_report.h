#pragma once

#include <tenon/systems/geometry.h>

#include <filesystem>

namespace tenon {

/// A page with maps of a three-dimensional space that is divided into boxes: a table of figures, the surface
/// of the region where a condition holds, in 3-D with shapes, and movable slices coloured by a quantity. The
/// page is one file that needs no network.
struct VolumeReport {
  enum class State { kFails, kUndecided, kHolds };

  /// A box of `size` cells beginning at cell `first`, all with the same state.
  struct Part {
    std::array<int, 3> first{}, size{};
    State state = State::kFails;
    std::vector<double> values = {};  ///< value of each quantity; NaN without value
  };
  struct Map {
    std::string title = {};
    std::array<std::string, 3> coordinates = {};  ///< names with units: "x_m"
    Vec<3> low = Vec<3>::Zero(), high = Vec<3>::Zero();
    std::array<int, 3> cells{1, 1, 1};
    std::vector<std::string> quantities =
        {};                        ///< names with units; the first one determines the initial colours
    std::vector<Part> parts = {};  ///< disjoint, and together the whole box
    Geometry shapes = {};          ///< shapes in the same coordinates
  };

  std::string title = {}, description = {};
  std::vector<std::pair<std::string, std::optional<double>>> figures = {};  ///< names with units
  std::vector<Map> maps = {};

  /// Writes the page by WriteFile. Throws ParameterError if the numbers of values and quantities differ,
  /// OutputError, and RunError if a library of the page is not installed.
  void Write(const std::filesystem::path& file) const;
};

}  // namespace tenon
