#pragma once

#include <tenon/controllers/cdpr/cdpr_kinematics.h>

#include <Eigen/Core>

#include <utility>
#include <vector>

namespace tenon {

/// Clearance of the cables from one another and from the platform.
struct CableClearance {
  double cables = 0;  ///< the least distance between the axes of two cables [m]
  double platform =
      0;  ///< sine of the least angle at which a cable leaves the platform; negative: through it
};

/// Interference of straight cables with one another and with the platform (Perreault, Cardou, Gosselin, Otis,
/// J. Mechanisms Robotics 2(3), 2010).
///
/// The distance of two cables is the distance of their segments, which begin where the cables leave anchors
/// or pulleys. Pairs that share an anchor or an attachment are skipped. The platform is modelled as the solid
/// convex hull of its attachments and its CoM: a cable runs through it if its direction points below all
/// faces that meet at its attachment, and its sine is the largest n . lambda over these faces. Not modelled:
/// platforms that are open frames or wider than their attachments.
class CableInterference {
 public:
  explicit CableInterference(const CdprDescription& robot);

  /// Clearance at the pose of `cables`, computed for the same robot. Does not allocate.
  CableClearance At(const CableKinematics& cables, const Eigen::Matrix3d& R_WB) const;

  /// A lower bound of the distance between two cables while the CoM moves by up to `distance` [m] and every
  /// arm r by up to `chord` |r|. Points at the fractions s and t of two cables, counted from the anchors,
  /// come nearer by at most |s - t| distance + chord (s |arm_i| + t |arm_j|), evaluated piece by piece.
  /// Valid for cables without pulleys.
  double LeastDistance(const CableKinematics& cables, double distance, double chord) const;

 private:
  std::vector<std::pair<int, int>> pairs_;           // of cables that could touch
  std::vector<std::vector<Eigen::Vector3d>> faces_;  // of each cable: outer normals in B at its attachment
};

}  // namespace tenon
