#include "tenon/plants/quadruped_body.h"

#include <tenon/plants/simbody.h>

#include <Eigen/Cholesky>
#include <array>
#include <utility>

namespace tenon {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kNumBodies = 1 + kNumJoints;

SimTK::Vec3 ToSimbody(const Eigen::Vector3d& v) {
  return {v[0], v[1], v[2]};
}
Vec<3> ToEigen(const SimTK::Vec3& v) {
  return {v[0], v[1], v[2]};
}

/// A force or momentum given at r from the point that it is wanted about: torque before force.
Vec<6> At(const Vec<3>& r, const Vec<3>& torque, const Vec<3>& force) {
  Vec<6> wrench;
  wrench << torque + r.cross(force), force;
  return wrench;
}

Eigen::Matrix3d Cross(const Vec<3>& v) {
  Eigen::Matrix3d m;
  m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return m;
}

/// What turns a body's spatial velocity into its momentum, both about the point from which its origin is at r.
Matrix6 InertiaAbout(const Vec<3>& r, const SimTK::SpatialInertia& at_origin) {
  const double mass = at_origin.getMass();
  const Vec<3> p = ToEigen(at_origin.getMassCenter()), com = r + p;
  const SimTK::SymMat33& unit = at_origin.getUnitInertia().asSymMat33();
  Matrix6 inertia;
  auto turning = inertia.topLeftCorner<3, 3>();
  turning << unit(0, 0), unit(1, 0), unit(2, 0), unit(1, 0), unit(1, 1), unit(2, 1), unit(2, 0), unit(2, 1),
      unit(2, 2);
  turning += p * p.transpose() - com * com.transpose();
  turning.diagonal().array() += com.squaredNorm() - p.squaredNorm();
  inertia.topRightCorner<3, 3>() = Cross(com);
  inertia.bottomLeftCorner<3, 3>() = -Cross(com);
  inertia.bottomRightCorner<3, 3>().setIdentity();
  return mass * inertia;
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
        axes[kJointsPerLeg * leg + i] = ToSimbody(joint.axis);
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
  std::array<SimTK::Vec3, kNumJoints> axes;  // in the body that moves, or the one that carries it
  std::array<SimTK::Vec3, kNumLegs> feet;
  std::array<int, kNumJoints> q_index, u_index;
  double rotor_inertia;
};

struct QuadrupedBody::Work {
  explicit Work(const Model& model) : state(model.system.getDefaultState()) {
    model.system.realizeModel(state);
    model.system.realize(state, SimTK::Stage::Instance);
  }
  SimTK::State state;
  // The equations of motion, with spatial vectors in W about the trunk's origin, angular before linear.
  Vec<3> origin;                      // of the trunk
  Eigen::Matrix<double, 6, 12> axes;  // velocities that unit joint speeds give
  Vec<6> trunk_bias;                  // forces that it takes for no accelerations
  Vec<12> joint_bias;
  std::array<Eigen::LLT<Eigen::Matrix3d>, kNumLegs> leg_mass;
  std::array<Eigen::Matrix<double, 3, 6>, kNumLegs> legs_per_trunk;  // how legs yield to the trunk
  Eigen::LLT<Matrix6> trunk_mass;                                    // felt at the trunk, with yielding legs
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
  Factorise();
}

void QuadrupedBody::Factorise() {
  Work& work = *work_;
  const SimTK::State& state = work.state;
  work.origin = ToEigen(model_->trunk.getBodyTransform(state).p());
  const auto inertia_of = [&](const SimTK::MobilizedBody& body, const Vec<3>& r) {
    return InertiaAbout(r, body.getBodySpatialInertiaInGround(state));
  };
  const auto bias_of = [&](const SimTK::MobilizedBody& body, const Vec<3>& r) {
    const SimTK::SpatialVec& force =
        model_->matter.getTotalCentrifugalForces(state, body.getMobilizedBodyIndex());
    return At(r, ToEigen(force[0]), ToEigen(force[1]));
  };
  Matrix6 inertia = inertia_of(model_->trunk, Vec<3>::Zero());
  work.trunk_bias = bias_of(model_->trunk, Vec<3>::Zero());
  for (int leg = 0; leg < kNumLegs; ++leg) {
    Matrix6 carried_inertia = Matrix6::Zero();
    Vec<6> carried_bias = Vec<6>::Zero();
    Eigen::Matrix3d M;
    Eigen::Matrix<double, 6, 3> momentum;  // of what each joint carries, at its unit speed
    for (int i = kJointsPerLeg - 1; i >= 0; --i) {
      const int j = kJointsPerLeg * leg + i;
      const SimTK::MobilizedBody& body = model_->bodies[static_cast<std::size_t>(1 + j)];
      const SimTK::Transform& X = body.getBodyTransform(state);
      const Vec<3> r = ToEigen(X.p()) - work.origin;
      const Vec<3> axis = ToEigen(X.R() * model_->axes[static_cast<std::size_t>(j)]);
      work.axes.col(j) << axis, r.cross(axis);
      carried_inertia += inertia_of(body, r);
      carried_bias += bias_of(body, r);
      momentum.col(i).noalias() = carried_inertia * work.axes.col(j);
      work.joint_bias[j] = work.axes.col(j).dot(carried_bias);
      for (int k = i; k < kJointsPerLeg; ++k) M(i, k) = M(k, i) = work.axes.col(j).dot(momentum.col(k));
      M(i, i) += model_->rotor_inertia;
    }
    auto& factor = work.leg_mass[static_cast<std::size_t>(leg)];
    auto& per_trunk = work.legs_per_trunk[static_cast<std::size_t>(leg)];
    factor.compute(M);
    per_trunk = factor.solve(momentum.transpose());
    inertia += carried_inertia;
    inertia.noalias() -= momentum * per_trunk;
    work.trunk_bias += carried_bias;
  }
  work.trunk_mass.compute(inertia);
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
  const Work& work = *work_;
  Vec<6> trunk_load = -work.trunk_bias;
  Vec<12> joint_load = torque - work.joint_bias;
  for (const PointForce& at : forces) {
    const Vec<6> wrench = At(at.p_W - work.origin, at.torque_W, at.force_W);
    trunk_load += wrench;
    if (at.body == 0) continue;
    const int joint = at.body - 1;
    for (int j = joint / kJointsPerLeg * kJointsPerLeg; j <= joint; ++j)
      joint_load[j] += work.axes.col(j).dot(wrench);
  }
  for (int leg = 0; leg < kNumLegs; ++leg)
    trunk_load.noalias() -= work.legs_per_trunk[static_cast<std::size_t>(leg)].transpose() *
                            joint_load.segment<kJointsPerLeg>(kJointsPerLeg * leg);
  const Vec<6> trunk = work.trunk_mass.solve(trunk_load);
  LeggedAcceleration out;
  out.alpha_W = trunk.head<3>();
  out.a_W = trunk.tail<3>() - Vec<3>(0, 0, gravity);
  for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
    const auto first = static_cast<Eigen::Index>(kJointsPerLeg * leg);
    out.qdd.segment<kJointsPerLeg>(first) =
        work.leg_mass[leg].solve(joint_load.segment<kJointsPerLeg>(first)) - work.legs_per_trunk[leg] * trunk;
  }
  return out;
}

}  // namespace tenon
