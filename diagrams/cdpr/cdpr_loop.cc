#include <tenon/controllers/cdpr/cdpr_kinematics.h>
#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/diagrams/late.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/plants/signals/quaternion.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace tenon {
namespace {

CdprPlantParams AtRest(const CdprLoopParams& loop) {
  const CdprReference start = loop.path->At(0);
  CdprPlantParams params;
  params.robot = loop.robot;
  params.p_WB = start.position + loop.start_offset;
  params.euler = start.euler + loop.start_turn;
  params.initial_tension = start.tension;
  try {
    params.homed_length =
        CalcCableKinematics(loop.path->robot(), params.p_WB, RotationFromEuler(params.euler)).length;
  } catch (const RunError& error) {
    throw ParameterError(std::string("at the start: ") + error.what());
  }
  return params;
}

CableSignals CablesAtRest(const CdprPlantParams& start) {
  const CableVector& length = start.homed_length;
  return {length, CableVector::Zero(length.size()), start.initial_tension,
          CalcRestLengths(start.robot.cable, length, start.initial_tension)};
}

CablePdParams PdOf(const CdprLoopParams& params) {
  return {params.path->robot(), params.pd_stiffness_N_per_m, params.pd_damping_N_s_per_m,
          params.control_rate};
}

bool IsOffsetFree(const CdprLoopParams& params) {
  return params.offset_free.value_or(params.mpc && params.mpc->equilibrium_input);
}

}  // namespace

LoadEstimatorParams MakeLoadEstimator(bool mpc) {
  LoadEstimatorParams params;
  if (!mpc) params.bandwidth = params.mass_bandwidth = 3;
  return params;
}

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
  AddHardware(params);
  AddDisturbances(params);

  const bool offset_free = IsOffsetFree(params);
  if (params.mpc || offset_free) {
    CdprEstimatorParams estimator_params = params.estimator;
    estimator_params.robot = params.path->robot();
    estimator = &Add<CdprEstimator>("estimator", estimator_params);
    Connect(*told_pose, estimator->pose);
    Connect(*told_inertial, estimator->inertial);
    Connect(*told_cables, estimator->cables);
  }
  if (offset_free) {
    LoadEstimatorParams load_params = params.load.value_or(MakeLoadEstimator(params.mpc.has_value()));
    load_params.robot = params.path->robot();
    load_params.rate = params.estimator.rate;
    load = &Add<LoadEstimator>("load", load_params);
    Connect(estimator->estimate, load->estimate);
    Connect(*told_inertial, load->inertial);
    Connect(*told_cables, load->cables);
  }
  if (params.mpc || params.feedforward || offset_free) {
    broken_cables = &Add<BrokenCableDetector>(
        "broken_cables", BrokenCableDetectorParams{.num_cables = params.robot.num_cables(),
                                                   .reel_damping = params.path->robot().winch.reel_damping,
                                                   .rate = params.control_rate});
    Connect(*told_cables, broken_cables->cables);
  }
  if (params.mpc) {
    mpc = &Add<CdprMpc>("mpc", *params.mpc);
    Connect(estimator->estimate, mpc->estimate);
    if (load != nullptr) Connect(load->load, mpc->load);
    Connect(broken_cables->broken, mpc->broken);
    Connect(mpc->command, broken_cables->command);
    Connect(mpc->command, *drive);
    Connect(mpc->command, command);
  } else {
    pd = &Add<CablePd>("pd", PdOf(params));
    if (params.feedforward || offset_free) {
      balancer = &Add<ReferenceBalancer>("balancer",
                                         ReferenceBalancerParams{params.path->robot(), params.control_rate});
      Connect(reference.reference, balancer->reference);
      if (load != nullptr) Connect(load->load, balancer->load);
      Connect(broken_cables->broken, balancer->broken);
      Connect(pd->command, broken_cables->command);
      Connect(balancer->balanced, pd->reference);
    } else {
      Connect(reference.reference, pd->reference);
    }
    Connect(*told_cables, pd->cables);
    Connect(pd->command, *drive);
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
  Connect(*told_pose, pose);
  Connect(*told_inertial, inertial);
}

void CdprLoop::AddDisturbances(const CdprLoopParams& params) {
  const OutputPort<PlatformWrench>* wrench = nullptr;
  if (!params.gusts.gusts.empty()) {
    gusts = &Add<Gusts>("gusts", params.gusts);
    wrench = &gusts->wrench;
  }
  if (params.hanging_load) {
    const CdprPlantParams start = AtRest(params);
    HangingLoadParams load_params = *params.hanging_load;
    const double length =
        load_params.length * (1 + load_params.mass * load_params.gravity / load_params.axial_stiffness);
    const double depth = std::sqrt(std::max(0.0, length * length - params.swing.squaredNorm()));
    load_params.p_W = start.p_WB + RotationFromEuler(start.euler) * load_params.attachment_B + params.swing -
                      Vec<3>(0, 0, depth);
    hanging_load = &Add<HangingLoad>("hanging_load", load_params);
    Connect(plant.platform, hanging_load->platform);
    if (wrench != nullptr) Connect(*wrench, hanging_load->others);
    wrench = &hanging_load->wrench;
  }
  if (wrench != nullptr) Connect(*wrench, plant.wrench);
}

void CdprLoop::AddHardware(const CdprLoopParams& params) {
  const CdprHardwareParams& hardware = params.hardware;
  const CdprPlantParams start = AtRest(params);
  drive = &plant.command;
  if (hardware.winch_errors) {
    auto& errors = Add<WinchErrors>("winch_errors", *hardware.winch_errors);
    Connect(plant.cables, errors.cables);
    Connect(errors.tension, *drive);
    drive = &errors.command;
  }
  if (hardware.command_delay) {
    JitteredDelayParams<CableVector> delay_params = *hardware.command_delay;
    delay_params.initial = start.initial_tension;
    auto& delay = Add<JitteredDelay<CableVector>>("command_delay", delay_params);
    Connect(delay.y, *drive);
    drive = &delay.u;
  }

  told_cables = &plant.cables;
  if (hardware.cable_sensors) {
    auto& sensors = Add<CableSensors>("cable_sensors", *hardware.cable_sensors);
    Connect(plant.cables, sensors.cables);
    told_cables = &Late(*this, "cables", sensors.measured, CablesAtRest(start), hardware.cable_sensors->rate,
                        hardware.cable_delay);
  }
  const Eigen::Matrix3d R_WB = RotationFromEuler(start.euler);
  told_pose =
      &Late<PoseMeasurement>(*this, "pose", pose_sensor.pose, {start.p_WB, QuaternionFromRotation(R_WB)},
                             params.pose_sensor.rate, hardware.pose_delay);
  told_inertial = &imu.measurement;
  if (hardware.imu_errors) {
    auto& errors = Add<ImuErrors>("imu_errors", *hardware.imu_errors);
    Connect(*told_inertial, errors.measurement);
    told_inertial = &errors.measured;
  }
  told_inertial = &Late<ImuMeasurement>(*this, "inertial", *told_inertial,
                                        {Vec<3>::Zero(), R_WB.transpose() * Vec<3>(0, 0, start.gravity)},
                                        params.imu.rate, hardware.imu_delay);
}

}  // namespace tenon
