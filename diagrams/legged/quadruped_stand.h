#pragma once

#include <tenon/controllers/legged/whole_body/joint_pd.h>
#include <tenon/diagrams/legged/quadruped_world.h>

namespace tenon {

struct QuadrupedStandParams {
  QuadrupedWorldParams world;
  JointPdParams pd;
};

/// Parameters of a robot at rest on level ground, with the gains of MakeJointPd.
QuadrupedStandParams MakeQuadrupedStand(const QuadrupedDescription& robot);

/// A quadruped that holds its stance by joint PD.
///
///     pd ──► world ──┐
///      ▲             │
///      └─────────────┘ joint angles and speeds
class QuadrupedStand final : public Subdiagram {
 public:
  explicit QuadrupedStand(const QuadrupedStandParams& params);

  JointPd& pd;
  QuadrupedWorld& world;
};

}  // namespace tenon
