#include <tenon/controllers/legged/planning/nominal_stance.h>
#include <tenon/plants/model/quadruped_model.h>

#include <fmt/core.h>

namespace tenon {
namespace {

constexpr double kFullestExtension = 0.95;  // fraction of the leg's length at which J_leg is still regular
constexpr double kWithinRange = 0.98;       // fraction of the extension at the end of the knee's range

}  // namespace

NominalStance::NominalStance(const QuadrupedDescription& robot) {
  LeggedState x;
  x.q = robot.stance;
  QuadrupedDynamics dynamics;
  QuadrupedModel(robot).Calc(x, &dynamics);
  com_B = dynamics.com_W;
  inertia_B = dynamics.centroidal_inertia_W;
  com_height = robot.StanceHeight() + com_B[2];
  center_B.setZero();
  for (const auto& f : dynamics.feet) center_B += f.p_W.head<2>() / kNumLegs;
  for (int i = 0; i < kNumLegs; ++i) {
    const Eigen::Vector3d p_foot = dynamics.feet[i].p_W;
    foot[i] = p_foot.head<2>() - center_B;
    // The leg turns about its second joint, so height and horizontal reach are bounded by its length.
    const double length = robot.LegLength(i);
    const Eigen::Vector3d leg = p_foot - robot.HipPosition(i, robot.stance);
    longest[i] = std::min(kFullestExtension * length, kWithinRange * robot.LongestExtension(i));
    const double horizontal = longest[i] * longest[i] - leg[2] * leg[2];
    reach[i] = horizontal > 0 ? std::sqrt(horizontal) - leg.head<2>().norm() : 0;
    if (reach[i] <= 0) {
      throw ParameterError(
          fmt::format("the {} leg of '{}' cannot step: in the nominal stance it is stretched to {:.3f} m of "
                      "{:.3f} m; bend the knees of nominal_stance",
                      kLegNames[i], robot.name, leg.norm(), length));
    }
  }
}

}  // namespace tenon
