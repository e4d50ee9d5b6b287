#include <tenon/diagrams/cdpr/cdpr_loop.h>

namespace tenon {
namespace {

CdprPlantParams AtRest(const CdprLoopParams& loop) {
  const CdprReference start = loop.path->At(0);
  CdprPlantParams params;
  params.robot = loop.robot;
  params.p_WB = start.position + loop.start_offset;
  params.euler = start.euler + loop.start_turn;
  params.initial_tension = start.tension;
  return params;
}

CablePdParams PdOf(const CdprLoopParams& params) {
  return {params.path->robot(), params.pd_stiffness_N_per_m, params.pd_damping_N_s_per_m,
          params.control_rate};
}

}  // namespace

CdprLoop::CdprLoop(const CdprLoopParams& params)
    : reference(
          Add<ReferenceGenerator>("reference", ReferenceGeneratorParams{params.path, params.control_rate})),
      payload(Add<PayloadSchedule>("payload", params.payload)),
      plant(Add<CdprPlant>("plant", AtRest(params))),
      pose_sensor(Add<PoseSensor>("pose_sensor", params.pose_sensor)),
      imu(Add<Imu>("imu", params.imu)) {
  auto& monitor = Add<CdprMonitor>("monitor", CdprMonitorParams{.robot = params.robot,
                                                                .forbid_slack = params.forbid_slack,
                                                                .max_tension_ratio = params.max_tension_ratio,
                                                                .rate = params.control_rate});

  if (params.mpc) {
    estimator = &Add<CdprEstimator>("estimator", params.estimator);
    mpc = &Add<CdprMpc>("mpc", *params.mpc);
    Connect(pose_sensor.pose, estimator->pose);
    Connect(imu.measurement, estimator->inertial);
    Connect(estimator->estimate, mpc->estimate);
    Connect(mpc->command, plant.command);
    Connect(mpc->command, command);
  } else {
    pd = &Add<CablePd>("pd", PdOf(params));
    Connect(reference.reference, pd->reference);
    Connect(plant.cables, pd->cables);
    Connect(pd->command, plant.command);
    Connect(pd->command, command);
  }
  Connect(payload.payload, plant.payload);

  Connect(plant.cables, monitor.cables);
  Connect(plant.platform, monitor.platform);
  Connect(plant.platform, pose_sensor.platform);
  Connect(plant.platform, imu.body);
  Connect(plant.acceleration, imu.acceleration);

  Connect(plant.platform, platform);
  Connect(plant.cables, cables);
  Connect(pose_sensor.pose, pose);
  Connect(imu.measurement, inertial);
}

}  // namespace tenon
