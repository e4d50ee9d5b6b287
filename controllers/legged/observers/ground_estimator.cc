#include <tenon/controllers/legged/observers/ground_estimator.h>
#include <tenon/controllers/legged/observers/mapped_ground.h>
#include <tenon/systems/analysis/internal/small_matrices.h>

namespace tenon {
namespace {

constexpr double kAnyHeight = 1e3;  // standard deviation of the height before the first foothold [m]
constexpr int kPasses = 3;          // after three, the slope changes by less than 1e-6

Eigen::Matrix3d Unpacked(const Vec<6>& c) {
  Eigen::Matrix3d P;
  P << c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5];
  return P;
}

Vec<6> Packed(const Eigen::Matrix3d& P) {
  Vec<6> c;
  c << P(0, 0), P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2);
  return c;
}

/// Prediction and correction at a foothold; the plane's reference point moves there.
void Correct(const Vec<3>& foothold_W, const GroundBelief& belief, double roughness,
             GroundEstimator::Memory& memory) {
  GroundPlane& plane = memory.plane;
  const Eigen::Vector2d place = foothold_W.head<2>();
  Eigen::Matrix3d there = Eigen::Matrix3d::Identity();
  there.block<1, 2>(0, 1) = (place - plane.p_W.head<2>()).transpose();
  Eigen::Matrix3d P = there * Unpacked(memory.covariance) * there.transpose();
  P(0, 0) += belief.level_walk * belief.level_walk;
  P(1, 1) += belief.slope_walk * belief.slope_walk;
  P(2, 2) += belief.slope_walk * belief.slope_walk;
  plane.p_W[2] = plane.HeightAt(place);
  plane.p_W.head<2>() = place;

  const double innovation = foothold_W[2] - plane.p_W[2];
  const Eigen::Vector3d gain = P.col(0) / (P(0, 0) + roughness * roughness);
  plane.p_W[2] += gain[0] * innovation;
  plane.slope += gain.tail<2>() * innovation;
  P -= (gain * P.row(0)).eval();
  memory.covariance = Packed(P);
}

/// Corrects the plane at the feet that have landed since the last call, and sets the output.
void Measure(const QuadrupedDescription& robot, const LeggedState& state, const ContactSchedule& schedule,
             const GroundBelief& belief, GroundEstimator::Memory& memory) {
  const double roughness = memory.started ? belief.roughness : belief.start_roughness;
  if (!memory.started) {
    const double slope = belief.start_slope * belief.start_slope;
    memory.covariance << kAnyHeight * kAnyHeight, 0, 0, slope, 0, slope;
    memory.started = true;
  }
  const Eigen::Matrix3d R = state.R_WB();
  Vec<3> sum = Vec<3>::Zero();
  int count = 0;
  for (int i = 0; i < kNumLegs; ++i) {
    const bool stands = schedule.legs[i].stance();
    if (stands) {
      const Vec<3> contact =
          state.p_WB + R * robot.FootPosition(i, state.q) + memory.plane.ContactArm(robot.foot_radius);
      if (!memory.stood[i]) Correct(contact, belief, roughness, memory);
      sum += contact;
      ++count;
    }
    memory.stood[i] = stands;
  }
  if (count > 0) memory.told.p_W = sum / count;
  const double doubt = belief.doubt * belief.doubt * (memory.covariance[3] + memory.covariance[5]) / 2;
  const double square = memory.plane.slope.squaredNorm();
  memory.told.slope =
      square > doubt ? Vec<2>((1 - doubt / square) * memory.plane.slope) : Vec<2>(Vec<2>::Zero());
}

}  // namespace

GroundPlane GroundEstimator::CalcGround(const LeggedState& state, const ContactSchedule& schedule,
                                        const GroundBelief& belief, Memory& memory) const {
  const bool first = !memory.started;
  Measure(params.robot, state, schedule, belief, memory);
  // On a slope, the first footholds are measured anew: their contact points depend on the slope, and the
  // plane does not wander between feet that stand at the same time.
  if (first && !memory.told.slope.isZero(0)) {
    GroundBelief still = belief;
    still.level_walk = still.slope_walk = 0;
    for (int pass = 0; pass < kPasses; ++pass) {
      memory.started = false;
      memory.stood.fill(false);
      Measure(params.robot, state, schedule, still, memory);
    }
  }
  return memory.told;
}

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
