#include <tenon/controllers/cdpr/broken_cable_detector.h>

namespace tenon {

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

}  // namespace tenon
