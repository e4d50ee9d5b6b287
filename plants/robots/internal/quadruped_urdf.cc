#include <tenon/plants/robots/internal/mesh_import.h>
#include <tenon/plants/robots/internal/quadruped_urdf.h>
#include <tenon/plants/robots/mesh_file.h>
#include <tenon/systems/analysis/internal/small_matrices.h>
#include <tenon/systems/files/input_file.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/yaml/mesh_paths.h>

#include <fmt/format.h>

#include <numbers>

namespace tenon::internal {
namespace {

/// Largest plausible radius of gyration of a link, and that of a link whose inertia is a placeholder,
/// relative to the length of a leg or, for links of the trunk, to twice the distance of the hips from their
/// centre.
constexpr double kMostGyration = 0.75, kUsualGyration = 0.25;
constexpr std::array<const char*, kJointsPerLeg> kLimitKeys{"abduction", "hip_pitch", "knee"};

/// Returns the nearest physically possible inertia, for which the second moments of mass along the principal
/// axes, J_i = (I_1 + I_2 + I_3) / 2 - I_i, are not negative.
Eigen::Matrix3d Mended(const Eigen::Matrix3d& inertia) {
  const auto [I, V] = internal::CalcSymmetricEigensystem3(inertia);
  const Eigen::Vector3d J = (Eigen::Vector3d::Constant(I.sum() / 2) - I).cwiseMax(0.0);
  const Eigen::Vector3d moments = Eigen::Vector3d::Constant(J.sum()) - J;
  return V * moments.asDiagonal() * V.transpose();
}

/// Reads one URDF; bodies are numbered 0 for the trunk, 1 + joint for those of the legs, and then follow
/// those on actuated joints.
class Reader {
 public:
  Reader(const std::filesystem::path& path, const UrdfReading& reading, QuadrupedDescription* robot)
      : file_(ReadUrdfFile(path)), reading_(reading), robot_(*robot) {}

  std::vector<std::string> Read(MovingParts* moving) {
    CheckLocked();
    for (int leg = 0; leg < kNumLegs; ++leg) FindLeg(leg, reading_.feet[leg]);
    Add(file_.FloatingLink(), 0, PoseOfRoot());
    MeasureExtents();
    ShareMass();
    KeepTrunkShapes();
    for (const auto& [body, link] : missing_at_)
      if (IsMain(link, parts_[body])) looks_[body] = {};
    for (int leg = 0; leg < kNumLegs; ++leg) FinishLeg(leg);
    robot_.trunk = SumOf(0);
    for (std::size_t i = 0; i < moving_.bodies.size(); ++i) FinishMoving(i);
    if (!moving_.bodies.empty()) robot_.trunk = robot_.trunk + moving_.at_rest;
    for (std::size_t body = 0; body <= kNumJoints; ++body) {
      if (looks_[body].triangles.empty()) continue;
      robot_.meshes[body] = Finished(std::move(looks_[body]));
    }
    WarnOfMeshes();
    warnings_.insert(warnings_.end(), file_.unread.begin(), file_.unread.end());
    if (moving != nullptr) *moving = std::move(moving_);
    return std::move(warnings_);
  }

  RobotLinks Links() const {
    RobotLinks made;
    const UrdfLink& root = file_.FloatingLink();
    const Eigen::Isometry3d T_BR = PoseOfRoot();
    const bool is_base = T_BR.isApprox(Eigen::Isometry3d::Identity(), 0);
    if (root.name == made.base && !is_base) made.base = "base";
    if (root.name != made.base)
      made.links.push_back({.parent = made.base,
                            .name = root.name,
                            .position = T_BR.translation(),
                            .rotation = T_BR.linear()});
    AddLinks(root, made);
    return made;
  }

 private:
  /// The contribution of a link to a body, in the base frame B with all joints at 0.
  struct Part {
    std::string link;
    RigidInertia inertia;
  };

