#pragma once

#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/simbody.h>
#include <tenon/systems/framework/types/signal.h>

namespace tenon::internal {

inline SimTK::Vec3 ToSimbody(const Eigen::Vector3d& v) {
  return {v[0], v[1], v[2]};
}
template <class Vec3>  // SimTK::Vec3 or SimTK::UnitVec3
Vec<3> ToEigen(const Vec3& v) {
  return {v[0], v[1], v[2]};
}

/// Simbody's mass properties, with the inertia about the body's origin.
inline SimTK::MassProperties MassOf(const RigidInertia& body) {
  const Eigen::Matrix3d I = body.inertia + PointInertia(body.mass, body.com);
  return SimTK::MassProperties(body.mass, ToSimbody(body.com),
                               SimTK::Inertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)));
}

}  // namespace tenon::internal
