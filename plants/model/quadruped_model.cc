#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/model/vectors.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/systems/analysis/internal/small_matrices.h>

#include <fmt/core.h>

#include <algorithm>
#include <numbers>

namespace tenon {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// PointInertia by entries, faster in the inner loop and equal up to rounding.
Matrix3d FastPointInertia(double mass, const Vector3d& c) {
  const Vector3d mc = mass * c;
  Matrix3d J;
  J(0, 0) = mc[1] * c[1] + mc[2] * c[2];
  J(1, 1) = mc[0] * c[0] + mc[2] * c[2];
  J(2, 2) = mc[0] * c[0] + mc[1] * c[1];
  J(0, 1) = J(1, 0) = -mc[0] * c[1];
  J(0, 2) = J(2, 0) = -mc[0] * c[2];
  J(1, 2) = J(2, 1) = -mc[1] * c[2];
  return J;
}

/// Pose, velocity, and acceleration at nu' = 0 of a body.
struct Frame {
  Matrix3d R;
  Vector3d p;         // position of its origin, relative to B's origin
  Vector3d w, v;      // angular velocity; velocity of its origin
  Vector3d alpha, a;  // angular acceleration; acceleration of its origin

  Vector3d Velocity(const Vector3d& arm) const { return v + w.cross(arm); }
  Vector3d Acceleration(const Vector3d& arm) const { return a + alpha.cross(arm) + w.cross(w.cross(arm)); }
};

/// Sums over a body and all bodies that it carries, about B's origin, in W.
struct Composite {
  double mass = 0;
  Vector3d moment = Vector3d::Zero();  // mass times CoM
  Matrix3d inertia = Matrix3d::Zero();
  Vector3d linear = Vector3d::Zero(), angular = Vector3d::Zero();  // momentum
  Vector3d force = Vector3d::Zero(), torque = Vector3d::Zero();    // rate of momentum at nu' = 0

  void Add(const Frame& frame, double body_mass, const Vector3d& com, const Matrix3d& body_inertia) {
    const Vector3d arm = frame.R * com;
    const Vector3d c = frame.p + arm;
    const Matrix3d I = frame.R * body_inertia * frame.R.transpose();
    const Vector3d k = I * frame.w;
    const Vector3d l = body_mass * frame.Velocity(arm);
    const Vector3d f = body_mass * frame.Acceleration(arm);
    mass += body_mass;
    moment += body_mass * c;
    inertia += I + FastPointInertia(body_mass, c);
    linear += l;
    angular += k + c.cross(l);
    force += f;
    torque += I * frame.alpha + frame.w.cross(k) + c.cross(f);
  }
  void Add(const Composite& other) {
    mass += other.mass;
    moment += other.moment;
    inertia += other.inertia;
    linear += other.linear;
    angular += other.angular;
    force += other.force;
    torque += other.torque;
  }
};

}  // namespace

DynamicsMatrix<3, 18> QuadrupedDynamics::FootJacobian(int leg) const {
  const Foot& own = foot(leg);
  DynamicsMatrix<3, 18> J = DynamicsMatrix<3, 18>::Zero();
  J.leftCols<3>().setIdentity();
  J.middleCols<3>(3) = -CrossMatrix(own.p_W - base_W);
  J.middleCols<3>(6 + kJointsPerLeg * leg) = own.J_leg;
  return J;
}

Eigen::Matrix3d QuadrupedDynamics::LegJacobian(int leg, const Eigen::Vector3d& p_W) const {
  Matrix3d J;
  for (int i = 0; i < kJointsPerLeg; ++i) {
    const int j = kJointsPerLeg * leg + i;
    J.col(i) = axis_W[j].cross(p_W - origin_W[j]);
  }
  return J;
}

QuadrupedDynamics::Foot QuadrupedDynamics::Contact(int leg, const Eigen::Vector3d& arm_W) const {
  Foot contact = foot(leg);
  contact.p_W += arm_W;
  contact.v_W += contact.w_W.cross(arm_W);
  contact.bias += contact.turn_bias.cross(arm_W);
  contact.J_leg = LegJacobian(leg, contact.p_W);
  return contact;
}