  void AddLinks(const UrdfLink& link, RobotLinks& made) const {
    for (const UrdfJoint* joint : link.joints) {
      RobotLinks::Link child{.parent = link.name, .name = joint->child, .axis = joint->axis.normalized()};
      for (int j = 0; j < kNumJoints; ++j)
        if (robot_.joint(j).name == joint->name) child.joint = j;
      Eigen::Isometry3d pose = joint->pose;
      if (child.joint < 0) pose = pose * joint->Moved(LockedAt(*joint).value_or(joint->Neutral()));
      child.position = pose.translation();
      child.rotation = pose.linear();
      made.links.push_back(child);
      AddLinks(file_.ChildOf(*joint), made);
    }
  }

  template <class... Args>
  void Warn(fmt::format_string<Args...> format, Args&&... args) {
    const std::string what = fmt::format(format, std::forward<Args>(args)...);
    warnings_.push_back(fmt::format("{}: {}", file_.PlaceOf(what), what));
  }

  /// Returns the pose of the link that floats in the robot's frame B.
  Eigen::Isometry3d PoseOfRoot() const {
    Eigen::Isometry3d T_RB = Eigen::Isometry3d::Identity();
    if (!reading_.trunk.empty()) {
      const UrdfLink* link = file_.FindLink(reading_.trunk);
      if (link == nullptr)
        file_.Fail("there is no link '{}', the trunk; correct its name under 'trunk_link'",
                   Excerpt(reading_.trunk));
      for (; link != &file_.FloatingLink() && link->parent != nullptr; link = link->parent) {
        const UrdfJoint& joint = *link->parent_joint;
        const std::optional<double> position = LockedAt(joint);
        if (joint.turns() && !position)
          file_.Fail("the link '{}' moves relative to the root; give a link of the trunk under 'trunk_link'",
                     reading_.trunk);
        T_RB = joint.pose * joint.Moved(position.value_or(0)) * T_RB;
      }
    }
    T_RB.rotate(RotationOf(reading_.forward, reading_.up));
    return T_RB.inverse();
  }

  void CheckLocked() const {
    for (const auto& [name, angle] : reading_.locked) {
      const UrdfJoint* joint = file_.FindJoint(name);
      const bool moves = Drive(name) != nullptr;
      if (joint != nullptr && (joint->turns() || (joint->slides() && !moves))) continue;
      if (joint != nullptr && moves)
        file_.Fail("joint '{}' does not turn; take it out of 'actuated_joints', or make it revolute", name);
      std::vector<std::string> names;
      for (const auto& entry : file_.joints)
        if (entry.second.turns() || entry.second.slides()) names.push_back(entry.first);
      const std::string nearest = NearestName(name, names);
      file_.Fail(
          "there is no joint '{}' that moves{}; correct its name, under 'locked_joints' or 'actuated_joints' "
          "or in --lock",
          Excerpt(name), nearest.empty() ? "" : " (did you mean '" + nearest + "'?)");
    }
  }

  std::optional<double> LockedAt(const UrdfJoint& joint) const {
    return internal::LockedAt(joint, reading_.locked);
  }

  /// Returns the drive of an actuated joint; null if it is none.
  const AttachedBody* Drive(const std::string& joint) const {
    for (const AttachedBody& drive : reading_.actuated)
      if (drive.name == joint) return &drive;
    return nullptr;
  }

  void CheckNotOfLeg(const std::string& joint) const {
    if (Drive(joint) != nullptr)
      file_.Fail(
          "joint '{}' moves with a leg, but 'actuated_joints' can only have joints on the trunk; take it out",
          joint);
  }

