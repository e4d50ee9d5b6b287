#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/diagrams/evaluation/walk_view.h>
#include <tenon/diagrams/faults/cdpr_faults.h>
#include <tenon/diagrams/faults/faults.h>
#include <tenon/diagrams/faults/legged_faults.h>
#include <tenon/diagrams/guide_dog/guide_dog.h>
#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/plants/cdpr/cable_fault.h>
#include <tenon/plants/legged/joint_lock.h>

#include <fmt/format.h>

#include <exception>

namespace tenon {

namespace {

/// The innermost message, without the names of blocks that DiagramBuilder puts in front.
std::string FirstMessage(const std::exception& error) {
  try {
    std::rethrow_if_nested(error);
  } catch (const std::exception& inner) {
    return FirstMessage(inner);
  }
  return error.what();
}

}  // namespace

FieldList Fault::Fields() {
  return {Required("kind", &Fault::kind),
          {"elements", &Fault::elements},
          Field("start_s", &Fault::start_s).AtLeast(0),
          Field("duration_s", &Fault::duration_s).AtLeast(0),
          {"size", &Fault::size},
          Field("period_s", &Fault::period_s).Positive(),
          Field("samples", &Fault::samples).Between(1, 1e6),
          Field("probability", &Fault::probability).Between(0, 1)};
}

void Fault::Validate() const {
  const auto belongs = [&](const char* key, bool given, bool needed, const char* to) {
    Demand(given || !needed, fmt::format("a fault of kind '{}' needs {}: add it", EnumName(kind), key));
    Demand(!given || needed,
           fmt::format("{} is for {}, not for a fault of kind '{}': remove it", key, to, EnumName(kind)));
  };
  using enum FaultKind;
  belongs("size", size.has_value(), kind == kSpike || kind == kOffset || kind == kLoss,
          "spike, offset and loss");
  belongs("samples", samples.has_value(), kind == kLate, "late");
  belongs("probability", probability.has_value(), kind == kLost, "lost");
  if (period_s) belongs("period_s", true, kind == kSpike, "spike");
}

std::vector<int> Fault::Indices(const char* type, const std::vector<Element>& parts) const {
  std::vector<int> indices;
  for (const std::string& element : elements) {
    const auto part = std::ranges::find(parts, element, &Element::name);
    if (part == parts.end()) {
      std::vector<std::string> names;
      for (const Element& other : parts) names.push_back(other.name);
      throw ParameterError(fmt::format("elements: there is no {} '{}', give some of {}", type, element,
                                       fmt::join(names, ", ")));
    }
    indices.push_back(static_cast<int>(part - parts.begin()));
  }
  return indices;
}

void FaultInserter::CheckCount(std::size_t count) {
  constexpr std::size_t kMost = 100;
  Demand(count <= kMost, fmt::format("{} faults are too many, at most {} are possible: give one fault "
                                     "several elements of a place",
                                     count, kMost));
}

void FaultInserter::InsertOne(std::size_t index, const char* place,
                              const std::function<void(const std::string& name)>& insert) {
  const std::string name = fmt::format("fault_{}", index);
  try {
    insert(name);
  } catch (const ParameterError& error) {
    throw FaultError(index, fmt::format("{} at '{}': {}", name, place, FirstMessage(error)));
  } catch (const BuildError& error) {
    throw FaultError(index, fmt::format("{} at '{}': {}", name, place, FirstMessage(error)));
  }
}

void DemandKind(const Fault& fault, const std::vector<FaultKind>& possible) {
  if (std::ranges::find(possible, fault.kind) != possible.end()) return;
  std::vector<const char*> names;
  for (const FaultKind kind : possible) names.push_back(EnumName(kind));
  throw ParameterError(fmt::format("kind '{}' is not possible there: give {}", EnumName(fault.kind),
                                   fmt::join(names, " or ")));
}

namespace internal {

void DemandPeriod(const Fault& fault, const Rate& rate) {
  if (!fault.period_s || *fault.period_s >= rate.period()) return;
  throw ParameterError(
      fmt::format("period_s = {} is shorter than the sample period of {} s", *fault.period_s, rate.period()));
}

SignalFaultKind SignalKind(const Fault& fault) {
  for (const auto& [kind, name] : EnumNames(SignalFaultKind{})) {
    if (std::string_view(name) == EnumName(fault.kind)) return kind;
  }
  throw ParameterError(fmt::format(
      "kind '{}' is not possible there: it is for mechanical parts, this is a signal; give another kind",
      EnumName(fault.kind)));
}

Rate RateOf(const Source& signal) {
  const Source& origin = signal.Current().Resolve();
  return origin.is_sampled() ? origin.trigger().sampled.rate : Hz(1000);
}

void ThrowUnread(const Source* signal, const char* hint) {
  throw ParameterError(signal == nullptr ? fmt::format("no block reads this signal: {}", hint)
                                         : fmt::format("no block reads '{}' ({}): {}", signal->path(),
                                                       signal->type_name(), hint));
}

}  // namespace internal

namespace {

constexpr const char* kOnlyPd =
    "only the controllers pd… read the reference; choose command, winch, cable, lengths, pose, imu or "
    "estimate";
constexpr const char* kOnlyEstimated =
    "only the controllers mpc_… and pd_offset_free have an estimator; choose command, winch, cable, lengths "
    "or reference";

}  // namespace

std::vector<const Source*> InsertFaults(DiagramBuilder& builder, CdprLoop& loop,
                                        const std::vector<CdprFault>& faults) {
  const CdprWorld& world = loop.world;
  const CdprObserver& observer = loop.observer;
  const OutputPort<CableVector>& issued = loop.control.command();
  const int num_cables = CurrentAs<LeafSystem<CdprPlantParams>>(world.plant).params.robot.num_cables();
  std::vector<const Source*> besides_drives{&loop.command},
      beside_sensors{&world.monitor.cables, &loop.cables};
  if (observer.broken_cables != nullptr) besides_drives.push_back(&observer.broken_cables->command);
  for (const auto& block : loop.blocks())
    if (const auto* errors = dynamic_cast<const WinchErrors*>(block.get()))
      beside_sensors.push_back(&errors->cables);
  FaultPoint<CableVector> command(issued, issued, internal::kReadIt, besides_drives,
                                  CableVector::Zero(num_cables));
  FaultPoint<CableSignals> lengths(world.cables, loop.reference.reference, internal::kReadIt, beside_sensors,
                                   CableSignals::Zero(num_cables));
  FaultPoint<CdprReference> reference(
      loop.reference.reference, issued, kOnlyPd, {},
      CurrentAs<LeafSystem<ReferenceGeneratorParams>>(loop.reference).params.path->At(0));
  FaultPoint<PoseMeasurement> pose(world.pose, world.pose, kOnlyEstimated, {&loop.pose});
  FaultPoint<ImuMeasurement> imu(world.inertial, world.inertial, kOnlyEstimated, {&loop.inertial});
  FaultPoint<PlatformEstimate> estimate(kOnlyEstimated);
  if (observer.estimator != nullptr) {
    const OutputPort<PlatformEstimate>& estimated = observer.estimator->estimate;
    estimate = {estimated, estimated, kOnlyEstimated};
  }

  FaultInserter inserter(builder);
  const auto insert = [&](const Fault& fault, const std::string& name, CableFaultKind kind) {
    auto& block = builder.Add<CableFault>(name, {.kind = kind,
                                                 .num_cables = num_cables,
                                                 .cables = fault.Indices("cable", Current(issued).elements()),
                                                 .schedule = fault.schedule(),
                                                 .rate = internal::RateOf(issued)});
    builder.InsertBefore(loop.world.plant.faults, block.others, block.faults);
    inserter.signals.push_back(&block.acting);
  };
  inserter.InsertAll(faults, [&](const CdprFault& fault, const std::string& name) {
    switch (fault.at) {
      case CdprFaultPlace::kCommand:
        return command.Insert(inserter, fault, name);
      case CdprFaultPlace::kWinch:
        DemandKind(fault, {FaultKind::kStuck});
        return insert(fault, name, CableFaultKind::kStuck);
      case CdprFaultPlace::kCable:
        DemandKind(fault, {FaultKind::kBroken});
        Demand(!fault.duration_s, "duration_s: a broken cable stays broken; remove duration_s");
        return insert(fault, name, CableFaultKind::kBroken);
      case CdprFaultPlace::kLengths:
        return lengths.Insert(inserter, fault, name);
      case CdprFaultPlace::kReference:
        return reference.Insert(inserter, fault, name);
      case CdprFaultPlace::kPose:
        return pose.Insert(inserter, fault, name);
      case CdprFaultPlace::kImu:
        return imu.Insert(inserter, fault, name);
      case CdprFaultPlace::kEstimate:
        return estimate.Insert(inserter, fault, name);
    }
  });
  return std::move(inserter.signals);
}

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
  // Broken joints lose all torque. They come last, next to the drives, so that no other fault of the command
  // gives them torque.
  inserter.InsertAll(faults, [&](const LeggedFault& fault, const std::string& name) {
    if (!BreaksJoint(fault)) return;
    JointsOf(fault, places);  // refuses unknown joints
    places.torque.Insert(inserter, LossOf(fault), name);
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
