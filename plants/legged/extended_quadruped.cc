#include <tenon/plants/legged/extended_quadruped.h>
#include <tenon/plants/legged/internal/simbody_conversions.h>
#include <tenon/plants/legged/quadruped_multibody.h>
#include <tenon/systems/analysis/matrix_functions.h>
#include <tenon/systems/framework/types/errors.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <fmt/format.h>

#include <array>
#include <exception>
#include <mutex>
#include <utility>
#include <vector>

namespace tenon {
namespace {

using internal::ToEigen;
using internal::ToSimbody;

constexpr int kNumBodies = 1 + kNumJoints;
constexpr double kNormRate = 5;         // decay rate of the error of a quaternion's length [1/s]
constexpr double kConstraintRate = 50;  // decay rate of the errors of constraints [1/s]
constexpr double kAssembled = 1e-9;     // largest error of constraints at the start [m, rad, m/s, rad/s]

/// Building Systems in two threads at once would call the user's function, which may keep state, in both.
std::mutex& BuildMutex() {
  static std::mutex mutex;
  return mutex;
}

Eigen::MatrixXd ToMatrix(const SimTK::Matrix& M) {
  Eigen::MatrixXd out(M.nrow(), M.ncol());
  for (int row = 0; row < M.nrow(); ++row)
    for (int column = 0; column < M.ncol(); ++column) out(row, column) = M(row, column);
  return out;
}
Eigen::VectorXd ToVector(const SimTK::Vector& v) {
  Eigen::VectorXd out(v.size());
  for (int i = 0; i < v.size(); ++i) out[i] = v[i];
  return out;
}
Eigen::VectorXd Pick(const SimTK::Vector& v, const std::vector<int>& indices) {
  Eigen::VectorXd out(static_cast<Eigen::Index>(indices.size()));
  for (std::size_t i = 0; i < indices.size(); ++i) out[static_cast<Eigen::Index>(i)] = v[indices[i]];
  return out;
}
void Place(const Eigen::VectorXd& values, const std::vector<int>& indices, SimTK::Vector& v) {
  for (std::size_t i = 0; i < indices.size(); ++i) v[indices[i]] = values[static_cast<Eigen::Index>(i)];
}

std::string Join(const std::vector<std::string>& items) {
  std::string list;
  for (std::size_t i = 0; i < items.size(); ++i) list += (i == 0 ? "" : ",") + items[i];
  return list;
}
/// The name of one of `count` elements of a joint.
std::string ElementName(const std::string& joint, int count, int index) {
  return count == 1 ? joint : fmt::format("{}_{}", joint, index);
}

}  // namespace

struct ExtendedQuadruped::Recipe {
  QuadrupedDescription robot;
  double gravity;
  ExtendQuadruped extend;
  Additions additions;
};

struct ExtendedQuadruped::Model : QuadrupedMultibody {
  Model(const QuadrupedDescription& robot, double gravity, const ExtendQuadruped& extend)
      : QuadrupedMultibody(robot, gravity),
        discrete(forces, matter),
        rotor_inertia(robot.drive.rotor_inertia) {
    const std::scoped_lock lock(BuildMutex());
    extend(*this);
    RealizeTopology(system);
    state = system.getDefaultState();
    system.realizeModel(state);
    system.realize(state, SimTK::Stage::Instance);
    for (int i = 0; i < kNumBodies; ++i)
      indices[static_cast<std::size_t>(i)] = body(i).getMobilizedBodyIndex();
    for (std::size_t j = 0; j < kNumJoints; ++j) {
      q_index[j] = body(1 + j).getFirstQIndex(state);
      u_index[j] = body(1 + j).getFirstUIndex(state);
    }
    for (SimTK::MobilizedBodyIndex i(1 + kNumBodies); i < matter.getNumBodies(); ++i) {
      const SimTK::MobilizedBody& joint = matter.getMobilizedBody(i);
      if (joint.hasMotion() || joint.isLockedByDefault())
        throw ParameterError(fmt::format(
            "the motion of the added joint '{}' is prescribed; give it a torque instead, or weld it",
            NameOf(i)));
      if (matter.isUsingQuaternion(state, i)) quaternions.push_back(joint.getFirstQIndex(state));
      for (int k = 0; k < joint.getNumQ(state); ++k) added_q.push_back(joint.getFirstQIndex(state) + k);
      for (int k = 0; k < joint.getNumU(state); ++k) added_u.push_back(joint.getFirstUIndex(state) + k);
    }
    num_z = state.getNZ();
    num_constraints = state.getNUDotErr();
    mobility_forces = SimTK::Vector(state.getNU(), 0.0);
    body_forces.resize(matter.getNumBodies());
  }
  std::string NameOf(int index) const {
    const auto at = names().find(index);
    return at == names().end() ? fmt::format("added_{}", index - 1 - kNumBodies) : at->second;
  }