  /// Finds the joints of a leg: the three movable joints between its foot and the root.
  void FindLeg(int leg, const std::string& foot) {
    const char* leg_name = kLegNames[leg];
    const UrdfLink* link = file_.FindLink(foot);
    if (link == nullptr) {
      std::vector<std::string> names;
      for (const auto& entry : file_.links) names.push_back(entry.first);
      const std::string nearest = NearestName(foot, names);
      file_.Fail("there is no link '{}', the foot of {}{}; give the names of the feet's links under 'feet'",
                 Excerpt(foot), leg_name, nearest.empty() ? "" : " (did you mean '" + nearest + "'?)");
    }
    std::vector<const UrdfJoint*> chain;
    for (; link->parent != nullptr; link = link->parent) {
      CheckNotOfLeg(link->parent_joint->name);
      if (link->parent_joint->turns() && !LockedAt(*link->parent_joint)) chain.push_back(link->parent_joint);
    }
    if (chain.size() != kJointsPerLeg) {
      std::string names;
      for (auto joint = chain.rbegin(); joint != chain.rend(); ++joint)
        names += (names.empty() ? "'" : ", '") + (*joint)->name + "'";
      file_.Fail(
          "leg {} has {} revolute joints between the root '{}' and its foot '{}' ({}) but must have {}: "
          "abduction, hip pitch and knee pitch; add missing joints, or lock additional ones under "
          "'locked_joints'",
          leg_name, chain.size(), file_.root->name, foot, names.empty() ? "none" : names, kJointsPerLeg);
    }
    for (int i = 0; i < kJointsPerLeg; ++i) {
      const UrdfJoint& joint = *chain[kJointsPerLeg - 1 - i];
      const std::string& name = joint.name;
      if (joint.mimic)
        file_.Fail(
            "joint '{}' of leg {} moves with '{}' (<mimic>), but a leg's joints have a drive each; lock it "
            "under 'locked_joints', or take <mimic> out",
            name, leg_name, joint.mimic->joint);
      const auto [at, is_new] = joints_.emplace(name, kJointsPerLeg * leg + i);
      if (!is_new)
        file_.Fail("the joint '{}' is in the legs {} and {}; give each leg a foot of its own under 'feet'",
                   name, kLegNames[at->second / kJointsPerLeg], leg_name);
    }
  }

  /// Adds a link and its subtree to `body`; T_BL is its pose with all joints at 0.
  void Add(const UrdfLink& link, int body, const Eigen::Isometry3d& T_BL) {
    poses_[link.name] = T_BL;
    std::string& names = names_[body];
    names += (names.empty() ? "'" : ", '") + link.name + "'";
    if (link.inertia)
      parts_[body].push_back({link.name, link.inertia->In(T_BL.linear(), T_BL.translation())});
    if (!link.inertia || !(link.inertia->mass > 0))
      for (const UrdfShape& shape : link.collisions.empty() ? link.visuals : link.collisions)
        volumes_[body] = volumes_[body] + FilledShape(shape).In(T_BL.linear(), T_BL.translation());
    for (const UrdfShape& visual : link.visuals)
      if (visual.kind == UrdfShape::Kind::kMesh) AddMesh(link.name, visual, body, T_BL * visual.pose);
    for (const UrdfShape& collision : link.collisions)
      if (body == 0) AddCollision(link.name, collision, T_BL * collision.pose);
    for (const UrdfJoint* joint : link.joints) {
      Eigen::Isometry3d T_BJ = T_BL * joint->pose;
      int child = body;
      if (const std::optional<double> position = LockedAt(*joint)) {
        AxisOf(*joint);  // refuses one of length 0
        T_BJ = T_BJ * joint->Moved(*position);
        if (const AttachedBody* drive = Drive(joint->name)) child = NoteMoving(*joint, *drive, body, T_BJ);
      } else if (joint->turns()) {
        child = NoteJoint(*joint, T_BJ) + 1;
      } else if (joint->type != UrdfJoint::Type::kFixed) {
        file_.Fail("joint '{}' must be revolute or fixed; make it fixed, or list it under 'locked_joints'",
                   joint->name);
      }
      Add(file_.ChildOf(*joint), child, T_BJ);
    }
  }

  /// Adds a collision shape to those of the trunk. A cylinder becomes the capsule that it contains, or if it
  /// is flat, a rounded box; a mesh becomes the box about it.
  void AddCollision(const std::string& link, const UrdfShape& shape, const Eigen::Isometry3d& T_BS) {
    using Kind = UrdfShape::Kind;
    RoundedBox box{T_BS.translation(), T_BS.linear(), shape.edges / 2, 0};
    if (shape.kind == Kind::kMesh) {
      const Eigen::AlignedBox3d around = BoxAbout(shape);
      if (around.isEmpty()) {
        unjudged_.push_back(
            fmt::format("link '{}': the mesh '{}' of its collision shape is not found or cannot be read",
                        link, shape.mesh));
        return;
      }
      box.p_B = T_BS * around.center();
      box.half = around.sizes() / 2;
    } else if (shape.kind != Kind::kBox) {
      box.radius = shape.kind == Kind::kSphere ? shape.radius : std::min(shape.radius, shape.length / 2);
      const double flat = shape.radius - box.radius;
      if (shape.kind == Kind::kCylinder) box.half << flat, flat, shape.length / 2 - box.radius;
    }
    robot_.trunk_shapes.push_back(box);
  }

