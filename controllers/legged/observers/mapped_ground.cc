#include <tenon/controllers/legged/observers/mapped_ground.h>
#include <tenon/systems/analysis/internal/small_matrices.h>

namespace tenon {

GroundPlane MappedGround::CalcGround(const ElevationMap& map, const LeggedState& state) const {
  const Eigen::Matrix3d R = state.R_WB();
  const Eigen::Vector2d ahead = R.col(0).head<2>().normalized(), left(-ahead[1], ahead[0]);
  const Eigen::Vector2d centre = state.p_WB.head<2>() + R.topLeftCorner<2, 2>() * stance_.center_B;
  GroundPlane ground;
  ground.p_W << centre, 0;
  if (!map.known()) return ground;
  Eigen::Vector2d half = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& foot : stance_.foot) half = half.cwiseMax(foot.cwiseAbs());
  half.array() += params.margin;
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  Eigen::Vector3d heights = Eigen::Vector3d::Zero();
  const double around = half.norm();
  for (int j = map.Index(1, centre[1] - around); j <= map.Index(1, centre[1] + around); ++j) {
    for (int i = map.Index(0, centre[0] - around); i <= map.Index(0, centre[0] + around); ++i) {
      const Eigen::Vector2d arm = map.first_W + map.cell * Eigen::Vector2d(i, j) - centre;
      if (std::abs(ahead.dot(arm)) > half[0] || std::abs(left.dot(arm)) > half[1]) continue;
      const Eigen::Vector3d row(1, arm[0], arm[1]);
      squares += row * row.transpose();
      heights += map.At(i, j) * row;
    }
  }
  if (squares(0, 0) < 3) return ground;
  const Eigen::Vector3d plane = internal::SolveLdlt<3>(squares, heights);
  ground.p_W[2] = plane[0];
  ground.slope = plane.tail<2>();
  return ground;
}

}  // namespace tenon
