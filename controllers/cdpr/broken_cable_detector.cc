#include <tenon/controllers/cdpr/broken_cable_detector.h>

#include <fmt/core.h>

namespace tenon {

void BrokenCableDetectorParams::Validate() const {
  Demand(num_cables > 0, fmt::format("num_cables = {} must be the number of the robot's cables", num_cables));
  Demand(share > 0 && share < 1,
         fmt::format("share = {} must be between 0 and 1: a part of the tension", share));
  Demand(least_tension > 0,
         fmt::format("least_tension = {} N must be positive: a cable without a command does not pull",
                     least_tension));
  Demand(reel_damping >= 0, fmt::format("reel_damping = {} N s/m must not be negative", reel_damping));
  Demand(patience > 0,
         fmt::format("patience = {} s must be positive: winches lag behind their commands", patience));
}

void BrokenCableDetector::CalcNext(const CableVector& missing, const CableSignals& cables,
                                   const CableVector& command, CableVector* next) const {
  for (const Eigen::Index num : {cables.tension.size(), command.size()})
    CheckNumCables(params.num_cables, num, "BrokenCableDetector");
  *next = missing;
  if ((cables.tension.array() <= 0).all()) return;
  for (Eigen::Index i = 0; i < missing.size(); ++i) {
    if (missing[i] >= params.patience) continue;
    const double expected = command[i] + params.reel_damping * cables.length_rate[i];
    const bool sound = expected < params.least_tension || cables.length[i] < cables.rest_length[i] ||
                       cables.tension[i] >= params.share * expected;
    (*next)[i] = sound ? 0 : std::min(missing[i] + params.rate.period(), params.patience);
  }
}

void BrokenCableDetector::CalcBroken(const CableVector& missing, CableVector* broken) const {
  *broken = (missing.array() >= params.patience).cast<double>();
}

}  // namespace tenon