  /// The box about the mesh of a shape, in its frame; empty if the mesh is not found or cannot be read.
  Eigen::AlignedBox3d BoxAbout(const UrdfShape& shape) const {
    Eigen::AlignedBox3d box;
    try {
      if (const auto file = FindMesh(shape.mesh, file_.name))
        for (const auto& [x, y, z] : ReadMesh(*file)->corners)
          box.extend(Eigen::Vector3d(x, y, z).cwiseProduct(shape.scale));
    } catch (const ParameterError&) {
    }
    return box;
  }

  /// The inertia of a shape filled with 1 kg/m^3, in its link, for a mesh that of the box about it.
  RigidInertia FilledShape(const UrdfShape& shape) const {
    using Kind = UrdfShape::Kind;
    const bool is_mesh = shape.kind == Kind::kMesh, is_ball = shape.kind == Kind::kSphere;
    const Eigen::AlignedBox3d about = is_mesh ? BoxAbout(shape) : Eigen::AlignedBox3d();
    // A ball and a bar have the radii of gyration of a box, of which they have a part of the volume.
    const double thick = std::sqrt(is_ball ? 2.4 : 3.0) * shape.radius;
    double part = 1;
    Eigen::Vector3d edges = shape.edges;
    if (is_mesh) edges = about.sizes().cwiseMax(0);
    if (is_ball || shape.kind == Kind::kCylinder) {
      edges << thick, thick, is_ball ? thick : shape.length;
      part = is_ball ? 4 * std::numbers::pi / 3 / std::pow(2.4, 1.5) : std::numbers::pi / 3;
    }
    const double volume = part * edges.prod();
    const Eigen::Vector3d squares = edges.cwiseAbs2(),
                          moments = volume / 12 * (Eigen::Vector3d::Constant(squares.sum()) - squares);
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    if (!about.isEmpty()) centre = about.center();
    return RigidInertia{volume, centre, moments.asDiagonal()}.In(shape.pose.linear(),
                                                                 shape.pose.translation());
  }

  /// Removes the collision shapes of the trunk if they are only those of small parts of it.
  void KeepTrunkShapes() {
    Eigen::AlignedBox3d shapes, hips;
    for (const RoundedBox& box : robot_.trunk_shapes) {
      const Eigen::Vector3d half = box.R_BS.cwiseAbs() * box.half + Eigen::Vector3d::Constant(box.radius);
      shapes.extend(Eigen::AlignedBox3d(box.p_B - half, box.p_B + half));
    }
    for (int leg = 0; leg < kNumLegs; ++leg) hips.extend(JointOf(kJointsPerLeg * leg).p_PJ);
    if (shapes.isEmpty() || shapes.sizes().x() < hips.sizes().x() / 3) robot_.trunk_shapes.clear();
  }

  /// The mesh to be drawn, without colours if none is given.
  static std::shared_ptr<const TriangleMesh> Finished(TriangleMesh look) {
    if (std::ranges::all_of(look.colours, [](const auto& colour) { return colour[3] == 0; }))
      look.colours = {};
    return std::make_shared<const TriangleMesh>(Simplified(std::move(look)));
  }

