#include "tenon/plants/free_rigid_body.h"

#include <fmt/format.h>
#include <tenon/plants/simbody.h>
#include <tenon/systems/errors.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <utility>

namespace tenon {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

SimTK::Vec3 ToSimbody(const Vec<3>& v) {
  return {v[0], v[1], v[2]};
}
Vec<3> FromSimbody(const SimTK::Vec3& v) {
  return {v[0], v[1], v[2]};
}

SimTK::MassProperties MakeMassProperties(double mass, const Eigen::Matrix3d& I) {
  try {
    return {mass, SimTK::Vec3(0), SimTK::Inertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2))};
  } catch (const std::exception& error) {
    throw ParameterError(fmt::format(
        "the inertia with the moments {}, {}, {} kg m^2 is that of no rigid body; check values and units: {}",
        I(0, 0), I(1, 1), I(2, 2), error.what()));
  }
}

Eigen::Matrix3d Cross(const Vec<3>& r) {
  Eigen::Matrix3d cross;
  cross << 0, -r[2], r[1], r[2], 0, -r[0], -r[1], r[0], 0;
  return cross;
}

/// Spatial inertia of a mass at r with the moments of inertia J, both about and from the body's origin;
/// angular before linear.
Matrix6 SpatialInertia(double mass, const Vec<3>& r, const Eigen::Matrix3d& J) {
  const Eigen::Matrix3d moment = mass * Cross(r);
  Matrix6 inertia;
  inertia << J, moment, -moment, mass * Eigen::Matrix3d::Identity();
  return inertia;
}

Matrix6 PointInertia(double mass, const Vec<3>& r) {
  return SpatialInertia(mass, r, -mass * Cross(r) * Cross(r));
}

Matrix6 BodyInertia(const SimTK::SpatialInertia& body) {
  const SimTK::SymMat33 moments = body.calcInertia().asSymMat33();
  Eigen::Matrix3d J;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) J(r, c) = r >= c ? moments(r, c) : moments(c, r);
  return SpatialInertia(body.getMass(), FromSimbody(body.getMassCenter()), J);
}

}  // namespace

struct FreeRigidBody::Model {
  Model(double mass, const Eigen::Matrix3d& inertia_B)
      : matter(system),
        body(matter.Ground(), SimTK::Transform(), SimTK::Body::Rigid(MakeMassProperties(mass, inertia_B)),
             SimTK::Transform()) {
    system.realizeTopology();
  }
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter;
  SimTK::MobilizedBody::Free body;
};

struct FreeRigidBody::Work {
  explicit Work(const Model& model) : state(model.system.getDefaultState()) {
    model.system.realizeModel(state);
    forces.setToZero();
  }
  SimTK::State state;
  SimTK::Vector mobility_forces{6, 0.0};
  SimTK::Vector_<SimTK::SpatialVec> forces{2};  ///< on ground and body, at their origins, in W
  SimTK::Vector u_dot{6};
  SimTK::Vector_<SimTK::SpatialVec> accelerations{2};
};

FreeRigidBody::FreeRigidBody() = default;
FreeRigidBody::~FreeRigidBody() = default;

FreeRigidBody::FreeRigidBody(double mass, const Eigen::Matrix3d& inertia_B)
    : model_(std::make_shared<const Model>(mass, inertia_B)), work_(std::make_unique<Work>(*model_)) {}

FreeRigidBody::FreeRigidBody(const FreeRigidBody& other)
    : model_(other.model_),
      work_(other.work_ == nullptr ? nullptr : std::make_unique<Work>(*other.work_)),
      acceleration_(other.acceleration_),
      quaternion_rate_(other.quaternion_rate_),
      kinetic_energy_(other.kinetic_energy_) {}

FreeRigidBody& FreeRigidBody::operator=(const FreeRigidBody& other) {
  FreeRigidBody copy(other);
  model_ = std::move(copy.model_);
  work_ = std::move(copy.work_);
  acceleration_ = copy.acceleration_;
  quaternion_rate_ = copy.quaternion_rate_;
  kinetic_energy_ = copy.kinetic_energy_;
  return *this;
}

void FreeRigidBody::Calc(const PlatformState& x, const PlatformWrench& wrench, const Payload& payload,
                         double gravity) {
  SimTK::State& state = work_->state;
  SimTK::Vector& q = state.updQ();  // (w, x, y, z), position
  SimTK::Vector& u = state.updU();  // angular before linear velocity, both in W
  for (int i = 0; i < 4; ++i) q[i] = x.q_WB[i];
  for (int i = 0; i < 3; ++i) {
    q[4 + i] = x.p_WB[i];
    u[i] = x.w_W[i];
    u[3 + i] = x.v_W[i];
  }
  model_->system.realize(state, SimTK::Stage::Dynamics);
  for (int i = 0; i < 4; ++i) quaternion_rate_[i] = state.getQDot()[i];
  kinetic_energy_ = model_->matter.calcKineticEnergy(state);

  const bool loaded = payload.mass != 0;
  Vec<3> r, pull;
  SimTK::SpatialVec force(ToSimbody(wrench.torque_W), ToSimbody(wrench.force_W));
  if (loaded) {
    r = RotationFromQuaternion(x.q_WB) * payload.p_B;
    pull = -payload.mass * x.w_W.cross(x.w_W.cross(r));
    force += SimTK::SpatialVec(ToSimbody(r.cross(pull)), ToSimbody(pull));
    kinetic_energy_ += payload.mass / 2 * (x.v_W + x.w_W.cross(r)).squaredNorm();
  }
  work_->forces[1] = force;
  model_->matter.calcAccelerationIgnoringConstraints(state, work_->mobility_forces, work_->forces,
                                                     work_->u_dot, work_->accelerations);
  acceleration_.alpha_W = FromSimbody(work_->accelerations[1][0]);
  acceleration_.a_W = FromSimbody(work_->accelerations[1][1]);

  if (loaded) {
    const Matrix6 bare = BodyInertia(model_->body.getBodySpatialInertiaInGround(state));
    Vector6 A;
    A << acceleration_.alpha_W, acceleration_.a_W;
    A = Matrix6(bare + PointInertia(payload.mass, r)).llt().solve(bare * A).eval();
    acceleration_.alpha_W = A.head<3>();
    acceleration_.a_W = A.tail<3>();
  }
  acceleration_.a_W[2] -= gravity;
}

}  // namespace tenon
