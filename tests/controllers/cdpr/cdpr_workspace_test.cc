#include <tenon/controllers/cdpr/cdpr_workspace.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

#include <random>

namespace tenon::cdpr_workspace_test {

using Eigen::Matrix3d, Eigen::Vector3d;

/// A point mass on cables from the corners of a polygon 4 m high, with tensions from 0 to 100 kN.
CdprDescription PointMass(const std::vector<Eigen::Vector2d>& corners) {
  CdprDescription robot = test::FourCableRobot();
  robot.cable.tension_min = 0;
  robot.cable.tension_max = 1e5;
  robot.cables.clear();
  for (const auto& corner : corners) robot.cables.push_back({{corner.x(), corner.y(), 4}, Vector3d::Zero()});
  return robot;
}

double Volume(const std::vector<WorkspaceCell>& cells, const WorkspaceGrid& grid) {
  double sum = 0;
  for (const WorkspaceCell& cell : cells) sum += cell.volume(grid);
  return sum;
}

// A hanging point mass can rest exactly below the polygon of its anchors.
TEST(CdprWorkspaceTest, StaticWorkspaceOfAPointMassIsThePrismBelowItsAnchors) {
  struct Shape {
    std::vector<Eigen::Vector2d> corners;
    double area;
  };
  for (const Shape& shape :
       {Shape{{{-2, -1}, {2, -1}, {0, 2}}, 6}, Shape{{{-2, -1.5}, {2, -1.5}, {2, 1.5}, {-2, 1.5}}, 12},
        Shape{{{-2, 0}, {-1, -1.5}, {1, -1.5}, {2, 0}, {1, 1.5}, {-1, 1.5}}, 9}}) {
    const CdprDescription robot = PointMass(shape.corners);
    PoseFeasibility feasibility(robot, RequiredWrenches(robot, {}));
    const WorkspaceGrid grid = WorkspaceGrid::OfSize({-2.5, -2.5, 0}, {2.5, 2.5, 3}, 0.1);
    const auto cells = MapWorkspace(feasibility, {.grid = grid});
    EXPECT_NEAR(Volume(cells, grid), 75, 1e-9);
    const WorkspaceVolume volume = VolumeOf(cells, grid);
    EXPECT_LE(volume.proven, 3 * shape.area);
    EXPECT_GE(volume.possible, 3 * shape.area);
    EXPECT_NEAR(volume.centres, 3 * shape.area, 0.03 * 3 * shape.area);
    EXPECT_GT(volume.proven, 0.7 * 3 * shape.area);
    EXPECT_LT(volume.possible, 1.3 * 3 * shape.area);
  }
}

// In planes, by the quadratic program, with a spring, on a table and for a point mass, too.
TEST(CdprWorkspaceTest, EveryPointOfAFeasibleCellInAPlaneIsFeasible) {
  std::mt19937_64 random(23);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  CdprDescription sprung = test::PlanarRobot(4);
  sprung.springs = {{{0.5, 0, 5}, {0, 0, 0.1}, 40, 1}};
  for (const CdprDescription& robot :
       {test::PlanarRobot(4), sprung, test::TableRobot(), PointMass({{-2, 0}, {2, 0}})}) {
    const CablePlane plane = *PlaneOf(robot);
    PoseFeasibility feasibility(robot, RequiredWrenches(robot, {}));
    Vector3d low(-2.5, -2.5, 0.2), high(2.5, 2.5, 3.8);
    low[plane.normal] = high[plane.normal] = plane.at;
    const WorkspaceGrid grid = WorkspaceGrid::OfSize(low, high, 0.05);
    const Matrix3d R = Eigen::AngleAxisd(0.1, Vector3d::Unit(plane.normal)).toRotationMatrix();
    const auto cells = MapWorkspace(feasibility, {.grid = grid, .R_WB = R});
    const WorkspaceVolume area = VolumeOf(cells, grid);
    EXPECT_GT(area.proven, 0.1 * grid.volume());
    EXPECT_LT(area.possible - area.proven, 0.15 * grid.volume());
    for (int i = 0; i < 500; ++i) {
      const WorkspaceCell& cell = cells[random() % cells.size()];
      if (cell.wrench == PoseVerdict::kUndecided) continue;
      Vector3d p = cell.centre(grid);
      for (int k = 0; k < 3; ++k) p[k] += uniform(random) * cell.size[k] * grid.cell()[k];
      EXPECT_EQ(DistributeTension(CalcCableKinematics(robot, p, R).structure, -PassiveWrench(robot, p, R),
                                  robot.tension_min(), robot.tension_max())
                    .feasible,
                cell.wrench == PoseVerdict::kHolds)
          << robot.name << " " << p.transpose();
    }
  }
}

// The bounds of finer cells approach the volume from both sides.
TEST(CdprWorkspaceTest, BoundsConverge) {
  const CdprDescription robot = PointMass({{-2, -1}, {2, -1}, {0, 2}});
  PoseFeasibility feasibility(robot, RequiredWrenches(robot, {}));
  double gap = 1e9;
  for (const double cell : {0.4, 0.2, 0.1}) {
    const WorkspaceGrid grid = WorkspaceGrid::OfSize({-2.4, -1.6, 0.8}, {2.4, 2.4, 2.4}, cell);
    const WorkspaceVolume volume = VolumeOf(MapWorkspace(feasibility, {.grid = grid}), grid);
    EXPECT_LT(volume.possible - volume.proven, 0.6 * gap);
    gap = volume.possible - volume.proven;
  }
}

// 2000 random points of cells next to the boundary: all feasible where the cell is said to hold, none where
// it is said to fail, by the quadratic program of tension_distribution.h.
TEST(CdprWorkspaceTest, EveryPointOfAFeasibleCellIsFeasible) {
  const CdprDescription robot = test::EightCableRobot();
  const WrenchBox required = RequiredWrenches(robot, {.load = 5});
  PoseFeasibility feasibility(robot, required);
  const WorkspaceGrid grid = WorkspaceGrid::OfSize({-3.5, -4.5, 0}, {3.5, 4.5, 4}, 0.25);
  const auto cells = MapWorkspace(feasibility, {.grid = grid});
  EXPECT_NEAR(Volume(cells, grid), grid.volume(), 1e-9 * grid.volume());

  // The smallest cells are the ones at the boundary.
  std::vector<const WorkspaceCell*> near;
  for (const WorkspaceCell& cell : cells) {
    if (cell.wrench != PoseVerdict::kUndecided && cell.size[0] * cell.size[1] * cell.size[2] <= 4)
      near.push_back(&cell);
  }
  ASSERT_GT(near.size(), 100U);
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  TensionDistributor distributor(8);
  int holds = 0;
  for (int i = 0; i < 2000; ++i) {
    const WorkspaceCell& cell = *near[random() % near.size()];
    Vector3d p = cell.centre(grid);
    for (int k = 0; k < 3; ++k) {
      // Every other point on a face.
      const double share = i % 6 == 2 * k ? 0.5 : uniform(random);
      p[k] += share * cell.size[k] * grid.cell()[k];
    }
    const CableMatrix6 W = CalcCableKinematics(robot, p, Matrix3d::Identity()).structure;
    const bool feasible =
        distributor.Solve(W, required.centre, robot.tension_min(), robot.tension_max()).feasible;
    ASSERT_EQ(feasible, cell.wrench == PoseVerdict::kHolds) << p.transpose();
    holds += feasible ? 1 : 0;
  }
  EXPECT_GT(holds, 600);
  EXPECT_LT(holds, 1900);
}

// The platform of eight cables at one position, turned about random axes.
TEST(CdprWorkspaceTest, EveryAttitudeOfAFeasibleCellIsFeasible) {
  const CdprDescription robot = test::EightCableRobot();
  const WrenchBox required = RequiredWrenches(robot, {});
  PoseFeasibility feasibility(robot, required);
  const WorkspaceGrid grid = WorkspaceGrid::OfSize(Vector3d::Constant(-1), Vector3d::Constant(1), 0.05);
  const WorkspaceOptions options{.kind = WorkspaceKind::kAttitude, .grid = grid, .p_WB = {0.4, -0.5, 1.8}};
  const auto cells = MapWorkspace(feasibility, options);
  const WorkspaceVolume volume = VolumeOf(cells, grid);
  EXPECT_GT(volume.proven, 0.1);
  EXPECT_LT(volume.possible, 0.95 * grid.volume());
  std::mt19937_64 random(19);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  TensionDistributor distributor(8);
  for (int i = 0; i < 1000; ++i) {
    const WorkspaceCell& cell = cells[random() % cells.size()];
    if (cell.wrench == PoseVerdict::kUndecided) continue;
    Vector3d rotation = cell.centre(grid);
    for (int k = 0; k < 3; ++k) rotation[k] += uniform(random) * cell.size[k] * grid.cell()[k];
    const Matrix3d R = Eigen::AngleAxisd(rotation.norm(), rotation.normalized()).toRotationMatrix();
    const CableMatrix6 W = CalcCableKinematics(robot, options.p_WB, R).structure;
    EXPECT_EQ(distributor.Solve(W, required.centre, robot.tension_min(), robot.tension_max()).feasible,
              cell.wrench == PoseVerdict::kHolds)
        << rotation.transpose();
  }
}

// The clear workspace is a part of the feasible one. The attachments are 0.3 m apart, so thicker cables
// touch.
TEST(CdprWorkspaceTest, ThickCablesLeaveNothing) {
  CdprDescription robot = test::EightCableRobot();
  for (CableDescription& cable : robot.cables) cable.attachment_B.z() *= -1;  // crossed ones touch everywhere
  PoseFeasibility feasibility(robot, RequiredWrenches(robot, {}));
  const WorkspaceGrid grid = WorkspaceGrid::OfSize({-0.3, -0.3, 1.5}, {0.3, 0.3, 2.1}, 0.05);
  WorkspaceVolume thin, thick;
  for (const auto& [diameter, volume] : {std::pair{0.02, &thin}, std::pair{0.31, &thick}}) {
    const auto cells = MapWorkspace(feasibility, {.grid = grid, .cable_diameter = diameter});
    *volume = VolumeOf(cells, grid, diameter);
    EXPECT_LE(volume->proven, volume->centres);
    EXPECT_LE(volume->centres, volume->possible);
    EXPECT_LE(volume->centres, VolumeOf(cells, grid).centres);
  }
  EXPECT_GT(thin.proven, 0);
  EXPECT_EQ(thick.centres, 0);
}

// Four cables in a tetrahedron pull a point mass in every direction exactly inside of it; cables that all
// come from above never do.
TEST(CdprWorkspaceTest, WrenchClosureOfAPointMassIsTheTetrahedronOfItsAnchors) {
  CdprDescription robot = PointMass({{-2, -1}, {2, -1}, {0, 2}});
  robot.cables.push_back({{0, 0, 0}, Vector3d::Zero()});
  PoseFeasibility closure = WrenchClosure(robot);
  const WorkspaceGrid grid = WorkspaceGrid::OfSize({-2, -1, 0}, {2, 2, 4}, 0.1);
  const WorkspaceVolume volume = VolumeOf(MapWorkspace(closure, {.grid = grid}), grid);
  EXPECT_NEAR(volume.centres, 8, 0.2);
  EXPECT_LT(volume.proven, 8);
  EXPECT_GT(volume.proven, 5);
  EXPECT_GT(volume.possible, 8);
  robot.cables.pop_back();
  EXPECT_FALSE(WrenchClosure(robot).At({0, 0, 2}, Matrix3d::Identity()).feasible());
}

// Poses at which tensions up to a thousand times the least one are in balance, by the quadratic program.
TEST(CdprWorkspaceTest, WrenchClosureIsABalanceOfPositiveTensions) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> draw(-1, 1);
  const CdprDescription robot = test::EightCableRobot();
  PoseFeasibility closure = WrenchClosure(robot);
  int found = 0;
  for (int n = 0; n < 200; ++n) {
    const Vector3d p(5 * draw(random), 6 * draw(random), 2 + 3 * draw(random));
    const Matrix3d R = Eigen::AngleAxisd(0.3 * draw(random), Vector3d::UnitX()).toRotationMatrix();
    const bool balanced = DistributeTension(CalcCableKinematics(robot, p, R).structure, Vector6d::Zero(),
                                            CableVector::Constant(8, 1), CableVector::Constant(8, 1000))
                              .feasible;
    EXPECT_EQ(closure.At(p, R).feasible(), balanced) << p.transpose();
    found += balanced ? 1 : 0;
  }
  EXPECT_GT(found, 20);
  EXPECT_LT(found, 180);
}

