#include <tenon/plants/cdpr/cable_fault.h>

#include <fmt/format.h>

namespace tenon {

void CableFaultParams::Validate() const {
  Demand(num_cables > 0, fmt::format("num_cables = {} must be the number of the robot's cables", num_cables));
  for (const int i : cables)
    Demand(i >= 0 && i < num_cables, fmt::format("there is no cable {}: give 0 to {}", i, num_cables - 1));
  Demand(kind != CableFaultKind::kBroken || std::isinf(schedule.duration),
         fmt::format("schedule.duration = {}, but a broken cable stays broken: leave it infinite",
                     schedule.duration));
}

bool CableFault::CalcActing(double time, const FaultSchedule& schedule, bool active, bool& acted) const {
  const bool acts = active && schedule.Acts(time, params.rate);
  acted = acted || acts;
  return params.kind == CableFaultKind::kBroken ? acted : acts;
}

void CableFault::CalcFaults(const CableFaults& others, bool acting, CableFaults* out) const {
  const auto take_over = [&](const CableVector& from, CableVector& to) {
    if (from.size() == 0) {
      to.setZero();
    } else if (from.size() == to.size()) {
      to = from;
    } else {
      throw RunError(fmt::format("`others` are of {} cables, but num_cables is {}: give both the robot's",
                                 from.size(), to.size()));
    }
  };
  take_over(others.stuck, out->stuck);
  take_over(others.broken, out->broken);
  if (!acting) return;
  CableVector& own = params.kind == CableFaultKind::kBroken ? out->broken : out->stuck;
  for (const int i : params.cables) own[i] = 1;
  if (params.cables.empty()) own.setOnes();
}

}  // namespace tenon
