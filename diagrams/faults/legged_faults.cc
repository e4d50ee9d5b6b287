#include <tenon/diagrams/faults/legged_faults.h>
#include <tenon/diagrams/guide_dog/guide_dog.h>
#include <tenon/diagrams/legged/foot_forces_of_legs.h>
#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/plants/legged/joint_lock.h>

namespace tenon {
namespace {

constexpr const char* kOnlyWalks = "the robot stands by joint PD; choose torque, joint or encoders";
constexpr const char* kOnlyGuideDogs = "only a guide dog has an obstacle detector; choose another place";
constexpr const char* kNoEstimator =
    "the controller reads the true state; set walk.state to estimated, or choose the place state";
constexpr const char* kNoFootSensors =
    "the feet have no sensors; set sensors.foot_force.mounted to world or shank, or choose torque_sensor";
constexpr const char* kNoRopes = "the robot has no ropes; give ropes, or choose another place";

/// The places of one diagram at which faults can occur.
struct Places {
  QuadrupedWorld* world;
  FaultPoint<Vec<12>> torque;
  FaultPoint<JointMotion> encoders;
  FaultPoint<Vec<12>> torque_sensor{kOnlyWalks};
  FaultPoint<FootForces> foot_force{kOnlyWalks};
  FaultPoint<ImuMeasurement> imu{kOnlyWalks};
  FaultPoint<LeggedState> state{kOnlyWalks};
  FaultPoint<WrenchEstimate> wrench{kOnlyWalks};
  FaultPoint<CableVector> rope{kNoRopes};
  FaultPoint<bool> obstacle{kOnlyGuideDogs};
  FaultChain<JointLocks> locks{world->plant.locks};
};

/// The places of a walk. A guide dog has further readers of state and wrench beside locomotion and observer.
Places PlacesOfWalk(QuadrupedWalk& loop, std::vector<InputPort<LeggedState>*> state_readers,
                    std::vector<InputPort<WrenchEstimate>*> wrench_readers) {
  QuadrupedWorld& world = loop.world;
  const Rate rate = loop.locomotion.whole_body.params.rate;
  FaultPoint<JointMotion> encoders(kNoEstimator);
  std::vector<InputPort<ImuMeasurement>*> imu_readers{&loop.observer.imu};
  if (loop.estimator != nullptr) {
    encoders = {world.joints, {&loop.estimator->joints}, world.encoders.params.rate};
    imu_readers = {&loop.estimator->imu};
  }
  std::vector<InputPort<Vec<12>>*> torque_readers{&loop.observer.torque};
  FaultPoint<FootForces> foot_force(kNoFootSensors);
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
  FaultPoint<CableVector> rope(kNoRopes);
  if (loop.ropes != nullptr)
    rope = {loop.winches->y, {&loop.ropes->command}, rate, loop.winches->params.initial};
  state_readers.insert(state_readers.begin(), {&loop.locomotion.state, &loop.observer.state});
  wrench_readers.insert(wrench_readers.begin(), &loop.locomotion.wrench);
  return {
      .world = &world,
      .torque = {loop.locomotion.torque, {&world.torque}, rate},
      .encoders = std::move(encoders),
      .torque_sensor = {world.measured_torque, std::move(torque_readers), world.torque_sensor.params.rate},
      .foot_force = std::move(foot_force),
      .imu = {world.inertial, std::move(imu_readers), world.imu.params.rate},
      .state = {loop.state, std::move(state_readers), rate},
      .wrench = {loop.observer.wrench, std::move(wrench_readers), rate},
      .rope = std::move(rope)};
}

bool BreaksJoint(const LeggedFault& fault) {
  return fault.at == LeggedFaultPlace::kJoint && fault.kind == FaultKind::kBroken;
}

std::vector<int> JointsOf(const Fault& fault, const Places& places) {
  return fault.Indices("joint", places.world->external_torque.elements());
}

void InsertJointLock(FaultInserter& inserter, const Fault& fault, const std::string& name, Places& places) {
  DemandKind(fault, {FaultKind::kStuck, FaultKind::kBroken});
  auto& lock = inserter.builder.Add<JointLock>(
      name, {.joints = JointsOf(fault, places), .schedule = fault.schedule()});
  inserter.builder.Connect(places.world->state, lock.state);
  places.locks.Append(inserter.builder, lock.locks, lock.others);
  inserter.signals.push_back(&lock.acting);
}

/// The loss of a whole signal, as which a broken part acts.
Fault LossOf(Fault broken) {
  broken.kind = FaultKind::kLoss;
  broken.size = 1;
  return broken;
}

/// Sets the torque of the joints to zero.
void InsertBrokenJoint(FaultInserter& inserter, const Fault& fault, const std::string& name, Places& places) {
  JointsOf(fault, places);
  places.torque.Insert(inserter, LossOf(fault), name);
}

/// Sets the tension of the ropes to zero.
void InsertBrokenRope(FaultInserter& inserter, const Fault& fault, const std::string& name, Places& places) {
  DemandKind(fault, {FaultKind::kBroken});
  Demand(!fault.duration_s, "duration_s: a broken rope stays broken; remove duration_s");
  places.rope.Insert(inserter, LossOf(fault), name);
}

void InsertFault(FaultInserter& inserter, const LeggedFault& fault, const std::string& name, Places& places) {
  switch (fault.at) {
    case LeggedFaultPlace::kTorque:
      return places.torque.Insert(inserter, fault, name);
    case LeggedFaultPlace::kJoint:
      return InsertJointLock(inserter, fault, name, places);
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
    case LeggedFaultPlace::kRope:
      return InsertBrokenRope(inserter, fault, name, places);
    case LeggedFaultPlace::kObstacle:
      return places.obstacle.Insert(inserter, fault, name);
  }
}

std::vector<const Source*> Insert(DiagramBuilder& builder, Places places,
                                  const std::vector<LeggedFault>& faults) {
  FaultInserter inserter(builder);
  inserter.InsertAll(faults, [&](const LeggedFault& fault, const std::string& name) {
    if (!BreaksJoint(fault)) InsertFault(inserter, fault, name, places);
  });
  // Broken joints come last, next to the drives, so that no other fault of the command gives them torque.
  inserter.InsertAll(faults, [&](const LeggedFault& fault, const std::string& name) {
    if (BreaksJoint(fault)) InsertBrokenJoint(inserter, fault, name, places);
  });
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

}  // namespace tenon
