#include "tenon/plants/quadruped_body.h"

#include <tenon/plants/simbody.h>

#include <Eigen/Cholesky>
#include <array>
#include <utility>

namespace tenon {
namespace {

constexpr int kNumBodies = 1 + kNumJoints;
constexpr int kNumVelocities = 6 + kNumJoints;

SimTK::Vec3 ToSimbody(const Eigen::Vector3d& v) {
  return {v[0], v[1], v[2]};
}
Vec<3> ToEigen(const SimTK::Vec3& v) {
  return {v[0], v[1], v[2]};
}

/// Simbody wants the inertia about the body's origin.
SimTK::Body::Rigid MakeBody(const RigidInertia& body) {
  const Eigen::Matrix3d I = body.inertia + body.mass * (body.com.squaredNorm() * Eigen::Matrix3d::Identity() -
                                                        body.com * body.com.transpose());
  return SimTK::Body::Rigid(SimTK::MassProperties(
      body.mass, ToSimbody(body.com), SimTK::Inertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2))));
}

}  // namespace

struct QuadrupedBody::Model {
  explicit Model(const QuadrupedDescription& robot)
      : matter(system),
        trunk(matter.Ground(), SimTK::Transform(), MakeBody(robot.trunk), SimTK::Transform()),
        rotor_inertia(robot.drive.rotor_inertia) {
    bodies[0] = trunk;
    for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
      SimTK::MobilizedBody parent = trunk;
      for (std::size_t i = 0; i < kJointsPerLeg; ++i) {
        const JointDescription& joint = robot.legs[leg].joints[i];
        // A Pin turns about the z axis of its frames.
        const SimTK::Rotation R(SimTK::UnitVec3(ToSimbody(joint.axis)), SimTK::ZAxis);
        SimTK::MobilizedBody::Pin pin(parent, SimTK::Transform(R, ToSimbody(joint.p_PJ)),
                                      MakeBody(robot.legs[leg].bodies[i]), SimTK::Transform(R));
        bodies[1 + kJointsPerLeg * leg + i] = pin;
        parent = pin;
      }
      feet[leg] = ToSimbody(robot.legs[leg].foot_J);
    }
    system.realizeTopology();
    SimTK::State state = system.getDefaultState();
    system.realizeModel(state);
    for (std::size_t j = 0; j < kNumJoints; ++j) {
      q_index[j] = bodies[1 + j].getFirstQIndex(state);
      u_index[j] = bodies[1 + j].getFirstUIndex(state);
    }
  }
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter;
  SimTK::MobilizedBody::Free trunk;
  std::array<SimTK::MobilizedBody, kNumBodies> bodies;
  std::array<SimTK::Vec3, kNumLegs> feet;
  std::array<int, kNumJoints> q_index, u_index;
  double rotor_inertia;
};

struct QuadrupedBody::Work {
  explicit Work(const Model& model)
      : state(model.system.getDefaultState()),
        mobility_forces(kNumVelocities, 0.0),
        body_forces(kNumBodies + 1, SimTK::SpatialVec(SimTK::Vec3(0), SimTK::Vec3(0))) {
    model.system.realizeModel(state);
    model.system.realize(state, SimTK::Stage::Instance);
  }
  SimTK::State state;
  SimTK::Vector mobility_forces, residual, udot;
  const SimTK::Vector at_rest;  // empty: accelerations are 0
  SimTK::Vector_<SimTK::SpatialVec> body_forces;
  SimTK::Matrix M;
};

QuadrupedBody::QuadrupedBody() = default;
QuadrupedBody::~QuadrupedBody() = default;

QuadrupedBody::QuadrupedBody(const QuadrupedDescription& robot)
    : model_(std::make_shared<const Model>(robot)), work_(std::make_unique<Work>(*model_)) {}

QuadrupedBody::QuadrupedBody(const QuadrupedBody& other)
    : model_(other.model_), work_(other.work_ == nullptr ? nullptr : std::make_unique<Work>(*other.work_)) {}

QuadrupedBody& QuadrupedBody::operator=(const QuadrupedBody& other) {
  QuadrupedBody copy(other);
  model_ = std::move(copy.model_);
  work_ = std::move(copy.work_);
  return *this;
}

