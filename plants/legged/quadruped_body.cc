#include <tenon/plants/legged/internal/per_leg.h>
#include <tenon/plants/legged/quadruped_body.h>
#include <tenon/plants/model/vectors.h>
#include <tenon/plants/multibody/internal/simbody_conversions.h>
#include <tenon/systems/analysis/internal/small_matrices.h>

namespace tenon {
namespace {

using internal::MassOf;
using internal::Matrix3;
using internal::PerLeg;
using internal::ToEigen;
using internal::ToSimbody;
using internal::Vector3;
template <class T>
using Vector6 = Eigen::Matrix<T, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kNumBodies = 1 + kNumJoints;

Matrix3<double> MatrixOf(const SimTK::Rotation& R) {
  Matrix3<double> out;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) out(row, column) = R.asMat33()(row, column);
  return out;
}
/// Index of the body that joint i of a leg moves; the trunk has index 0.
int BodyOf(int leg, int i) {
  return 1 + kJointsPerLeg * leg + i;
}

/// The vector of one leg.
template <int R>
Eigen::Matrix<double, R, 1> Of(int leg, const Eigen::Matrix<PerLeg, R, 1>& legs) {
  Eigen::Matrix<double, R, 1> out;
  for (int i = 0; i < R; ++i) out[i] = legs[i][leg];
  return out;
}
/// Sum over the legs.
template <int R, int C>
Eigen::Matrix<double, R, C> Sum(const Eigen::Matrix<PerLeg, R, C>& of_legs) {
  Eigen::Matrix<double, R, C> sum;
  for (int i = 0; i < R * C; ++i) sum(i) = of_legs(i).Sum();
  return sum;
}

/// Wrench about a point of a torque and a force that acts at r from this point: torque before force.
template <class T>
Vector6<T> At(const Vector3<T>& r, const Vector3<T>& torque, const Vector3<T>& force) {
  Vector6<T> wrench;
  wrench.template head<3>() = torque + r.cross(force);
  wrench.template tail<3>() = force;
  return wrench;
}

/// Motion of a body's origin in W: velocities, and accelerations at zero accelerations of trunk and joints.
template <class T>
struct Motion {
  Vector3<T> w, v, alpha, a;
};

/// The inertia of a body, in W about its origin.
template <class T>
struct Inertia {
  T mass;
  Vector3<T> com;
  Matrix3<T> unit;  // divided by mass

  /// The wrench that the motion requires, about a point with the body's origin at r.
  Vector6<T> Bias(const Vector3<T>& r, const Motion<T>& motion) const {
    const Vector3<T>& w = motion.w;
    const Vector3<T> force = mass * (motion.a + motion.alpha.cross(com) + w.cross(w.cross(com)));
    const Vector3<T> torque = mass * (unit * motion.alpha + com.cross(motion.a) + w.cross(unit * w));
    return At(r, torque, force);
  }
};

/// Converts Simbody's inertias; `get` applies a function to one SpatialInertia for each component of T.
template <class T, class Get>
Inertia<T> MakeInertia(const Get& get) {
  Inertia<T> inertia;
  inertia.mass = get([](const SimTK::SpatialInertia& body) { return body.getMass(); });
  for (int i = 0; i < 3; ++i) {
    inertia.com[i] = get([i](const SimTK::SpatialInertia& body) { return body.getMassCenter()[i]; });
    for (int k = 0; k <= i; ++k)
      inertia.unit(i, k) = inertia.unit(k, i) =
          get([i, k](const SimTK::SpatialInertia& body) { return body.getUnitInertia().asSymMat33()(i, k); });
  }
  return inertia;
}

/// The inertia of bodies that move as one, about a point.
template <class T>
struct Composite {
  T mass = T(0);
  Vector3<T> moment = Vector3<T>::Zero();  // mass times position of the centre of mass
  Matrix3<T> inertia = Matrix3<T>::Zero();

