#include <tenon/controllers/cdpr/reference_balancer.h>
#include <tenon/plants/signals/euler.h>

namespace tenon {

CdprReference ReferenceBalancer::Empty(int num_cables) {
  CdprReference reference;
  reference.length = reference.length_rate = reference.tension = CableVector::Zero(num_cables);
  return reference;
}

void ReferenceBalancer::CalcBalanced(double time, const CdprReference& reference, const LoadEstimate& load,
                                     const CableVector& broken, ReferenceShift& shift,
                                     BalancedReference& work, CdprReference* balanced) const {
  CheckNumCables(params.robot.num_cables(), reference.tension.size(), "ReferenceBalancer");
  if (broken.size() > 0) CheckNumCables(params.robot.num_cables(), broken.size(), "ReferenceBalancer");
  work.Calc(reference, load, broken, shift, time);
  *balanced = reference;
  balanced->euler = work.euler();
  balanced->tension = work.tension();
  params.robot.LimitTension(&balanced->tension);
  const Eigen::Matrix3d R_WB = RotationFromEuler(work.euler());
  const Eigen::Vector3d w_W = EulerRateMatrix(reference.euler) * reference.euler_rate;
  for (int i = 0; i < params.robot.num_cables(); ++i) {
    const CableLine cable = CalcCableLine(params.robot, i, reference.position, R_WB, anchors, time);
    balanced->length[i] = cable.length;
    balanced->length_rate[i] =
        -cable.wrench.head<3>().dot(reference.velocity) - cable.wrench.tail<3>().dot(w_W);
    if (anchors.any()) balanced->length_rate[i] += cable.anchor_rate;
  }
}

}  // namespace tenon
