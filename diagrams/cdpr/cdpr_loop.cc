#include <tenon/diagrams/cdpr/cdpr_control.h>
#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/diagrams/cdpr/cdpr_messages.h>
#include <tenon/diagrams/cdpr/cdpr_observer.h>
#include <tenon/diagrams/cdpr/cdpr_profile.h>
#include <tenon/diagrams/cdpr/cdpr_world.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/systems/primitives/late.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/systems/yaml/yaml.h>

#include <fmt/core.h>

namespace tenon {

CdprLoop::CdprLoop(const CdprLoopParams& params)
    : reference(
          Add<ReferenceGenerator>("reference", ReferenceGeneratorParams{params.path, params.control_rate})),
      world(*this, params),
      observer(*this, params, world),
      control(*this, params, reference, world, observer) {
  Connect(control.command(), world.command);
  if (observer.broken_cables != nullptr) Connect(control.command(), observer.broken_cables->command);

  Connect(control.command(), command);
  Connect(world.plant.platform, platform);
  Connect(world.plant.cables, cables);
  Connect(world.pose, pose);
  Connect(world.inertial, inertial);
}

namespace {

CdprPlantParams AtRest(const CdprLoopParams& loop) {
  const CdprReference start = loop.path->At(0);
  CdprPlantParams params;
  params.robot = loop.robot;
  params.extend = loop.extend;
  if (loop.robot.on_table) params.gravity = 0;
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

/// Adds the blocks between the controller and the plant; returns the input of the first one.
InputPort<CableVector>& AddDrives(Subdiagram& loop, const CdprHardwareParams& hardware, CdprPlant& plant) {
  InputPort<CableVector>* in = &plant.command;
  if (hardware.winch_errors) {
    auto& errors = loop.Add<WinchErrors>("winch_errors", *hardware.winch_errors);
    loop.Connect(plant.cables, errors.cables);
    loop.Connect(errors.tension, *in);
    in = &errors.command;
  }
  if (hardware.command_delay) {
    JitteredDelayParams<CableVector> delay_params = *hardware.command_delay;
    delay_params.initial = plant.params.initial_tension;
    auto& delay = loop.Add<JitteredDelay<CableVector>>("command_delay", delay_params);
    loop.Connect(delay.y, *in);
    in = &delay.u;
  }
  return *in;
}

const OutputPort<CableSignals>& AddCableSensors(Subdiagram& loop, const CdprHardwareParams& hardware,
                                                CdprPlant& plant) {
  if (!hardware.cable_sensors) return plant.cables;
  auto& sensors = loop.Add<CableSensors>("cable_sensors", *hardware.cable_sensors);
  loop.Connect(plant.cables, sensors.cables);
  return Late(loop, "cables", sensors.measured, CablesAtRest(plant.params), hardware.cable_sensors->rate,
              hardware.cable_sensors->latency);
}

const OutputPort<PoseMeasurement>& AddPoseDelay(Subdiagram& loop, const CdprHardwareParams& hardware,
                                                const CdprPlantParams& start, PoseSensor& sensor) {
  const Eigen::Matrix3d R_WB = RotationFromEuler(start.euler);
  return Late<PoseMeasurement>(loop, "pose", sensor.pose, {start.p_WB, QuaternionFromRotation(R_WB)},
                               sensor.params.rate, hardware.pose_delay);
}

const OutputPort<ImuMeasurement>& AddImuErrors(Subdiagram& loop, const CdprHardwareParams& hardware,
                                               const CdprPlantParams& start, Imu& imu) {
  const OutputPort<ImuMeasurement>* measured = &imu.measurement;
  if (hardware.imu_errors) {
    auto& errors = loop.Add<ImuErrors>("imu_errors", *hardware.imu_errors);
    loop.Connect(*measured, errors.measurement);
    measured = &errors.measured;
  }
  const Eigen::Matrix3d R_WB = RotationFromEuler(start.euler);
  return Late<ImuMeasurement>(loop, "inertial", *measured,
                              {Vec<3>::Zero(), R_WB.transpose() * Vec<3>(0, 0, imu.params.gravity)},
                              imu.params.rate, hardware.imu_delay);
}

}  // namespace

CdprWorld::CdprWorld(Subdiagram& loop, const CdprLoopParams& params)
    : payload(loop.Add<PayloadSchedule>("payload", params.payload)),
      plant(loop.Add<CdprPlant>("plant", AtRest(params))),
      pose_sensor(loop.Add<PoseSensor>("pose_sensor", params.pose_sensor)),
      imu(loop.Add<Imu>("imu", params.imu)),
      monitor(
          loop.Add<CdprMonitor>("monitor", CdprMonitorParams{.robot = params.robot,
                                                             .forbid_slack = params.forbid_slack,
                                                             .max_tension_ratio = params.max_tension_ratio,
                                                             .rate = params.control_rate})),
      command(AddDrives(loop, params.hardware, plant)),
      cables(AddCableSensors(loop, params.hardware, plant)),
      pose(AddPoseDelay(loop, params.hardware, plant.params, pose_sensor)),
      inertial(AddImuErrors(loop, params.hardware, plant.params, imu)) {
  AddDisturbances(loop, params);
  loop.Connect(payload.payload, plant.payload);
  loop.Connect(plant.cables, monitor.cables);
  loop.Connect(plant.platform, monitor.platform);
  loop.Connect(plant.platform, pose_sensor.platform);
  loop.Connect(plant.platform, imu.body);
  loop.Connect(plant.acceleration, imu.acceleration);
}

void CdprWorld::AddDisturbances(Subdiagram& loop, const CdprLoopParams& params) {
  const OutputPort<PlatformWrench>* wrench = nullptr;
  if (!params.gusts.gusts.empty()) {
    gusts = &loop.Add<Gusts>("gusts", params.gusts);
    wrench = &gusts->wrench;
  }
  if (params.hanging_load) {
    const CdprPlantParams& start = plant.params;
    HangingLoadParams load_params = *params.hanging_load;
    const double length =
        load_params.length * (1 + load_params.mass * load_params.gravity / load_params.axial_stiffness);
    const double depth = std::sqrt(std::max(0.0, length * length - params.swing.squaredNorm()));
    load_params.p_W = start.p_WB + RotationFromEuler(start.euler) * load_params.attachment_B + params.swing -
                      Vec<3>(0, 0, depth);
    hanging_load = &loop.Add<HangingLoad>("hanging_load", load_params);
    loop.Connect(plant.platform, hanging_load->platform);
    if (wrench != nullptr) loop.Connect(*wrench, hanging_load->others);
    wrench = &hanging_load->wrench;
  }
  if (wrench != nullptr) loop.Connect(*wrench, plant.wrench);
}

LoadEstimatorParams MakeLoadEstimator(bool mpc) {
  LoadEstimatorParams params;
  if (!mpc) params.bandwidth = params.mass_bandwidth = 3;
  return params;
}

CdprObserver::CdprObserver(Subdiagram& loop, const CdprLoopParams& params, const CdprWorld& world) {
  const CdprDescription& robot = params.path->robot();
  const bool offset_free = params.IsOffsetFree();
  if (params.mpc || offset_free) {
    CdprEstimatorParams estimator_params = params.estimator;
    estimator_params.robot = robot;
    estimator = &loop.Add<CdprEstimator>("estimator", estimator_params);
    loop.Connect(world.pose, estimator->pose);
    loop.Connect(world.inertial, estimator->inertial);
    loop.Connect(world.cables, estimator->cables);
  }
  if (offset_free) {
    LoadEstimatorParams load_params = params.load.value_or(MakeLoadEstimator(params.mpc.has_value()));
    load_params.robot = robot;
    load_params.rate = params.estimator.rate;
    load = &loop.Add<LoadEstimator>("load", load_params);
    loop.Connect(estimator->estimate, load->estimate);
    loop.Connect(world.inertial, load->inertial);
    loop.Connect(world.cables, load->cables);
    if (params.known_additions) loop.Connect(world.plant.added_wrench, load->known_wrench);
    controller_load = &load->load;
  } else if (params.known_additions) {
    controller_load = &loop.AddFunction(
        "added_load", Sampled{params.control_rate}, Uses(world.plant.added_wrench),
        [](const PlatformWrench& wrench) { return LoadEstimate{.payload = {}, .rest = wrench}; });
  }
  if (params.mpc || params.feedforward || offset_free) {
    broken_cables = &loop.Add<BrokenCableDetector>(
        "broken_cables", BrokenCableDetectorParams{.num_cables = params.robot.num_cables(),
                                                   .reel_damping = robot.winch.reel_damping,
                                                   .rate = params.control_rate});
    loop.Connect(world.cables, broken_cables->cables);
  }
}

CdprControl::CdprControl(Subdiagram& loop, const CdprLoopParams& params, const ReferenceGenerator& reference,
                         const CdprWorld& world, const CdprObserver& observer) {
  const CdprDescription& robot = params.path->robot();
  if (params.mpc) {
    if (SlowOptions slow = params.hardware.calculation; slow.any()) {
      slow.rate = params.mpc->command_rate;
      auto& slow_mpc = loop.Add<Slow<CdprMpc, &CdprMpc::plan>>("mpc", {.block = *params.mpc, .slow = slow});
      mpc = &slow_mpc;
      mpc_age = &slow_mpc.age;
    } else {
      mpc = &loop.Add<CdprMpc>("mpc", *params.mpc);
    }
    loop.Connect(observer.estimator->estimate, mpc->estimate);
    if (observer.controller_load != nullptr) loop.Connect(*observer.controller_load, mpc->load);
    loop.Connect(observer.broken_cables->broken, mpc->broken);
    return;
  }
  pd = &loop.Add<CablePd>("pd", CablePdParams{robot, params.pd_stiffness_N_per_m, params.pd_damping_N_s_per_m,
                                              params.control_rate});
  loop.Connect(world.cables, pd->cables);
  if (!params.feedforward && !params.IsOffsetFree()) {
    Demand(!params.known_additions,
           "known_additions needs a controller that takes a load: an MPC, or a PD with feedforward or "
           "offset-free control");
    loop.Connect(reference.reference, pd->reference);
    return;
  }
  balancer = &loop.Add<ReferenceBalancer>("balancer", ReferenceBalancerParams{robot, params.control_rate});
  loop.Connect(reference.reference, balancer->reference);
  if (observer.controller_load != nullptr) loop.Connect(*observer.controller_load, balancer->load);
  loop.Connect(observer.broken_cables->broken, balancer->broken);
  loop.Connect(balancer->balanced, pd->reference);
}

using namespace ros2;

sensor_msgs::JointState CdprMessages::MakeCables() const {
  std::vector<std::string> names;
  for (int i = 1; i <= params.num_cables; ++i) names.push_back(fmt::format("cable_{}", i));
  return MakeJointState(names);
}

void CdprMessages::CalcCables(double t, const CableSignals& measured, sensor_msgs::JointState* out) const {
  out->header.stamp = StampOf(t);
  for (std::size_t i = 0; i < out->name.size(); ++i) {
    const auto cable = static_cast<Eigen::Index>(i);
    out->position[i] = measured.length[cable];
    out->velocity[i] = measured.length_rate[cable];
    out->effort[i] = measured.tension[cable];
  }
}

void CdprMessages::CalcDisturbance(double t, const PlatformState& x, const LoadEstimate& estimate,
                                   Wrench* out) const {
  const Eigen::Matrix3d R_BW = x.R_WB().transpose();
  out->header.stamp = StampOf(t);
  Set(R_BW * estimate.rest.force_W, &out->wrench.force);
  Set(R_BW * estimate.rest.torque_W, &out->wrench.torque);
}

void CdprMessages::CalcTf(double t, const PlatformState& x, tf2_msgs::TFMessage* out) const {
  geometry_msgs::TransformStamped& frame = out->transforms.front();
  frame.header.stamp = StampOf(t);
  Set(x.p_WB, &frame.transform.translation);
  frame.transform.rotation = QuaternionOf(x.q_WB);
}

CdprScale ScaleOf(const CdprDescription& robot, const Eigen::Vector3d& p_WB, double gravity) {
  CdprScale scale;
  scale.mass = robot.mass;
  scale.gravity = gravity;
  double length = 0, square = 0;
  for (const CableDescription& cable : robot.cables) {
    length += (cable.anchor_W - p_WB - cable.attachment_B).norm();
    square += cable.attachment_B.squaredNorm();
  }
  scale.length = length / robot.num_cables();
  scale.arm = std::sqrt(square / robot.num_cables());
  return scale;
}

CdprProfile LoadCdprProfile(const YamlFile& file, const CdprScale& scale) {
  return LoadResource("profiles", file, "mpc").Read<CdprProfile>(&scale);
}

}  // namespace tenon
