#include <tenon/apps/cdpr/cdpr_limits.h>
#include <tenon/apps/cdpr/cdpr_run.h>

#include <Eigen/Geometry>

namespace tenon::apps {
namespace {

constexpr double kNever = 1e9;  // [s], since recordings cannot store infinity

/// A spring with a quarter of the platform's weight at 0.25 m, saturated at half of the weight, with a fifth
/// of the critical damping.
PlatformPullParams PullFor(const CdprDescription& robot) {
  const double weight = kGravity * robot.mass, stiffness = weight;
  return {stiffness, 0.2 * 2 * std::sqrt(stiffness * robot.mass), weight / 2};
}

const std::shared_ptr<const EquilibriumPath>& PathOf(const CdprLoop& loop) {
  return CurrentAs<LeafSystem<ReferenceGeneratorParams>>(loop.reference).params.path;
}

}  // namespace

CdprLive::CdprLive(DiagramBuilder& builder, CdprLoop& loop)
    : loop_(loop),
      pull_(builder.Add<PlatformPull>("live_pull", PullFor(RobotOf(loop.world.plant)))),
      goal_(builder.Add<GoalPath>("live_goal", GoalPathParams{.path = PathOf(loop)})) {
  // A block of the user's may lack an input; the live page then lacks what it is for.
  const auto connect = [&](auto& input) {
    if (FindCurrent(input) != nullptr) builder.Connect(goal_.path, input);
  };
  connect(loop.reference.path);
  if (loop.control.mpc != nullptr) connect(loop.control.mpc->path);
  builder.Connect(loop.world.plant.platform, pull_.platform);
  acts_ = FindCurrent(loop.world.plant.wrench) != nullptr && KnowsLimits<CdprPlantParams>(loop.world.plant);
  if (acts_) builder.InsertBefore(loop.world.plant.wrench, pull_.others, pull_.wrench);
}

LiveControls CdprLive::Controls() const {
  LiveControls controls;
  if (FindCurrent(loop_.reference.path) != nullptr) controls.goal = Goal();
  LiveControls::Pull pull;
  pull.stiffness = pull_.params.stiffness;
  pull.max_force = pull_.params.max_force;
  pull.bodies[0] = "platform";
  pull.set = [this](Context& context, std::size_t, const Vec<3>& point_W, const Vec<3>& target_W,
                    bool first) {
    PlatformGrip grip = context.Eval(pull_.grip);
    grip.on = true;
    grip.target_W = target_W;
    if (first) {
      const PlatformState& platform = context.Eval(loop_.world.plant.platform);
      grip.p_B = platform.R_WB().transpose() * (point_W - platform.p_WB);
    }
    return LiveSets{SetTo(pull_.grip, grip)};
  };
  pull.release = [this] { return LiveSets{SetTo(pull_.grip, {})}; };
  pull.state = [this](Context& context) {
    const PlatformState& platform = context.Eval(loop_.world.plant.platform);
    const PlatformGrip& grip = context.Eval(pull_.grip);
    const Vec<3> point = platform.p_WB + platform.R_WB() * grip.p_B;
    return std::pair(point, pull_.Force(platform, grip));
  };
  if (!acts_) return controls;
  controls.pull = std::move(pull);
  const PayloadSchedule& payload = CurrentAs(loop_.world.payload);
  if (CurrentBlock(payload) != &payload) return controls;
  const double mass = RobotOf(loop_.world.plant).mass;
  controls.load = {
      "payload", {0.01 * mass, 0.5 * mass}, 0.2 * mass, [&payload](Context& context, double load) {
        if (load == 0) return LiveSets{SetTo(payload.release, context.time())};
        return LiveSets{SetTo(payload.load, {load, context.Eval(payload.load).p_B}),
                        SetTo(payload.release, kNever), SetTo(payload.attach, context.time())};
      }};
  return controls;
}

/// The box between the anchors, before and after they move, and the floor. GoalPath refuses goals that the
/// robot cannot reach.
LiveControls::Goal CdprLive::Goal() const {
  Eigen::AlignedBox3d box;
  const CdprDescription& robot = RobotOf(loop_.world.plant);
  const MovingAnchors anchors(robot);
  for (const double time : {0.0, anchors.end_time()})
    for (const CableDescription& cable : anchors.RobotAt(robot, time).cables) box.extend(cable.anchor_W);
  const Vec<3> start = PathOf(loop_)->At(0).position;
  box.extend(start);
  if (!robot.on_table) box.extend(Vec<3>(start[0], start[1], robot.floor));
  return {"reference", {box.min(), box.max()}, [this](Context& context, const Vec<3>& place) {
            const CdprReference& reference = context.Eval(loop_.reference.reference);
            return LiveSets{SetTo(goal_.goal, goal_.GoalAt(place, context.time(), reference))};
          }};
}

}  // namespace tenon::apps
