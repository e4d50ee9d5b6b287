#pragma once

#include <tenon/controllers/cdpr/cdpr_kinematics.h>

namespace tenon {

/// A distance at a pose of the platform and its gradient, which is 0 where two axes meet.
struct PoseDistance {
  double value = 0;                                       ///< [m]
  double kept = 0;                                        ///< distance that is kept [m]
  Eigen::Vector3d by_position = Eigen::Vector3d::Zero();  ///< by the position of the CoM
  Eigen::Vector3d by_turn = Eigen::Vector3d::Zero();  ///< by a rotation vector in W, see CalcWrenchJacobian()
};

/// Distances that a cable robot keeps: the platform, as its PlatformBox(), and its straight cables from the
/// surfaces of the robot's obstacles, and the axes of cables from one another. Cables that are nearer to one
/// another at the start are assumed to be guided past each other, like the crossed cables of cdpr_8, or to
/// share an end, and keep no distance.
class CdprClearance {
 public:
  /// Keeps no distance.
  CdprClearance() = default;
  /// Without a value, the distance from obstacles or between cables is not kept [m]. `start` are the cables
  /// at the start.
  CdprClearance(const CdprDescription& robot, std::optional<double> from_obstacles,
                std::optional<double> between_cables, const CableKinematics& start);

  int size() const { return size_; }

  /// Calls visit(a, b, distance) `size` times: for each obstacle with the platform (a = b = -1) and each
  /// cable a (b = -1), then for each pair of cables. exit_W(i) is where cable i leaves its pulley, or its
  /// anchor; exits that move with the platform do not enter the gradient.
  template <class Exit, class Visit>
  void ForEach(const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB, const Exit& exit_W,
               const Visit& visit) const {
    const auto span = [&](int cable) {
      const Eigen::Vector3d arm_W = R_WB * attachments_B_[cable];
      return Span{exit_W(cable), p_WB + arm_W, arm_W};
    };
    for (const ObstacleDescription& obstacle : obstacles_) {
      visit(-1, -1, FromPlatform(p_WB, R_WB, obstacle));
      for (int i = 0; i < static_cast<int>(attachments_B_.size()); ++i)
        visit(i, -1, FromCable(span(i), obstacle));
    }
    for (const auto& [i, j] : pairs_) visit(i, j, Between(span(i), span(j), between_cables_));
  }

 private:
  // A cable from its exit to its attachment, `arm_W` from the CoM, or the axis of an obstacle.
  struct Span {
    Eigen::Vector3d from_W, to_W, arm_W = Eigen::Vector3d::Zero();
  };
  static PoseDistance Between(const Span& a, const Span& b, double kept, bool b_moves = true);
  PoseDistance FromCable(const Span& cable, const ObstacleDescription& obstacle) const;
  PoseDistance FromPlatform(const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB,
                            const ObstacleDescription& obstacle) const;

  int size_ = 0;
  double from_obstacles_ = 0, between_cables_ = 0;
  Eigen::Vector3d box_ = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> attachments_B_;
  std::vector<ObstacleDescription> obstacles_;
  std::vector<std::pair<int, int>> pairs_;
};

}  // namespace tenon
