#include <tenon/plants/legged/joint_lock.h>

#include <fmt/core.h>

namespace tenon {

void JointLockParams::Validate() const {
  for (const int j : joints)
    Demand(j >= 0 && j < kNumJoints,
           fmt::format("joint {} does not exist: give 3 leg + i, from 0 to {}", j, kNumJoints - 1));
  Demand(std::isfinite(stiffness) && stiffness > 0,
         fmt::format("stiffness = {} must be positive: give N m/rad", stiffness));
  Demand(std::isfinite(damping) && damping >= 0,
         fmt::format("damping = {} must not be negative: give N m s/rad", damping));
}

JointLocks JointLock::CalcLocks(const LeggedState& x, const JointLocks& others, bool acting,
                                Memory& memory) const {
  if (acting && !memory.acts) memory.angle = x.q;
  memory.acts = acting;
  JointLocks locks = others;
  if (!acting) return locks;
  const auto lock = [&](int j) {
    locks.angle[j] = memory.angle[j];
    locks.stiffness[j] = params.stiffness;
    locks.damping[j] = params.damping;
  };
  for (const int j : params.joints) lock(j);
  for (int j = 0; params.joints.empty() && j < kNumJoints; ++j) lock(j);
  return locks;
}

}  // namespace tenon
