#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/systems/framework/block/random_stream.h>
#include <tenon/systems/framework/types/fields.h>

namespace tenon {

/// Bounds of random errors in a model of a robot. Each error is drawn for each of the 13 bodies
/// independently, from a uniform distribution symmetric about 0.
struct ModelErrorParams {
  double mass_ratio = 0;     ///< error of a body's mass, which scales its inertia
  double com_ratio = 0;      ///< error of a body's CoM along each axis, over the body's length
  double inertia_ratio = 0;  ///< error of a body's inertia about its CoM, in addition to the mass error
  double length_ratio = 0;   ///< error of the length of each link of a leg

  static FieldList Fields() {
    FieldList fields{{"mass_ratio", &ModelErrorParams::mass_ratio},
                     {"com_ratio", &ModelErrorParams::com_ratio},
                     {"inertia_ratio", &ModelErrorParams::inertia_ratio},
                     {"length_ratio", &ModelErrorParams::length_ratio}};
    for (Field& field : fields) field.AtLeast(0).Below(1).Because("0.1 is an error of up to 10 %");
    return fields;
  }
};

/// A robot with random errors in the masses, centres of mass and inertias of all bodies and in the lengths of
/// the legs' links, drawn from `random`. A body's length is the distance to the next joint or to the foot;
/// the trunk's is the distance between the centres of its front and rear hips. Joint axes, drives, feet and
/// stance angles are unchanged. Throws ParameterError.
QuadrupedDescription WithModelError(QuadrupedDescription robot, const ModelErrorParams& error,
                                    RandomStream& random);

}  // namespace tenon
