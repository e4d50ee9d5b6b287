#pragma once

#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// A gust of wind on the platform.
struct Gust {
  Vec<3> force_W = Vec<3>::Zero();  ///< peak force F in W [N]
  double start = 0;                 ///< start time t_0 [s]
  double duration = 1;              ///< duration T [s]

  static FieldList Fields() {
    return {Required("force_N", &Gust::force_W).Finite(), Required("start_s", &Gust::start).Finite(),
            Required("duration_s", &Gust::duration).Positive()};
  }
};

struct GustsParams {
  std::vector<Gust> gusts;
  static FieldList Fields() { return {{"gusts", &GustsParams::gusts}}; }
};

/// Gusts of wind on a platform, as forces at its CoM. Each gust has the 1-cosine profile of the discrete gust
/// in aviation (EASA CS-25, 25.341); overlapping gusts are added:
///
///     f(t) = F (1 - cos(2 pi (t - t_0) / T)) / 2   for t_0 <= t < t_0 + T, else 0
class Gusts final : public LeafSystem<GustsParams> {
 public:
  using LeafSystem::LeafSystem;
  OutputPort<PlatformWrench> wrench{this, {"wrench"}, Uses(time), &Gusts::CalcWrench};

 private:
  PlatformWrench CalcWrench(double time) const;
};

}  // namespace tenon
