#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/diagrams/faults/cdpr_faults.h>
#include <tenon/plants/cdpr/cable_fault.h>

namespace tenon {
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

}  // namespace tenon
