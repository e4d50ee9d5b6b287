#include <tenon/plants/cdpr/free_rigid_body.h>
#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/model/vectors.h>
#include <tenon/plants/simbody.h>
#include <tenon/systems/analysis/internal/small_matrices.h>

#include <fmt/format.h>

namespace tenon {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

SimTK::MassProperties MakeMassProperties(double mass, const Eigen::Matrix3d& I) {
  try {
    return {mass, SimTK::Vec3(0), SimTK::Inertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2))};
  } catch (const std::exception& error) {
    throw ParameterError(fmt::format(
        "the inertia with the moments {}, {}, {} kg m^2 is that of no rigid body; check values and units: {}",
        I(0, 0), I(1, 1), I(2, 2), error.what()));
  }
}

Matrix6 ToEigen(const SimTK::SpatialInertia& body) {
  const SimTK::SymMat33 moments = body.calcInertia().asSymMat33();
  Eigen::Matrix3d J;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) J(r, c) = r >= c ? moments(r, c) : moments(c, r);
  const SimTK::Vec3& com = body.getMassCenter();
  return SpatialInertia(body.getMass(), {com[0], com[1], com[2]}, J);
}

}  // namespace

struct FreeRigidBody::Model {
  Model(double mass, const Eigen::Matrix3d& inertia_B)
      : matter(system),
        body(matter.Ground(), SimTK::Transform(), SimTK::Body::Rigid(MakeMassProperties(mass, inertia_B)),
             SimTK::Transform()) {
    RealizeTopology(system);
  }
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter;
  SimTK::MobilizedBody::Free body;
};

struct FreeRigidBody::Work {
  explicit Work(const Model& model) : state(model.system.getDefaultState()) {
    model.system.realizeModel(state);
    Find(model);
  }
  Work(const Model& model, const Work& other) : state(other.state) { Find(model); }

  SimTK::State state;
  const SimTK::SpatialInertia* inertia = nullptr;  // constant address in the state's cache

 private:
  void Find(const Model& model) {
    model.system.realize(state, SimTK::Stage::Instance);
    model.matter.realizePositionKinematics(state);
    inertia = &model.body.getBodySpatialInertiaInGround(state);
  }
};

FreeRigidBody::FreeRigidBody() = default;
FreeRigidBody::~FreeRigidBody() = default;

FreeRigidBody::FreeRigidBody(double mass, const Eigen::Matrix3d& inertia_B)
    : model_(std::make_shared<const Model>(mass, inertia_B)), work_(std::make_unique<Work>(*model_)) {}

FreeRigidBody::FreeRigidBody(const FreeRigidBody& other)
    : model_(other.model_),
      work_(other.work_ == nullptr ? nullptr : std::make_unique<Work>(*model_, *other.work_)),
      acceleration_(other.acceleration_),
      kinetic_energy_(other.kinetic_energy_) {}

FreeRigidBody& FreeRigidBody::operator=(const FreeRigidBody& other) {
  FreeRigidBody copy(other);
  model_ = std::move(copy.model_);
  work_ = std::move(copy.work_);
  acceleration_ = copy.acceleration_;
  kinetic_energy_ = copy.kinetic_energy_;
  return *this;
}

void FreeRigidBody::Calc(const PlatformState& x, const PlatformWrench& wrench, const Payload& payload,
                         double gravity) {
  SimTK::State& state = work_->state;
  // Raw data, because Simbody as packaged checks every access to an element.
  double* q = state.updQ().updContiguousScalarData();  // (w, x, y, z), position
  Vector6 velocity;
  velocity << x.w_W, x.v_W;
  for (int i = 0; i < 4; ++i) q[i] = x.q_WB[i];
  for (int i = 0; i < 3; ++i) q[4 + i] = x.p_WB[i];
  // Realizes only what is read below: whole stages of the System take four times as long.
  model_->matter.realizePositionKinematics(state);

  const SimTK::SpatialInertia& body = *work_->inertia;
  Matrix6 inertia = ToEigen(body);
  Vector6 force;
  force << wrench.torque_W, wrench.force_W;
  const SimTK::Vec3 w(x.w_W[0], x.w_W[1], x.w_W[2]);
  const SimTK::Vec3 gyroscopic = body.getMass() * (w % (body.getUnitInertia() * w));
  for (int i = 0; i < 3; ++i) force[i] -= gyroscopic[i];
  if (payload.mass != 0) {
    const Vec<3> r = RotationFromQuaternion(x.q_WB) * payload.p_B;
    const Vec<3> centripetal = payload.mass * x.w_W.cross(x.w_W.cross(r));
    inertia += SpatialInertia(payload.mass, r, -payload.mass * CrossMatrix(r) * CrossMatrix(r));
    force.head<3>() -= r.cross(centripetal);
    force.tail<3>() -= centripetal;
  }
  kinetic_energy_ = velocity.dot(inertia * velocity) / 2;
  const Vector6 A = internal::SolveCholesky<6>(inertia, force);
  acceleration_.alpha_W = A.head<3>();
  acceleration_.a_W = A.tail<3>();
  acceleration_.a_W[2] -= gravity;
}

}  // namespace tenon
