#pragma once

#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/simbody.h>

namespace tenon::test {

/// The quantities of QuadrupedDynamics from Simbody's operators, in Tenon's order of velocities, without
/// rotors. For files that are compiled with -UNDEBUG, see plants/simbody.h.
class QuadrupedSimbody {
 public:
  explicit QuadrupedSimbody(const QuadrupedDescription& robot)
      : matter_(system_),
        trunk_(matter_.Ground(), SimTK::Transform(), Body(robot.trunk), SimTK::Transform()) {
    bodies_[0] = trunk_;
    for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
      for (std::size_t i = 0; i < kJointsPerLeg; ++i) {
        const JointDescription& joint = robot.legs[leg].joints[i];
        const SimTK::Rotation R(SimTK::UnitVec3(To(joint.axis)), SimTK::ZAxis);
        SimTK::MobilizedBody& parent = bodies_[i == 0 ? 0 : kJointsPerLeg * leg + i];
        bodies_[1 + kJointsPerLeg * leg + i] =
            SimTK::MobilizedBody::Pin(parent, SimTK::Transform(R, To(joint.p_PJ)),
                                      Body(robot.legs[leg].bodies[i]), SimTK::Transform(R));
      }
      feet_[leg] = To(robot.legs[leg].foot_J);
    }
    system_.realizeTopology();
    state_ = system_.getDefaultState();
    system_.realizeModel(state_);
    // Row i of Tenon is row order_[i] of Simbody.
    for (int i = 0; i < 3; ++i) order_[i] = 3 + i, order_[3 + i] = i;
    for (int j = 0; j < kNumJoints; ++j) order_[6 + j] = bodies_[1 + j].getFirstUIndex(state_);
  }

  void Calc(const LeggedState& x, double gravity) {
    SetState(x);
    system_.realize(state_, SimTK::Stage::Velocity);

    SimTK::Matrix M;
    matter_.calcM(state_, M);
    SimTK::Vector zero(kNumVelocities, 0.0), residual, momentum;
    SimTK::Vector_<SimTK::SpatialVec> none(matter_.getNumBodies(),
                                           SimTK::SpatialVec(SimTK::Vec3(0), SimTK::Vec3(0)));
    SimTK::Vector_<SimTK::SpatialVec> weight = none;
    for (const SimTK::MobilizedBody& body : bodies_) {
      const SimTK::Vec3 arm = body.getBodyTransform(state_).R() * body.getBodyMassCenterStation(state_);
      const SimTK::Vec3 force(0, 0, -gravity * body.getBodyMass(state_));
      weight[body.getMobilizedBodyIndex()] = SimTK::SpatialVec(arm % force, force);
    }
    matter_.calcResidualForceIgnoringConstraints(state_, zero, none, zero, residual);
    SimTK::Vector with_gravity;
    matter_.calcResidualForceIgnoringConstraints(state_, zero, weight, zero, with_gravity);
    matter_.multiplyByM(state_, state_.getU(), momentum);
    for (int i = 0; i < kNumVelocities; ++i) {
      for (int k = 0; k < kNumVelocities; ++k) out.M(i, k) = M(order_[i], order_[k]);
      out.coriolis[i] = residual[order_[i]];
      out.gravity[i] = with_gravity[order_[i]] - residual[order_[i]];
      if (i >= 6) out.leg_momentum[i - 6] = momentum[order_[i]];
    }

    for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
      const SimTK::MobilizedBody& shank = bodies_[kJointsPerLeg * (leg + 1)];
      SimTK::Matrix J;
      matter_.calcStationJacobian(state_, shank.getMobilizedBodyIndex(), feet_[leg], J);
      for (int i = 0; i < kNumVelocities; ++i)
        for (int r = 0; r < 3; ++r) foot_jacobian[leg](r, i) = J(r, order_[i]);
      out.feet[leg].p_W = From(shank.findStationLocationInGround(state_, feet_[leg]));
      out.feet[leg].v_W = From(shank.findStationVelocityInGround(state_, feet_[leg]));
      out.feet[leg].bias =
          From(matter_.calcBiasForStationJacobian(state_, shank.getMobilizedBodyIndex(), feet_[leg]));
    }

    out.com_W = From(matter_.calcSystemMassCenterLocationInGround(state_));
    out.com_velocity_W = From(matter_.calcSystemMassCenterVelocityInGround(state_));
    const SimTK::SpatialVec central = matter_.calcSystemCentralMomentum(state_);
    out.angular_momentum_W = From(central[0]);
    const SimTK::SymMat33 I = matter_.calcSystemCentralInertiaInGround(state_).asSymMat33();
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) out.centroidal_inertia_W(r, c) = r >= c ? I(r, c) : I(c, r);
  }

  /// Accelerations by articulated bodies, without contact and gravity.
  const LeggedAcceleration& CalcAcceleration(const LeggedState& x, const Vec<12>& torque) {
    SetState(x);
    for (int j = 0; j < kNumJoints; ++j) mobility_forces_[order_[6 + j]] = torque[j];
    system_.realize(state_, SimTK::Stage::Dynamics);
    matter_.calcAccelerationIgnoringConstraints(state_, mobility_forces_, body_forces_, udot_, body_rates_);
    for (int i = 0; i < 3; ++i) acceleration_.a_W[i] = udot_[3 + i], acceleration_.alpha_W[i] = udot_[i];
    for (int j = 0; j < kNumJoints; ++j) acceleration_.qdd[j] = udot_[order_[6 + j]];
    return acceleration_;
  }

  QuadrupedDynamics out;  ///< without the maps and rates of the momenta
  std::array<DynamicsMatrix<3, 18>, kNumLegs> foot_jacobian;

 private:
  static SimTK::Vec3 To(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }
  static Eigen::Vector3d From(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }
  void SetState(const LeggedState& x) {
    SimTK::Vector& q = state_.updQ();
    SimTK::Vector& u = state_.updU();
    for (int i = 0; i < 4; ++i) q[i] = x.q_WB[i];
    for (int i = 0; i < 3; ++i) q[4 + i] = x.p_WB[i], u[i] = x.w_W[i], u[3 + i] = x.v_W[i];
    for (int j = 0; j < kNumJoints; ++j) {
      q[bodies_[1 + j].getFirstQIndex(state_)] = x.q[j];
      u[order_[6 + j]] = x.qd[j];
    }
  }
  static SimTK::Body::Rigid Body(const RigidInertia& body) {
    const Eigen::Matrix3d& I = body.inertia;
    const SimTK::Inertia central(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
    return SimTK::Body::Rigid(SimTK::MassProperties(body.mass, To(body.com),
                                                    central.shiftFromMassCenter(-To(body.com), body.mass)));
  }

  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  SimTK::MobilizedBody::Free trunk_;
  std::array<SimTK::MobilizedBody, 1 + kNumJoints> bodies_;
  std::array<SimTK::Vec3, kNumLegs> feet_;
  std::array<int, kNumVelocities> order_{};
  SimTK::State state_;
  SimTK::Vector mobility_forces_ = SimTK::Vector(kNumVelocities, 0.0), udot_;
  SimTK::Vector_<SimTK::SpatialVec> body_forces_ =
      SimTK::Vector_<SimTK::SpatialVec>(2 + kNumJoints, SimTK::SpatialVec(SimTK::Vec3(0), SimTK::Vec3(0)));
  SimTK::Vector_<SimTK::SpatialVec> body_rates_;
  LeggedAcceleration acceleration_;
};

}  // namespace tenon::test
