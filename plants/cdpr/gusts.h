#pragma once

#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/system.h>

#include <vector>

namespace tenon {

struct Gust {
  Vec<3> force_W = Vec<3>::Zero();  ///< F, at its peak [N]
  double start = 0;                 ///< t_0 [s]
  double duration = 1;              ///< T [s]
};

struct GustsParams {
  std::vector<Gust> gusts;
  void Validate() const;  ///< throws ParameterError
};

/// Gusts of wind on a platform, as forces at its CoM. Each is a discrete gust with the 1-cosine profile of
/// aviation (EASA CS-25, 25.341), and those that overlap add up:
///
///     f(t) = F (1 - cos(2 pi (t - t_0) / T)) / 2   for t_0 <= t < t_0 + T, else 0
///
///     port out  wrench  on the platform
class Gusts final : public LeafSystem<GustsParams> {
 public:
  using LeafSystem::LeafSystem;
  OutputPort<PlatformWrench> wrench{this, {"wrench"}, Uses(time), &Gusts::CalcWrench};

 private:
  PlatformWrench CalcWrench(double time) const;
};

}  // namespace tenon
