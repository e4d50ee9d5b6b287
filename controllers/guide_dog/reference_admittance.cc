#include <tenon/controllers/guide_dog/reference_admittance.h>
#include <tenon/plants/signals/euler.h>

#include <Eigen/Geometry>

namespace tenon {
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
