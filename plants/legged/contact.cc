#include <tenon/plants/legged/body_contact.h>
#include <tenon/plants/legged/foot_contact.h>
#include <tenon/plants/legged/quadruped_geometry.h>

#include <Eigen/Geometry>

#include <algorithm>

namespace tenon {
namespace {

constexpr double kElastic = 0.7;  // fraction of z_max up to which the bristle is elastic

/// Exactly 0 below 0 and 1 above 1, with zero slope at both.
double SmoothStep(double x) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  return x * x * (3 - 2 * x);
}

double Penetration(double depth, double blend) {
  if (depth <= 0) return 0;
  return depth < blend ? depth * depth / (2 * blend) : depth - blend / 2;
}

/// Two unit tangents, images of x and y in the smallest rotation that takes z to n; n must not point down.
Eigen::Matrix<double, 3, 2> Tangents(const Vec<3>& n) {
  const double s = 1 / (1 + n[2]);
  Eigen::Matrix<double, 3, 2> T;
  T << 1 - s * n[0] * n[0], -s * n[0] * n[1], -s * n[0] * n[1], 1 - s * n[1] * n[1], -n[0], -n[1];
  return T;
}

}  // namespace

FootContact CalcFootContact(const Terrain& terrain, const ContactProperties& contact, double radius,
                            const FootMotion& foot, const Vec<2>& bristle) {
  FootContact out{Vec<3>::Zero(), foot.p_W, -bristle / contact.release_time, Vec<3>::Zero(), 0, 0};
  const Terrain::Contacts contacts = terrain.Touch(foot.p_W, radius);
  Vec<3> sum = Vec<3>::Zero();
  double friction = 0, arm = 0;  // force-weighted means; arm is the distance from the centre to the surface
  for (int i = 0; i < contacts.count; ++i) {
    const Terrain::Contact& at = contacts.at[i];
    const double rate = -at.normal_W.dot(foot.v_W);
    const double N = contact.stiffness * Penetration(at.depth, contact.blend) *
                     std::max(0.0, 1 + contact.dissipation * rate);
    sum += N * at.normal_W;
    out.normal_force += N;
    friction += N * at.friction;
    arm += N * (radius - at.depth);
    out.depth = std::max(out.depth, at.depth);
  }
  const double resultant = sum.norm();
  if (resultant == 0) return out;
  const double N = out.normal_force;
  const Vec<3> normal = sum / resultant;
  friction /= N;
  const Vec<3> to_surface = -arm / N * normal;
  out.p_W = foot.p_W + to_surface;
  out.force_W = sum;

  const Eigen::Matrix<double, 3, 2> tangents = Tangents(normal);
  const Vec<2> v = tangents.transpose() * (foot.v_W + foot.w_W.cross(to_surface));
  out.slip_W = tangents * v;
  if (friction == 0) return out;
  const double m = std::max(friction, contact.bristle_friction);
  const double z_max = m / contact.bristle_stiffness;
  const double slip = SmoothStep((bristle.norm() / z_max - kElastic) / (1 - kElastic));
  const Vec<2> held = v - slip * std::max(0.0, bristle.dot(v)) / (z_max * z_max) * bristle;
  const double gate = SmoothStep(N / contact.full_friction);
  out.bristle_rate = gate * held + (1 - gate) * out.bristle_rate;
  const Vec<2> w = contact.bristle_stiffness * bristle + contact.bristle_damping * out.bristle_rate;
  const double size = w.norm();
  const double scale = size > m ? m / size : 1;
  out.force_W -= N * scale * (friction / m) * (tangents * w);
  return out;
}

namespace {

constexpr double kEdge = 0.005;   // radius of sharp edges [m]
constexpr double kTime = 0.01;    // T, see BodyContact [s]
constexpr double kHardness = 10;  // stiffness of a shell over that of a foot

}  // namespace

