#include <tenon/plants/model/attached_body.h>

#include <fmt/format.h>

namespace tenon {

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
