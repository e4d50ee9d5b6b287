#pragma once

#include <tenon/plants/signals/elevation_map.h>

#include <span>

namespace tenon {

/// Choice of footholds on an elevation map.
struct MapFootholdProperties {
  double radius = 0.05;      ///< radius of the ground around a foothold that should be flat [m]
  double roughness = 0.015;  ///< standard deviation of heights up to which ground counts as flat [m]
  double search = 0.12;      ///< largest displacement of a foothold along x and y [m]
  double clear = 0.08;       ///< least distance of a foothold from those of the other feet [m]

  static FieldList Fields() {
    return {Field("radius_m", &MapFootholdProperties::radius).Above(0).AtMost(0.2),
            Field("roughness_m", &MapFootholdProperties::roughness).AtLeast(0),
            Field("search_m", &MapFootholdProperties::search).Between(0, 0.5),
            Field("clear_m", &MapFootholdProperties::clear).Between(0, 0.5)};
  }
};

/// A place on the map, and the mean and standard deviation of the heights around it.
struct MapPlace {
  Eigen::Vector2d position;  ///< [m]
  double height = 0;         ///< [m]
  double deviation = 0;      ///< [m]
};

/// The square of cells that reaches at least `radius` beyond `position` on each side.
MapPlace Survey(const ElevationMap& map, const Eigen::Vector2d& position, double radius);

/// The place with the least sum of displacement from `wanted` and `edge_weight` times the deviation above
/// `roughness`. Places closer than `clear` to one in `taken` are excluded and, with a `level`, those whose
/// height differs by more than `climb`. If none is left, it is `wanted`.
MapPlace FlatPlace(const ElevationMap& map, const Eigen::Vector2d& wanted, const std::optional<double>& level,
                   const MapFootholdProperties& choice, std::span<const Vec<3>> taken = {},
                   double climb = 0.05 /* [m] */, double edge_weight = 10);

/// The greatest height along the line between two places [m].
double HighestBetween(const ElevationMap& map, const Eigen::Vector2d& from, const Eigen::Vector2d& to);

}  // namespace tenon