  /// A body with its origin at r.
  void Add(const Vector3<T>& r, const Inertia<T>& body) {
    const Vector3<T>& p = body.com;
    const Vector3<T> com = r + p;
    const Vector3<T> squares = com.cwiseProduct(com) - p.cwiseProduct(p);
    mass += body.mass;
    moment += body.mass * com;
    inertia(0, 0) += body.mass * (body.unit(0, 0) + squares[1] + squares[2]);
    inertia(1, 1) += body.mass * (body.unit(1, 1) + squares[2] + squares[0]);
    inertia(2, 2) += body.mass * (body.unit(2, 2) + squares[0] + squares[1]);
    for (int i = 1; i < 3; ++i)
      for (int k = 0; k < i; ++k)
        inertia(k, i) = inertia(i, k) += body.mass * (body.unit(i, k) + p[i] * p[k] - com[i] * com[k]);
  }
  void Add(const Composite& other) {
    mass += other.mass;
    moment += other.moment;
    inertia += other.inertia;
  }
  /// Spatial momentum of a motion with this velocity about the point, angular before linear.
  Vector6<T> Momentum(const Vector6<T>& velocity) const {
    const Vector3<T> w = velocity.template head<3>(), v = velocity.template tail<3>();
    Vector6<T> momentum;
    momentum.template head<3>() = inertia * w + moment.cross(v);
    momentum.template tail<3>() = mass * v + w.cross(moment);
    return momentum;
  }
};

Matrix6 MassMatrix(const Composite<double>& bodies) {
  Matrix6 M;
  M << bodies.inertia, CrossMatrix(bodies.moment), -CrossMatrix(bodies.moment),
      bodies.mass * Matrix3<double>::Identity();
  return M;
}

Composite<double> Sum(const Composite<PerLeg>& legs) {
  return {legs.mass.Sum(), Sum(legs.moment), Sum(legs.inertia)};
}

/// Inverse of a symmetric matrix.
Matrix3<PerLeg> Inverse(const Matrix3<PerLeg>& M) {
  Matrix3<PerLeg> out;
  const PerLeg a = M(1, 1) * M(2, 2) - M(1, 2) * M(1, 2), b = M(0, 2) * M(1, 2) - M(0, 1) * M(2, 2),
               c = M(0, 1) * M(1, 2) - M(0, 2) * M(1, 1);
  const PerLeg inverse_determinant = PerLeg(1) / (M(0, 0) * a + M(0, 1) * b + M(0, 2) * c);
  out(0, 0) = inverse_determinant * a;
  out(0, 1) = out(1, 0) = inverse_determinant * b;
  out(0, 2) = out(2, 0) = inverse_determinant * c;
  out(1, 1) = inverse_determinant * (M(0, 0) * M(2, 2) - M(0, 2) * M(0, 2));
  out(1, 2) = out(2, 1) = inverse_determinant * (M(0, 1) * M(0, 2) - M(0, 0) * M(1, 2));
  out(2, 2) = inverse_determinant * (M(0, 0) * M(1, 1) - M(0, 1) * M(0, 1));
  return out;
}

/// A frame with z along the axis, equal for parallel axes.
SimTK::Rotation Turned(const Eigen::Vector3d& axis) {
  return SimTK::Rotation(SimTK::UnitVec3(ToSimbody(axis)), SimTK::ZAxis);
}

}  // namespace

