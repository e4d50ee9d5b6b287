#include "tenon/diagrams/cdpr_loop.h"

namespace tenon {
namespace {

CdprPlantParams AtRest(const CdprDescription& robot, const CdprReference& start) {
  CdprPlantParams params;
  params.robot = robot;
  params.p_WB = start.position;
  params.euler = start.euler;
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
      pd(Add<CablePd>("pd", PdOf(params))),
      payload(Add<PayloadSchedule>("payload", params.payload)),
      plant(Add<CdprPlant>("plant", AtRest(params.robot, params.path->At(0)))),
      pose_sensor(Add<PoseSensor>("pose_sensor", params.pose_sensor)),
      imu(Add<Imu>("imu", params.imu)) {
  auto& slack = Add<SlackMonitor>("slack", SlackMonitorParams{params.forbid_slack, params.control_rate});

  Connect(reference.reference, pd.reference);
  Connect(pd.command, plant.command);
  Connect(payload.payload, plant.payload);

  Connect(plant.cables, pd.cables);
  Connect(plant.cables, slack.cables);
  Connect(plant.platform, pose_sensor.platform);
  Connect(plant.platform, imu.platform);
  Connect(plant.acceleration, imu.acceleration);

  Connect(plant.platform, platform);
  Connect(plant.cables, cables);
  Connect(pose_sensor.pose, pose);
  Connect(imu.measurement, inertial);
}

}  // namespace tenon
