#include <tenon/plants/legged/foot_contact.h>

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
    const Terrain::Contact& at = contacts.at[static_cast<std::size_t>(i)];
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

}  // namespace tenon
