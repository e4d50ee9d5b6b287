#pragma once

#include <tenon/plants/signals/cable_vector.h>

namespace tenon {

inline constexpr int kMinCables = 2;

/// Motion of an anchor on a crane or a gantry. The anchor rests at its place until the first time, passes
/// through the displacements at their times on quintic splines, and rests at the last one. Between two equal
/// successive displacements it rests.
struct AnchorPath {
  std::vector<double> times = {};             ///< increasing times, from 0 on [s]
  std::vector<Eigen::Vector3d> offsets = {};  ///< displacements in W, the first one 0 [m]

  static FieldList Fields() {
    return {Required("times_s", &AnchorPath::times), Required("offsets_m", &AnchorPath::offsets)};
  }
  void Validate() const;  ///< throws ParameterError
};

/// The cable between a platform attachment and an anchor.
struct CableDescription {
  Eigen::Vector3d anchor_W = Eigen::Vector3d::Zero();  ///< anchor point in the world [m]
  Eigen::Vector3d attachment_B =
      Eigen::Vector3d::Zero();                 ///< attachment, from the CoM, in the platform frame [m]
  std::optional<double> tension_min = {};      ///< limit of this cable; empty: that of all cables [N]
  std::optional<double> tension_max = {};      ///< limit of this cable; empty: that of all cables [N]
  std::optional<double> pulley_radius = {};    ///< of this cable's pulley; empty: that of all winches [m]
  std::optional<AnchorPath> anchor_path = {};  ///< motion of the anchor; empty: it stands

  static FieldList Fields() {
    return {Required("anchor_m", &CableDescription::anchor_W),
            Required("attachment_m", &CableDescription::attachment_B),
            Field("tension_min_N", &CableDescription::tension_min).AtLeast(0).Because("a cable cannot push"),
            Field("tension_max_N", &CableDescription::tension_max).Finite(),
            Field("pulley_radius_m", &CableDescription::pulley_radius).AtLeast(0),
            {"anchor_path", &CableDescription::anchor_path}};
  }
};

/// A linear spring between the frame and the platform, without mass and damping. It pulls where it is longer
/// than its rest length and pushes where it is shorter; with a rest length of 0 its force is proportional to
/// its length, as that of a spring with pulley or preload can be made.
struct SpringDescription {
  Eigen::Vector3d anchor_W = Eigen::Vector3d::Zero();      ///< its end at the frame, in the world [m]
  Eigen::Vector3d attachment_B = Eigen::Vector3d::Zero();  ///< its end at the platform, from the CoM [m]
  double stiffness = 0;                                    ///< force per length [N/m]
  double rest_length = 0;                                  ///< length without force [m]

  static FieldList Fields() {
    return {Required("anchor_m", &SpringDescription::anchor_W).Between(-1e4, 1e4),
            Required("attachment_m", &SpringDescription::attachment_B).Between(-1e4, 1e4),
            Required("stiffness_N_per_m", &SpringDescription::stiffness).Positive(),
            Required("rest_length_m", &SpringDescription::rest_length).AtLeast(0)};
  }
};

/// An obstacle beside the robot: a post or a bar with round ends.
struct ObstacleDescription {
  Eigen::Vector3d from_W = Eigen::Vector3d::Zero();  ///< one end of its axis, in the world [m]
  Eigen::Vector3d to_W = Eigen::Vector3d::Zero();    ///< the other end of its axis, in the world [m]
  double radius = 0;                                 ///< its radius, also that of its ends [m]

  static FieldList Fields() {
    return {Required("from_m", &ObstacleDescription::from_W).Between(-1e4, 1e4),
            Required("to_m", &ObstacleDescription::to_W).Between(-1e4, 1e4),
            Required("radius_m", &ObstacleDescription::radius).AtLeast(0)};
  }
};

/// Properties of all cables of a robot.
struct CableProperties {
  double axial_stiffness = 0;  ///< EA [N]; the stiffness of a cable of rest length l0 is EA / l0
  double axial_damping =
      0;  ///< EA times the material's damping time [N s]; the damping of a cable is this over l0
  double tension_min = 0;  ///< lower bound of the commanded tension, where a cable has none of its own [N]
  double tension_max = 0;  ///< upper bound of the commanded tension, where a cable has none of its own [N]
  double mass_per_length =
      0;  ///< mass per unstrained length [kg/m]; only for the plant, controllers assume massless cables

