#include <tenon/controllers/guide_dog/admittance_filter.h>
#include <tenon/controllers/guide_dog/reference_admittance.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/systems/analysis/matrix_functions.h>

#include <Eigen/Geometry>
#include <fmt/core.h>

namespace tenon {

void AdmittanceGains::Validate() const {
  Demand(max_forward > min_forward,
         fmt::format("max_forward_m_per_s = {} must be above min_forward_m_per_s = {}", max_forward,
                     min_forward));
  Demand(yield_tension == 0 || yield_tension > desired_tension,
         fmt::format("yield_tension_N = {} must be 0 or above desired_tension_N = {}", yield_tension,
                     desired_tension));
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

AdmittanceFilter::Memory AdmittanceFilter::CalcProgress(const WalkCommand& command,
                                                        const WrenchEstimate& wrench,
                                                        const LeggedState& state,
                                                        const AdmittanceGains& gains, const Steps& steps,
                                                        Memory& memory) const {
  const Eigen::Vector2d heading = state.R_WB().col(0).head<2>().normalized();
  const Eigen::Vector2d to_left(-heading[1], heading[0]);
  const Eigen::Vector2d force_W = wrench.force_W.head<2>();
  const Eigen::Vector2d force(heading.dot(force_W), to_left.dot(force_W));
  const Eigen::Vector2d ahead(gains.desired_tension, 0);

  AdmittanceMotion next;
  next.direction = ahead == force ? Eigen::Vector2d(1, 0) : (ahead - force).normalized();
  next.tension = -force.dot(next.direction);
  const bool commanded = command.gait != Gait::kStand;
  if (commanded) memory.gait = command.gait;
  const double bearable =
      memory.yields ? (gains.desired_tension + gains.yield_tension) / 2 : gains.yield_tension;
  memory.yields =
      !commanded && memory.gait != Gait::kStand && gains.yield_tension > 0 && -force[0] > bearable;
  if (!commanded) memory.adaptation = 0;
  next.walks = commanded || memory.yields;
  if (!next.walks) {
    memory.motion = next;
    return memory;
  }

  const AdmittanceMotion& last = memory.motion;
  const Eigen::Vector2d drive = (gains.desired_tension - next.tension) * next.direction;
  const Eigen::Vector2d asked =
      commanded ? Eigen::Vector2d(command.forward, command.left) : Eigen::Vector2d(0, 0);
  const Eigen::Vector2d nominal = asked + Eigen::Vector2d(memory.adaptation, 0);
  const Eigen::Vector3d along = steps.along * Eigen::Vector3d(0, last.correction[0], drive[0]);
  const Eigen::Vector3d across = steps.across * Eigen::Vector3d(last.offset, last.correction[1], drive[1]);
  const Eigen::Vector2d wanted = nominal + Eigen::Vector2d(along[1], across[1]);

  const Eigen::Vector2d lowest(commanded ? gains.min_forward : -gains.max_backward, -gains.max_left);
  const Eigen::Vector2d highest(commanded ? gains.max_forward : 0, gains.max_left);
  const double period = params.rate.period();
  const Eigen::Array2d change = Eigen::Array2d::Constant(gains.acceleration * period);
  const Eigen::Array2d inside =
      wanted.array().max(lowest.cwiseMin(asked).array()).min(highest.cwiseMax(asked).array());
  next.velocity = inside.max(last.velocity.array() - change).min(last.velocity.array() + change);
  next.correction = next.velocity - nominal;
  next.offset = next.velocity[1] == wanted[1] ? across[0] : last.offset + period * next.correction[1];
  if (commanded && next.velocity[0] == wanted[0])
    memory.adaptation += period * gains.adaptation_rate * drive[0] / gains.damping;
  memory.motion = next;
  return memory;
}

WalkCommand AdmittanceFilter::CalcWalk(const WalkCommand& command, const Memory& progress) const {
  WalkCommand walk = command;
  if (progress.yields) walk.gait = progress.gait;
  walk.forward = progress.motion.velocity[0];
  walk.left = progress.motion.velocity[1];
  return walk;
}

namespace {

Eigen::Matrix3d HeadingOf(const BodyReference& body) {
  const double yaw = EulerFromRotation(RotationFromQuaternion(body.q_WB))[2];
  return Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

}  // namespace

Vec<6> ReferenceAdmittance::CalcRate(const Vec<6>& x, const BodyReference& body, const WrenchEstimate& wrench,
                                     const ReferenceAdmittanceGains& gains) const {
  const Eigen::Array3d force = (gains.desired_force + HeadingOf(body).transpose() * wrench.force_W).array();
  Vec<6> rate;
  rate << x.tail<3>(),
      ((force - gains.damping.array() * x.tail<3>().array() - gains.stiffness.array() * x.head<3>().array()) /
       gains.mass.array())
          .matrix();
  return rate;
}

BodyReference ReferenceAdmittance::CalcModified(const Vec<6>& x, const BodyReference& body,
                                                const WrenchEstimate& wrench,
                                                const ReferenceAdmittanceGains& gains) const {
  const Eigen::Matrix3d R = HeadingOf(body);
  BodyReference modified = body;
  modified.com_W += R * x.head<3>();
  modified.com_velocity_W += R * x.tail<3>();
  modified.com_acceleration_W += R * CalcRate(x, body, wrench, gains).tail<3>();
  return modified;  // neglects the rate of the heading
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::AdmittanceMotion);
