#include <tenon/diagrams/cdpr/cdpr_control.h>

namespace tenon {

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

}  // namespace tenon