struct QuadrupedBody::Model {
  explicit Model(const QuadrupedDescription& robot)
      : matter(system), rotor_inertia(robot.drive.rotor_inertia) {
    axes[0] = Turned(robot.legs[0].joints[0].axis);
    const SimTK::Vec4 turn = axes[0].convertRotationToQuaternion().asVec4();
    trunk_turn = {turn[0], turn[1], turn[2], turn[3]};
    bodies[0] = SimTK::MobilizedBody::Free(matter.Ground(), SimTK::Transform(),
                                           SimTK::Body::Rigid(MassOf(robot.trunk).reexpress(axes[0])),
                                           SimTK::Transform());
    for (int leg = 0; leg < kNumLegs; ++leg) {
      for (int i = 0; i < kJointsPerLeg; ++i) {
        const JointDescription& joint = robot.legs[leg].joints[i];
        const int own = BodyOf(leg, i), carrier = i == 0 ? 0 : own - 1;
        axes[own] = Turned(joint.axis);
        bodies[own] = SimTK::MobilizedBody::Pin(
            bodies[carrier],
            SimTK::Transform(~axes[carrier] * axes[own], ~axes[carrier] * ToSimbody(joint.p_PJ)),
            SimTK::Body::Rigid(MassOf(robot.legs[leg].bodies[i]).reexpress(axes[own])), SimTK::Transform());
      }
    }
    for (std::size_t i = 0; i < kJointsPerLeg; ++i) {
      for (int k = 0; k < 3; ++k)
        offsets[i][k] = PerLeg::Of([&](int leg) {
          const int own = BodyOf(leg, i), before = i == 0 ? 0 : own - 1;
          const LegDescription& of = robot.legs[leg];
          return (~axes[before] * ToSimbody(of.joints[i].p_PJ))[k];
        });
    }
    for (int k = 0; k < 3; ++k)
      feet[k] = PerLeg::Of([&](int leg) {
        const LegDescription& of = robot.legs[leg];
        return (~axes[BodyOf(leg, kJointsPerLeg - 1)] * ToSimbody(of.foot_J))[k];
      });
    RealizeTopology(system);
    SimTK::State state = system.getDefaultState();
    system.realizeModel(state);
    for (std::size_t j = 0; j < kNumJoints; ++j) {
      q_index[j] = bodies[1 + j].getFirstQIndex(state);
      u_index[j] = bodies[1 + j].getFirstUIndex(state);
    }
  }
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter;
  std::array<SimTK::MobilizedBody, kNumBodies> bodies;
  // Axes of Simbody's bodies in the frames of the description, with z along the joint's axis, about which a
  // Pin turns; the trunk's z is along the first hip's axis. Joint frames that coincide with body frames save
  // a sixth of the time of Simbody's kinematics, and so do axes equal to those of the parent.
  std::array<SimTK::Rotation, kNumBodies> axes;
  Vec<4> trunk_turn;  // axes[0] as a quaternion
  std::array<int, kNumJoints> q_index, u_index;
  // Positions of all legs' joints in the frames of their parents, and of the feet in the frames of the
  // shanks.
  std::array<Vector3<PerLeg>, kJointsPerLeg> offsets;
  Vector3<PerLeg> feet;
  double rotor_inertia;
};

struct QuadrupedBody::Work {
  explicit Work(const Model& model) : state(model.system.getDefaultState()) {
    model.system.realizeModel(state);
    Find(model);
  }
  Work(const Model& model, const Work& other) : Work(other) { Find(model); }

  SimTK::State state;
  // Pointers into the state, where these values stay; each access through Simbody would take two dynamic
  // casts.
  std::array<const SimTK::Transform*, kNumBodies> poses;
  std::array<const SimTK::SpatialInertia*, kNumBodies> inertias;
  LeggedState x;
  // The equations of motion, with spatial vectors in W about the trunk's origin, angular before linear.
  Vec<3> origin;  // origin of the trunk
  Vec<3> com;     // centre of mass of the robot
  std::array<FootMotion, kNumLegs> feet;
  std::array<Vector6<PerLeg>, kJointsPerLeg> axes;  // spatial velocities at unit joint speeds
  Vec<6> trunk_bias;                                // trunk's rows of the bias force
  Vector3<PerLeg> joint_bias;
  Matrix3<PerLeg> leg_mass_inverse;
  Eigen::Matrix<PerLeg, 3, 6> legs_per_trunk;  // -(leg accelerations) per trunk acceleration
  internal::Cholesky<6> trunk_mass;            // mass matrix of the trunk after the elimination of the legs

 private:
  Work(const Work&) = default;
  void Find(const Model& model) {
    model.system.realize(state, SimTK::Stage::Instance);
    model.matter.realizePositionKinematics(state);
    for (std::size_t i = 0; i < kNumBodies; ++i) {
      poses[i] = &model.bodies[i].getBodyTransform(state);
      inertias[i] = &model.bodies[i].getBodySpatialInertiaInGround(state);
    }
  }
};

QuadrupedBody::QuadrupedBody() = default;
QuadrupedBody::~QuadrupedBody() = default;

QuadrupedBody::QuadrupedBody(const QuadrupedDescription& robot)
    : model_(std::make_shared<const Model>(robot)), work_(std::make_unique<Work>(*model_)) {}

QuadrupedBody::QuadrupedBody(const QuadrupedBody& other)
    : model_(other.model_),
      work_(other.work_ == nullptr ? nullptr : std::make_unique<Work>(*model_, *other.work_)) {}

QuadrupedBody& QuadrupedBody::operator=(const QuadrupedBody& other) {
  QuadrupedBody copy(other);
  model_ = std::move(copy.model_);
  work_ = std::move(copy.work_);
  return *this;
}

