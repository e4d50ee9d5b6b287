#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/diagrams/evaluation/walk_view.h>
#include <tenon/diagrams/faults/legged_faults.h>
#include <tenon/diagrams/guide_dog/guide_dog.h>
#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/plants/legged/joint_lock.h>

namespace tenon {
namespace {

constexpr const char* kOnlyWalks = "the robot stands by joint PD; choose torque, joint or encoders";
constexpr const char* kOnlyGuideDogs = "only a guide dog has an obstacle detector; choose another place";
constexpr const char* kNoEstimator =
    "the controller reads the true state; set walk.state to estimated, or choose the place state";
constexpr const char* kNoFootSensors =
    "the feet have no sensors; set sensors.foot_force.mounted to world or shank, or choose torque_sensor";
constexpr const char* kNoDeployment = "the walk has no supervisor; give deployment, or choose another place";
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
  FaultPoint<double> link{kNoDeployment};
  FaultPoint<bool> obstacle{kOnlyGuideDogs};
};

/// The places of a walk. The blocks `beside` simulate the surroundings and read the true state.
Places PlacesOfWalk(QuadrupedWalk& loop, std::vector<const Source*> beside = {}) {
  QuadrupedWorld& world = loop.world;
  const Source& clock = loop.locomotion.torque;
  beside.insert(beside.end(), {&loop.errors.state, &loop.errors.told, &loop.view.state});
  if (loop.map != nullptr) beside.push_back(&loop.map->state);
  Places places{.world = &world,
                .torque = {loop.locomotion.torque, clock},
                .encoders = {world.joints, world.joints, kNoEstimator},
                .torque_sensor = {world.measured_torque, world.measured_torque},
                .foot_force = {world.foot_forces, world.foot_forces, kNoFootSensors},
                .imu = {world.inertial, world.inertial},
                .wrench = {loop.observer.wrench, clock, internal::kReadIt, {&loop.view.wrench}}};
  if (loop.ropes != nullptr) {
    beside.push_back(&loop.ropes->robot);
    places.rope = {loop.winches->y,
                   clock,
                   kNoRopes,
                   {},
                   CurrentAs<LeafSystem<HeldLagParams<CableVector>>>(*loop.winches).params.initial};
  }
  if (loop.deployment != nullptr) {
    places.link = {*loop.heartbeat, *loop.heartbeat};
    places.encoders = {world.joints, world.joints, kNoEstimator, {&loop.drives->joints}};
  }
  places.state = {loop.state, clock, internal::kReadIt, std::move(beside)};
  return places;
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
  inserter.builder.InsertBefore(places.world->plant.locks, lock.others, lock.locks);
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
    case LeggedFaultPlace::kLink:
      return places.link.Insert(inserter, fault, name);
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
  return Insert(
      builder,
      {.world = &world, .torque = {loop.pd.torque, loop.pd.torque}, .encoders = {world.joints, world.joints}},
      faults);
}

std::vector<const Source*> InsertFaults(DiagramBuilder& builder, QuadrupedWalk& loop,
                                        const std::vector<LeggedFault>& faults) {
  return Insert(builder, PlacesOfWalk(loop), faults);
}

std::vector<const Source*> InsertFaults(DiagramBuilder& builder, GuideDog& loop,
                                        const std::vector<LeggedFault>& faults) {
  Places places = PlacesOfWalk(loop, {&loop.obstacles.state, &loop.leash.robot});
  places.obstacle = {loop.obstacles.in_sight, loop.supervisor.walk};
  return Insert(builder, std::move(places), faults);
}

}  // namespace tenon
