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
  CdprWorld& world = loop.world;
  CdprObserver& observer = loop.observer;
  CdprControl& control = loop.control;
  const int num_cables = world.plant.params.robot.num_cables();
  const Rate rate = control.rate();
  FaultPoint<CableVector> command(control.command(), {&world.command}, rate, CableVector::Zero(num_cables));
  FaultPoint<CdprReference> reference(kOnlyPd);
  FaultPoint<PoseMeasurement> pose(kOnlyEstimated);
  FaultPoint<ImuMeasurement> imu(kOnlyEstimated);
  FaultPoint<PlatformEstimate> estimate(kOnlyEstimated);
  std::vector<InputPort<CableSignals>*> length_readers;
  if (control.pd != nullptr) length_readers.push_back(&control.pd->cables);
  if (observer.estimator != nullptr) length_readers.push_back(&observer.estimator->cables);
  if (observer.load != nullptr) length_readers.push_back(&observer.load->cables);
  if (observer.broken_cables != nullptr) length_readers.push_back(&observer.broken_cables->cables);
  FaultPoint<CableSignals> lengths(world.cables, length_readers, loop.reference.params.rate,
                                   CableSignals::Zero(num_cables));
  if (control.pd != nullptr) {
    InputPort<CdprReference>& reader =
        control.balancer != nullptr ? control.balancer->reference : control.pd->reference;
    reference = {loop.reference.reference, {&reader}, rate, loop.reference.params.path->At(0)};
  }
  if (observer.estimator != nullptr) {
    std::vector<InputPort<ImuMeasurement>*> imu_readers{&observer.estimator->inertial};
    std::vector<InputPort<PlatformEstimate>*> estimate_readers;
    if (control.mpc != nullptr) estimate_readers.push_back(&control.mpc->estimate);
    if (observer.load != nullptr) {
      imu_readers.push_back(&observer.load->inertial);
      estimate_readers.push_back(&observer.load->estimate);
    }
    pose = {world.pose, {&observer.estimator->pose}, world.pose_sensor.params.rate};
    imu = {world.inertial, imu_readers, world.imu.params.rate};
    estimate = {observer.estimator->estimate, estimate_readers, observer.estimator->params.rate};
  }

  FaultInserter inserter(builder);
  FaultChain<CableFaults> chain(world.plant.faults);
  const auto insert = [&](const Fault& fault, const std::string& name, CableFaultKind kind) {
    auto& block =
        builder.Add<CableFault>(name, {.kind = kind,
                                       .num_cables = num_cables,
                                       .cables = fault.Indices("cable", control.command().elements()),
                                       .schedule = fault.schedule(),
                                       .rate = rate});
    chain.Append(builder, block.faults, block.others);
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