QuadrupedModel::QuadrupedModel(const QuadrupedDescription& robot, double gravity)
    : trunk_{Vector3d::Zero(), Vector3d::Zero(), robot.trunk.com, robot.trunk.inertia, robot.trunk.mass},
      rotor_inertia_(robot.drive.rotor_inertia),
      mass_(robot.mass()),
      gravity_(gravity) {
  for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
    for (std::size_t i = 0; i < kJointsPerLeg; ++i) {
      const JointDescription& joint = robot.legs[leg].joints[i];
      const RigidInertia& body = robot.legs[leg].bodies[i];
      bodies_[kJointsPerLeg * leg + i] = {joint.p_PJ, joint.axis, body.com, body.inertia, body.mass};
    }
    feet_[leg] = robot.legs[leg].foot_J;
  }
}

void QuadrupedModel::Calc(const LeggedState& x, QuadrupedDynamics* out) const {
  const Frame base{x.R_WB(), Vector3d::Zero(), x.w_W, x.v_W, Vector3d::Zero(), Vector3d::Zero()};
  Composite robot;
  robot.Add(base, trunk_.mass, trunk_.com, trunk_.inertia);
  out->base_W = x.p_WB;
  out->M.setZero();

  for (int leg = 0; leg < kNumLegs; ++leg) {
    std::array<Frame, kJointsPerLeg> frames;
    std::array<Vector3d, kJointsPerLeg> axis, spin;  // motion vectors (angular, linear) about B's origin
    const Frame* parent = &base;
    for (int i = 0; i < kJointsPerLeg; ++i) {
      const int j = kJointsPerLeg * leg + i;
      const Body& body = bodies_[j];
      Frame& frame = frames[i];
      const Vector3d arm = parent->R * body.p_PJ;
      const Vector3d a = parent->R * body.axis;
      frame.R = parent->R * Eigen::AngleAxisd(x.q[j], body.axis).toRotationMatrix();
      frame.p = parent->p + arm;
      frame.v = parent->Velocity(arm);
      frame.a = parent->Acceleration(arm);
      frame.w = parent->w + x.qd[j] * a;
      frame.alpha = parent->alpha + x.qd[j] * parent->w.cross(a);
      axis[i] = a;
      spin[i] = frame.p.cross(a);
      out->axis_W[j] = a;
      out->origin_W[j] = x.p_WB + frame.p;
      parent = &frame;
    }

    QuadrupedDynamics::Foot& foot = out->feet[leg];
    const Vector3d arm = parent->R * feet_[leg];
    foot.p_W = x.p_WB + parent->p + arm;
    foot.v_W = parent->Velocity(arm);
    foot.bias = parent->Acceleration(arm);
    foot.w_W = parent->w;
    foot.turn_bias = parent->alpha;
    foot.J_leg = out->LegJacobian(leg, foot.p_W);

    Composite carried;  // the bodies that joint i moves
    for (int i = kJointsPerLeg - 1; i >= 0; --i) {
      const int j = kJointsPerLeg * leg + i;
      const Body& body = bodies_[j];
      const Frame& frame = frames[i];
      carried.Add(frame, body.mass, body.com, body.inertia);
      const Vector3d &a = axis[i], &s = spin[i];

      // The momentum of these bodies at unit joint speed, projected on this joint and those above it.
      const Vector3d linear = carried.mass * s + a.cross(carried.moment);
      const Vector3d angular = carried.inertia * a + carried.moment.cross(s);
      out->M.block<3, 1>(0, 6 + j) = linear;
      out->M.block<3, 1>(3, 6 + j) = angular;
      for (int k = i; k >= 0; --k) {
        const double m = axis[k].dot(angular) + spin[k].dot(linear);
        out->M(6 + kJointsPerLeg * leg + k, 6 + j) = m;
        out->M(6 + j, 6 + kJointsPerLeg * leg + k) = m;
      }
      out->M(6 + j, 6 + j) += rotor_inertia_;

      out->coriolis[6 + j] = a.dot(carried.torque) + s.dot(carried.force);
      out->gravity[6 + j] =
          gravity_ * (a[0] * carried.moment[1] - a[1] * carried.moment[0] + s[2] * carried.mass);
      out->leg_momentum[j] = a.dot(carried.angular) + s.dot(carried.linear) + rotor_inertia_ * x.qd[j];
      const Vector3d v_origin = frame.v - frame.w.cross(frame.p);
      out->leg_momentum_rate[j] =
          frame.w.cross(a).dot(carried.angular) + (frame.w.cross(s) + v_origin.cross(a)).dot(carried.linear);
    }
    robot.Add(carried);
  }

  out->M.block<3, 3>(0, 0).diagonal().setConstant(robot.mass);
  out->M.block<3, 3>(0, 3) = -CrossMatrix(robot.moment);
  out->M.block<3, 3>(3, 0) = CrossMatrix(robot.moment);
  out->M.block<3, 3>(3, 3) = robot.inertia;
  out->M.block<12, 6>(6, 0) = out->M.block<6, 12>(0, 6).transpose();
  out->coriolis.head<3>() = robot.force;
  out->coriolis.segment<3>(3) = robot.torque;
  out->gravity.head<6>() << 0, 0, gravity_ * robot.mass, gravity_ * robot.moment[1],
      -gravity_ * robot.moment[0], 0;

  const Vector3d com = robot.moment / robot.mass;
  out->com_W = x.p_WB + com;
  out->com_velocity_W = robot.linear / robot.mass;
  out->com_bias_W = robot.force / robot.mass;
  out->centroidal_inertia_W = robot.inertia - FastPointInertia(robot.mass, com);
  out->angular_momentum_W = robot.angular - com.cross(robot.linear);
  out->angular_momentum_bias_W = robot.torque - com.cross(robot.force);
  for (int c = 0; c < kNumVelocities; ++c) {
    const Vector3d linear = out->M.block<3, 1>(0, c);
    out->angular_map.col(c) = out->M.block<3, 1>(3, c) - com.cross(linear);
  }
}

