#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/systems/framework/block/random_stream.h>
#include <tenon/systems/framework/types/fields.h>

namespace tenon {

/// How far off a robot may be from what is known of it. Each bound holds for each of the 13 bodies on its
/// own, in whose two directions errors are drawn evenly.
struct ModelErrorParams {
  double mass_ratio = 0;     ///< of a body's mass; its inertia goes along
  double com_ratio = 0;      ///< of the place of its CoM, along each of its axes, to its length
  double inertia_ratio = 0;  ///< of its inertia about its CoM, beyond what its mass makes
  double length_ratio = 0;   ///< of each link of a leg, to its length

  static FieldList Fields() {
    return {{"mass_ratio", &ModelErrorParams::mass_ratio},
            {"com_ratio", &ModelErrorParams::com_ratio},
            {"inertia_ratio", &ModelErrorParams::inertia_ratio},
            {"length_ratio", &ModelErrorParams::length_ratio}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// A robot as someone may believe it to be whose data are off: masses, centres of mass and inertias of all
/// bodies and lengths of those of the legs, each by an error of its own, drawn from `random`. A body's length
/// is that to the next joint or to the foot; the trunk's lies between the means of its front and its rear
/// hips. Joints, drives, feet and the stance's angles stay. Throws ParameterError.
QuadrupedDescription WithModelError(QuadrupedDescription robot, const ModelErrorParams& error,
                                    RandomStream& random);

}  // namespace tenon
