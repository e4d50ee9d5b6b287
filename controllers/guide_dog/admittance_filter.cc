#include <tenon/controllers/guide_dog/admittance_filter.h>
#include <tenon/systems/analysis/matrix_functions.h>

#include <fmt/core.h>

#include <algorithm>

namespace tenon {

void AdmittanceGains::Validate() const {
  Demand(max_forward > min_forward,
         fmt::format("max_forward_m_per_s = {} must be above min_forward_m_per_s = {}", max_forward,
                     min_forward));
}

AdmittanceFilter::Steps AdmittanceFilter::CalcSteps(const AdmittanceGains& gains) const {
  const auto step = [&](double stiffness) -> Eigen::Matrix3d {
    Eigen::Matrix3d rates;
    rates << 0, 1, 0,                                                          //
        -stiffness / gains.mass, -gains.damping / gains.mass, 1 / gains.mass,  //
        0, 0, 0;
    return Exponential(params.rate.period() * rates);
  };
  return {step(0), step(gains.stiffness)};
}

AdmittanceMotion AdmittanceFilter::CalcMotion(const WalkCommand& command, const WrenchEstimate& wrench,
                                              const LeggedState& state, const AdmittanceGains& gains,
                                              const Steps& steps, AdmittanceMotion& memory) const {
  const Eigen::Vector2d heading = state.R_WB().col(0).head<2>().normalized();
  const Eigen::Vector2d to_left(-heading[1], heading[0]);
  const Eigen::Vector2d force_W = wrench.force_W.head<2>();
  const Eigen::Vector2d force(heading.dot(force_W), to_left.dot(force_W));
  const Eigen::Vector2d ahead(gains.desired_tension, 0);

  AdmittanceMotion next;
  next.direction = ahead == force ? Eigen::Vector2d(1, 0) : (ahead - force).normalized();
  next.tension = -force.dot(next.direction);
  next.walks = command.gait != Gait::kStand;
  if (!next.walks) return memory = next;

  const Eigen::Vector2d drive = (gains.desired_tension - next.tension) * next.direction;
  const Eigen::Vector2d nominal(command.forward, command.left);
  const Eigen::Vector3d along = steps.along * Eigen::Vector3d(0, memory.correction[0], drive[0]);
  const Eigen::Vector3d across =
      steps.across * Eigen::Vector3d(memory.offset, memory.correction[1], drive[1]);
  const Eigen::Vector2d wanted = nominal + Eigen::Vector2d(along[1], across[1]);

  const Eigen::Vector2d lowest(gains.min_forward, -gains.max_left);
  const Eigen::Vector2d highest(gains.max_forward, gains.max_left);
  const double period = params.rate.period();
  const Eigen::Array2d change = Eigen::Array2d::Constant(gains.acceleration * period);
  const Eigen::Array2d inside =
      wanted.array().max(lowest.cwiseMin(nominal).array()).min(highest.cwiseMax(nominal).array());
  next.velocity = inside.max(memory.velocity.array() - change).min(memory.velocity.array() + change);
  next.correction = next.velocity - nominal;
  next.offset = next.velocity[1] == wanted[1] ? across[0] : memory.offset + period * next.correction[1];
  return memory = next;
}

WalkCommand AdmittanceFilter::CalcWalk(const WalkCommand& command, const AdmittanceMotion& motion) const {
  WalkCommand walk = command;
  walk.forward = motion.velocity[0];
  walk.left = motion.velocity[1];
  return walk;
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::AdmittanceMotion);
