#include <tenon/tests/plants/legged/mujoco_quadruped.h>

#include <Eigen/Geometry>

namespace tenon::test {
namespace {

/// The part of the terrain that MuJoCo's feet touch. The friction is the ground's alone, because of its
/// priority.
std::string GroundShapes(const TerrainParams& params, double contact_time) {
  const Terrain terrain(params);
  const Vec<4> axes = QuaternionFromRotation(terrain.R_WS());
  const auto shape = [&](const std::string& kind, const Vec<3>& position, double friction) {
    const Vec<3> p = terrain.R_WS() * position;
    return fmt::format(
        R"(<geom {} pos="{}" quat="{} {} {} {}" friction="{} 0 0" priority="1" solref="{} 1" contype="1" conaffinity="0"/>)",
        kind, Numbers(p), axes[0], axes[1], axes[2], axes[3], friction, contact_time);
  };
  std::string text = shape(R"(type="plane" size="99 99 1")", Vec<3>::Zero(), params.friction);
  for (const TerrainBox& box : terrain.boxes())
    text += shape(fmt::format(R"(type="box" size="{} {} {}")", box.size[0] / 2, box.size[1] / 2, box.height),
                  {box.centre[0], box.centre[1], 0}, box.friction);
  return text;
}

/// The boxes around the shapes of the trunk.
std::string TrunkShapes(const QuadrupedDescription& robot) {
  std::string text;
  std::vector<RoundedBox> boxes = robot.trunk_shapes;
  if (boxes.empty()) boxes = {BoxBetweenHips(robot)};
  for (const RoundedBox& box : boxes) {
    const Vec<4> q = QuaternionFromRotation(box.R_BS);
    text += fmt::format(
        R"(<geom type="box" size="{}" pos="{}" quat="{} {} {} {}" contype="0" conaffinity="1"/>)",
        Numbers((box.half.array() + box.radius).matrix()), Numbers(box.p_B), q[0], q[1], q[2], q[3]);
  }
  return text;
}

std::shared_ptr<const mjModel> MakeModel(const MujocoQuadrupedParams& params) {
  const QuadrupedDescription robot = WithPayload(params.plant.robot, params.plant.payload);
  const std::string knee =
      fmt::format(R"(<geom type="sphere" size="{}" contype="0" conaffinity="1"/>)", LinkRadius(robot));
  MuJoCoModel model = LoadMuJoCo(Mjcf(robot, GroundShapes(params.plant.terrain, params.contact_time),
                                      params.lies ? TrunkShapes(robot) : "", params.lies ? knee : ""));
  model->opt.timestep = 1e-3 / params.steps_per_ms;
  model->opt.gravity[2] = -params.plant.gravity;
  model->opt.cone = mjCONE_ELLIPTIC;
  model->opt.impratio = 10;
  model->opt.enableflags |= mjENBL_ENERGY;
  for (int j = 0; j < kNumJoints; ++j) {
    model->dof_damping[6 + j] = robot.drive.damping;
    model->dof_frictionloss[6 + j] = robot.drive.friction;
    model->jnt_limited[1 + j] = 1;
    model->jnt_range[2 * (1 + j)] = robot.joint(j).lower;
    model->jnt_range[2 * (1 + j) + 1] = robot.joint(j).upper;
  }
  return {model.release(), FreeMuJoCo()};
}

Eigen::Map<const Eigen::Vector3d> At(const mjtNum* numbers, int index) {
  return Eigen::Map<const Eigen::Vector3d>(numbers + 3 * index);
}

}  // namespace

void MujocoQuadrupedParams::Validate() const {
  plant.Validate();
  if (plant.extend) throw ParameterError("the plant has additions, which MuJoCo's model leaves out");
  if (!(steps_per_ms > 0))
    throw ParameterError(fmt::format("steps_per_ms is {}; give 1 or more", steps_per_ms));
  if (!(contact_time * steps_per_ms >= 2e-3))
    throw ParameterError(fmt::format("contact_time is {} s; give two steps or more", contact_time));
}

MujocoRobot::MujocoRobot(const MujocoQuadrupedParams& params)
    : model_(MakeModel(params)), data_(mj_makeData(model_.get())), payload_(params.plant.payload) {}

MujocoRobot::MujocoRobot(const MujocoRobot& other)
    : model_(other.model_), data_(mj_makeData(model_.get())), payload_(other.payload_) {}

MujocoRobot& MujocoRobot::operator=(const MujocoRobot& other) {
  if (this == &other) return *this;
  model_ = other.model_;
  data_.reset(mj_makeData(model_.get()));
  payload_ = other.payload_;
  return *this;
}

void MujocoRobot::Step(const Vec<12>& torque, const ExternalForces& external, MujocoStep* step) {
  const mjModel* m = model_.get();
  mjData* d = data_.get();
  LeggedState& x = step->state;
  Eigen::Map<Vec<19>> q(d->qpos);
  Eigen::Map<Vec<18>> u(d->qvel), applied(d->qfrc_applied);
  q << x.p_WB, x.q_WB, x.q;
  u << x.v_W, x.R_WB().transpose() * x.w_W, x.qd;  // MuJoCo's angular velocity is in B
  Eigen::Map<Vec<18>>(d->qacc_warmstart) = step->last_acceleration;
  mj_step1(m, d);

  const Vec<3> com =
      (m->body_subtreemass[1] * At(d->subtree_com, 1) - payload_.mass * (x.p_WB + x.R_WB() * payload_.com)) /
      (m->body_subtreemass[1] - payload_.mass);
  WrenchEstimate& wrench = step->external_wrench;
  wrench.force_W = payload_.mass * At(m->opt.gravity, 0);
  wrench.torque_W = (x.p_WB + x.R_WB() * payload_.com - com).cross(wrench.force_W);
  applied.setZero();
  for (const ExternalForce& force : external) {
    const int body = 1 + force.body;
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(d->xmat + 9 * body);
    const Vec<3> p = At(d->xpos, body) + R * force.p_B;
    mj_applyFT(m, d, force.force_W.data(), force.torque_W.data(), p.data(), body, d->qfrc_applied);
    wrench.force_W += force.force_W;
    wrench.torque_W += force.torque_W + (p - com).cross(force.force_W);
  }
  step->external_torque = applied.tail<12>();
  applied.tail<12>() += torque;
  mj_step2(m, d);

  const Vec<18> acceleration = Eigen::Map<Vec<18>>(d->qacc);
  step->last_acceleration = acceleration;
  step->acceleration = {acceleration.head<3>(), x.R_WB() * acceleration.segment<3>(3),
                        acceleration.tail<12>()};
  step->energy = {d->energy[1], d->energy[0]};
  AddContacts(step);
  x.p_WB = q.head<3>();
  x.q_WB = q.segment<4>(3);
  x.q = q.tail<12>();
  x.v_W = u.head<3>();
  x.w_W = x.R_WB() * u.segment<3>(3);
  x.qd = u.tail<12>();
}

void MujocoRobot::AddContacts(MujocoStep* step) {
  const mjModel* m = model_.get();
  mjData* d = data_.get();
  step->foot_forces = {};
  step->foot_depths.setZero();
  step->foot_slips.fill(Vec<3>::Zero());
  const auto leg_of = [&](int shape) {  // -1 for all shapes but feet
    const int body = m->geom_bodyid[shape], joint = body - 2;
    const bool is_foot = joint >= 0 && m->body_geomadr[body] == shape;
    return is_foot ? joint / kJointsPerLeg : -1;
  };
  for (int i = 0; i < d->ncon; ++i) {
    const mjContact& contact = d->contact[i];
    const bool foot_second = leg_of(contact.geom2) >= 0;
    const int foot = foot_second ? contact.geom2 : contact.geom1, leg = leg_of(foot);
    if (leg < 0) continue;
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(contact.frame);
    Vec<6> force, velocity;
    mj_contactForce(m, d, i, force.data());  // on the second body
    step->foot_forces[leg] += (foot_second ? 1 : -1) * axes.transpose() * force.head<3>();
    if (-contact.dist <= step->foot_depths[leg]) continue;
    step->foot_depths[leg] = -contact.dist;
    mj_objectVelocity(m, d, mjOBJ_GEOM, foot, velocity.data(), 0);
    const Vec<3> arm = Eigen::Map<const Vec<3>>(contact.pos) - At(d->geom_xpos, foot);
    const Vec<3> v = velocity.tail<3>() + velocity.head<3>().cross(arm), normal = axes.row(0);
    step->foot_slips[static_cast<std::size_t>(leg)] = v - normal.dot(v) * normal;
  }
}

Vec<12> MujocoQuadruped::CalcJointTorque(const MujocoStep& step, const Vec<12>& command) const {
  Vec<12> torque;
  for (int j = 0; j < kNumJoints; ++j)
    torque[j] = DriveTorque(command[j], step.state.qd[j], params.robot.joint(j), params.robot.drive,
                            params.limit_speed);
  return torque;
}

void MujocoQuadruped::CalcGeometry(const MujocoStep& step, const ExternalForces& external,
                                   Geometry* out) const {
  MoveQuadrupedGeometry(params.robot, params.payload, step.state, step.foot_forces, external, out);
}

MujocoStep MujocoQuadruped::Advance(const MujocoStep& step, const Vec<12>& torque,
                                    const ExternalForces& external, MujocoRobot& robot) const {
  MujocoStep next = step;
  robot.Step(torque, external, &next);
  return next;
}

}  // namespace tenon::test

TENON_DEFINE_SIGNAL(tenon::test::MujocoStep);
