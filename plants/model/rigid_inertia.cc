#include <tenon/plants/model/attached_body.h>
#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/model/vectors.h>
#include <tenon/systems/analysis/internal/small_matrices.h>

#include <fmt/format.h>

namespace tenon {
namespace {

/// Tolerance relative to the largest entry, for inertias given with few digits.
constexpr double kInertiaTolerance = 1e-9;

}  // namespace

RigidInertia RigidInertia::In(const Eigen::Matrix3d& R, const Eigen::Vector3d& p) const {
  return {mass, p + R * com, R * inertia * R.transpose()};
}

Eigen::Matrix3d PointInertia(double mass, const Eigen::Vector3d& r) {
  return mass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
}

Eigen::Matrix<double, 6, 6> SpatialInertia(double mass, const Eigen::Vector3d& r, const Eigen::Matrix3d& J) {
  const Eigen::Matrix3d moment = mass * CrossMatrix(r);
  Eigen::Matrix<double, 6, 6> inertia;
  inertia << J, moment, -moment, mass * Eigen::Matrix3d::Identity();
  return inertia;
}

RigidInertia operator+(const RigidInertia& a, const RigidInertia& b) {
  const double mass = a.mass + b.mass;
  if (mass == 0) return a;
  const Eigen::Vector3d com = (a.mass * a.com + b.mass * b.com) / mass;
  return {mass, com,
          a.inertia + PointInertia(a.mass, a.com - com) + b.inertia + PointInertia(b.mass, b.com - com)};
}

void CheckInertia(const Eigen::Matrix3d& inertia) {
  const double tolerance = kInertiaTolerance * inertia.cwiseAbs().maxCoeff();
  if (!inertia.allFinite())
    throw ParameterError("inertia has entries that are not finite; give all in kg m^2");
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < r; ++c)
      if (std::abs(inertia(r, c) - inertia(c, r)) > tolerance)
        throw ParameterError(fmt::format(
            "inertia is not symmetric: row {} column {} is {} kg m^2, row {} column {} is {} kg m^2; "
            "give both the same value, the negative of the product of inertia",
            c, r, inertia(c, r), r, c, inertia(r, c)));

  const Eigen::Vector3d principal = internal::SymmetricEigenvalues3(inertia);
  const std::string moments =
      fmt::format("{:.6g}, {:.6g}, {:.6g} kg m^2", principal[0], principal[1], principal[2]);
  if (principal[0] <= 0)
    throw ParameterError(
        fmt::format("inertia is not positive definite: its principal moments are {}; "
                    "all must be positive, check signs and units",
                    moments));
  if (principal[0] + principal[1] < principal[2] - tolerance)
    throw ParameterError(fmt::format(
        "no rigid body has this inertia: its principal moments are {}, the largest above the sum of the "
        "other two; check the values and that they are about the CoM",
        moments));
}

void CheckGravity(double gravity) {
  if (!(gravity > 0)) throw ParameterError(fmt::format("gravity is {} m/s^2: it must be positive", gravity));
}

void AttachedBody::Validate() const {
  if (joint != AttachedJoint::kWeld && joint != AttachedJoint::kBall && !(axis.norm() > 0))
    throw ParameterError("axis has the length 0: give the direction of the pin or slider");
  if ((radius > 0) == (edges.minCoeff() > 0))
    throw ParameterError(
        fmt::format("edges_m and radius_m give the shape of '{}': set either the radius of a ball or three "
                    "edges of a box",
                    name));
  const bool fixed = joint == AttachedJoint::kWeld || joint == AttachedJoint::kBall;
  if (fixed && (rest != 0 || amplitude != 0))
    throw ParameterError(
        fmt::format("{} is given, but a {} joint has none: remove it, or choose a pin or slider",
                    rest != 0 ? "rest" : "amplitude", EnumName(joint)));
}

}  // namespace tenon
