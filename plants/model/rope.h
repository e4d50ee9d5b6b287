#pragma once

#include <tenon/plants/signals/cable_vector.h>
#include <tenon/plants/signals/disturbance_signals.h>

namespace tenon {

inline constexpr int kMaxRopes = 4;

/// A straight rope without mass from a winch on a quadruped's trunk to an anchor in the world.
struct Rope {
  std::string name;                         ///< name in logs and drawings
  Vec<3> anchor_W = Vec<3>::Zero();         ///< anchor in the world [m]
  Vec<3> attachment_B = Vec<3>::Zero();     ///< point of the trunk where the rope leaves the winch [m]
  double tension_min = 0, tension_max = 0;  ///< limits of the tension [N]

  static FieldList Fields() {
    return {Required("name", &Rope::name), Required("anchor_m", &Rope::anchor_W).Between(-1000, 1000),
            Required("attachment_m", &Rope::attachment_B).Between(-100, 100),
            Field("tension_min_N", &Rope::tension_min).AtLeast(0).Because("a rope cannot push"),
            Required("tension_max_N", &Rope::tension_max).Positive().Because("a slack rope is no rope")};
  }
  void Validate() const;  ///< throws ParameterError
};

/// Throws ParameterError unless there are 1 to kMaxRopes valid ropes with different names.
void CheckRopes(const std::vector<Rope>& ropes);
/// The names of the ropes, as elements of a port.
std::string RopeElements(const std::vector<Rope>& ropes);

/// A rope in one state of the robot: it pulls the trunk at p_WB + arm_W with tension * direction_W.
struct RopeLine {
  Vec<3> arm_W;        ///< from B's origin to the attachment [m]
  Vec<3> direction_W;  ///< unit vector from the attachment to the anchor
  double length;       ///< [m]
};
/// Throws RunError if anchor and attachment coincide.
RopeLine LineOf(const Rope& rope, const LeggedState& robot);

}  // namespace tenon
