#pragma once

#include <tenon/controllers/cdpr/cdpr_kinematics.h>

namespace tenon {

/// Clearance of the cables from one another and from the platform.
struct CableClearance {
  double cables = 0;    ///< smallest distance between the axes of two cables [m]
  double platform = 0;  ///< sine of the smallest angle between a cable and the platform; negative: through it
};

/// Interference of straight cables with one another and with the platform (Perreault, Cardou, Gosselin, Otis,
/// J. Mechanisms Robotics 2(3), 2010).
///
/// The distance between two cables is that of their straight segments, which begin at the anchors or where
/// the cables leave the pulleys. Pairs that share an anchor or an attachment are skipped. The platform is
/// modelled as the solid convex hull of its attachments and its CoM, which is thick if the robot is
/// planar. A cable runs through it if the cable's
/// direction lambda points below all faces that meet at its attachment; the sine of its angle to the platform
/// is the largest n . lambda over the normals n of these faces. Not modelled: platforms that are open frames
/// or wider than their attachments.
class CableInterference {
 public:
  explicit CableInterference(const CdprDescription& robot);

  /// Computes the clearance at the pose of `cables`, which must belong to the same robot. Does not allocate.
  CableClearance At(const CableKinematics& cables, const Eigen::Matrix3d& R_WB) const;
  /// Sine of the angle between one cable and the platform; negative: through it.
  double PlatformSine(int cable, const CableKinematics& cables, const Eigen::Matrix3d& R_WB) const;

  /// Returns a lower bound of the distance between two cables while the CoM moves by up to `distance` [m] and
  /// each arm r changes by up to `chord` |r|. The distance between the points at the fractions s and t of
  /// cables i and j, counted from the anchors, decreases by at most |s - t| distance + chord (s |arm_i| + t
  /// |arm_j|); the bound is evaluated piece by piece. Valid for cables without pulleys.
  double LeastDistance(const CableKinematics& cables, double distance, double chord) const;

 private:
  std::vector<std::pair<int, int>> pairs_;           // pairs of cables that could touch
  std::vector<std::vector<Eigen::Vector3d>> faces_;  // outer normals in B at each cable's attachment
};

}  // namespace tenon
