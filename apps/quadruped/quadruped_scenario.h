#pragma once

#include <tenon/apps/common/scenario_keys.h>
#include <tenon/apps/quadruped/legged_scenario.h>
#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/plants/model/attached_body.h>

namespace tenon::apps {

/// Joint PD control of a standing robot. The default gains are those of MakeJointPd: K_p = 3.886 m g l per
/// rad, K_d = 0.3099 m g l t, see RobotScale.
struct JointPdScenario {
  std::optional<double> stiffness_N_m_per_rad;  ///< K_p of the joint angles; empty: 3.886 m g l
  std::optional<double> damping_N_m_s_per_rad;  ///< K_d of the joint speeds; empty: 0.31 m g l sqrt(l / g)
  bool gravity_compensation =
      JointPdParams().gravity_compensation;    ///< adds the torques that hold the weight
  double rate_hz = JointPdParams().rate.hz();  ///< sample rate of the controller

  static FieldList Fields() {
    return {Field("stiffness_N_m_per_rad", &JointPdScenario::stiffness_N_m_per_rad).AtLeast(0),
            Field("damping_N_m_s_per_rad", &JointPdScenario::damping_N_m_s_per_rad).AtLeast(0),
            {"gravity_compensation", &JointPdScenario::gravity_compensation},
            Field("rate_hz", &JointPdScenario::rate_hz).In(Rates())};
  }
};

/// A force that changes every period, see RandomForce.
struct RandomForceScenario {
  bool on_trunk = false;  ///< acts on the trunk; false: on a random leg, chosen anew at each change
  double lower_N = 0;     ///< minimum magnitude
  double upper_N = 0;     ///< maximum magnitude
  double period_s = 2;    ///< time between changes

  static FieldList Fields() {
    return {{"on_trunk", &RandomForceScenario::on_trunk},
            Required("lower_N", &RandomForceScenario::lower_N).AtLeast(0),
            Required("upper_N", &RandomForceScenario::upper_N),
            Field("period_s", &RandomForceScenario::period_s).In(SamplePeriods())};
  }
  void Validate() const;  ///< throws ParameterError
};

/// A uniform box on the trunk for the whole run. It is missing from the controller's model.
struct TrunkLoadScenario {
  double mass_kg = 0;                                    ///< mass of the box
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< centre of the box in the trunk's frame
  Eigen::Vector3d edges_m = Eigen::Vector3d::Zero();     ///< lengths of the box's edges
  std::optional<SlidingLoadParams> slides;               ///< sliding of the box on the trunk; empty: fixed

  static FieldList Fields() {
    return {Field("mass_kg", &TrunkLoadScenario::mass_kg).Between(0, 1e6),
            Field("position_m", &TrunkLoadScenario::position_m).In(Places()),
            Field("edges_m", &TrunkLoadScenario::edges_m).Between(0, 100),
            {"slides", &TrunkLoadScenario::slides}};
  }
};

/// The task of a walk or a stand.
struct WalkTask : Task {
  /// Whether a walk must cover its path: the distance between start and end, less the tolerance of the path.
  bool arrives = true;

  static FieldList Fields() { return Task::Fields() + FieldList{{"arrives", &WalkTask::arrives}}; }
};

/// Scenario of tenon-quadruped, read from a YAML file.
struct QuadrupedScenario : LeggedScenario {
  double start_height_m = 0;          ///< initial height of the feet above the ground, in the nominal stance
  std::optional<JointPdScenario> pd;  ///< joint PD control of a standing robot; excludes `walk`
  std::optional<WalkScenario> walk;   ///< commanded walk of a walking robot; excludes `pd`
  std::optional<DeploymentParams> deployment;      ///< supervisor of a walk with its modes; empty: none
  std::optional<ObserverKind> observer;            ///< overrides the observer of the profile
  std::vector<RandomForceScenario> random_forces;  ///< forces that change at random
  std::vector<Rope> ropes;  ///< ropes from winches on the trunk to anchors in the world, see docs/limbs.md
  TrunkLoadScenario payload;
  std::vector<AttachedBody> attached;  ///< bodies on joints, missing from the controller's model
  /// Whether the walking controller measures the wrench of attached bodies and actuated joints on the robot,
  /// as by a force sensor under the base of an arm.
  bool known_additions = false;
  WalkTask task;                      ///< task, without which the case is not finished
  std::vector<ObserverKind> compare;  ///< observers that --compare runs; empty: all observers
  double log_rate_hz = 200;           ///< sample rate of signals.csv

