#include <tenon/apps/cdpr/cdpr_live.h>

#include <cmath>

namespace tenon::apps {
namespace {

constexpr double kGravity = 9.81;  // [m/s^2], for the sizes of pull and payload alone
constexpr double kNever = 1e9;     // [s], for recordings have no infinity

/// A quarter of the platform's weight for 0.25 m, half of it at most, a fifth of the critical damping.
PlatformPullParams PullFor(const CdprDescription& robot) {
  const double weight = kGravity * robot.mass, stiffness = weight;
  return {stiffness, 0.2 * 2 * std::sqrt(stiffness * robot.mass), weight / 2};
}

}  // namespace

CdprLive::CdprLive(DiagramBuilder& builder, CdprLoop& loop)
    : loop_(loop), pull_(builder.Add<PlatformPull>("live_pull", PullFor(loop.plant.params.robot))) {
  builder.Connect(loop.plant.platform, pull_.platform);
  if (loop.hanging_load != nullptr || loop.gusts != nullptr) {
    builder.Disconnect(loop.plant.wrench);
    builder.Connect(loop.hanging_load != nullptr ? loop.hanging_load->wrench : loop.gusts->wrench,
                    pull_.others);
  }
  builder.Connect(pull_.wrench, loop.plant.wrench);
}

LiveControls CdprLive::Controls() const {
  LiveControls controls;
  LiveControls::Pull pull;
  pull.stiffness = pull_.params.stiffness;
  pull.max_force = pull_.params.max_force;
  pull.bodies[0] = "platform";
  pull.set = [this](Context& context, std::size_t, const Vec<3>& point_W, const Vec<3>& target_W,
                    bool first) {
    PlatformGrip grip = context.Eval(pull_.grip);
    if (first) {
      const PlatformState& platform = context.Eval(loop_.plant.platform);
      grip.p_B = platform.R_WB().transpose() * (point_W - platform.p_WB);
    }
    return LiveSets{{pull_.grip.path(),
                     {1.0, grip.p_B[0], grip.p_B[1], grip.p_B[2], target_W[0], target_W[1], target_W[2]}}};
  };
  pull.release = [this] { return LiveSets{{pull_.grip.path(), std::vector<double>(7, 0.0)}}; };
  pull.state = [this](Context& context) {
    const PlatformState& platform = context.Eval(loop_.plant.platform);
    const PlatformGrip& grip = context.Eval(pull_.grip);
    const Vec<3> point = platform.p_WB + platform.R_WB() * grip.p_B;
    return std::pair(point, pull_.Force(platform, grip));
  };
  controls.pull = std::move(pull);

  const PayloadSchedule& payload = loop_.payload;
  const double mass = loop_.plant.params.robot.mass;
  controls.load = {
      "payload", {0.01 * mass, 0.5 * mass}, 0.2 * mass, [&payload](Context& context, double load) {
        const Vec<3> place = context.Eval(payload.load).p_B;
        if (load == 0) return LiveSets{{payload.release.path(), {context.time()}}};
        return LiveSets{{payload.load.path(), {load, place[0], place[1], place[2]}},
                        {payload.release.path(), {kNever}},
                        {payload.attach.path(), {context.time()}}};
      }};
  return controls;
}

}  // namespace tenon::apps