void QuadrupedBody::SetState(const LeggedState& x) {
  work_->x = x;
  SimTK::State& state = work_->state;
  // Raw data, since the packaged Simbody checks the bounds of every access.
  double* q = state.updQ().updContiguousScalarData();  // (w, x, y, z), position, joint angles
  const Vec<4> turn = QuaternionProduct(x.q_WB, model_->trunk_turn);
  for (int i = 0; i < 4; ++i) q[i] = turn[i];
  for (int i = 0; i < 3; ++i) q[4 + i] = x.p_WB[i];
  for (int j = 0; j < kNumJoints; ++j) q[model_->q_index[j]] = x.q[j];
  // Computes only the values that are read below; complete stages of the System take longer.
  model_->matter.realizePositionKinematics(state);
  Factorise();
}

void QuadrupedBody::Factorise() {
  Work& work = *work_;
  const LeggedState& x = work.x;
  const auto trunk = MakeInertia<double>([&](auto element) { return element(*work.inertias[0]); });
  const Vec<3> none = Vec<3>::Zero();
  work.origin = ToEigen(work.poses[0]->p());
  Composite<double> all;
  all.Add(none, trunk);
  work.trunk_bias = trunk.Bias(none, {x.w_W, x.v_W, none, none});

  // From the trunk to the feet.
  std::array<Vector3<PerLeg>, kJointsPerLeg> places;  // from the trunk's origin
  std::array<Inertia<PerLeg>, kJointsPerLeg> bodies;
  std::array<Vector6<PerLeg>, kJointsPerLeg> biases;
  Matrix3<PerLeg> R = MatrixOf(work.poses[0]->R()).cast<PerLeg>();
  Vector3<PerLeg> r = none.cast<PerLeg>();
  Motion<PerLeg> motion{x.w_W.cast<PerLeg>(), x.v_W.cast<PerLeg>(), r, r};
  for (std::size_t i = 0; i < kJointsPerLeg; ++i) {
    const Vector3<PerLeg> arm = R * model_->offsets[i], w = motion.w;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column)
        R(row, column) =
            PerLeg::Of([&](int leg) { return work.poses[BodyOf(leg, i)]->R().asMat33()(row, column); });
    const Vector3<PerLeg> axis = R.col(2);
    const PerLeg speed = PerLeg::Of([&](int leg) { return x.qd[BodyOf(leg, i) - 1]; });
    motion.a += motion.alpha.cross(arm) + w.cross(w.cross(arm));
    motion.alpha += speed * w.cross(axis);
    motion.v += w.cross(arm);
    motion.w += speed * axis;
    r += arm;
    places[i] = r;
    bodies[i] = MakeInertia<PerLeg>([&](auto element) {
      return PerLeg::Of([&](int leg) { return element(*work.inertias[BodyOf(leg, i)]); });
    });
    biases[i] = bodies[i].Bias(r, motion);
    work.axes[i].head<3>() = axis;
    work.axes[i].tail<3>() = r.cross(axis);
  }
  const Vector3<PerLeg> arm = R * model_->feet;
  const Vector3<PerLeg> foot = r + arm, foot_velocity = motion.v + motion.w.cross(arm);
  for (int leg = 0; leg < kNumLegs; ++leg)
    work.feet[leg] = {work.origin + Of(leg, foot), Of(leg, foot_velocity), Of(leg, motion.w)};

  // From the feet to the trunk.
  Composite<PerLeg> carried;
  Vector6<PerLeg> bias = Vector6<PerLeg>::Zero();
  Matrix3<PerLeg> M;
  Eigen::Matrix<PerLeg, 6, 3> momentum;  // momentum of the bodies that each joint carries, at unit speed
  for (int i = kJointsPerLeg - 1; i >= 0; --i) {
    const Vector6<PerLeg>& axis = work.axes[i];
    carried.Add(places[i], bodies[i]);
    bias += biases[i];
    momentum.col(i) = carried.Momentum(axis);
    for (int k = i; k < kJointsPerLeg; ++k) M(i, k) = M(k, i) = axis.dot(momentum.col(k));
    M(i, i) += model_->rotor_inertia;
    work.joint_bias[i] = axis.dot(bias);
  }
  work.leg_mass_inverse = Inverse(M);
  work.legs_per_trunk = work.leg_mass_inverse.lazyProduct(momentum.transpose());
  all.Add(Sum(carried));
  work.com = work.origin + all.moment / all.mass;
  work.trunk_bias += Sum(bias);
  Matrix6 mass = MassMatrix(all);
  for (int k = 0; k < 6; ++k)  // the lower triangle, which the Cholesky decomposition reads
    for (int i = k; i < 6; ++i)
      mass(i, k) -= momentum.row(i).transpose().dot(work.legs_per_trunk.col(k)).Sum();
  work.trunk_mass.Compute(mass);
}

