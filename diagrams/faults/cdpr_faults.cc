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
  const int num_cables = loop.plant.params.robot.num_cables();
  const OutputPort<CableVector>& controller = loop.mpc != nullptr ? loop.mpc->command : loop.pd->command;
  const Rate rate = loop.mpc != nullptr ? loop.mpc->params.command_rate : loop.pd->params.rate;
  FaultPoint<CableVector> command(controller, {loop.drive}, rate, CableVector::Zero(num_cables));
  FaultPoint<CdprReference> reference(kOnlyPd);
  FaultPoint<PoseMeasurement> pose(kOnlyEstimated);
  FaultPoint<ImuMeasurement> imu(kOnlyEstimated);
  FaultPoint<PlatformEstimate> estimate(kOnlyEstimated);
  std::vector<InputPort<CableSignals>*> length_readers;
  if (loop.pd != nullptr) length_readers.push_back(&loop.pd->cables);
  if (loop.estimator != nullptr) length_readers.push_back(&loop.estimator->cables);
  if (loop.load != nullptr) length_readers.push_back(&loop.load->cables);
  if (loop.broken_cables != nullptr) length_readers.push_back(&loop.broken_cables->cables);
  FaultPoint<CableSignals> lengths(*loop.told_cables, length_readers, loop.reference.params.rate,
                                   CableSignals::Zero(num_cables));
  if (loop.pd != nullptr) {
    InputPort<CdprReference>& reader =
        loop.balancer != nullptr ? loop.balancer->reference : loop.pd->reference;
    reference = {loop.reference.reference, {&reader}, rate, loop.reference.params.path->At(0)};
  }
  if (loop.estimator != nullptr) {
    std::vector<InputPort<ImuMeasurement>*> imu_readers{&loop.estimator->inertial};
    std::vector<InputPort<PlatformEstimate>*> estimate_readers;
    if (loop.mpc != nullptr) estimate_readers.push_back(&loop.mpc->estimate);
    if (loop.load != nullptr) {
      imu_readers.push_back(&loop.load->inertial);
      estimate_readers.push_back(&loop.load->estimate);
    }
    pose = {*loop.told_pose, {&loop.estimator->pose}, loop.pose_sensor.params.rate};
    imu = {*loop.told_inertial, imu_readers, loop.imu.params.rate};
    estimate = {loop.estimator->estimate, estimate_readers, loop.estimator->params.rate};
  }

  FaultInserter inserter(builder);
  FaultChain<CableFaults> chain(loop.plant.faults);
  const auto insert = [&](const Fault& fault, const std::string& name, CableFaultKind kind) {
    auto& block = builder.Add<CableFault>(name, {.kind = kind,
                                                 .num_cables = num_cables,
                                                 .cables = fault.Indices("cable", controller.elements()),
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
