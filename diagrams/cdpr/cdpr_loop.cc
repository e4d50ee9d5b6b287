#include <tenon/diagrams/cdpr/cdpr_loop.h>

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

}  // namespace tenon