void QuadrupedModel::CalcDecoupled(const LeggedState& x, const QuadrupedDynamics& dynamics,
                                   DecoupledDynamics* out) const {
  const auto& M = dynamics.M;
  const Eigen::Matrix<double, 6, 12> M_bj = M.block<6, 12>(0, 6);
  const internal::Cholesky<6> M_bb(M.block<6, 6>(0, 0));
  const Eigen::Matrix<double, 6, 12> X = M_bb.Solve<12>(M_bj);
  out->M_q = M.block<12, 12>(6, 6);
  out->M_q.noalias() -= M_bj.transpose() * X;
  out->coriolis = dynamics.coriolis.tail<12>() - X.transpose() * dynamics.coriolis.head<6>();
  out->momentum = out->M_q * x.qd;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const DynamicsMatrix<3, 18> J = dynamics.FootJacobian(leg);
    out->J_q.middleRows<3>(3 * leg) = J.rightCols<12>();
    out->J_q.middleRows<3>(3 * leg).noalias() -= J.leftCols<6>() * X;
  }

  // M_q depends on the joint angles alone, so M_q' qd can be evaluated for any motion of the trunk. In the
  // motion nu_0 = (-X qd, qd) the robot has no momentum, so M_q qd are the joints' rows p of M nu_0, and at
  // constant qd p' = C^T nu_0 + C_q nu_0 (joints' rows).
  LeggedState without_momentum = x;
  const Vec<6> trunk = -X * x.qd;
  without_momentum.v_W = trunk.head<3>();
  without_momentum.w_W = trunk.tail<3>();
  QuadrupedDynamics at;
  Calc(without_momentum, &at);
  out->momentum_rate =
      at.leg_momentum_rate + at.coriolis.tail<12>() - X.transpose() * at.coriolis.head<6>() - out->coriolis;
}