  /// Adds a mesh, in B, to the appearance of a body; counts meshes that cannot be read. Parts without a
  /// colour of their own get that of the visual element.
  void AddMesh(const std::string& link, const UrdfShape& visual, int body, const Eigen::Isometry3d& T_BM) {
    const MeshColour colour = visual.colour
                                  ? ColourFrom((*visual.colour)[0], (*visual.colour)[1], (*visual.colour)[2])
                                  : MeshColour{};
    const auto miss = [&](std::vector<std::string>& list, const std::string& why) {
      missing_at_.emplace_back(static_cast<std::size_t>(body), link);
      list.push_back(fmt::format("link '{}': {}", link, why));
    };
    const std::optional<std::filesystem::path> file = FindMesh(visual.mesh, file_.name);
    if (!file) return miss(not_found_, fmt::format("the mesh '{}' is not found", visual.mesh));
    try {
      const std::shared_ptr<const TriangleMesh> mesh = ReadMesh(*file);
      TriangleMesh& out = looks_[body];
      const auto first = static_cast<std::uint32_t>(out.corners.size());
      out.colours.resize(first, {});
      out.colours.insert(out.colours.end(), mesh->colours.begin(), mesh->colours.end());
      out.colours.resize(first + mesh->corners.size(), colour);
      for (std::size_t i = first; i < out.colours.size(); ++i)
        if (out.colours[i][3] == 0) out.colours[i] = colour;
      for (const auto& [x, y, z] : mesh->corners) {
        const Eigen::Vector3d p(x * visual.scale.x(), y * visual.scale.y(), z * visual.scale.z());
        const Eigen::Vector3f p_B = (T_BM * p).cast<float>();
        out.corners.push_back({p_B.x(), p_B.y(), p_B.z()});
      }
      for (const auto& [a, b, c] : mesh->triangles)
        out.triangles.push_back({first + a, first + b, first + c});
    } catch (const ParameterError& error) {
      miss(unreadable_, error.what());
    }
  }

  /// Whether a link is the heaviest of a body, which the body's other meshes cannot replace.
  static bool IsMain(const std::string& link, const std::vector<Part>& parts) {
    const auto heaviest =
        std::ranges::max_element(parts, {}, [](const Part& part) { return part.inertia.mass; });
    return heaviest == parts.end() || heaviest->link == link;
  }

  void WarnOfMeshes() {
    const auto warn = [&](const std::vector<std::string>& list, const char* effect) {
      if (list.empty()) return;
      const std::size_t others = list.size() - 1;
      const std::string more = others == 0 ? ""
                                           : fmt::format(", nor {} {} other{}", others == 1 ? "is" : "are",
                                                         others, others == 1 ? "" : "s");
      Warn("{}{}; {}", list[0], more, effect);
    };
    warn(
        not_found_,
        "without the mesh of its main link, a body is drawn as a plain shape (packages are looked for around "
        "the URDF and in ROS_PACKAGE_PATH)");
    warn(unreadable_,
         "without the mesh of its main link, a body is drawn as a plain shape (the file exists, but is no "
         "mesh that can be read)");
    warn(unjudged_, "contact of the trunk is judged without it");
  }

  Eigen::Vector3d AxisOf(const UrdfJoint& joint) const {
    if (!(joint.axis.norm() > 0)) file_.Fail("joint '{}' has the axis 0 0 0; give its direction", joint.name);
    return joint.axis.normalized();
  }

  /// Stores a joint of a leg and returns its index.
  int NoteJoint(const UrdfJoint& joint, const Eigen::Isometry3d& T_BJ) {
    const auto at = joints_.find(joint.name);
    if (at == joints_.end())
      file_.Fail(
          "joint '{}' turns but belongs to no leg; list it under 'locked_joints' or 'actuated_joints', or "
          "make it fixed",
          joint.name);
    JointDescription& out = JointOf(at->second);
    out.name = joint.name;
    out.p_PJ = T_BJ.translation();  // in B until FinishLeg
    out.axis = T_BJ.linear() * AxisOf(joint);
    const int kind = at->second % kJointsPerLeg;
    const JointLimits& own = reading_.limits[kind];
    const std::optional<UrdfJoint::Limits>& limits = joint.limits;
    out.torque_limit = own.torque.value_or(limits ? limits->effort : 0);
    out.speed_limit = own.speed.value_or(limits ? limits->velocity : 0);
    if (!(out.torque_limit > 0 && out.speed_limit > 0))
      file_.Fail(
          "joint '{}' has no limits of torque and speed; add <limit effort=\"N m\" velocity=\"rad/s\" .../> "
          "with positive values, or torque_N_m and speed_rad_per_s under 'joint_limits.{}' in the YAML",
          joint.name, kLimitKeys[kind]);
    out.lower = -std::numeric_limits<double>::infinity();
    out.upper = std::numeric_limits<double>::infinity();
    if (own.range) {
      out.lower = (*own.range)[0];
      out.upper = (*own.range)[1];
    } else if (joint.type == UrdfJoint::Type::kRevolute) {
      out.lower = limits->lower;
      out.upper = limits->upper;
    }
    if (!(out.lower < out.upper))
      file_.Fail(
          "joint '{}' has the range {} to {} rad; the lower limit must be below the upper: correct it, or "
          "give range_rad under 'joint_limits.{}' in the YAML",
          joint.name, out.lower, out.upper, kLimitKeys[kind]);
    return at->second;
  }

