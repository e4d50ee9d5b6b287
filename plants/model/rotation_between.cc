#include <tenon/plants/model/rotation_between.h>

#include <Eigen/SVD>

namespace tenon {

Eigen::Quaterniond RotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to);
}

}  // namespace tenon