  static FieldList Fields() {
    return {
        Required("axial_stiffness_N", &CableProperties::axial_stiffness)
            .Positive()
            .Because("EA, Young's modulus times cross-section"),
        Required("axial_damping_N_s", &CableProperties::axial_damping)
            .AtLeast(0)
            .Because("EA times the material's damping time"),
        Required("tension_min_N", &CableProperties::tension_min).AtLeast(0).Because("a cable cannot push"),
        Required("tension_max_N", &CableProperties::tension_max).Finite(),
        Field("mass_kg_per_m", &CableProperties::mass_per_length).AtLeast(0)};
  }
  void Validate() const;  ///< throws ParameterError
};

enum class WinchMode {
  kTension,  ///< the winch's own controller tracks the commanded tension
  kTorque,   ///< the command is the motor's torque, as tension at the drum
};

/// A drum with several layers of cable, see plants/cdpr/layered_drum.h.
struct DrumProperties {
  double radius = 0;           ///< radius of the first layer, to the cable's centreline [m]
  double cable_diameter = 0;   ///< diameter of the cable [m]
  double turns_per_layer = 0;  ///< the drum's width over the cable's diameter
  double cable_length = 0;     ///< total length, on the drum and paid out [m]

  static FieldList Fields() {
    return {Required("radius_m", &DrumProperties::radius)
                .Positive()
                .Because("it is the radius of the first layer, to the middle of the cable"),
            Required("cable_diameter_m", &DrumProperties::cable_diameter)
                .Positive()
                .Because("each layer adds it to the radius"),
            Required("turns_per_layer", &DrumProperties::turns_per_layer)
                .Positive()
                .Because("its width over the cable's diameter"),
            Required("cable_length_m", &DrumProperties::cable_length)
                .Positive()
                .Because("all the cable that it has")};
  }
};

/// Two drums, i and j, on the outputs of a symmetric bevel gear differential, two motors at its inputs:
///
///     w_a = w_i + w_j,   w_b = w_i - w_j,   so by power   T_a = (T_i + T_j) / 2,   T_b = (T_i - T_j) / 2
///
/// with T_a, T_b the motors' torques over the drum's radius. Each motor is limited to `motor_tension_max`,
/// which couples the tensions of the two cables: their sum is at most twice that. Lag, friction and inertia
/// of equal motors are those of one motor per drum (1/2 J (w_a^2 + w_b^2) = J (w_i^2 + w_j^2)). The coupling
/// of actuators is from Morlando 2023, section 3.5.1, which gives no equations.
struct DifferentialProperties {
  std::vector<std::array<int, 2>> pairs =
      {};                        ///< pairs of cables, counted from 0; other cables have a motor each
  double motor_tension_max = 0;  ///< largest torque of a motor over the drum's radius [N]

  static FieldList Fields() {
    return {Required("pairs", &DifferentialProperties::pairs),
            Required("motor_tension_max_N", &DifferentialProperties::motor_tension_max)
                .Positive()
                .Because("the motor's largest torque over the drum's radius")};
  }
  void Validate() const;  ///< throws ParameterError
};

/// The winch of a cable, reduced to the drum. Except for the pulley, controllers do not use the properties
/// that have a default.
struct WinchProperties {
  WinchMode mode = WinchMode::kTension;  ///< whether the winch tracks tensions by a loop of its own
  double time_constant = 0;              ///< first-order lag from the command to the motor [s]
  double reel_damping =
      0;  ///< tension error per reeling speed in tension mode, friction in torque mode [N s/m]
  double effective_mass =
      0;  ///< rotor inertia over drum radius squared, gear included [kg]; torque mode only
  double pulley_radius =
      0;  ///< radius of the pulleys at the anchors, where a cable has none of its own; 0: a point [m]
  /// Whether the winches ride on the platform, so that the pulleys are at the attachments, see
  /// plants/model/swivel_pulley.h.
  bool pulleys_on_platform = false;
  std::optional<DrumProperties> drum = {};                  ///< constant radius if not given
  std::optional<DifferentialProperties> differential = {};  ///< none: a motor per drum

