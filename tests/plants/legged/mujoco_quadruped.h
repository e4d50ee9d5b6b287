#pragma once

#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/tests/plants/model/quadruped_mujoco.h>

namespace tenon::test {

struct MujocoQuadrupedParams {
  QuadrupedPlantParams plant;
  int steps_per_ms = 4;
  bool lies = false;            ///< boxes of the trunk and spheres of the knees touch the ground, too
  double contact_time = 0.004;  ///< time constant of a contact (`solref`), at least two steps [s]

  void Validate() const;  ///< throws ParameterError
};

/// A step of MuJoCo: the state at its end, all else at its begin.
struct MujocoStep {
  LeggedState state;
  LeggedAcceleration acceleration;
  FootForces foot_forces;
  Vec<4> foot_depths = Vec<4>::Zero();
  std::array<Vec<3>, kNumLegs> foot_slips{Vec<3>::Zero(), Vec<3>::Zero(), Vec<3>::Zero(), Vec<3>::Zero()};
  LeggedEnergy energy;
  WrenchEstimate external_wrench;
  Vec<12> external_torque = Vec<12>::Zero();
  Vec<18> last_acceleration = Vec<18>::Zero();  ///< in MuJoCo's coordinates, from which its solver starts

  static FieldList Fields() {
    return {{"state", &MujocoStep::state},
            {"acceleration", &MujocoStep::acceleration},
            {"foot_forces", &MujocoStep::foot_forces},
            {"foot_depths", &MujocoStep::foot_depths},
            {"foot_slips", &MujocoStep::foot_slips},
            {"energy", &MujocoStep::energy},
            {"external_wrench", &MujocoStep::external_wrench},
            {"external_torque", &MujocoStep::external_torque},
            {"last_acceleration", &MujocoStep::last_acceleration}};
  }
};

/// MuJoCo's model of a robot on its terrain, and its work space. Copies share the model.
class MujocoRobot {
 public:
  explicit MujocoRobot(const MujocoQuadrupedParams& params);
  MujocoRobot(const MujocoRobot& other);
  MujocoRobot& operator=(const MujocoRobot& other);

  /// Advances by one step under joint torques [N m] and external forces.
  void Step(const Vec<12>& torque, const ExternalForces& external, MujocoStep* step);

 private:
  void AddContacts(MujocoStep* step);

  std::shared_ptr<const mjModel> model_;
  MuJoCoData data_;
  RigidInertia payload_;
};

/// A quadruped on terrain, simulated by MuJoCo, in the place of a QuadrupedPlant without additions and locked
/// joints. Masses, inertias, limits of the drives, the terrain and its friction are those of the
/// QuadrupedPlant. The friction and the end stops of joints are MuJoCo's, and so are the contacts, whose
/// friction cones are elliptic. Forces on the feet and accelerations are those at the begin of the last step.
class MujocoQuadruped final : public LeafSystem<QuadrupedPlantParams> {
 public:
  explicit MujocoQuadruped(const MujocoQuadrupedParams& given) : LeafSystem(given.plant), options(given) {
    given.Validate();
  }
  const MujocoQuadrupedParams options;
  InputPort<Vec<12>> torque{this, {"torque", "N m"}};
  InputPort<ExternalForces> external{this, {"external"}, ExternalForces{}};

  DiscreteState<MujocoStep> step{this, {"step"}, MujocoStep{.state = params.initial}};
  Workspace<MujocoRobot> robot{this, "robot", MujocoRobot(options)};

  OutputPort<LeggedState> state{this, {"state"}, Uses(step), [](const MujocoStep& s) { return s.state; }};
  OutputPort<Vec<12>> joint_torque{
      this, {"joint_torque", "N m", kJointElements}, Uses(step, torque), &MujocoQuadruped::CalcJointTorque};
  OutputPort<LeggedAcceleration> acceleration{
      this, {"acceleration"}, Uses(step), [](const MujocoStep& s) { return s.acceleration; }};
  OutputPort<FootForces> foot_forces{
      this, {"foot_forces"}, Uses(step), [](const MujocoStep& s) { return s.foot_forces; }};
  OutputPort<Vec<4>> foot_depths{
      this, {"foot_depths", "m", kLegElements}, Uses(step), [](const MujocoStep& s) {
        return s.foot_depths;
      }};
  OutputPort<std::array<Vec<3>, kNumLegs>> foot_slips{
      this, {"foot_slips", "m/s", kLegElements}, Uses(step), [](const MujocoStep& s) {
        return s.foot_slips;
      }};
  OutputPort<LeggedEnergy> energy{this, {"energy"}, Uses(step), [](const MujocoStep& s) { return s.energy; }};
  OutputPort<WrenchEstimate> external_wrench{
      this, {"external_wrench"}, Uses(step), [](const MujocoStep& s) { return s.external_wrench; }};
  OutputPort<Vec<12>> external_torque{
      this, {"external_torque", "N m", kJointElements}, Uses(step), [](const MujocoStep& s) {
        return s.external_torque;
      }};
  OutputPort<WrenchEstimate> added_wrench{this, {"added_wrench"}, Uses(), [] { return WrenchEstimate{}; }};
  OutputPort<Geometry> geometry{this,
                                {"geometry"},
                                MakeQuadrupedGeometry(params.robot, params.payload, params.terrain),
                                Uses(step, external),
                                &MujocoQuadruped::CalcGeometry};

  Update<MujocoStep> advance{step, Sampled{Hz(1000 * options.steps_per_ms)},
                             Uses(step, joint_torque, external, robot), &MujocoQuadruped::Advance};

 private:
  Vec<12> CalcJointTorque(const MujocoStep& step, const Vec<12>& command) const;
  void CalcGeometry(const MujocoStep& step, const ExternalForces& external, Geometry* out) const;
  MujocoStep Advance(const MujocoStep& step, const Vec<12>& torque, const ExternalForces& external,
                     MujocoRobot& robot) const;
};

}  // namespace tenon::test

TENON_DECLARE_SIGNAL(tenon::test::MujocoStep);
