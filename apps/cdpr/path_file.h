#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

namespace tenon::apps {

/// The points of a path with their times.
struct PathTable {
  std::vector<double> times;               ///< [s]
  std::vector<Eigen::Vector3d> points;     ///< positions of the CoM in W [m]
  std::vector<Eigen::Vector3d> attitudes;  ///< roll, pitch, yaw [rad]; none, or one per point
};

/// Reads a path from a CSV file: a header, `t,x,y,z` or `t,x,y,z,roll,pitch,yaw`, then a row per point, in s,
/// m and rad. Throws ParameterError with file and line if the header has other columns, a row has too few or
/// too many values, a value is not a finite number, the times do not increase, or there are fewer than two
/// rows.
PathTable ReadPathFile(const std::string& file);

}  // namespace tenon::apps
