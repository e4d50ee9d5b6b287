#include <tenon/plants/attached_bodies.h>
#include <tenon/plants/cdpr/cdpr_multibody.h>
#include <tenon/plants/legged/quadruped_multibody.h>
#include <tenon/plants/multibody/internal/simbody_conversions.h>
#include <tenon/systems/text/text.h>

#include <fmt/format.h>

#include <algorithm>

namespace tenon {
namespace {

using internal::ToSimbody;

/// The spring and damper of AttachedBody.
class Spring final : public SimTK::Force::Custom::Implementation {
 public:
  /// `reference` is null on a ball joint.
  Spring(const SimTK::MobilizedBody& joint, AttachedBody of, const RobotMultibody::Reference* reference)
      : joint_(joint), of_(std::move(of)), reference_(reference) {}

  void calcForce(const SimTK::State& state, SimTK::Vector_<SimTK::SpatialVec>&, SimTK::Vector_<SimTK::Vec3>&,
                 SimTK::Vector& mobility_forces) const override {
    const SimTK::Vec3 error = Error(state);
    const double speed = reference_ != nullptr ? reference_->speed : 0;
    for (int i = 0; i < joint_.getNumU(state); ++i) {
      const double force = of_.stiffness * error[i] + of_.damping * (speed - joint_.getOneU(state, i));
      joint_.applyOneMobilityForce(state, i, std::clamp(force, -of_.limit, of_.limit), mobility_forces);
    }
  }
  SimTK::Real calcPotentialEnergy(const SimTK::State& state) const override {
    return of_.stiffness / 2 * Error(state).normSqr();
  }

 private:
  SimTK::Vec3 Error(const SimTK::State& state) const {
    if (of_.joint == AttachedJoint::kBall) {
      const SimTK::Vec4 turn = joint_.getMobilizerTransform(state).R().convertRotationToAngleAxis();
      return -turn[0] * turn.getSubVec<3>(1);
    }
    const double own = of_.rest + of_.amplitude * (std::sin(of_.frequency * state.getTime() + of_.phase) -
                                                   std::sin(of_.phase));
    return {(std::isnan(reference_->position) ? own : reference_->position) - joint_.getOneQ(state, 0), 0, 0};
  }

  SimTK::MobilizedBody joint_;
  AttachedBody of_;
  const RobotMultibody::Reference* reference_;
};

RigidInertia InertiaOf(const AttachedBody& body) {
  if (!body.inertia.isZero(0)) return {body.mass, body.centre, body.inertia};
  if (body.radius == 0) return UniformBoxInertia(body.mass, body.centre, body.edges);
  return {body.mass, body.centre, 0.4 * body.mass * body.radius * body.radius * Eigen::Matrix3d::Identity()};
}

SimTK::MobilizedBody Add(SimTK::MobilizedBody& carrier, const AttachedBody& of) {
  const SimTK::Body::Rigid body(internal::MassOf(InertiaOf(of)));
  const SimTK::Vec3 position = ToSimbody(of.position);
  switch (of.joint) {
    case AttachedJoint::kWeld:
      return SimTK::MobilizedBody::Weld(carrier, SimTK::Transform(position), body, SimTK::Transform());
    case AttachedJoint::kBall:
      return SimTK::MobilizedBody::Ball(carrier, SimTK::Transform(position), body, SimTK::Transform());
    case AttachedJoint::kPin: {  // a Pin turns about z
      const SimTK::Rotation R(SimTK::UnitVec3(ToSimbody(of.axis)), SimTK::ZAxis);
      SimTK::MobilizedBody::Pin pin(carrier, SimTK::Transform(R, position), body, SimTK::Transform(R));
      pin.setDefaultAngle(of.rest);
      return pin;
    }
    case AttachedJoint::kSlider:
      break;  // below: a Slider moves along x
  }
  const SimTK::Rotation R(SimTK::UnitVec3(ToSimbody(of.axis)), SimTK::XAxis);
  SimTK::MobilizedBody::Slider slider(carrier, SimTK::Transform(R, position), body, SimTK::Transform(R));
  slider.setDefaultLength(of.rest);
  return slider;
}

/// Adds bodies to `robot`. `find` returns the body of the robot that `on` names.
template <class Find>
void AddAll(const std::vector<AttachedBody>& bodies, RobotMultibody& robot, const Find& find) {
  std::map<std::string, SimTK::MobilizedBody> attached;
  for (const AttachedBody& of : bodies) {
    of.Validate();
    const auto earlier = attached.find(of.on);
    SimTK::MobilizedBody& carrier = earlier != attached.end() ? earlier->second
                                    : of.on.empty()           ? robot.base()
                                                              : find(of.on);
    const SimTK::MobilizedBody body = Add(carrier, of);
    robot.Name(body, of.name);
    if (of.joint != AttachedJoint::kWeld && (of.stiffness > 0 || of.damping > 0)) {
      const bool one = of.joint != AttachedJoint::kBall;
      const RobotMultibody::Reference* reference = one ? &robot.AddReference(body) : nullptr;
      SimTK::Force::Custom(robot.forces, new Spring(body, of, reference));  // Simbody owns it
    }
    Shape shape = of.mesh != nullptr ? Shape::Mesh(ShapeRole::kLoad, of.name, of.mesh)
                  : of.radius > 0    ? Shape::Sphere(ShapeRole::kLoad, of.name, of.radius)
                                     : Shape::Box(ShapeRole::kLoad, of.name, of.edges);
    if (of.mesh == nullptr) shape.p_W = of.centre;
    robot.Draw(body, shape);
    attached[of.name] = body;
  }
}

}  // namespace

RigidInertia UniformBoxInertia(double mass, const Eigen::Vector3d& centre, const Eigen::Vector3d& edges) {
  const Eigen::Vector3d squares = edges.cwiseAbs2();
  RigidInertia box{mass, centre, Eigen::Matrix3d::Zero()};
  box.inertia.diagonal() = mass / 12 * (Eigen::Vector3d::Constant(squares.sum()) - squares);
  return box;
}

ExtendQuadruped Attach(std::vector<AttachedBody> bodies, const RigidInertia& replaced) {
  return [bodies = std::move(bodies), replaced](QuadrupedMultibody& robot) {
    robot.Replace(replaced);
    AddAll(bodies, robot, [&](const std::string& on) -> SimTK::MobilizedBody& {
      return on == "trunk" ? robot.trunk() : robot.link(on);
    });
  };
}

ExtendCdpr AttachToPlatform(std::vector<AttachedBody> bodies) {
  return [bodies = std::move(bodies)](CdprMultibody& robot) {
    AddAll(bodies, robot, [&](const std::string& on) -> SimTK::MobilizedBody& {
      if (on == "platform") return robot.platform();
      std::vector<std::string> names{"platform"};
      for (const AttachedBody& body : bodies) names.push_back(body.name);
      const std::string nearest = internal::NearestName(on, names);
      throw ParameterError(
          fmt::format("a body is attached on '{}', which is not known here{}; give 'platform' or the name of "
                      "an earlier body",
                      on, nearest.empty() ? "" : " (did you mean '" + nearest + "'?)"));
    });
  };
}

}  // namespace tenon
