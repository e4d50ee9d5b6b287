#include <tenon/plants/sensors/cable_sensors.h>
#include <tenon/plants/sensors/imu.h>
#include <tenon/plants/sensors/imu_errors.h>
#include <tenon/plants/sensors/pose_sensor.h>
#include <tenon/plants/sensors/sensor_noise.h>
#include <tenon/plants/sensors/terrain_mapper.h>

#include <Eigen/Geometry>

#include <numbers>

namespace tenon {

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

template <class State, class Acceleration>
ImuMeasurement BasicImu<State, Acceleration>::CalcMeasurement(
    const State& body, const Acceleration& acceleration, const Vec<3>& angular_velocity_noise,
    const Vec<3>& specific_force_noise, const Vec<3>& angular_velocity_bias,
    const Vec<3>& specific_force_bias, RandomStream& noise) const {
  const Eigen::Matrix3d R_WB = body.R_WB();
  const Vec<3> r_W = R_WB * params.p_B;
  const Vec<3> a_W = acceleration.a_W + acceleration.alpha_W.cross(r_W) + body.w_W.cross(body.w_W.cross(r_W));
  const Vec<3> w_B = R_WB.transpose() * body.w_W;
  const Vec<3> f_B = R_WB.transpose() * (a_W + Vec<3>(0, 0, params.gravity));
  ImuMeasurement out;
  out.angular_velocity_B = w_B + angular_velocity_bias + NormalVector(noise, angular_velocity_noise);
  out.specific_force_B = f_B + specific_force_bias + NormalVector(noise, specific_force_noise);
  return out;
}

template class BasicImu<PlatformState, PlatformAcceleration>;
template class BasicImu<LeggedState, LeggedAcceleration>;

ImuErrors::Unit ImuErrors::Draw(RandomStream& random) const {
  Unit unit;
  unit.turn_B = NormalVector(random, Vec<3>::Constant(params.misalignment));
  unit.angular_velocity_bias = NormalVector(random, Vec<3>::Constant(params.angular_velocity_bias));
  unit.specific_force_bias = NormalVector(random, Vec<3>::Constant(params.specific_force_bias));
  return unit;
}

ImuErrors::Unit ImuErrors::Walk(const Unit& unit, RandomStream& random) const {
  const double root = std::sqrt(params.rate.period());
  Unit next = unit;
  next.angular_velocity_bias += NormalVector(random, Vec<3>::Constant(params.angular_velocity_walk * root));
  next.specific_force_bias += NormalVector(random, Vec<3>::Constant(params.specific_force_walk * root));
  return next;
}

ImuMeasurement ImuErrors::CalcMeasured(const ImuMeasurement& in, const Unit& unit) const {
  const Eigen::Matrix3d R_IB = RotationFromQuaternion(QuaternionFromRotationVector(-unit.turn_B));
  ImuMeasurement out;
  out.angular_velocity_B = R_IB * in.angular_velocity_B + unit.angular_velocity_bias;
  out.specific_force_B = R_IB * in.specific_force_B + unit.specific_force_bias;
  return out;
}

PoseSensor::Offset PoseSensor::Draw(RandomStream& calibration) const {
  Offset offset;
  offset.position = NormalVector(calibration, Vec<3>::Constant(params.position_offset));
  offset.turn = NormalVector(calibration, Vec<3>::Constant(params.attitude_offset));
  return offset;
}

PoseMeasurement PoseSensor::CalcPose(const PlatformState& platform, const Vec<3>& position_noise,
                                     const Vec<3>& attitude_noise, const Offset& offset,
                                     RandomStream& noise) const {
  const Vec<3> p_WB = platform.p_WB + offset.position + NormalVector(noise, position_noise);
  const Vec<3> turn = offset.turn + NormalVector(noise, attitude_noise);
  return {p_WB, QuaternionProduct(platform.q_WB, QuaternionFromRotationVector(turn))};
}

TerrainMapper::TerrainMapper(const TerrainMapperParams& params) : LeafSystem(params) {
  RandomStream random(params.seed, "terrain_map");
  for (double& error : noise_) error = params.map.noise * random.Normal();
}

void TerrainMapper::CalcMap(const LeggedState& state, const LeggedState& told, ElevationMap* map) const {
  constexpr int n = ElevationMap::kSize;
  const double cell = params.map.cell;
  const Eigen::Vector3d is = state.R_WB().col(0), seems = told.R_WB().col(0);
  const Eigen::Rotation2Dd turn(std::atan2(is[1], is[0]) - std::atan2(seems[1], seems[0]));
  const Eigen::Array2d corner = (told.p_WB.head<2>().array() / cell).round() - n / 2;
  map->cell = cell;
  map->first_W = cell * corner;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const Eigen::Vector2d place = map->first_W + cell * Eigen::Vector2d(i, j);
      const Eigen::Vector2d there = state.p_WB.head<2>() + turn * (place - told.p_WB.head<2>());
      const auto wrapped = [](double index) { return (static_cast<int>(index) % n + n) % n; };
      const int of_noise = wrapped(corner[0] + i) + n * wrapped(corner[1] + j);
      map->height[i + n * j] =
          terrain_.At(there[0], there[1]).height + told.p_WB[2] - state.p_WB[2] + noise_[of_noise];
    }
  }
}

}  // namespace tenon