  static FieldList Fields() {
    using S = QuadrupedScenario;
    return LeggedScenario::Fields() + FieldList{Field("start_height_m", &S::start_height_m)
                                                    .AtLeast(0)
                                                    .Because("below 0 the feet start in the ground"),
                                                {"pd", &S::pd},
                                                {"walk", &S::walk},
                                                {"deployment", &S::deployment},
                                                {"observer", &S::observer},
                                                {"random_forces", &S::random_forces},
                                                {"ropes", &S::ropes},
                                                {"payload", &S::payload},
                                                {"attached", &S::attached},
                                                {"known_additions", &S::known_additions},
                                                {"task", &S::task},
                                                {"compare", &S::compare},
                                                Field("log_rate_hz", &S::log_rate_hz).In(Rates())};
  }
  static std::vector<RenamedKey> Renamed() {
    return {{"sweep", "forces.0.start_s and forces.0.turn_rad, which a campaign varies, see cases_pushes"}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// Size of a robot relative to DogBot, for which the thesis gives forces and blocks.
struct SizeRatio {
  double weight = 1;               ///< ratio of the weights
  double length = 1;               ///< ratio of the lengths of a leg
  Vec<3> offset = Vec<3>::Zero();  ///< centre of the hips in B, less DogBot's times the ratio of lengths [m]
};
/// Returns the size of the scenario's robot, read from its file, or 1, 1 and 0 without `scale_forces`.
SizeRatio RatioOf(const LeggedScenario& scenario);
/// Scales the scenario to a robot of this size. Forces and the payload's mass are multiplied by the ratio of
/// the weights; heights, sizes and gaps of blocks and lengths of steps and payload by the ratio of the leg
/// lengths; torques by both. Points on the trunk keep their places relative to the hips, because the origin
/// of B may lie anywhere. Times, speeds, the path and the positions of blocks do not change.
QuadrupedScenario ScaledToRobot(QuadrupedScenario scenario, const SizeRatio& ratio);

/// Notes on the robot of a walk whose torque limits hold neither it nor its load on two legs.
std::vector<std::string> Notes(const QuadrupedScenario& scenario);

/// Returns the simulated time of a scenario [s].
double Duration(const QuadrupedScenario& scenario);
/// Reads the files that a scenario names and makes the parameters of its diagram. Throws KeyError.
QuadrupedStandParams MakeStandParams(const QuadrupedScenario& scenario);
/// Reads the files that a scenario names and makes the parameters of its diagram. Throws KeyError.
QuadrupedWalkParams MakeWalkParams(const QuadrupedScenario& scenario);

/// The mass that the drives of a quadruped can hold.
struct HeldMass {
  double mass = 0;    ///< including the robot's own [kg]
  double load = 0;    ///< the largest load beside the robot; 0 if even the robot is too heavy [kg]
  int joint = 0;      ///< joint whose torque limit determines it, see QuadrupedDescription::joint()
  double torque = 0;  ///< torque of this joint while the robot itself is held [N m]
};

/// Returns the mass that two legs hold in the nominal stance by vertical forces
/// at their feet. In a trot, two legs are in the air.
HeldMass HeldByTwoLegs(const QuadrupedDescription& robot);

/// Says that two legs, which hold `held`, cannot hold the robot, and which joint needs which torque.
std::string CannotHold(const QuadrupedDescription& robot, const HeldMass& held);

}  // namespace tenon::apps