namespace {

/// Returns the first joint that is out of its range, or kNumJoints.
int JointBeyondItsRange(const QuadrupedDescription& robot, const Vec<12>& q) {
  int j = 0;
  while (j < kNumJoints && q[j] >= robot.joint(j).lower && q[j] <= robot.joint(j).upper) ++j;
  return j;
}

}  // namespace

LeggedState StandingOn(const QuadrupedDescription& robot, const GroundPlane& ground, double yaw,
                       const Vec<2>& feet_shift) {
  const QuadrupedModel model(robot);
  LeggedState x;
  x.q = robot.stance;
  QuadrupedDynamics dynamics;
  model.Calc(x, &dynamics);

  const Eigen::Vector3d com_B = dynamics.com_W;
  const Eigen::Matrix3d R_WB = RotationFromEuler(EulerOnSlope(ground.slope, yaw));
  const Eigen::Matrix2d footprint = R_WB.topLeftCorner<2, 2>();
  const Eigen::Vector2d middle = ground.p_W.head<2>();
  const auto above = [&](const Eigen::Vector3d& p_B, double height, const Vec<2>& shift) {
    const Eigen::Vector2d place = middle + footprint * p_B.head<2>() + shift;
    return Eigen::Vector3d(place[0], place[1], ground.HeightAt(place) + height);
  };
  const Eigen::Vector3d com_W = above(com_B, robot.StanceHeight() + com_B[2], Vec<2>::Zero());
  x.p_WB = com_W - R_WB * com_B;
  x.q_WB = QuaternionFromRotation(R_WB);
  const double center_height =
      robot.foot_radius /
      ground.Normal()[2];  // height of the centre of a foot's sphere that touches the plane
  std::array<Eigen::Vector3d, kNumLegs> target;
  for (std::size_t i = 0; i < kNumLegs; ++i)
    target[i] = above(dynamics.feet[i].p_W, center_height, feet_shift);

  const auto refuse = [&](std::ptrdiff_t leg) {
    throw ParameterError(fmt::format(
        "the {} leg of '{}' does not reach ground of slope ({}, {}) from its nominal stance within the "
        "ranges of its joints; reduce the slope, or bend the knees of nominal_stance",
        kLegNames[leg], robot.name, ground.slope[0], ground.slope[1]));
  };
  // Newton's method for each leg; the trunk is moved to keep the CoM at its target.
  constexpr int kMostSteps = 100;
  constexpr double kTolerance = 1e-9;                    // m
  constexpr double kLongestStep = std::numbers::pi / 8;  // largest step of a joint angle [rad]
  std::array<double, kNumLegs> error{};
  for (int step = 0; step < kMostSteps; ++step) {
    model.Calc(x, &dynamics);
    const Eigen::Vector3d off = com_W - dynamics.com_W;
    double worst = off.norm();
    for (std::size_t i = 0; i < kNumLegs; ++i) {
      error[i] = (target[i] - dynamics.feet[i].p_W).norm();
      worst = std::max(worst, error[i]);
    }
    if (worst <= kTolerance) {
      const int beyond = JointBeyondItsRange(robot, x.q);
      if (beyond < kNumJoints) refuse(beyond / kJointsPerLeg);
      return x;
    }
    x.p_WB += off;
    for (int i = 0; i < kNumLegs; ++i) {
      const Eigen::Vector3d missing = target[i] - dynamics.feet[i].p_W - off;
      const Eigen::Vector3d turn = internal::SolveLu<3>(dynamics.feet[i].J_leg, missing);
      x.q.segment<3>(kJointsPerLeg * i) += turn.cwiseMax(-kLongestStep).cwiseMin(kLongestStep);
    }
  }
  refuse(std::max_element(error.begin(), error.end()) - error.begin());
  return x;
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::QuadrupedDynamics);
