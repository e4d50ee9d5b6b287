#include <tenon/apps/quadruped/quadruped_faults.h>
#include <tenon/diagrams/legged/foot_forces_of_legs.h>
#include <tenon/plants/legged/joint_lock.h>

namespace tenon::apps {
namespace {

constexpr const char* kOnlyWalks = "it is there for a robot that walks; choose torque, joint or encoders";
constexpr const char* kOnlyGuideDogs = "it is there for tenon-guide-dog; choose another place";

/// The places that a diagram has.
struct Places {
  QuadrupedWorld* world;
  FaultPoint<Vec<12>> torque;
  FaultPoint<JointMotion> encoders;
  FaultPoint<Vec<12>> torque_sensor{kOnlyWalks};
  FaultPoint<FootForces> foot_force{kOnlyWalks};
  FaultPoint<ImuMeasurement> imu{kOnlyWalks};
  FaultPoint<LeggedState> state{kOnlyWalks};
  FaultPoint<WrenchEstimate> wrench{kOnlyWalks};
  FaultPoint<bool> obstacle{kOnlyGuideDogs};
  FaultChain<JointLocks> locks{world->plant.locks};
};

/// Of what walks, QuadrupedWalk or GuideDog; these read state and wrench beside locomotion and observer.
Places PlacesOfWalk(auto& loop, std::vector<InputPort<LeggedState>*> state_readers,
                    std::vector<InputPort<WrenchEstimate>*> wrench_readers) {
  QuadrupedWorld& world = loop.world;
  const Rate rate = loop.locomotion.whole_body.params.rate;
  FaultPoint<JointMotion> encoders(
      "the controller is told the true state; set walk.state to estimated, or choose the place state");
  std::vector<InputPort<ImuMeasurement>*> imu_readers{&loop.observer.imu};
  if (loop.estimator != nullptr) {
    encoders = {world.joints, {&loop.estimator->joints}, world.encoders.params.rate};
    imu_readers = {&loop.estimator->imu};
  }
  std::vector<InputPort<Vec<12>>*> torque_readers{&loop.observer.torque};
  FaultPoint<FootForces> foot_force(
      "the feet have no sensors; set sensors.foot_force.mounted to world or shank, or choose torque_sensor");
  if (loop.foot_forces_of_legs != nullptr) {
    torque_readers.push_back(&loop.foot_forces_of_legs->torque);
    state_readers.push_back(&loop.foot_forces_of_legs->state);
  } else {
    std::vector<InputPort<FootForces>*> readers{&loop.locomotion.foot_forces, &loop.observer.foot_forces};
    if (loop.foot_force_estimate != nullptr) {
      readers = {&loop.foot_force_estimate->shank};
      state_readers.push_back(&loop.foot_force_estimate->state);
    }
    foot_force = {world.foot_forces, std::move(readers), world.foot_sensor.params.rate};
  }
  state_readers.insert(state_readers.begin(), {&loop.locomotion.state, &loop.observer.state});
  wrench_readers.insert(wrench_readers.begin(), &loop.locomotion.wrench);
  return {
      .world = &world,
      .torque = {loop.locomotion.torque, {&world.torque}, rate},
      .encoders = std::move(encoders),
      .torque_sensor = {world.measured_torque, std::move(torque_readers), world.torque_sensor.params.rate},
      .foot_force = std::move(foot_force),
      .imu = {world.inertial, std::move(imu_readers), world.imu.params.rate},
      .state = {loop.estimator != nullptr ? loop.estimator->state : world.state, std::move(state_readers),
                rate},
      .wrench = {loop.observer.wrench, std::move(wrench_readers), rate}};
}

void InsertJointFault(FaultInserter& inserter, const Fault& fault, const std::string& name, Places& places) {
  DemandKind(fault, {FaultKind::kStuck, FaultKind::kBroken});
  const std::vector<int> joints = fault.Indices("joint", places.world->external_torque.elements());
  if (fault.kind == FaultKind::kBroken) {
    Fault loss = fault;
    loss.kind = FaultKind::kLoss;
    loss.size = 1;
    return places.torque.Insert(inserter, loss, name);
  }
  auto& lock = inserter.builder.Add<JointLock>(name, {.joints = joints, .schedule = fault.schedule()});
  inserter.builder.Connect(places.world->state, lock.state);
  places.locks.Append(inserter.builder, lock.locks, lock.others);
  inserter.signals.push_back(&lock.acting);
}

std::vector<const Source*> Insert(DiagramBuilder& builder, Places places,
                                  const std::vector<LeggedFault>& faults) {
  FaultInserter inserter(builder);
  bool breaks = false;
  const auto insert = [&](const LeggedFault& fault, const std::string& name) {
    if ((fault.at == LeggedFaultPlace::kJoint && fault.kind == FaultKind::kBroken) != breaks) return;
    switch (fault.at) {
      case LeggedFaultPlace::kTorque:
        return places.torque.Insert(inserter, fault, name);
      case LeggedFaultPlace::kJoint:
        return InsertJointFault(inserter, fault, name, places);
      case LeggedFaultPlace::kEncoders:
        return places.encoders.Insert(inserter, fault, name);
      case LeggedFaultPlace::kTorqueSensor:
        return places.torque_sensor.Insert(inserter, fault, name);
      case LeggedFaultPlace::kFootForce:
        return places.foot_force.Insert(inserter, fault, name);
      case LeggedFaultPlace::kImu:
        return places.imu.Insert(inserter, fault, name);
      case LeggedFaultPlace::kState:
        return places.state.Insert(inserter, fault, name);
      case LeggedFaultPlace::kWrench:
        return places.wrench.Insert(inserter, fault, name);
      case LeggedFaultPlace::kObstacle:
        return places.obstacle.Insert(inserter, fault, name);
    }
  };
  inserter.InsertAll(faults, insert);
  breaks = true;  // last, next to the drives: what broke gives no torque, whatever the command is
  inserter.InsertAll(faults, insert);
  return std::move(inserter.signals);
}

}  // namespace

std::vector<const Source*> InsertFaults(DiagramBuilder& builder, QuadrupedStand& loop,
                                        const std::vector<LeggedFault>& faults) {
  QuadrupedWorld& world = loop.world;
  return Insert(builder,
                {.world = &world,
                 .torque = {loop.pd.torque, {&world.torque}, loop.pd.params.rate},
                 .encoders = {world.joints, {&loop.pd.joints}, world.encoders.params.rate}},
                faults);
}

std::vector<const Source*> InsertFaults(DiagramBuilder& builder, QuadrupedWalk& loop,
                                        const std::vector<LeggedFault>& faults) {
  return Insert(builder, PlacesOfWalk(loop, {}, {}), faults);
}

std::vector<const Source*> InsertFaults(DiagramBuilder& builder, GuideDog& loop,
                                        const std::vector<LeggedFault>& faults) {
  Places places = PlacesOfWalk(loop, {&loop.supervisor.state, &loop.admittance.state},
                               {&loop.supervisor.wrench, &loop.admittance.wrench});
  places.obstacle = {loop.obstacles.obstacle, {&loop.supervisor.obstacle}, loop.supervisor.params.rate};
  return Insert(builder, std::move(places), faults);
}

}  // namespace tenon::apps