FootMotion QuadrupedBody::Foot(int leg) const {
  return work_->feet[leg];
}

FootMotion QuadrupedBody::MotionOf(int body, const Vec<3>& p_B) const {
  const Work& work = *work_;
  const Vec<3> p_W = Position(body, p_B), r = p_W - work.origin;
  FootMotion motion{p_W, work.x.v_W + work.x.w_W.cross(r), work.x.w_W};
  const int joint = body - 1, leg = body == 0 ? 0 : joint / kJointsPerLeg;
  for (int i = 0; body > 0 && i <= joint % kJointsPerLeg; ++i) {
    const Vec<6> axis = work.x.qd[kJointsPerLeg * leg + i] * Of(leg, work.axes[i]);
    motion.w_W += axis.head<3>();
    motion.v_W += axis.tail<3>() + Vec<3>(axis.head<3>()).cross(r);
  }
  return motion;
}

Vec<3> QuadrupedBody::Origin(int body) const {
  return ToEigen(work_->poses[body]->p());
}

Vec<3> QuadrupedBody::Position(int body, const Vec<3>& p_B) const {
  return ToEigen(*work_->poses[body] * (~model_->axes[body] * ToSimbody(p_B)));
}

double QuadrupedBody::KineticEnergy() const {
  const LeggedState& x = work_->x;
  double* u = work_->state.updU().updContiguousScalarData();  // angular before linear velocity, both in W
  for (int i = 0; i < 3; ++i) {
    u[i] = x.w_W[i];
    u[3 + i] = x.v_W[i];
  }
  for (int j = 0; j < kNumJoints; ++j) u[model_->u_index[j]] = x.qd[j];
  model_->matter.realizeVelocityKinematics(work_->state);
  return model_->matter.calcKineticEnergy(work_->state) + model_->rotor_inertia / 2 * x.qd.squaredNorm();
}

Vec<3> QuadrupedBody::Com() const {
  return work_->com;
}

LeggedAcceleration QuadrupedBody::Acceleration(const Vec<12>& torque, std::span<const PointForce> forces,
                                               double gravity) const {
  const Work& work = *work_;
  Vec<6> trunk_load = -work.trunk_bias;
  Vec<12> joint_load = torque;
  for (const PointForce& at : forces) {
    const Vec<6> wrench = At<double>(at.p_W - work.origin, at.torque_W, at.force_W);
    trunk_load += wrench;
    if (at.body == 0) continue;
    const int joint = at.body - 1, leg = joint / kJointsPerLeg;
    for (int i = 0; i <= joint % kJointsPerLeg; ++i)
      joint_load[kJointsPerLeg * leg + i] += Of(leg, work.axes[i]).dot(wrench);
  }
  Vector3<PerLeg> load;
  for (int i = 0; i < kJointsPerLeg; ++i)
    load[i] = PerLeg::Of([&](int leg) { return joint_load[kJointsPerLeg * leg + i]; }) - work.joint_bias[i];
  for (int i = 0; i < 6; ++i) trunk_load[i] -= work.legs_per_trunk.col(i).dot(load).Sum();
  const Vec<6> trunk = work.trunk_mass.Solve<1>(trunk_load);
  const Vector3<PerLeg> legs =
      work.leg_mass_inverse * load - work.legs_per_trunk.lazyProduct(trunk.cast<PerLeg>());
  LeggedAcceleration out;
  out.alpha_W = trunk.head<3>();
  out.a_W = trunk.tail<3>() - Vec<3>(0, 0, gravity);
  for (int leg = 0; leg < kNumLegs; ++leg)
    out.qdd.segment<kJointsPerLeg>(kJointsPerLeg * leg) = Of(leg, legs);
  return out;
}

}  // namespace tenon
