#include <tenon/apps/cdpr/cdpr_scenario.h>

#include <fmt/core.h>

#include <algorithm>

#include <tenon/apps/common/blame.h>
#include <tenon/apps/common/checks.h>
#include <tenon/plants/model/resources.h>
#include <tenon/systems/yaml/yaml.h>

namespace tenon::apps {

void PathScenario::Validate() const {
  DemandNotNegative("tension_aim_N", tension_aim_N);
  Demand(
      tension_aim_N == 0 || attitude_rad,
      fmt::format("tension_aim_N = {} takes attitude_rad: without it the tensions follow from the attitude",
                  tension_aim_N));
  const std::size_t points = points_m.size();
  if (kind == PathKind::kCircle) return;  // Path::Circle judges its numbers
  if (kind == PathKind::kHold) {
    Demand(points == 1, fmt::format("a path that holds needs one entry in points_m, found {}", points));
    return;
  }
  Demand(kind != PathKind::kLine || points == 2,
         fmt::format("a line needs two entries in points_m, found {}", points));
  Demand(times_s.size() == points,
         fmt::format("points_m has {} entries and times_s has {}: give one time per point", points,
                     times_s.size()));
}

Path PathScenario::Make() const {
  switch (kind) {
    case PathKind::kHold:
      return Path::Hold(points_m[0]);
    case PathKind::kLine:
    case PathKind::kSpline:
      return Path::Spline(points_m, times_s);
    case PathKind::kCircle:
      break;
  }
  return Path::Circle(center_m, radius_m, period_s, ramp_s);
}

void PdScenario::Validate() const {
  DemandRate("rate_hz", rate_hz);
}

void MpcScenario::Validate() const {
  DemandBetween("horizon_s", horizon_s, 1e-3, 100);
  DemandBetween("num_steps", num_steps, 1, 1000);
  DemandRate("rate_hz", rate_hz);
  DemandRate("command_rate_hz", command_rate_hz);
  DemandNotNegative("max_fallbacks_in_a_row", max_fallbacks_in_a_row);
}

void PayloadScenario::Validate() const {
  DemandNotNegative("mass_kg", mass_kg);
  Demand(release_s >= attach_s, fmt::format("release_s = {} lies before attach_s = {}", release_s, attach_s));
}

void NoiseScenario::Validate() const {
  DemandNotNegative("position_m", position_m);
  DemandNotNegative("attitude_rad", attitude_rad);
  DemandNotNegative("angular_velocity_rad_per_s", angular_velocity_rad_per_s);
  DemandNotNegative("acceleration_m_per_s2", acceleration_m_per_s2);
  DemandRate("pose_rate_hz", pose_rate_hz);
  DemandRate("imu_rate_hz", imu_rate_hz);
}

void IntegratorScenario::Validate() const {
  DemandBetween("order", order, 2, 5);
  DemandBetween("rtol", rtol, 1e-14, 0.1);
  DemandPositive("atol", atol);
}

void CdprScenario::Validate() const {
  Demand(duration_s > 0, fmt::format("duration_s = {} must be positive", duration_s));
  Demand(
      !IsMpc(controller) || mpc.has_value(),
      fmt::format("controller is '{}' but there is no section mpc: give its weights", EnumName(controller)));
  Demand(!mpc || mpc->mass_error > -1, "mpc.mass_error must be above -1: the model would have no mass");
  DemandRate("log_rate_hz", log_rate_hz);
  Demand(max_tension_ratio >= 1, fmt::format("max_tension_ratio = {} must be at least 1", max_tension_ratio));
}

namespace {

CdprMpcParams MakeMpcParams(const CdprScenario& scenario,
                            const std::shared_ptr<const EquilibriumPath>& path) {
  const MpcScenario& mpc = *scenario.mpc;
  CdprMpcParams params;
  params.path = path;
  params.equilibrium_input = scenario.controller == CdprController::kMpcEquilibrium;
  params.horizon = mpc.horizon_s;
  params.num_steps = mpc.num_steps;
  params.weights = mpc.weights;
  params.slq.method = mpc.method;
  params.rate = Hz(mpc.rate_hz);
  params.command_rate = Hz(mpc.command_rate_hz);
  params.max_fallbacks_in_a_row = mpc.max_fallbacks_in_a_row;
  return params;
}

}  // namespace

CdprLoopParams MakeLoopParams(const CdprScenario& scenario) {
  CdprLoopParams params;
  params.robot = Blame("robot", [&] { return LoadCdpr(FindResource("robots", scenario.robot)); });
  CdprDescription believed = params.robot;
  if (scenario.mpc) {
    believed.mass *= 1 + scenario.mpc->mass_error;
    believed.inertia_B *= 1 + scenario.mpc->mass_error;
  }
  params.path = Blame("path", [&] {
    return std::make_shared<EquilibriumPath>(
        believed, scenario.path.Make(),
        StaticsOptions{.attitude = scenario.path.attitude_rad, .tension_aim = scenario.path.tension_aim_N});
  });
  if (IsMpc(scenario.controller))
    params.mpc = Blame("mpc", [&] { return MakeMpcParams(scenario, params.path); });
  params.feedforward = scenario.controller == CdprController::kPdFeedforward;
  params.offset_free = scenario.controller == CdprController::kPdOffsetFree ||
                       (scenario.controller == CdprController::kMpcEquilibrium && scenario.mpc->offset_free);
  params.load = {.robot = params.robot,
                 .rate = Hz(scenario.noise.pose_rate_hz),
                 .bandwidth = scenario.load.bandwidth_rad_per_s.value_or(params.mpc ? 20 : 3),
                 .mass_bandwidth = scenario.load.mass_bandwidth_rad_per_s.value_or(params.mpc ? 100 : 3)};
  if (params.offset_free) Blame("load", [&] { params.load.Validate(); });
  params.start_offset = scenario.start_offset_m;
  params.start_turn = scenario.start_turn_rad;
  params.control_rate = Hz(scenario.pd.rate_hz);
  params.pd_stiffness_N_per_m = scenario.pd.stiffness_N_per_m;
  params.pd_damping_N_s_per_m = scenario.pd.damping_N_s_per_m;
  params.payload.payload = {scenario.payload.mass_kg, scenario.payload.position_m};
  params.payload.attach_s = scenario.payload.attach_s;
  params.payload.release_s = scenario.payload.release_s;
  params.pose_sensor.rate = Hz(scenario.noise.pose_rate_hz);
  params.pose_sensor.position_noise.setConstant(scenario.noise.position_m);
  params.pose_sensor.attitude_noise.setConstant(scenario.noise.attitude_rad);
  params.imu.rate = Hz(scenario.noise.imu_rate_hz);
  params.imu.angular_velocity_noise.setConstant(scenario.noise.angular_velocity_rad_per_s);
  params.imu.specific_force_noise.setConstant(scenario.noise.acceleration_m_per_s2);
  // The filter knows its sensors, but takes none for perfect.
  params.estimator.rate = Hz(scenario.noise.pose_rate_hz);
  params.estimator.noise.position = std::max(scenario.noise.position_m, 1e-4);
  params.estimator.noise.attitude = std::max(scenario.noise.attitude_rad, 1e-4);
  params.estimator.noise.angular_velocity = std::max(scenario.noise.angular_velocity_rad_per_s, 1e-4);
  params.estimator.noise.specific_force = std::max(scenario.noise.acceleration_m_per_s2, 1e-3);
  Blame("hardware", [&] { SetHardware(LoadCdprHardware(scenario.hardware), params); });
  params.forbid_slack = scenario.forbid_slack;
  params.max_tension_ratio = scenario.max_tension_ratio;
  return params;
}

SimulatorOptions MakeSimulatorOptions(const CdprScenario& scenario) {
  return {.method = Method::kErk,
          .order = scenario.integrator.order,
          .rtol = scenario.integrator.rtol,
          .atol = scenario.integrator.atol,
          .seed = scenario.seed};
}

}  // namespace tenon::apps
