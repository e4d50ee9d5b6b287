#pragma once

#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/robots/load_robot.h>

namespace tenon::test {

inline QuadrupedDescription DogBot() {
  return LoadQuadruped(TENON_ROBOTS_DIR "/dogbot.yaml");
}
inline QuadrupedDescription A1() {
  return LoadQuadruped(TENON_ROBOTS_DIR "/a1.yaml");
}

template <int N>
Vec<N> RandomVector(RandomStream& random, double size) {
  Vec<N> v;
  for (int i = 0; i < N; ++i) v[i] = random.Uniform(-size, size);
  return v;
}

/// DogBot with random axes of its joints, where those of the shipped robots are along x and y.
inline QuadrupedDescription SkewDogBot() {
  RandomStream random(52);
  QuadrupedDescription robot = DogBot();
  for (LegDescription& leg : robot.legs)
    for (JointDescription& joint : leg.joints) joint.axis = RandomVector<3>(random, 1).normalized();
  return robot;
}

/// A random state, with joint angles up to 1 rad.
inline LeggedState RandomState(RandomStream& random) {
  return {.p_WB = RandomVector<3>(random, 2),
          .q_WB = QuaternionFromRotationVector(RandomVector<3>(random, 2)),
          .q = RandomVector<12>(random, 1),
          .v_W = RandomVector<3>(random, 2),
          .w_W = RandomVector<3>(random, 3),
          .qd = RandomVector<12>(random, 6)};
}

/// Velocities and accelerations in the order of QuadrupedDynamics::M.
inline Vec<18> Velocities(const LeggedState& x) {
  Vec<18> nu;
  nu << x.v_W, x.w_W, x.qd;
  return nu;
}
inline Vec<18> Stacked(const LeggedAcceleration& a) {
  Vec<18> rates;
  rates << a.a_W, a.alpha_W, a.qdd;
  return rates;
}

inline QuadrupedDynamics DynamicsOf(const QuadrupedModel& model, const LeggedState& x) {
  QuadrupedDynamics dynamics;
  model.Calc(x, &dynamics);
  return dynamics;
}

/// At rest in the nominal stance, with the feet just touching the plane z = 0.
inline LeggedState Standing(const QuadrupedDescription& robot) {
  return {.p_WB = {0, 0, robot.StanceHeight()}, .q = robot.stance};
}

}  // namespace tenon::test
