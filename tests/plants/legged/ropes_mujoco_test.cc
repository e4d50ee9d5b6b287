// A quadruped on ropes in the air, against MuJoCo's tendons and against the conservation of energy and
// momentum.

#include <tenon/plants/legged/disturbances.h>
#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/plants/legged/ropes.h>
#include <tenon/systems/primitives/constant.h>
#include <tenon/tests/plants/model/quadruped_mujoco.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::ropes_mujoco_test {

constexpr double kDuration = 0.3;  // [s]
const CableVector kTension = Vec<4>(40, 70, 55, 90);

std::vector<Rope> FourRopes() {
  std::vector<Rope> ropes;
  for (const double x : {1.0, -1.0})
    for (const double y : {1.0, -1.0})
      ropes.push_back(
          {fmt::format("rope_{}", ropes.size()), {2 * x, 1.5 * y, 7.5}, {0.3 * x, 0.1 * y, 0.05}, 0, 250});
  return ropes;
}

/// DogBot without losses and end stops, 5 m above the ground, with some speed of every coordinate.
QuadrupedPlantParams InTheAir() {
  QuadrupedPlantParams params{.robot = test::DogBot(), .initial = test::Standing(test::DogBot())};
  params.robot.drive.damping = params.robot.drive.friction = 0;
  for (LegDescription& leg : params.robot.legs)
    for (JointDescription& joint : leg.joints) joint.lower = -INFINITY, joint.upper = INFINITY;
  params.limit_speed = false;
  RandomStream random(53);
  params.initial.p_WB[2] = 5;
  params.initial.q_WB = QuaternionFromRotationVector(test::RandomVector<3>(random, 0.3));
  params.initial.v_W = test::RandomVector<3>(random, 0.5);
  params.initial.w_W = test::RandomVector<3>(random, 0.5);
  params.initial.qd = test::RandomVector<12>(random, 1);
  return params;
}

struct OnRopes {
  LeggedState begin, end;
  double energy_change;  ///< of the robot and of ropes with constant tension [J]
};

OnRopes Simulate(const QuadrupedPlantParams& params, const std::vector<Rope>& ropes) {
  DiagramBuilder builder;
  auto& plant = builder.Add<QuadrupedPlant>("plant", params);
  auto& pull = builder.Add<Ropes>("ropes", RopesParams{ropes});
  auto& bundle = builder.Add<ForceBundle>("bundle", ForceBundleParams{1});
  auto& torque = builder.Add<ConstantSource<Vec<12>>>("torque", {.unit = "N m", .elements = kJointElements});
  auto& tension = builder.Add<ConstantSource<CableVector>>(
      "tension", {.value = kTension, .unit = "N", .elements = RopeElements(ropes)});
  builder.Connect(torque.y, plant.torque);
  builder.Connect(tension.y, pull.command);
  builder.Connect(plant.state, pull.robot);
  builder.Connect(pull.force, bundle.force[0]);
  builder.Connect(bundle.forces, plant.external);
  Simulator simulator(builder.Build(), {.rtol = 1e-9, .atol = 1e-10});
  const Context& context = simulator.context();
  const auto energy = [&] {
    double sum = context.Eval(plant.energy).total();
    for (std::size_t i = 0; i < ropes.size(); ++i)
      sum += kTension[static_cast<Eigen::Index>(i)] * LineOf(ropes[i], context.Eval(plant.state)).length;
    return sum;
  };
  simulator.RunTo(0);
  const LeggedState begin = context.Eval(plant.state);
  const double before = energy();
  simulator.RunTo(kDuration);
  return {begin, context.Eval(plant.state), energy() - before};
}

/// The robot's MJCF with a tendon under constant tension for each rope.
std::string Mjcf(const QuadrupedDescription& robot, const std::vector<Rope>& ropes) {
  std::string anchors, attachments, tendons, motors;
  for (std::size_t i = 0; i < ropes.size(); ++i) {
    anchors += fmt::format(R"(<site name="a{}" pos="{}"/>)", i, test::Numbers(ropes[i].anchor_W));
    attachments += fmt::format(R"(<site name="b{}" pos="{}"/>)", i, test::Numbers(ropes[i].attachment_B));
    tendons += fmt::format(R"(<spatial name="t{0}"><site site="a{0}"/><site site="b{0}"/></spatial>)", i);
    motors += fmt::format(R"(<motor tendon="t{}" gear="-1"/>)", i);
  }
  std::string text = test::Mjcf(robot);
  const auto insert = [&](const std::string& behind, const std::string& part) {
    text.insert(text.find(behind) + behind.size(), part);
  };
  insert("<worldbody>", anchors);
  insert("<freejoint/>", attachments);
  insert("</worldbody>", "<tendon>" + tendons + "</tendon><actuator>" + motors + "</actuator>");
  return text;
}

