#include <tenon/plants/cdpr/winch_errors.h>

#include <fmt/format.h>

namespace tenon {

void WinchErrorsParams::Validate() const {
  Demand(num_cables > 0, fmt::format("num_cables = {} must be positive", num_cables));
}

void WinchErrors::Draw(RandomStream& random, CableVector* gain) const {
  gain->resize(params.num_cables);
  for (double& each : *gain) each = params.gain_deviation * random.Normal();
}

void WinchErrors::CalcTension(const CableVector& command, const CableSignals& cables, const CableVector& gain,
                              RandomStream& random, CableVector* tension) const {
  for (const auto& [name, size] :
       {std::pair{"command", command.size()}, std::pair{"cables", cables.length_rate.size()}})
    if (size != params.num_cables)
      throw RunError(fmt::format("'{}' has {} cables, num_cables is {}", name, size, params.num_cables));
  for (Eigen::Index i = 0; i < tension->size(); ++i) {
    const double rubs = 1 + params.friction * std::tanh(cables.length_rate[i] / params.friction_speed);
    (*tension)[i] = (1 + gain[i]) * (1 + params.ripple * random.Normal()) * rubs * command[i];
  }
}

}  // namespace tenon