  static FieldList Fields() {
    return {{"mode", &WinchProperties::mode},
            Required("time_constant_s", &WinchProperties::time_constant)
                .Positive()
                .Because("the lag of the motor's current loop"),
            Required("reel_damping_N_s_per_m", &WinchProperties::reel_damping).AtLeast(0),
            Field("effective_mass_kg", &WinchProperties::effective_mass).AtLeast(0),
            Field("pulley_radius_m", &WinchProperties::pulley_radius)
                .AtLeast(0)
                .Because("0 is a cable that leaves from a point"),
            {"pulleys_on_platform", &WinchProperties::pulleys_on_platform},
            {"drum", &WinchProperties::drum},
            {"differential", &WinchProperties::differential}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// A cable-driven parallel robot: one rigid platform, 2 or more cables, one winch each.
///
/// Frames: W is the world, z up; B has its origin at the platform's CoM. The keys of a file are those of
/// Fields(); the inertia is a list of three rows, or of the diagonal elements.
struct CdprDescription {
  std::string name;                                     ///< name of the robot
  double mass = 0;                                      ///< mass of the platform [kg]
  Eigen::Matrix3d inertia_B = Eigen::Matrix3d::Zero();  ///< inertia about the CoM, in B [kg m^2]
  std::vector<CableDescription> cables;                 ///< two cables or more
  std::vector<SpringDescription> springs;               ///< springs between frame and platform
  std::vector<ObstacleDescription> obstacles;           ///< rods that platform and cables avoid
  CableProperties cable;                                ///< properties of all cables
  WinchProperties winch;                                ///< properties of all winches
  double floor = 0;                                     ///< height of the floor in W [m]
  /// Whether the platform slides without friction on a level table, which carries its weight and all forces
  /// and torques that would lift or tilt it.
  bool on_table = false;

  int num_cables() const { return static_cast<int>(cables.size()); }
  double tension_min(Eigen::Index i) const;    ///< lower bound of the commanded tension of a cable [N]
  double tension_max(Eigen::Index i) const;    ///< upper bound of the commanded tension of a cable [N]
  double pulley_radius(Eigen::Index i) const;  ///< radius of the pulley of a cable; 0: none [m]
  bool has_pulleys() const;                    ///< whether a cable has a pulley
  bool carries_pulley(Eigen::Index i) const;   ///< whether a cable leaves the platform over a pulley
  void RemovePulleys();                        ///< makes all cables leave from points
  bool ends_in_one_point() const;              ///< whether all cables and springs have the same attachment
  CableVector tension_min() const;
  CableVector tension_max() const;
  void LimitTension(CableVector* tension) const;  ///< clamps tensions [N] to these bounds; does not allocate

  static FieldList Fields() {
    return {Required("name", &CdprDescription::name),
            Required("mass_kg", &CdprDescription::mass).Above(0).AtMost(1e6),
            Required("inertia_kg_m2", &CdprDescription::inertia_B),
            Required("cables", &CdprDescription::cables),
            {"springs", &CdprDescription::springs},
            {"obstacles", &CdprDescription::obstacles},
            Required("cable_properties", &CdprDescription::cable),
            Required("winch", &CdprDescription::winch),
            Field("floor_m", &CdprDescription::floor).Finite(),
            {"on_table", &CdprDescription::on_table}};
  }
  /// Throws ParameterError for a mass that is not positive, an inertia that no rigid body has, too few
  /// cables, two cables in one place, cables or springs on a table that are not level, cables with mass over
  /// pulleys on the platform, and invalid properties of the parts.
  void Validate() const;
};

/// Half edges of the platform's box in B [m]: centred at the CoM, it contains all attachments.
Eigen::Vector3d PlatformBox(const CdprDescription& robot);

}  // namespace tenon
