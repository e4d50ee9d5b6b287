#include <tenon/plants/multibody/extended_robot.h>
#include <tenon/plants/multibody/internal/simbody_conversions.h>
#include <tenon/plants/multibody/robot_multibody.h>
#include <tenon/systems/analysis/matrix_functions.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <fmt/format.h>

#include <exception>
#include <mutex>

namespace tenon {
namespace {

using internal::ToEigen;
using internal::ToSimbody;

constexpr double kNormRate = 5;         // decay rate of the error of a quaternion's length [1/s]
constexpr double kConstraintRate = 50;  // decay rate of the errors of constraints [1/s]
constexpr double kNotConnected = std::numeric_limits<double>::quiet_NaN();
constexpr double kAssembled = 1e-9;  // largest error of constraints at the start [m, rad, m/s, rad/s]

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
  for (std::size_t i = 0; i < indices.size(); ++i) out[i] = v[indices[i]];
  return out;
}
void Place(const Eigen::VectorXd& values, const std::vector<int>& indices, SimTK::Vector& v) {
  for (std::size_t i = 0; i < indices.size(); ++i) v[indices[i]] = values[i];
}

std::string Join(const std::vector<std::string>& items) {
  std::string list;
  for (std::size_t i = 0; i < items.size(); ++i) list += (i == 0 ? "" : ",") + items[i];
  return list;
}
void CheckSize(const char* what, const Eigen::VectorXd& given, const char* of,
               const ExtendedRobot::Added& wanted) {
  if (given.size() == wanted.initial.size()) return;
  throw RunError(fmt::format("the {} have {} entries but the added joints have {}: {}; give one for each {}",
                             what, given.size(), wanted.initial.size(), wanted.spec.elements, of));
}
/// The name of one of `count` elements of a joint.
std::string ElementName(const std::string& joint, int count, int index) {
  return count == 1 ? joint : fmt::format("{}_{}", joint, index);
}

}  // namespace

struct ExtendedRobot::Recipe {
  Make make;
  Extend extend;
  double rotor_inertia;
  Additions additions;
};

