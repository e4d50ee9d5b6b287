#include <tenon/plants/sensors/cable_sensors.h>

#include <fmt/format.h>

#include <numbers>

namespace tenon {

void CableSensorsParams::Validate() const {
  Demand(num_cables > 0, fmt::format("num_cables = {} must be positive", num_cables));
}

void CableSensors::Draw(RandomStream& random, Offsets* offsets) const {
  *offsets = {Zero(), Zero()};
  for (double& each : offsets->length) each = params.length_offset * random.Normal();
  for (double& each : offsets->tension) each = params.tension_offset * random.Normal();
}

void CableSensors::CalcMeasured(const CableSignals& cables, const Offsets& offsets, RandomStream& random,
                                Memory& memory, CableSignals* measured) const {
  CheckNumCables(params.num_cables, cables.length.size(), "CableSensors");
  const auto rounded = [&](double length) {
    return params.resolution > 0 ? params.resolution * std::round(length / params.resolution) : length;
  };
  const double h = params.rate.period();
  const double a = std::exp(-2 * std::numbers::pi * params.rate_bandwidth * h);
  for (Eigen::Index i = 0; i < measured->length.size(); ++i) {
    const double length = rounded(cables.length[i] + offsets.length[i]);
    const double difference = memory.started ? (length - memory.length[i]) / h : 0;
    measured->length[i] = length;
    measured->length_rate[i] =
        params.rate_bandwidth > 0 ? a * memory.rate[i] + (1 - a) * difference : cables.length_rate[i];
    measured->rest_length[i] = rounded(cables.rest_length[i] + offsets.length[i]);
    measured->tension[i] =
        std::max(0.0, cables.tension[i] * (1 + params.tension_noise * random.Normal()) + offsets.tension[i]);
    memory.length[i] = length;
    memory.rate[i] = measured->length_rate[i];
  }
  memory.started = true;
}

}  // namespace tenon