void QuadrupedBody::SetState(const LeggedState& x) {
  SimTK::State& state = work_->state;
  // Raw data, because Simbody as packaged checks every access to an element.
  double* q = state.updQ().updContiguousScalarData();  // (w, x, y, z), position, joint angles
  double* u = state.updU().updContiguousScalarData();  // angular before linear velocity, both in W
  for (int i = 0; i < 4; ++i) q[i] = x.q_WB[i];
  for (int i = 0; i < 3; ++i) {
    q[4 + i] = x.p_WB[i];
    u[i] = x.w_W[i];
    u[3 + i] = x.v_W[i];
  }
  for (std::size_t j = 0; j < kNumJoints; ++j) {
    q[model_->q_index[j]] = x.q[static_cast<Eigen::Index>(j)];
    u[model_->u_index[j]] = x.qd[static_cast<Eigen::Index>(j)];
  }
  // No more than what is read below: whole stages of the System take longer.
  model_->matter.realizePositionKinematics(state);
  model_->matter.realizeVelocityKinematics(state);
}

FootMotion QuadrupedBody::Foot(int leg) const {
  const SimTK::MobilizedBody& shank = model_->bodies[static_cast<std::size_t>(1 + kJointsPerLeg * leg + 2)];
  const SimTK::Transform& X = shank.getBodyTransform(work_->state);
  const SimTK::SpatialVec& V = shank.getBodyVelocity(work_->state);
  const Vec<3> arm = ToEigen(X.R() * model_->feet[static_cast<std::size_t>(leg)]);
  const Vec<3> w = ToEigen(V[0]);
  return {ToEigen(X.p()) + arm, ToEigen(V[1]) + w.cross(arm), w};
}

Vec<3> QuadrupedBody::Position(int body, const Vec<3>& p_B) const {
  return ToEigen(model_->bodies[static_cast<std::size_t>(body)].getBodyTransform(work_->state) *
                 ToSimbody(p_B));
}

double QuadrupedBody::KineticEnergy() const {
  const SimTK::Vector& u = work_->state.getU();
  double energy = model_->matter.calcKineticEnergy(work_->state);
  for (const int index : model_->u_index) energy += model_->rotor_inertia / 2 * u[index] * u[index];
  return energy;
}

Vec<3> QuadrupedBody::Com() const {
  return ToEigen(model_->matter.calcSystemMassCenterLocationInGround(work_->state));
}

LeggedAcceleration QuadrupedBody::Acceleration(const Vec<12>& torque, std::span<const PointForce> forces,
                                               double gravity) const {
  Work& work = *work_;
  double* mobility = work.mobility_forces.updContiguousScalarData();
  for (std::size_t j = 0; j < kNumJoints; ++j)
    mobility[model_->u_index[j]] = torque[static_cast<Eigen::Index>(j)];
  work.body_forces.setToZero();
  for (const PointForce& at : forces) {
    const SimTK::MobilizedBody& body = model_->bodies[static_cast<std::size_t>(at.body)];
    const Vec<3> arm = at.p_W - ToEigen(body.getBodyTransform(work.state).p());
    work.body_forces[body.getMobilizedBodyIndex()] +=
        SimTK::SpatialVec(ToSimbody(arm.cross(at.force_W)), ToSimbody(at.force_W));
  }
  // What is left of the forces at u' = 0, and what accelerations take it: M u' = -residual.
  model_->matter.calcResidualForceIgnoringConstraints(work.state, work.mobility_forces, work.body_forces,
                                                      work.at_rest, work.residual);
  model_->matter.realizeArticulatedBodyInertias(work.state);
  model_->matter.multiplyByMInv(work.state, work.residual, work.udot);
  double* udot = work.udot.updContiguousScalarData();
  for (int i = 0; i < kNumVelocities; ++i) udot[i] = -udot[i];
  if (model_->rotor_inertia > 0) {
    using Matrix18 = Eigen::Matrix<double, kNumVelocities, kNumVelocities>;
    model_->matter.calcM(work.state, work.M);
    Matrix18 M = Eigen::Map<const Matrix18>(work.M.getContiguousScalarData());
    Eigen::Matrix<double, kNumVelocities, 1> load = Eigen::Matrix<double, kNumVelocities, 1>::Zero();
    for (const int index : model_->u_index) {
      M(index, index) += model_->rotor_inertia;
      load[index] = model_->rotor_inertia * udot[index];
    }
    Eigen::Map<Eigen::Matrix<double, kNumVelocities, 1>>(udot, kNumVelocities) -= M.llt().solve(load);
  }
  LeggedAcceleration out;
  out.alpha_W << udot[0], udot[1], udot[2];
  out.a_W << udot[3], udot[4], udot[5] - gravity;
  for (std::size_t j = 0; j < kNumJoints; ++j)
    out.qdd[static_cast<Eigen::Index>(j)] = udot[model_->u_index[j]];
  return out;
}

}  // namespace tenon
