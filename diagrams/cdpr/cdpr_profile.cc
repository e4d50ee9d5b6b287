#include <tenon/diagrams/cdpr/cdpr_profile.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/systems/yaml/yaml.h>

#include <cmath>

namespace tenon {
namespace {

struct RelativeWeights {
  double position = 0, velocity = 0, attitude = 0, angular_velocity = 0, tension = 0;

  static FieldList Fields() {
    return {Required("position_l2", &RelativeWeights::position).AtLeast(0),
            Required("velocity_l2_per_t2", &RelativeWeights::velocity).AtLeast(0),
            Required("attitude_l2_per_a2", &RelativeWeights::attitude).AtLeast(0),
            Required("angular_velocity_l2_per_a2_t2", &RelativeWeights::angular_velocity).AtLeast(0),
            Required("tension_m2_g2", &RelativeWeights::tension).AtLeast(0)};
  }
};

struct RelativeMpc {
  double horizon = 0;
  int num_steps = 0;
  RelativeWeights weights;

  static FieldList Fields() {
    return {Required("horizon_t", &RelativeMpc::horizon).Positive(),
            Required("num_steps", &RelativeMpc::num_steps).Between(1, 1000),
            Required("weights", &RelativeMpc::weights)};
  }
};

struct RelativePd {
  double stiffness = 0, damping = 0;

  static FieldList Fields() {
    return {Required("stiffness_m_per_s2", &RelativePd::stiffness).Positive(),
            Required("damping_m_per_s", &RelativePd::damping).AtLeast(0)};
  }
};

/// The file of a profile.
struct RelativeProfile {
  RelativeMpc mpc;
  RelativePd pd;

  static FieldList Fields() {
    return {Required("mpc", &RelativeProfile::mpc), Required("pd", &RelativeProfile::pd)};
  }
};

}  // namespace

CdprScale ScaleOf(const CdprDescription& robot, const Eigen::Vector3d& p_WB, double gravity) {
  CdprScale scale;
  scale.mass = robot.mass;
  scale.gravity = gravity;
  double length = 0, square = 0;
  for (const CableDescription& cable : robot.cables) {
    length += (cable.anchor_W - p_WB - cable.attachment_B).norm();
    square += cable.attachment_B.squaredNorm();
  }
  scale.length = length / robot.num_cables();
  scale.arm = std::sqrt(square / robot.num_cables());
  return scale;
}

CdprProfile LoadCdprProfile(const YamlFile& file, const CdprScale& scale) {
  const auto relative = LoadResource("profiles", file, "mpc").Read<RelativeProfile>();
  const double m = scale.mass, l = scale.length, a = scale.arm, t = scale.Time();
  const RelativeWeights& weights = relative.mpc.weights;
  return {.horizon = relative.mpc.horizon * t,
          .num_steps = relative.mpc.num_steps,
          .weights = {.position = weights.position / (l * l),
                      .velocity = weights.velocity * t * t / (l * l),
                      .attitude = weights.attitude * a * a / (l * l),
                      .angular_velocity = weights.angular_velocity * a * a * t * t / (l * l),
                      .tension = weights.tension / (scale.Weight() * scale.Weight())},
          .pd_stiffness_N_per_m = relative.pd.stiffness * m,
          .pd_damping_N_s_per_m = relative.pd.damping * m};
}

}  // namespace tenon