LeggedState RunMuJoCo(const QuadrupedPlantParams& params, const std::vector<Rope>& ropes) {
  const test::MuJoCoModel model = test::LoadMuJoCo(Mjcf(params.robot, ropes));
  const test::MuJoCoData data(mj_makeData(model.get()));
  model->opt.integrator = mjINT_RK4;
  model->opt.timestep = 1e-4;
  const LeggedState& x = params.initial;
  Eigen::Map<Eigen::VectorXd>(data->qpos, 19) << x.p_WB, x.q_WB, x.q;
  Eigen::Map<Eigen::VectorXd>(data->qvel, 18) << x.v_W, x.R_WB().transpose() * x.w_W, x.qd;
  Eigen::Map<Eigen::VectorXd>(data->ctrl, 4) = kTension;
  for (int n = 0; n < 3000; ++n) mj_step(model.get(), data.get());
  LeggedState end{.p_WB = Eigen::Map<Eigen::Vector3d>(data->qpos),
                  .q_WB = Eigen::Map<Eigen::Vector4d>(data->qpos + 3),
                  .q = Eigen::Map<Eigen::VectorXd>(data->qpos + 7, 12),
                  .v_W = Eigen::Map<Eigen::Vector3d>(data->qvel)};
  end.w_W = end.R_WB() * Eigen::Map<Eigen::Vector3d>(data->qvel + 3);
  end.qd = Eigen::Map<Eigen::VectorXd>(data->qvel + 6, 12);
  return end;
}

// Constant tensions have the potential T l. The legs of the robot swing freely meanwhile.
TEST(RopesMuJoCoTest, SameMotionAndNoEnergyLost) {
  const QuadrupedPlantParams params = InTheAir();
  const std::vector<Rope> ropes = FourRopes();
  const OnRopes ours = Simulate(params, ropes);
  EXPECT_NEAR(ours.energy_change, 0, 1e-5);
  const LeggedState theirs = RunMuJoCo(params, ropes);
  EXPECT_GT((theirs.q - params.initial.q).norm(), 0.3);
  EXPECT_THAT(ours.end.p_WB, IsNear(theirs.p_WB, 1e-6));
  EXPECT_THAT(ours.end.R_WB(), IsNear(theirs.R_WB(), 1e-6));
  EXPECT_THAT(ours.end.q, IsNear(theirs.q, 1e-6));
  EXPECT_THAT(ours.end.v_W, IsNear(theirs.v_W, 1e-5));
  EXPECT_THAT(ours.end.w_W, IsNear(theirs.w_W, 1e-5));
  EXPECT_THAT(ours.end.qd, IsNear(theirs.qd, 1e-4));
}

// Ropes to one anchor exert no moment about it, so the angular momentum about the vertical through it stays.
TEST(RopesMuJoCoTest, RopesToOneAnchorKeepTheAngularMomentumAboutIt) {
  const QuadrupedPlantParams params = InTheAir();
  std::vector<Rope> ropes = FourRopes();
  for (Rope& rope : ropes) rope.anchor_W = {0.5, -0.3, 8};
  const OnRopes run = Simulate(params, ropes);
  const QuadrupedModel model(params.robot);
  const auto about_anchor = [&](const LeggedState& x) {
    const QuadrupedDynamics d = test::DynamicsOf(model, x);
    return (d.angular_momentum_W + model.mass() * (d.com_W - ropes[0].anchor_W).cross(d.com_velocity_W))[2];
  };
  EXPECT_NEAR(about_anchor(run.end), about_anchor(run.begin), 1e-6);
  EXPECT_NEAR(run.energy_change, 0, 1e-5);
}

}  // namespace tenon::ropes_mujoco_test
