#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// Box on the ground with sides along x and y.
struct TerrainBox {
  Vec<2> centre = Vec<2>::Zero();  ///< centre of the box's footprint [m]
  Vec<2> size = Vec<2>::Zero();    ///< edge lengths of the box's footprint [m]
  double height = 0;               ///< height of the box's top above the plane [m]
  double friction = 0;             ///< friction coefficient of the box's faces, 0 to 10

  static FieldList Fields() {
    using B = TerrainBox;
    return {Required("centre_m", &B::centre).Between(-1e5, 1e5),
            Required("size_m", &B::size).Between(1e-3, 1e5),
            Required("height_m", &B::height).Above(0).AtMost(100).Because("boxes stand on the plane"),
            Required("friction", &B::friction).Between(0, 10).Because("about 1 for rubber on a dry floor")};
  }
};

/// Kind of boxes in a field.
struct BoxKind {
  double height = 0;    ///< height of the boxes above the plane [m]
  double friction = 0;  ///< friction coefficient of the boxes, 0 to 10

  static FieldList Fields() {
    return {
        Required("height_m", &BoxKind::height).Above(0).AtMost(100).Because("boxes stand on the plane"),
        Required("friction", &BoxKind::friction).Between(0, 10).Because("about 1 for rubber on a dry floor")};
  }
};

/// Boxes of equal size on a grid with a random offset. Each cell has a box with the probability `coverage`,
/// of a random kind. Equal seeds yield equal boxes.
struct BoxField {
  Vec<2> lower = Vec<2>::Zero(), upper = Vec<2>::Zero();  ///< bounds of the field along x and y [m]
  Vec<2> size{0.3, 0.3};                                  ///< edges of a box [m]
  double gap = 0.1;       ///< gap between adjacent cells; feet get stuck in gaps narrower than a foot [m]
  double coverage = 0.5;  ///< probability of a box in a cell, 0 to 1
  std::vector<BoxKind> kinds;
  std::uint64_t seed = 1;  ///< seed of the layout, added to the run's seed

  static FieldList Fields() {
    return {Required("lower_m", &BoxField::lower).Between(-1e5, 1e5),
            Required("upper_m", &BoxField::upper).Between(-1e5, 1e5),
            Field("size_m", &BoxField::size).Between(1e-3, 1e5),
            Field("gap_m", &BoxField::gap).AtLeast(0).Because("boxes cannot overlap"),
            Field("coverage", &BoxField::coverage).Between(0, 1).Because("it is a probability"),
            Required("kinds", &BoxField::kinds),
            {"seed", &BoxField::seed}};
  }
  void Validate() const;  ///< throws ParameterError
  std::vector<TerrainBox> Boxes() const;
};

/// Stairs up along x, a landing, and stairs down. With a single step they are a kerb.
struct Stairs {
  Vec<2> begin{1, 0};   ///< middle of the first edge [m]
  double rise = 0;      ///< height of a step [m]
  double run = 0.3;     ///< depth of a step [m]
  int steps = 1;        ///< number of steps on each side, 1 to 1000
  double landing = 1;   ///< length of the landing [m]
  double width = 4;     ///< extent along y [m]
  double friction = 1;  ///< friction coefficient of the steps, 0 to 10

  static FieldList Fields() {
    return {Field("begin_m", &Stairs::begin).Between(-1e5, 1e5),
            Required("rise_m", &Stairs::rise).Above(0).AtMost(1),
            Field("run_m", &Stairs::run).Between(0.05, 10),
            Field("steps", &Stairs::steps).Between(1, 1000),
            Field("landing_m", &Stairs::landing).Between(0.05, 1e4),
            Field("width_m", &Stairs::width).Between(0.1, 1e4),
            Field("friction", &Stairs::friction).Between(0, 10).Because("about 1 for rubber on a dry floor")};
  }
  std::vector<TerrainBox> Boxes() const;  ///< one for each step, the lower ones below the higher ones
};

/// A plane through the origin of W, with boxes on it. Defaults: level, without boxes.
struct TerrainParams {
  Vec<2> grade = Vec<2>::Zero();  ///< slope of the plane, dz/dx and dz/dy
  double friction = 1;            ///< friction coefficient of the plane, 0 to 10
  std::vector<TerrainBox>
      boxes;  ///< boxes in coordinates of the plane: x up its slope seen from above, z along its normal
  std::optional<BoxField> field{};  ///< field of additional, random boxes
  std::optional<Stairs> stairs{};   ///< additional boxes that form stairs

  static FieldList Fields() {
    return {Field("grade", &TerrainParams::grade).Between(-1000, 1000).Because("the slopes dz/dx, dz/dy"),
            Field("friction", &TerrainParams::friction)
                .Between(0, 10)
                .Because("about 1 for rubber on a dry floor"),
            {"boxes", &TerrainParams::boxes},
            {"field", &TerrainParams::field},
            {"stairs", &TerrainParams::stairs}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// Ground for feet: a plane with boxes, solid without limit downwards.
///
/// A foot is a sphere. It may have several contacts at once (the plane and the side of a box, for example),
/// each at the nearest point of the plane or of a box, so contact is continuous when it rolls over an edge.
/// Adjoining or overlapping boxes have a contact each, so their seam is stiffer than a single box. Boxes are
/// stored in a grid: the time of a query does not depend on their number.
class Terrain {
 public:
  /// Contact of a sphere with a solid.
  struct Contact {
    Vec<3> normal_W;  ///< unit normal of the surface, towards the sphere's centre
    double depth;     ///< depth of the sphere in the surface [m]
    double friction;
  };
  static constexpr int kMaxContacts = 4;
  /// The deepest contacts of one sphere.
  struct Contacts {
    int count = 0;
    std::array<Contact, kMaxContacts> at;
  };
  /// The surface straight below or above a point.
  struct Surface {
    double height;    ///< [m]
    Vec<3> normal_W;  ///< unit normal of the face
    double friction;
  };

  explicit Terrain(const TerrainParams& params = {});

  Surface At(double x, double y) const;
  /// For spheres of up to kMaxRadius.
  Contacts Touch(const Vec<3>& centre_W, double radius) const;
  const std::vector<TerrainBox>& boxes() const { return boxes_; }
  /// Axes of the plane, in which boxes are given; its normal is the last column.
  const Eigen::Matrix3d& R_WS() const { return R_WS_; }

  static constexpr double kMaxRadius = 0.1;  ///< [m]

 private:
  /// The boxes near a point of the plane.
  struct Range {
    const int* begin_;
    const int* end_;
    const int* begin() const { return begin_; }
    const int* end() const { return end_; }
  };
  Range Near(const Vec<3>& p_S) const;

  Eigen::Matrix3d R_WS_;  // S: the plane's frame, origin and z on it
  double friction_;
  std::vector<TerrainBox> boxes_;
  // Grid over the boxes: cell (i, j) holds members_[starts_[i + nx_ j]] to members_[starts_[i + nx_ j + 1]].
  Vec<2> corner_ = Vec<2>::Zero();
  double cell_ = 1;
  int nx_ = 0, ny_ = 0;
  std::vector<int> starts_, members_;
};

}  // namespace tenon