struct ExtendedRobot::Model {
  explicit Model(const Recipe& recipe)
      : robot(recipe.make()),
        system(robot->system),
        matter(robot->matter),
        discrete(robot->forces, matter),
        rotor_inertia(recipe.rotor_inertia) {
    const std::scoped_lock lock(BuildMutex());
    recipe.extend(*robot);
    RealizeTopology(system);
    state = system.getDefaultState();
    system.realizeModel(state);
    system.realize(state, SimTK::Stage::Instance);
    for (std::size_t i = 1; i < robot->num_bodies(); ++i) {
      q_index.push_back(robot->body(i).getFirstQIndex(state));
      u_index.push_back(robot->body(i).getFirstUIndex(state));
    }
    for (SimTK::MobilizedBodyIndex i = first_added(); i < matter.getNumBodies(); ++i) {
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
  SimTK::MobilizedBodyIndex first_added() const {
    return SimTK::MobilizedBodyIndex(static_cast<int>(1 + robot->num_bodies()));
  }
  std::string NameOf(int index) const {
    const auto at = robot->names().find(index);
    return at == robot->names().end() ? fmt::format("added_{}", index - first_added()) : at->second;
  }

  void SetRobot(const Motion& motion) {
    SimTK::Vector& q = state.updQ();  // (w, x, y, z), position, joint angles
    SimTK::Vector& u = state.updU();  // angular before linear velocity, both in W
    const Vec<4> turn = motion.base.q_WB.normalized();
    for (int i = 0; i < 4; ++i) q[i] = turn[i];
    for (int i = 0; i < 3; ++i) {
      q[4 + i] = motion.base.p_WB[i];
      u[i] = motion.base.w_W[i];
      u[3 + i] = motion.base.v_W[i];
    }
    for (std::size_t j = 0; j < q_index.size(); ++j) {
      q[q_index[j]] = motion.q[j];
      u[u_index[j]] = motion.u[j];
    }
  }

  Additions MakeAdditions(const Motion& initial) {
    SetRobot(initial);
    if (num_constraints > 0) Assemble();
    system.realize(state, SimTK::Stage::Velocity);
    struct Names {
      std::vector<std::string> elements{}, units{};
      void JoinTo(Added& out) const {
        out.spec.elements = Join(elements);
        out.spec.units = Join(units);
      }
    } q, u, z, forces, positions, speeds;
    for (SimTK::MobilizedBodyIndex i = first_added(); i < matter.getNumBodies(); ++i) {
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
        forces.units.push_back(turns(k) ? "N m" : "N");
      }
    }
    forces.elements = u.elements;
    for (int k = 0; k < num_z; ++k) z.elements.push_back(fmt::format("z_{}", k));
    for (const RobotMultibody::Reference& each : robot->references()) {
      const SimTK::MobilizedBody& joint = matter.getMobilizedBody(each.joint);
      if (joint.getNumQ(state) != 1 || joint.getNumU(state) != 1)
        throw ParameterError(
            fmt::format("the added joint '{}' has {} coordinates; give references to joints with one",
                        NameOf(each.joint), joint.getNumQ(state)));
      const bool turns = joint.getHCol(state, SimTK::MobilizerUIndex(0))[0].norm() > 0;
      positions.elements.push_back(NameOf(each.joint));
      positions.units.push_back(turns ? "rad" : "m");
      speeds.units.push_back(turns ? "rad/s" : "m/s");
    }
    speeds.elements = positions.elements;
    Additions out;
    q.JoinTo(out.q);
    u.JoinTo(out.u);
    z.JoinTo(out.z);
    forces.JoinTo(out.forces);
    positions.JoinTo(out.position_references);
    speeds.JoinTo(out.speed_references);
    out.q.initial = Pick(state.getQ(), added_q);
    out.u.initial = Pick(state.getU(), added_u);
    out.z.initial = ToVector(state.getZ());
    out.forces.initial = Eigen::VectorXd::Zero(out.u.initial.size());
    const auto drives = static_cast<Eigen::Index>(positions.elements.size());
    out.position_references.initial = Eigen::VectorXd::Constant(drives, kNotConnected);
    out.speed_references.initial = Eigen::VectorXd::Zero(drives);
    for (const RobotMultibody::Drawn& each : robot->drawn()) out.shapes.push_back(each.shape_B);
    out.replaced = robot->replaced();
    system.realize(state, SimTK::Stage::Acceleration);
    if (!ToVector(state.getUDot()).allFinite())
      throw ParameterError(
          "the added joints have no finite accelerations at the start; give the bodies at the ends of chains "
          "mass and inertia");
    return out;
  }

  /// Moves the added coordinates such that the constraints are met.
  void Assemble() {
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
      for (SimTK::MobilizedBodyIndex i(1); i < first_added(); ++i) assembler.lockMobilizer(i);
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
  void Correct(const Eigen::Matrix<double, 6, 6>& payload, Eigen::VectorXd& rates) const {
    SimTK::Matrix simbody;
    matter.calcM(state, simbody);
    Eigen::MatrixXd M = ToMatrix(simbody);
    Eigen::VectorXd load = Eigen::VectorXd::Zero(rates.size());
    M.topLeftCorner<6, 6>() += payload;
    load.head<6>() = -payload * rates.head<6>();
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

  std::unique_ptr<RobotMultibody> robot;
  SimTK::MultibodySystem& system;
  SimTK::SimbodyMatterSubsystem& matter;
  SimTK::Force::DiscreteForces discrete;
  double rotor_inertia;
  SimTK::State state;
  std::vector<int> q_index, u_index;  // of the robot's joints
  std::vector<int> added_q, added_u;
  std::vector<int> quaternions;  // first coordinates of added quaternions
  int num_z = 0, num_constraints = 0;
  SimTK::Vector mobility_forces;
  SimTK::Vector_<SimTK::SpatialVec> body_forces;
};

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

ExtendedRobot::ExtendedRobot(Make make, Extend extend, double rotor_inertia, const Motion& initial) {
  Guarded<ParameterError>("Simbody refuses the additions to the robot", [&] {
    Recipe recipe{std::move(make), std::move(extend), rotor_inertia, {}};
    model_ = std::make_unique<Model>(recipe);
    recipe.additions = model_->MakeAdditions(initial);
    recipe_ = std::make_shared<const Recipe>(std::move(recipe));
  });
}

ExtendedRobot::ExtendedRobot() = default;
ExtendedRobot::ExtendedRobot(ExtendedRobot&& other) = default;
ExtendedRobot& ExtendedRobot::operator=(ExtendedRobot&& other) = default;
ExtendedRobot::~ExtendedRobot() = default;

ExtendedRobot::ExtendedRobot(const ExtendedRobot& other) : recipe_(other.recipe_) {
  if (!other.exists()) return;
  Guarded<ParameterError>("Simbody refuses the additions to the robot",
                          [&] { model_ = std::make_unique<Model>(*recipe_); });
  const Model& of = *other.model_;
  if (model_->added_q != of.added_q || model_->added_u != of.added_u || model_->num_z != of.num_z ||
      model_->num_constraints != of.num_constraints ||
      model_->robot->drawn().size() != of.robot->drawn().size() ||
      model_->robot->references().size() != of.robot->references().size())
    throw ParameterError("'extend' has added something else than before; it must add the same at each call");
  model_->state.updTime() = of.state.getTime();
  model_->state.updQ() = of.state.getQ();
  model_->state.updU() = of.state.getU();
  model_->state.updZ() = of.state.getZ();
  model_->robot->references() = of.robot->references();
  model_->system.realize(model_->state, SimTK::Stage::Velocity);
}

ExtendedRobot& ExtendedRobot::operator=(const ExtendedRobot& other) {
  if (this != &other) *this = ExtendedRobot(other);
  return *this;
}

const ExtendedRobot::Additions& ExtendedRobot::additions() const {
  static const Additions none;
  return exists() ? recipe_->additions : none;
}

void ExtendedRobot::SetState(double time, const Motion& robot, const Eigen::VectorXd& q,
                             const Eigen::VectorXd& u, const Eigen::VectorXd& z,
                             const Eigen::VectorXd& position_references,
                             const Eigen::VectorXd& speed_references) {
  Model& model = *model_;
  SimTK::State& state = model.state;
  state.updTime() = time;
  model.SetRobot(robot);
  Place(q, model.added_q, state.updQ());
  Place(u, model.added_u, state.updU());
  if (model.num_z > 0) {
    SimTK::Vector& to = state.updZ();
    for (int i = 0; i < model.num_z; ++i) to[i] = z[i];
  }
  CheckSize("position references", position_references, "joint", additions().position_references);
  CheckSize("speed references", speed_references, "joint", additions().speed_references);
  Eigen::Index next = 0;
  for (RobotMultibody::Reference& each : model.robot->references()) {
    each.position = position_references[next];
    each.speed = speed_references[next++];
  }
  Guarded<RunError>("Simbody cannot compute the motion of the extended robot",
                    [&] { model.system.realize(state, SimTK::Stage::Velocity); });
}

void ExtendedRobot::CalcRates(std::span<const double> torque, std::span<const PointForce> forces,
                              const Eigen::VectorXd& added, const Eigen::Matrix<double, 6, 6>& payload,
                              Eigen::VectorXd* robot, AddedRates* rates) const {
  Model& model = *model_;
  SimTK::State& state = model.state;
  CheckSize("added forces", added, "speed", additions().forces);
  for (std::size_t j = 0; j < model.u_index.size(); ++j) model.mobility_forces[model.u_index[j]] = torque[j];
  Place(added, model.added_u, model.mobility_forces);
  for (int i = 0; i < model.body_forces.size(); ++i)
    model.body_forces[i] = SimTK::SpatialVec(SimTK::Vec3(0), SimTK::Vec3(0));
  for (const PointForce& at : forces) {
    const SimTK::MobilizedBody& body = model.robot->body(static_cast<std::size_t>(at.body));
    const SimTK::Vec3 arm = ToSimbody(at.p_W) - body.getBodyOriginLocation(state);
    const SimTK::Vec3 force = ToSimbody(at.force_W);
    model.body_forces[body.getMobilizedBodyIndex()] +=
        SimTK::SpatialVec(ToSimbody(at.torque_W) + arm % force, force);
  }
  Eigen::VectorXd u;
  Guarded<RunError>("Simbody cannot compute the accelerations of the extended robot", [&] {
    model.discrete.setAllMobilityForces(state, model.mobility_forces);
    model.discrete.setAllBodyForces(state, model.body_forces);
    model.system.realize(state, SimTK::Stage::Acceleration);
    u = ToVector(state.getUDot());
    if (model.rotor_inertia > 0 || model.num_constraints > 0 || !payload.isZero(0)) model.Correct(payload, u);
  });
  const auto joints = static_cast<Eigen::Index>(model.u_index.size());
  robot->resize(6 + joints);
  robot->head<6>() = u.head<6>();
  for (Eigen::Index j = 0; j < joints; ++j) (*robot)[6 + j] = u[model.u_index[j]];
  rates->u.resize(static_cast<Eigen::Index>(model.added_u.size()));
  for (std::size_t i = 0; i < model.added_u.size(); ++i) rates->u[i] = u[model.added_u[i]];
  SimTK::Vector qdot = state.getQDot();
  const SimTK::Vector& q = state.getQ();
  for (const int first : model.quaternions) {
    const double excess = 1 - q(first, 4).normSqr();
    for (int i = first; i < first + 4; ++i) qdot[i] += kNormRate * excess * q[i];
  }
  rates->q = Pick(qdot, model.added_q);
  rates->z = ToVector(state.getZDot());
}

PlatformWrench ExtendedRobot::MomentumRate(const Eigen::VectorXd& robot, const Vec<3>& p_W) const {
  const Model& model = *model_;
  SimTK::Vector u(model.state.getNU(), 0.0);  // added joints do not affect the robot's bodies
  for (int i = 0; i < 6; ++i) u[i] = robot[i];
  for (std::size_t j = 0; j < model.u_index.size(); ++j) u[model.u_index[j]] = robot[6 + j];
  SimTK::Vector_<SimTK::SpatialVec> accelerations;
  model.matter.calcBodyAccelerationFromUDot(model.state, u, accelerations);
  SimTK::Vec3 force(0), torque(0);
  for (SimTK::MobilizedBodyIndex index(1); index < model.first_added(); ++index) {
    const SimTK::MobilizedBody& body = model.matter.getMobilizedBody(index);
    const SimTK::SpatialVec rate = body.getBodySpatialInertiaInGround(model.state) * accelerations[index] +
                                   model.matter.getGyroscopicForce(model.state, index);
    force += rate[1];
    torque += rate[0] + (body.getBodyOriginLocation(model.state) - ToSimbody(p_W)) % rate[1];
  }
  PlatformWrench wrench{ToEigen(force), ToEigen(torque)};
  if (const RigidInertia& replaced = model.robot->replaced(); replaced.mass > 0) {  // as if fixed to the base
    const SimTK::MobilizedBody& base = model.robot->body(0);
    const Vec<3> origin = ToEigen(base.getBodyOriginLocation(model.state)),
                 w = ToEigen(base.getBodyAngularVelocity(model.state)), alpha = robot.head<3>();
    const SimTK::Vec4 turn = base.getBodyRotation(model.state).convertRotationToQuaternion().asVec4();
    const RigidInertia part =
        replaced.In(RotationFromQuaternion({turn[0], turn[1], turn[2], turn[3]}), origin);
    const Vec<3> arm = part.com - origin;
    const Vec<3> rate = part.mass * (robot.segment<3>(3) + alpha.cross(arm) + w.cross(w.cross(arm)));
    wrench.force_W += rate;
    wrench.torque_W +=
        (part.com - p_W).cross(rate) + part.inertia * alpha + w.cross((part.inertia * w).eval());
  }
  return wrench;
}

double ExtendedRobot::KineticEnergy() const {
  double rotors = 0;
  for (const int i : model_->u_index) rotors += model_->state.getU()[i] * model_->state.getU()[i];
  return model_->system.calcKineticEnergy(model_->state) + model_->rotor_inertia / 2 * rotors;
}

double ExtendedRobot::PotentialEnergy() const {
  model_->system.realize(model_->state, SimTK::Stage::Dynamics);
  return model_->system.calcPotentialEnergy(model_->state);
}

void ExtendedRobot::MoveShapes(std::size_t first, Geometry* geometry) const {
  for (std::size_t i = 0; i < model_->robot->drawn().size(); ++i) {
    const RobotMultibody::Drawn& each = model_->robot->drawn()[i];
    const SimTK::Transform& X = model_->matter.getMobilizedBody(each.body).getBodyTransform(model_->state);
    const SimTK::Vec4 turn = X.R().convertRotationToQuaternion().asVec4();
    Shape& shape = (*geometry)[first + i];
    shape.p_W = ToEigen(X * ToSimbody(each.shape_B.p_W));
    shape.q_W = QuaternionProduct({turn[0], turn[1], turn[2], turn[3]}, each.shape_B.q_W);
    shape.vector_W = ToEigen(X.R() * ToSimbody(each.shape_B.vector_W));
  }
}

}  // namespace tenon
