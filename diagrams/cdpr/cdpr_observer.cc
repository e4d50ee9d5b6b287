#include <tenon/diagrams/cdpr/cdpr_observer.h>

namespace tenon {

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

}  // namespace tenon