BodyContact::BodyContact(const QuadrupedDescription& robot, const TerrainParams& terrain)
    : terrain_(terrain), contact_(robot.contact) {
  std::vector<RoundedBox> shapes = robot.trunk_shapes;
  if (shapes.empty()) shapes = {BoxBetweenHips(robot)};
  for (const RoundedBox& shape : shapes) {
    const double radius = std::clamp(shape.radius, kEdge, Terrain::kMaxRadius);
    const Vec<3> half = (shape.half.array() + (shape.radius - radius)).max(0);
    for (int corner = 0; corner < 8; ++corner) {
      bool repeats = false;
      Vec<3> p = half;
      for (int i = 0; i < 3; ++i) {
        if ((corner >> i & 1) == 0) continue;
        p[i] = -p[i];
        repeats = repeats || half[i] == 0;
      }
      if (!repeats) spheres_.push_back({0, shape.p_B + shape.R_BS * p, radius});
    }
  }
  const double radius = std::min(LinkRadius(robot), Terrain::kMaxRadius);
  Vec<3> upper = Vec<3>::Constant(-std::numeric_limits<double>::infinity()), lower = -upper;
  const auto include = [&](const Vec<3>& p, double reach) {
    upper = upper.cwiseMax((p.array() + reach).matrix());
    lower = lower.cwiseMin((p.array() - reach).matrix());
  };
  for (const Sphere& sphere : spheres_) include(sphere.p, sphere.radius);
  for (int i = 1; i < kJointsPerLeg; ++i) {
    for (int leg = 0; leg < kNumLegs; ++leg) {
      const auto& joints = robot.legs[leg].joints;
      const Vec<3>& p = joints[i].p_PJ;
      spheres_.push_back({kJointsPerLeg * leg + i, p, radius});
      if (i == 1) include(joints[0].p_PJ, p.norm() + radius);
    }
  }
  middle_ = (upper + lower) / 2;
  half_ = (upper - lower) / 2;
  double friction = terrain.friction;
  for (const TerrainBox& box : terrain_.boxes()) {
    top_ = std::max(top_, box.height);
    friction = std::min(friction, box.friction);
  }
  contact_.stiffness *= kHardness;
  contact_.bristle_friction = std::max(friction, contact_.bristle_friction);  // of all friction that there is
}

void BodyContact::CalcForces(const QuadrupedBody& body, const LeggedState& x, Forces* out) const {
  const Vec<3> up_W = terrain_.R_WS().col(2);
  const double up_trunk = up_W.dot(x.p_WB);
  const Vec<3> up_B = x.R_WB().transpose() * up_W;
  const bool trunk_is_near = up_trunk + up_B.dot(middle_) - up_B.cwiseAbs().dot(half_) < top_;
  const std::size_t knees = spheres_.size() - kNumLegs;
  const double most = kElastic * contact_.bristle_friction / contact_.bristle_stiffness;
  out->count = 0;
  for (std::size_t i = trunk_is_near ? 0 : knees; i < spheres_.size(); ++i) {
    const Sphere& sphere = spheres_[i];
    if (i >= knees && up_W.dot(body.Origin(sphere.body + 1)) - sphere.radius > top_) continue;
    const FootMotion motion = body.MotionOf(sphere.body, sphere.p);
    Vec<2> bristle = kTime * (motion.v_W - sphere.radius * motion.w_W.cross(up_W)).head<2>();
    bristle *= std::min(1.0, most / std::max(bristle.norm(), 1e-9));
    const FootContact contact = CalcFootContact(terrain_, contact_, sphere.radius, motion, bristle);
    if (contact.depth <= 0) continue;
    if (out->count == 0 || out->at[out->count - 1].body != sphere.body)
      out->at[out->count++] = {sphere.body, contact.p_W, Vec<3>::Zero()};
    PointForce& sum = out->at[out->count - 1];
    sum.force_W += contact.force_W;
    sum.torque_W += (contact.p_W - sum.p_W).cross(contact.force_W);
  }
}

}  // namespace tenon