  /// Stores an actuated joint on the body `carrier` and returns the number of its own body. T_BJ is the pose
  /// of the URDF's frame with the joint at rest.
  int NoteMoving(const UrdfJoint& joint, const AttachedBody& drive, int carrier,
                 const Eigen::Isometry3d& T_BJ) {
    if (carrier > 0 && carrier <= kNumJoints) CheckNotOfLeg(joint.name);
    const std::optional<UrdfJoint::Limits>& limits = joint.limits;
    if (!limits || !(limits->effort > 0))
      file_.Fail(
          "joint '{}' has no limit of torque; add <limit effort=\"N m\" .../> with a positive value, or move "
          "it from 'actuated_joints' to 'locked_joints'",
          joint.name);
    const double centre = drive.rest - drive.amplitude * std::sin(drive.phase);
    constexpr double kRounding = 1e-9;
    if (joint.type == UrdfJoint::Type::kRevolute &&
        (std::min(drive.rest, centre - drive.amplitude) < limits->lower - kRounding ||
         std::max(drive.rest, centre + drive.amplitude) > limits->upper + kRounding))
      file_.Fail(
          "joint '{}' turns from {} to {} rad, but under 'actuated_joints' its angle_rad is {}, its "
          "amplitude_rad {} and its phase_rad {}; change them",
          joint.name, limits->lower, limits->upper, drive.rest, drive.amplitude, drive.phase);
    AttachedBody body = drive;
    Eigen::Isometry3d T_BC = Eigen::Isometry3d::Identity();
    if (carrier > 0) {
      const int index = carrier - 1 - kNumJoints;
      body.on = moving_.bodies[index].name;
      T_BC = moving_poses_[index];
    }
    body.limit = limits->effort;
    body.position = T_BC.inverse() * T_BJ.translation();
    body.axis = T_BC.linear().transpose() * T_BJ.linear() * AxisOf(joint);
    moving_poses_.push_back(T_BC * Eigen::Translation3d(body.position) *
                            Eigen::AngleAxisd(body.rest, body.axis));
    moving_.bodies.push_back(std::move(body));
    parts_.emplace_back();
    names_.emplace_back();
    volumes_.emplace_back();
    looks_.emplace_back();
    return static_cast<int>(parts_.size()) - 1;
  }

  /// Measures the length of a leg and the distance of the hips from their centre, while the joints are in B.
  void MeasureExtents() {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (int leg = 0; leg < kNumLegs; ++leg) centre += JointOf(kJointsPerLeg * leg).p_PJ / kNumLegs;
    for (int leg = 0; leg < kNumLegs; ++leg) {
      const Eigen::Vector3d hip = JointOf(kJointsPerLeg * leg + 1).p_PJ,
                            knee = JointOf(kJointsPerLeg * leg + 2).p_PJ,
                            foot = poses_.at(reading_.feet[leg]) * reading_.foot_centres[leg];
      leg_extent_ = std::max(leg_extent_, (knee - hip).norm() + (foot - knee).norm());
      trunk_extent_ = std::max(trunk_extent_, (JointOf(kJointsPerLeg * leg).p_PJ - centre).norm());
    }
  }

  /// Transforms the joints and bodies of a leg from B to the joints' frames.
  void FinishLeg(int leg) {
    LegDescription& out = robot_.legs[leg];
    Eigen::Vector3d parent = Eigen::Vector3d::Zero();
    for (int i = 0; i < kJointsPerLeg; ++i) {
      JointDescription& joint = out.joints[i];
      const Eigen::Vector3d p_BJ = joint.p_PJ;
      out.bodies[i] = SumOf(1 + kJointsPerLeg * leg + i).In(Eigen::Matrix3d::Identity(), -p_BJ);
      for (std::array<float, 3>& p : looks_[1 + kJointsPerLeg * leg + i].corners)
        for (int k = 0; k < 3; ++k) p[k] -= static_cast<float>(p_BJ[k]);
      joint.p_PJ = p_BJ - parent;
      parent = p_BJ;
    }
    out.foot_J = poses_.at(reading_.feet[leg]) * reading_.foot_centres[leg] - parent;
  }