  void SetRobot(const LeggedState& x) {
    SimTK::Vector& q = state.updQ();  // (w, x, y, z), position, joint angles
    SimTK::Vector& u = state.updU();  // angular before linear velocity, both in W
    const Vec<4> turn = x.q_WB.normalized();
    for (int i = 0; i < 4; ++i) q[i] = turn[i];
    for (int i = 0; i < 3; ++i) q[4 + i] = x.p_WB[i], u[i] = x.w_W[i], u[3 + i] = x.v_W[i];
    for (std::size_t j = 0; j < kNumJoints; ++j) {
      q[q_index[j]] = x.q[static_cast<Eigen::Index>(j)];
      u[u_index[j]] = x.qd[static_cast<Eigen::Index>(j)];
    }
  }
  Additions MakeAdditions(const LeggedState& initial);
  void Assemble();
  void Correct(Eigen::VectorXd& rates) const;

  SimTK::Force::DiscreteForces discrete;
  double rotor_inertia;
  SimTK::State state;
  std::array<SimTK::MobilizedBodyIndex, kNumBodies> indices;
  std::array<int, kNumJoints> q_index{}, u_index{};
  std::vector<int> added_q, added_u;
  std::vector<int> quaternions;  // first coordinates of added quaternions
  int num_z = 0, num_constraints = 0;
  SimTK::Vector mobility_forces;
  SimTK::Vector_<SimTK::SpatialVec> body_forces;
};

ExtendedQuadruped::Additions ExtendedQuadruped::Model::MakeAdditions(const LeggedState& initial) {
  SetRobot(initial);
  if (num_constraints > 0) Assemble();
  system.realize(state, SimTK::Stage::Velocity);
  struct Names {
    std::vector<std::string> elements{}, units{};
    States Joined() const { return {Join(elements), Join(units), {}}; }
  } q, u, z;
  std::vector<std::string> force_units;
  for (SimTK::MobilizedBodyIndex i(1 + kNumBodies); i < matter.getNumBodies(); ++i) {
    const SimTK::MobilizedBody& joint = matter.getMobilizedBody(i);
    const int nq = joint.getNumQ(state), nu = joint.getNumU(state);
    const int ratios = matter.isUsingQuaternion(state, i) ? 4 : 0;
    const auto turns = [&](int k) {
      return k < nu && joint.getHCol(state, SimTK::MobilizerUIndex(k))[0].norm() > 0;
    };
    for (int k = 0; k < nq; ++k) {
      q.elements.push_back(ElementName(NameOf(i), nq, k));
      q.units.push_back(k < ratios ? "" : turns(ratios > 0 ? k - 1 : k) ? "rad" : "m");
    }
    for (int k = 0; k < nu; ++k) {
      u.elements.push_back(ElementName(NameOf(i), nu, k));
      u.units.push_back(turns(k) ? "rad/s" : "m/s");
      force_units.push_back(turns(k) ? "N m" : "N");
    }
  }
  for (int k = 0; k < num_z; ++k) z.elements.push_back(fmt::format("z_{}", k));
  Additions out{q.Joined(), u.Joined(), z.Joined(), Join(force_units), {}};
  out.q.initial = Pick(state.getQ(), added_q);
  out.u.initial = Pick(state.getU(), added_u);
  out.z.initial = ToVector(state.getZ());
  for (const Drawn& each : drawn()) out.shapes.push_back(each.shape_B);
  system.realize(state, SimTK::Stage::Acceleration);
  if (!ToVector(state.getUDot()).allFinite())
    throw ParameterError(
        "the added joints have no finite accelerations at the start; give the bodies at the ends of chains "
        "mass and inertia");
  return out;
}

/// Moves the added coordinates such that the constraints are met.
void ExtendedQuadruped::Model::Assemble() {
  const auto errors_of = [](const SimTK::Vector& errors, int count) {
    return ToVector(errors).head(count).eval();
  };
  system.realize(state, SimTK::Stage::Position);
  const int positions = state.getNQErr() - matter.getNumQuaternionsInUse(state);
  const auto misses = [&](const Eigen::VectorXd& error) {
    return error.size() > 0 && error.lpNorm<Eigen::Infinity>() > kAssembled;
  };
  if (misses(errors_of(state.getQErr(), positions))) {
    SimTK::Assembler assembler(system);
    assembler.setErrorTolerance(kAssembled / 10);
    for (const SimTK::MobilizedBodyIndex index : indices) assembler.lockMobilizer(index);
    assembler.assemble(state);
  }
  system.realize(state, SimTK::Stage::Velocity);
  SimTK::Matrix G;
  matter.calcG(state, G);
  const Eigen::MatrixXd all = ToMatrix(G).topRows(state.getNUErr());
  Eigen::MatrixXd added(all.rows(), static_cast<Eigen::Index>(added_u.size()));
  for (std::size_t i = 0; i < added_u.size(); ++i)
    added.col(static_cast<Eigen::Index>(i)) = all.col(added_u[i]);
  const Eigen::VectorXd error = ToVector(state.getUErr());
  if (!misses(error)) return;
  Eigen::VectorXd u = Pick(state.getU(), added_u);
  if (u.size() > 0) u -= SolveLeastSquares(added, error).x;
  Place(u, added_u, state.updU());
  system.realize(state, SimTK::Stage::Velocity);
  if (misses(ToVector(state.getUErr())))
    throw ParameterError(fmt::format(
        "the added constraints are not met by the robot's initial velocities, by {} m/s or rad/s; "
        "start at rest",
        ToVector(state.getUErr()).lpNorm<Eigen::Infinity>()));
}

/// Adds the acceleration d of the class's comment.
void ExtendedQuadruped::Model::Correct(Eigen::VectorXd& rates) const {
  SimTK::Matrix simbody;
  matter.calcM(state, simbody);
  Eigen::MatrixXd M = ToMatrix(simbody);
  Eigen::VectorXd load = Eigen::VectorXd::Zero(rates.size());
  for (const int i : u_index) {
    M(i, i) += rotor_inertia;
    load[i] = -rotor_inertia * rates[i];
  }
  const Eigen::LLT<Eigen::MatrixXd> factors(M);
  Eigen::VectorXd change = factors.solve(load);
  if (num_constraints > 0) {
    matter.calcG(state, simbody);
    const Eigen::MatrixXd G = ToMatrix(simbody);
    const Eigen::VectorXd v = ToVector(state.getUErr()), p = ToVector(state.getQErr());
    const Eigen::Index holonomic = p.size() - matter.getNumQuaternionsInUse(state);
    Eigen::VectorXd wanted = Eigen::VectorXd::Zero(num_constraints);
    wanted.head(v.size()) -= 2 * kConstraintRate * v;
    wanted.head(holonomic) -= kConstraintRate * kConstraintRate * p.head(holonomic);
    const Eigen::MatrixXd response = factors.solve(G.transpose());
    const Eigen::VectorXd multipliers = SolveLeastSquares(G * response, G * change - wanted).x;
    change -= response * multipliers;
  }
  rates += change;
}

namespace {

/// Calls `f`, with Simbody's exceptions as an Error of the framework.
template <class E, class F>
decltype(auto) Guarded(const char* what, const F& f) {
  try {
    return f();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw E(fmt::format("{}: {}", what, error.what()));
  }
}

}  // namespace

ExtendedQuadruped::ExtendedQuadruped(const QuadrupedDescription& robot, double gravity,
                                     const ExtendQuadruped& extend, const LeggedState& initial) {
  if (!extend) return;
  Guarded<ParameterError>("Simbody refuses the additions to the robot", [&] {
    model_ = std::make_unique<Model>(robot, gravity, extend);
    recipe_ = std::make_shared<const Recipe>(Recipe{robot, gravity, extend, model_->MakeAdditions(initial)});
  });
}

ExtendedQuadruped::ExtendedQuadruped() = default;
ExtendedQuadruped::ExtendedQuadruped(ExtendedQuadruped&& other) = default;
ExtendedQuadruped& ExtendedQuadruped::operator=(ExtendedQuadruped&& other) = default;
ExtendedQuadruped::~ExtendedQuadruped() = default;

ExtendedQuadruped::ExtendedQuadruped(const ExtendedQuadruped& other) : recipe_(other.recipe_) {
  if (!other.exists()) return;
  Guarded<ParameterError>("Simbody refuses the additions to the robot", [&] {
    model_ = std::make_unique<Model>(recipe_->robot, recipe_->gravity, recipe_->extend);
  });
  const Model& of = *other.model_;
  if (model_->added_q != of.added_q || model_->added_u != of.added_u || model_->num_z != of.num_z ||
      model_->num_constraints != of.num_constraints || model_->drawn().size() != of.drawn().size())
    throw ParameterError("'extend' has added something else than before; it must add the same at each call");
  model_->state.updTime() = of.state.getTime();
  model_->state.updQ() = of.state.getQ();
  model_->state.updU() = of.state.getU();
  model_->state.updZ() = of.state.getZ();
  model_->system.realize(model_->state, SimTK::Stage::Velocity);
}

ExtendedQuadruped& ExtendedQuadruped::operator=(const ExtendedQuadruped& other) {
  if (this != &other) *this = ExtendedQuadruped(other);
  return *this;
}

const ExtendedQuadruped::Additions& ExtendedQuadruped::additions() const {
  static const Additions none;
  return exists() ? recipe_->additions : none;
}

void ExtendedQuadruped::SetState(double time, const LeggedState& x, const Eigen::VectorXd& q,
                                 const Eigen::VectorXd& u, const Eigen::VectorXd& z) {
  Model& model = *model_;
  SimTK::State& state = model.state;
  state.updTime() = time;
  model.SetRobot(x);
  Place(q, model.added_q, state.updQ());
  Place(u, model.added_u, state.updU());
  if (model.num_z > 0) {
    SimTK::Vector& to = state.updZ();
    for (int i = 0; i < model.num_z; ++i) to[i] = z[i];
  }
  Guarded<RunError>("Simbody cannot compute the motion of the extended robot",
                    [&] { model.system.realize(state, SimTK::Stage::Velocity); });
}

void ExtendedQuadruped::CalcRates(const Vec<12>& torque, std::span<const PointForce> forces,
                                  const Eigen::VectorXd& added, ExtendedRates* rates) const {
  Model& model = *model_;
  SimTK::State& state = model.state;
  for (std::size_t j = 0; j < kNumJoints; ++j)
    model.mobility_forces[model.u_index[j]] = torque[static_cast<Eigen::Index>(j)];
  Place(added, model.added_u, model.mobility_forces);
  for (int i = 0; i < model.body_forces.size(); ++i)
    model.body_forces[i] = SimTK::SpatialVec(SimTK::Vec3(0), SimTK::Vec3(0));
  for (const PointForce& at : forces) {
    const auto index = static_cast<std::size_t>(at.body);
    const SimTK::Vec3 arm = ToSimbody(at.p_W) - model.body(index).getBodyOriginLocation(state);
    const SimTK::Vec3 force = ToSimbody(at.force_W);
    model.body_forces[model.indices[index]] += SimTK::SpatialVec(ToSimbody(at.torque_W) + arm % force, force);
  }
  Eigen::VectorXd u;
  Guarded<RunError>("Simbody cannot compute the accelerations of the extended robot", [&] {
    model.discrete.setAllMobilityForces(state, model.mobility_forces);
    model.discrete.setAllBodyForces(state, model.body_forces);
    model.system.realize(state, SimTK::Stage::Acceleration);
    u = ToVector(state.getUDot());
    if (model.rotor_inertia > 0 || model.num_constraints > 0) model.Correct(u);
  });
  rates->robot.alpha_W = u.segment<3>(0);
  rates->robot.a_W = u.segment<3>(3);
  for (std::size_t j = 0; j < kNumJoints; ++j)
    rates->robot.qdd[static_cast<Eigen::Index>(j)] = u[model.u_index[j]];
  rates->u.resize(static_cast<Eigen::Index>(model.added_u.size()));
  for (std::size_t i = 0; i < model.added_u.size(); ++i)
    rates->u[static_cast<Eigen::Index>(i)] = u[model.added_u[i]];
  SimTK::Vector qdot = state.getQDot();
  const SimTK::Vector& q = state.getQ();
  for (const int first : model.quaternions) {
    const double excess = 1 - q(first, 4).normSqr();
    for (int i = first; i < first + 4; ++i) qdot[i] += kNormRate * excess * q[i];
  }
  rates->q = Pick(qdot, model.added_q);
  rates->z = ToVector(state.getZDot());
}

WrenchEstimate ExtendedQuadruped::MomentumRate(const LeggedAcceleration& acceleration,
                                               const Vec<3>& p_W) const {
  const Model& model = *model_;
  SimTK::Vector u(model.state.getNU(), 0.0);  // added joints do not affect the robot's bodies
  for (int i = 0; i < 3; ++i) u[i] = acceleration.alpha_W[i], u[3 + i] = acceleration.a_W[i];
  for (std::size_t j = 0; j < kNumJoints; ++j)
    u[model.u_index[j]] = acceleration.qdd[static_cast<Eigen::Index>(j)];
  SimTK::Vector_<SimTK::SpatialVec> accelerations;
  model.matter.calcBodyAccelerationFromUDot(model.state, u, accelerations);
  SimTK::Vec3 force(0), torque(0);
  for (const SimTK::MobilizedBodyIndex index : model.indices) {
    const SimTK::MobilizedBody& body = model.matter.getMobilizedBody(index);
    const SimTK::SpatialVec rate = body.getBodySpatialInertiaInGround(model.state) * accelerations[index] +
                                   model.matter.getGyroscopicForce(model.state, index);
    force += rate[1];
    torque += rate[0] + (body.getBodyOriginLocation(model.state) - ToSimbody(p_W)) % rate[1];
  }
  WrenchEstimate wrench{ToEigen(force), ToEigen(torque)};
  if (const RigidInertia& replaced = model.replaced(); replaced.mass > 0) {  // as if fixed to the trunk
    const SimTK::MobilizedBody& trunk = model.body(0);
    const Vec<3> origin = ToEigen(trunk.getBodyOriginLocation(model.state)),
                 w = ToEigen(trunk.getBodyAngularVelocity(model.state)), alpha = acceleration.alpha_W;
    const SimTK::Vec4 turn = trunk.getBodyRotation(model.state).convertRotationToQuaternion().asVec4();
    const RigidInertia part =
        replaced.In(RotationFromQuaternion({turn[0], turn[1], turn[2], turn[3]}), origin);
    const Vec<3> arm = part.com - origin;
    const Vec<3> rate = part.mass * (acceleration.a_W + alpha.cross(arm) + w.cross(w.cross(arm)));
    wrench.force_W += rate;
    wrench.torque_W +=
        (part.com - p_W).cross(rate) + part.inertia * alpha + w.cross((part.inertia * w).eval());
  }
  return wrench;
}

double ExtendedQuadruped::KineticEnergy() const {
  double rotors = 0;
  for (const int i : model_->u_index) rotors += model_->state.getU()[i] * model_->state.getU()[i];
  return model_->system.calcKineticEnergy(model_->state) + model_->rotor_inertia / 2 * rotors;
}

double ExtendedQuadruped::PotentialEnergy() const {
  model_->system.realize(model_->state, SimTK::Stage::Dynamics);
  return model_->system.calcPotentialEnergy(model_->state);
}

void ExtendedQuadruped::MoveShapes(std::size_t first, Geometry* geometry) const {
  for (std::size_t i = 0; i < model_->drawn().size(); ++i) {
    const QuadrupedMultibody::Drawn& each = model_->drawn()[i];
    const SimTK::Transform& X = model_->matter.getMobilizedBody(each.body).getBodyTransform(model_->state);
    const SimTK::Vec4 turn = X.R().convertRotationToQuaternion().asVec4();
    Shape& shape = (*geometry)[first + i];
    shape.p_W = ToEigen(X * ToSimbody(each.shape_B.p_W));
    shape.q_W = QuaternionProduct({turn[0], turn[1], turn[2], turn[3]}, each.shape_B.q_W);
    shape.vector_W = ToEigen(X.R() * ToSimbody(each.shape_B.vector_W));
  }
}

}  // namespace tenon