// A platform that hangs from one point on strong cables rests wherever this point is below the triangle of
// the anchors.
TEST(CdprWorkspaceTest, EquilibriaFromOnePointAreThePrismBelowTheAnchors) {
  CdprDescription robot = PointMass({{-2, -1}, {2, -1}, {0, 2}});
  for (CableDescription& cable : robot.cables) cable.attachment_B = {0, 0, 0.1};
  const WorkspaceGrid grid = WorkspaceGrid::OfSize({-2.5, -2.5, 1}, {2.5, 2.5, 3}, 0.5);
  std::vector<double> shares;
  const auto found = MapEquilibria(robot, grid, [&](double share) { shares.push_back(share); });
  ASSERT_EQ(found.size(), 10 * 10 * 4U);
  for (std::size_t n = 0; n < found.size(); ++n) {
    const double x = -2.25 + 0.5 * static_cast<double>(n % 10),
                 y = -2.25 + 0.5 * static_cast<double>(n / 10 % 10);
    const bool below = y > -1 && 2 * y + 3 * std::abs(x) < 4;
    EXPECT_EQ(found[n].has_value(), below) << x << ", " << y;
  }
  EXPECT_TRUE(std::ranges::is_sorted(shares));
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        MapEquilibria(robot, WorkspaceGrid::OfSize({5, 5, 1}, {6, 6, 2}, 1), {});
      },
      "(5.5, 5.5, 1.5)"));
}

TEST(CdprWorkspaceTest, ReportsItsProgress) {
  const CdprDescription robot = test::EightCableRobot();
  PoseFeasibility feasibility(robot, RequiredWrenches(robot, {}));
  std::vector<double> shares;
  MapWorkspace(feasibility, {.grid = WorkspaceGrid::OfSize({-2, -3, 0.5}, {2, 3, 3.5}, 0.25),
                             .progress = [&](double share) { shares.push_back(share); }});
  ASSERT_GT(shares.size(), 3U);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_GT(shares.front(), 0);
  EXPECT_LE(shares.back(), 1 + 1e-9);
}

TEST(CdprWorkspaceTest, RefusesImpossibleGrids) {
  const auto refuses = [](const Vector3d& upper, double cell, const char* key) {
    return Throws<ParameterError>([&] { WorkspaceGrid::OfSize({0, 0, 0}, upper, cell); }, key);
  };
  EXPECT_TRUE(refuses({1, -1, 1}, 0.1, "along y"));
  EXPECT_TRUE(refuses({1, 1, 1}, 0, "cells of 0"));
  EXPECT_TRUE(refuses({10, 10, 10}, 0.01, "cells"));
}

}  // namespace tenon::cdpr_workspace_test