  /// Transforms a body on an actuated joint from B to its own frame.
  void FinishMoving(std::size_t index) {
    const std::size_t body = 1 + kNumJoints + index;
    const RigidInertia at_rest = SumOf(static_cast<int>(body));
    moving_.at_rest = moving_.at_rest + at_rest;
    const Eigen::Isometry3d T_JB = moving_poses_[index].inverse();
    const RigidInertia own = at_rest.In(T_JB.linear(), T_JB.translation());
    AttachedBody& out = moving_.bodies[index];
    out.mass = own.mass;
    out.centre = own.com;
    out.inertia = own.inertia;
    out.radius = std::sqrt(own.inertia.trace() / (1.2 * own.mass));  // of a ball with this trace
    TriangleMesh& look = looks_[body];
    if (look.triangles.empty()) return;
    for (auto& [x, y, z] : look.corners) {
      const Eigen::Vector3f p = (T_JB * Eigen::Vector3d(x, y, z)).cast<float>();
      x = p.x(), y = p.y(), z = p.z();
    }
    out.mesh = Finished(std::move(look));
  }

  /// Returns the inertia that a link contributes to a body of given mass, corrected if it is impossible.
  /// Links that only define frames often have invented inertias.
  RigidInertia Believed(const Part& part, double extent) {
    RigidInertia given = part.inertia;
    if (given.mass < 0)
      file_.Fail("link '{}' has the mass {} kg; give a positive mass, or no <inertial> at all", part.link,
                 given.mass);
    if (given.mass == 0) {
      if (!given.inertia.isZero(0)) Warn("link '{}' has an inertia but no mass and is ignored", part.link);
      return {};
    }
    const double usual = kUsualGyration * extent,
                 gyration = std::sqrt(given.inertia.trace() / 2 / given.mass);
    if (!reading_.strict && given.inertia.isZero(0)) {
      given.inertia = 2.0 / 3 * given.mass * usual * usual * Eigen::Matrix3d::Identity();
      Warn("link '{}' has a mass but no inertia; taken with a radius of gyration of {:.3g} m", part.link,
           usual);
    } else if (!reading_.strict && gyration > kMostGyration * extent) {
      given.inertia *= std::pow(usual / gyration, 2);
      Warn(
          "link '{}': its inertia is that of a body with a radius of gyration of {:.3g} m, which is too "
          "large for this robot and may be a placeholder; taken with {:.3g} m",
          part.link, gyration, usual);
    }
    try {
      CheckInertia(given.inertia);
      return given;
    } catch (const ParameterError& error) {
      const Eigen::Matrix3d mended = Mended(given.inertia);
      if (reading_.strict) file_.Fail("link '{}': {}", part.link, error.what());
      const Eigen::Vector3d taken = internal::SymmetricEigenvalues3(mended);
      Warn("link '{}': {}; taken with {:.3g}, {:.3g}, {:.3g} kg m^2", part.link, error.what(), taken[0],
           taken[1], taken[2]);
      return {given.mass, given.com, mended};
    }
  }

