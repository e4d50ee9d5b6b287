#include <tenon/plants/legged/quadruped_body.h>

#include <tenon/plants/simbody.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <utility>

namespace tenon {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kNumBodies = 1 + kNumJoints;

SimTK::Vec3 ToSimbody(const Eigen::Vector3d& v) {
  return {v[0], v[1], v[2]};
}
template <class Vec3>  // Simbody's, unit or not
Vec<3> ToEigen(const Vec3& v) {
  return {v[0], v[1], v[2]};
}

/// A force at r from the point that it is wanted about: torque before force.
Vec<6> At(const Vec<3>& r, const Vec<3>& torque, const Vec<3>& force) {
  Vec<6> wrench;
  wrench << torque + r.cross(force), force;
  return wrench;
}

/// The inertia of bodies that move as one, about a point.
struct Composite {
  double mass = 0;
  Vec<3> moment = Vec<3>::Zero();  // mass times position of the centre of mass
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();

  /// A body with its origin at r.
  void Add(const Vec<3>& r, const SimTK::SpatialInertia& body) {
    const double m = body.getMass();
    const Vec<3> p = ToEigen(body.getMassCenter()), com = r + p;
    const SimTK::SymMat33& unit = body.getUnitInertia().asSymMat33();
    const Vec<3> squares = com.cwiseAbs2() - p.cwiseAbs2();
    mass += m;
    moment += m * com;
    inertia(0, 0) += m * (unit(0, 0) + squares[1] + squares[2]);
    inertia(1, 1) += m * (unit(1, 1) + squares[2] + squares[0]);
    inertia(2, 2) += m * (unit(2, 2) + squares[0] + squares[1]);
    for (int i = 1; i < 3; ++i)
      for (int k = 0; k < i; ++k)
        inertia(k, i) = inertia(i, k) += m * (unit(i, k) + p[i] * p[k] - com[i] * com[k]);
  }
  void Add(const Composite& other) {
    mass += other.mass;
    moment += other.moment;
    inertia += other.inertia;
  }
  /// Of a motion with this velocity about the point, angular before linear.
  Vec<6> Momentum(const Vec<6>& velocity) const {
    const Vec<3> w = velocity.head<3>(), v = velocity.tail<3>();
    Vec<6> momentum;
    momentum << inertia * w + moment.cross(v), mass * v + w.cross(moment);
    return momentum;
  }
  Matrix6 AsMatrix() const {
    Matrix6 M;
    for (int i = 0; i < 6; ++i) M.col(i) = Momentum(Vec<6>::Unit(i));
    return M;
  }
};

/// Simbody wants the inertia about the body's origin.
SimTK::MassProperties MassOf(const RigidInertia& body) {
  const Eigen::Matrix3d I = body.inertia + body.mass * (body.com.squaredNorm() * Eigen::Matrix3d::Identity() -
                                                        body.com * body.com.transpose());
  return SimTK::MassProperties(body.mass, ToSimbody(body.com),
                               SimTK::Inertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)));
}

}  // namespace

struct QuadrupedBody::Model {
  explicit Model(const QuadrupedDescription& robot)
      : matter(system),
        trunk(matter.Ground(), SimTK::Transform(), SimTK::Body::Rigid(MassOf(robot.trunk)),
              SimTK::Transform()),
        rotor_inertia(robot.drive.rotor_inertia) {
    bodies[0] = trunk;
    for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
      for (std::size_t i = 0; i < kJointsPerLeg; ++i) {
        const JointDescription& joint = robot.legs[leg].joints[i];
        const std::size_t own = 1 + kJointsPerLeg * leg + i, carrier = i == 0 ? 0 : own - 1;
        axes[own] = SimTK::Rotation(SimTK::UnitVec3(ToSimbody(joint.axis)), SimTK::ZAxis);
        bodies[own] = SimTK::MobilizedBody::Pin(
            bodies[carrier],
            SimTK::Transform(~axes[carrier] * axes[own], ~axes[carrier] * ToSimbody(joint.p_PJ)),
            SimTK::Body::Rigid(MassOf(robot.legs[leg].bodies[i]).reexpress(axes[own])), SimTK::Transform());
      }
      feet[leg] = ~axes[kJointsPerLeg * (leg + 1)] * ToSimbody(robot.legs[leg].foot_J);
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
  // Of the bodies here in those of the description: z on the joint's axis, about which a Pin turns. Frames of
  // Pins that coincide with their bodies' save Simbody a sixth of its kinematics.
  std::array<SimTK::Rotation, kNumBodies> axes;
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
  std::array<Eigen::Matrix3d, kNumLegs> leg_mass_inverse;
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
  const auto bias_of = [&](const SimTK::MobilizedBody& body, const Vec<3>& r) {
    const SimTK::SpatialVec& force =
        model_->matter.getTotalCentrifugalForces(state, body.getMobilizedBodyIndex());
    return At(r, ToEigen(force[0]), ToEigen(force[1]));
  };
  Composite all;
  all.Add(Vec<3>::Zero(), model_->trunk.getBodySpatialInertiaInGround(state));
  work.trunk_bias = bias_of(model_->trunk, Vec<3>::Zero());
  Matrix6 yielded = Matrix6::Zero();
  for (int leg = 0; leg < kNumLegs; ++leg) {
    Composite carried;
    Vec<6> carried_bias = Vec<6>::Zero();
    Eigen::Matrix3d M;
    Eigen::Matrix<double, 6, 3> momentum;  // of what each joint carries, at its unit speed
    for (int i = kJointsPerLeg - 1; i >= 0; --i) {
      const int j = kJointsPerLeg * leg + i;
      const SimTK::MobilizedBody& body = model_->bodies[static_cast<std::size_t>(1 + j)];
      const SimTK::Transform& X = body.getBodyTransform(state);
      const Vec<3> r = ToEigen(X.p()) - work.origin;
      const Vec<3> axis = ToEigen(X.R().z());
      Vec<6> motion;
      motion << axis, r.cross(axis);
      carried.Add(r, body.getBodySpatialInertiaInGround(state));
      carried_bias += bias_of(body, r);
      momentum.col(i) = carried.Momentum(motion);
      for (int k = i; k < kJointsPerLeg; ++k) M(i, k) = M(k, i) = motion.dot(momentum.col(k));
      M(i, i) += model_->rotor_inertia;
      work.axes.col(j) = motion;
      work.joint_bias[j] = motion.dot(carried_bias);
    }
    Eigen::Matrix3d& inverse = work.leg_mass_inverse[static_cast<std::size_t>(leg)];
    Eigen::Matrix<double, 3, 6>& per_trunk = work.legs_per_trunk[static_cast<std::size_t>(leg)];
    inverse = M.inverse();
    per_trunk = inverse.lazyProduct(momentum.transpose());
    yielded += momentum.lazyProduct(per_trunk);
    all.Add(carried);
    work.trunk_bias += carried_bias;
  }
  work.trunk_mass.compute(all.AsMatrix() - yielded);
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
  const auto index = static_cast<std::size_t>(body);
  return ToEigen(model_->bodies[index].getBodyTransform(work_->state) *
                 (~model_->axes[index] * ToSimbody(p_B)));
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
        work.leg_mass_inverse[leg] * joint_load.segment<kJointsPerLeg>(first) -
        work.legs_per_trunk[leg] * trunk;
  }
  return out;
}

}  // namespace tenon
