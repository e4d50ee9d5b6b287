#include <tenon/controllers/cdpr/cable_interference.h>
#include <tenon/controllers/optimization/infinity.h>
#include <tenon/plants/model/vectors.h>

#include <algorithm>

namespace tenon {
namespace {

constexpr int kPieces = 5;        // pieces of each cable in the lower bound of the distance
constexpr double kOnFace = 1e-9;  // tolerance of points in a face, relative to the platform

/// Outer normals of the faces of the convex hull of `points` that meet at points[at]: planes through it and
/// two other points with all points on one side. A flat platform has two faces.
std::vector<Eigen::Vector3d> FacesAt(const std::vector<Eigen::Vector3d>& points, std::size_t at) {
  double size = 0;
  for (const auto& point : points) size = std::max(size, (point - points[at]).norm());
  std::vector<Eigen::Vector3d> normals;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      Eigen::Vector3d normal = (points[i] - points[at]).cross(points[j] - points[at]);
      if (normal.norm() <= kOnFace * size * size) continue;
      normal.normalize();
      double low = 0, high = 0;
      for (const auto& point : points) {
        const double height = normal.dot(point - points[at]);
        low = std::min(low, height);
        high = std::max(high, height);
      }
      if (high <= kOnFace * size) normals.push_back(normal);
      if (low >= -kOnFace * size) normals.push_back(-normal);
    }
  }
  return normals;
}

}  // namespace

CableInterference::CableInterference(const CdprDescription& robot) {
  std::vector<Eigen::Vector3d> hull{Eigen::Vector3d::Zero()};
  for (const CableDescription& cable : robot.cables) hull.push_back(cable.attachment_B);
  if (const auto plane =
          robot.cables.empty() ? std::nullopt : PlaneOf(robot)) {  // as a flat platform would have no side
    for (std::size_t k = hull.size(); k-- > 0;)
      for (const double side : {-1, 1}) hull.push_back(hull[k] + side * Eigen::Vector3d::Unit(plane->normal));
  }
  for (int i = 0; i < robot.num_cables(); ++i) {
    faces_.push_back(FacesAt(hull, static_cast<std::size_t>(i) + 1));
    for (int j = i + 1; j < robot.num_cables(); ++j) {
      const CableDescription &a = robot.cables[i], &b = robot.cables[j];
      if (a.anchor_W != b.anchor_W && a.attachment_B != b.attachment_B) pairs_.emplace_back(i, j);
    }
  }
}

CableClearance CableInterference::At(const CableKinematics& cables, const Eigen::Matrix3d& R_WB) const {
  CableClearance clearance{kInfinity, 1};
  for (const auto& [i, j] : pairs_) {
    const double distance =
        SegmentDistance(cables.exit_W.col(i), -cables.free_length[i] * cables.direction.col(i),
                        cables.exit_W.col(j), -cables.free_length[j] * cables.direction.col(j));
    clearance.cables = std::min(clearance.cables, distance);
  }
  for (int i = 0; i < cables.num_cables(); ++i)
    clearance.platform = std::min(clearance.platform, PlatformSine(i, cables, R_WB));
  return clearance;
}

double CableInterference::PlatformSine(int cable, const CableKinematics& cables,
                                       const Eigen::Matrix3d& R_WB) const {
  const Eigen::Vector3d direction_B = R_WB.transpose() * cables.direction.col(cable);
  double sine = faces_[cable].empty() ? 1 : -1;  // an attachment inside the platform is on no face
  for (const Eigen::Vector3d& normal : faces_[cable]) sine = std::max(sine, normal.dot(direction_B));
  return sine;
}

double CableInterference::LeastDistance(const CableKinematics& cables, double distance, double chord) const {
  double least = kInfinity;
  for (const auto& [i, j] : pairs_) {
    const Eigen::Vector3d u = -cables.free_length[i] / kPieces * cables.direction.col(i);
    const Eigen::Vector3d v = -cables.free_length[j] / kPieces * cables.direction.col(j);
    const double arm_i = cables.arm_W.col(i).norm(), arm_j = cables.arm_W.col(j).norm();
    for (int a = 0; a < kPieces; ++a) {
      for (int b = 0; b < kPieces; ++b) {
        const double apart = (std::abs(a - b) + 1.0) / kPieces * distance;
        const double turned = chord * ((a + 1) * arm_i + (b + 1) * arm_j) / kPieces;
        least = std::min(
            least, SegmentDistance(cables.exit_W.col(i) + a * u, u, cables.exit_W.col(j) + b * v, v) - apart -
                       turned);
      }
    }
  }
  return least;
}

}  // namespace tenon