  /// Shares what the robot's mass exceeds the masses in the URDF among the bodies without mass, by the volume
  /// of their shapes. Refuses bodies that then have none, all in one message.
  void ShareMass() {
    std::string without;
    bool have_shapes = true;
    std::vector<std::size_t> bodies;
    double given = 0, volume = 0;
    for (std::size_t body = 0; body < parts_.size(); ++body) {
      double own = 0;
      for (const Part& part : parts_[body]) own += part.inertia.mass;
      given += own;
      if (own != 0) continue;
      bodies.push_back(body);
      volume += volumes_[body].mass;
      const bool has_shape = volumes_[body].mass > 0;
      have_shapes = have_shapes && has_shape;
      if (!has_shape || !reading_.mass)
        without += fmt::format("{}{}", without.empty() ? "" : "; ", names_[body]);
    }
    if (!without.empty())
      file_.Fail(
          "no mass is given for the bodies of link {}; give a link of each one an <inertial> with a positive "
          "mass, or {}{}{}",
          without, have_shapes ? "" : "a <collision> with a volume whose mesh is found",
          have_shapes || reading_.mass ? "" : " and ",
          reading_.mass ? "" : "the robot's mass by --mass KG or mass_kg");
    if (!reading_.mass) return;
    const double left = *reading_.mass - given;
    if (bodies.empty() || left <= 0)
      file_.Fail("the robot's mass is given as {} kg, but its links have {:.4g} kg{}", *reading_.mass, given,
                 bodies.empty() ? ", and no body is without mass; take it out" : "; give more");
    for (const std::size_t body : bodies) {
      const auto& [filled, com, inertia] = volumes_[body];
      parts_[body].push_back({names_[body], {left / volume * filled, com, left / volume * inertia}});
    }
    Warn("{:.4g} kg are spread by the volume of their shapes over the bodies without mass: {} of {}", left,
         bodies.size(), parts_.size());
  }

  /// Returns the inertia of a body in B.
  RigidInertia SumOf(int body) {
    const std::vector<Part>& parts = parts_[body];
    const std::string& names = names_[body];
    RigidInertia sum;
    const double extent = body > 0 && body <= kNumJoints ? leg_extent_ : 2 * trunk_extent_;
    for (const Part& part : parts) sum = sum + Believed(part, extent);
    try {
      CheckInertia(sum.inertia);
    } catch (const ParameterError& error) {
      file_.Fail("the body of link {}: {}", names, error.what());
    }
    return sum;
  }

  JointDescription& JointOf(int j) { return robot_.legs[j / kJointsPerLeg].joints[j % kJointsPerLeg]; }

  const UrdfFile file_;
  const UrdfReading& reading_;
  QuadrupedDescription& robot_;
  std::map<std::string, int> joints_;                     // indices of the legs' joints by name
  std::map<std::string, Eigen::Isometry3d> poses_;        // poses of the links in B by name
  std::vector<std::vector<Part>> parts_{1 + kNumJoints};  // parts of each body
  std::vector<RigidInertia> volumes_{1 + kNumJoints};     // bodies' shapes, filled with 1 kg/m^3
  std::vector<std::string> names_{1 + kNumJoints};        // names of the links of each body
  std::vector<TriangleMesh> looks_{1 + kNumJoints};       // appearance of the bodies that have meshes
  MovingParts moving_;
  std::vector<Eigen::Isometry3d> moving_poses_;                  // poses of the moving bodies at rest in B
  double leg_extent_ = 0, trunk_extent_ = 0;                     // length of a leg, distance of the hips [m]
  std::vector<std::pair<std::size_t, std::string>> missing_at_;  // bodies and links that lack meshes
  std::vector<std::string> not_found_, unreadable_,
      unjudged_;  // reasons for meshes that are not found, cannot be read, and of the trunk
  std::vector<std::string> warnings_;
};

}  // namespace

void JointLimits::Validate() const {
  if (range && !((*range)[0] < (*range)[1]))
    throw ParameterError(
        fmt::format("range_rad is {} to {}, but the first must be below the second; leave it "
                    "out for the URDF's",
                    (*range)[0], (*range)[1]));
}

Eigen::Vector3d Along(LinkAxis axis) {
  const int index = static_cast<int>(axis);
  return (index < 3 ? 1 : -1) * Eigen::Vector3d::Unit(index % 3);
}

Eigen::Matrix3d RotationOf(LinkAxis forward, LinkAxis up) {
  Eigen::Matrix3d R;
  R << Along(forward), Along(up).cross(Along(forward)), Along(up);
  return R;
}

std::vector<std::string> ReadUrdf(const std::filesystem::path& path, const UrdfReading& reading,
                                  QuadrupedDescription* robot, MovingParts* moving) {
  return Reader(path, reading, robot).Read(moving);
}

RobotLinks ReadLinks(const std::filesystem::path& path, const UrdfReading& reading,
                     const QuadrupedDescription& robot) {
  QuadrupedDescription copy = robot;
  RobotLinks links = Reader(path, reading, &copy).Links();
  links.urdf = ReadText(path);
  return links;
}

}  // namespace tenon::internal
