#include <tenon/controllers/legged/planning/support_polygon.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::support_polygon_test {

using Feet = std::vector<Eigen::Vector2d>;

TEST(SupportPolygon, OfARectangleIsTheRectangleInAnyOrder) {
  Feet feet{{2, 1}, {2, -1}, {-2, -1}, {-2, 1}};
  std::array<int, 4> order{0, 1, 2, 3};
  do {
    const Feet shuffled{feet[order[0]], feet[order[1]], feet[order[2]], feet[order[3]]};
    const SupportPolygon polygon(shuffled, 0.1, 0.25);
    ASSERT_EQ(polygon.edges().size(), 4);
    EXPECT_NEAR(polygon.Depth({0, 0}), 0.75, 1e-15);
    EXPECT_NEAR(polygon.Depth({1.5, 0}), 0.25, 1e-15);
    EXPECT_NEAR(polygon.Depth({-2, 0.5}), -0.25, 1e-15);
    EXPECT_NEAR(polygon.Depth({0, -1.5}), -0.75, 1e-15);
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(SupportPolygon, LeavesOutAFootInside) {
  const Feet feet{{0, 0}, {1, 0.8}, {3, 0}, {0, 3}};
  const SupportPolygon polygon(feet, 0.1, 0);
  EXPECT_EQ(polygon.edges().size(), 3);
  EXPECT_NEAR(polygon.Depth({1, 0.8}), 0.8, 1e-15);
  EXPECT_NEAR(polygon.Depth({2, 2}), -1 / std::sqrt(2), 1e-15);
}

TEST(SupportPolygon, LeavesOutAFootUponAnEdgeInAnyOrder) {
  const Feet feet{{0, 0}, {0, 0.25}, {0, 1}, {1, 0.5}};
  std::array<int, 4> order{0, 1, 2, 3};
  do {
    const Feet shuffled{feet[order[0]], feet[order[1]], feet[order[2]], feet[order[3]]};
    const SupportPolygon polygon(shuffled, 0.1, 0);
    EXPECT_EQ(polygon.edges().size(), 3);
    for (const Eigen::Vector2d& foot : feet) EXPECT_NEAR(polygon.Depth(foot), 0, 1e-15);
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(SupportPolygon, WidensALine) {
  const Eigen::Vector2d along = Eigen::Vector2d(3, 4) / 5, across(-along[1], along[0]), begin(7, -2);
  for (const Feet& feet : {Feet{begin, begin + 2 * along}, Feet{begin + 2 * along, begin},
                           Feet{begin + along, begin, begin + 2 * along, begin}}) {
    const SupportPolygon polygon(feet, 0.05, 0.02);
    ASSERT_EQ(polygon.edges().size(), 4);
    EXPECT_NEAR(polygon.Depth(begin + along), 0.05, 1e-14);
    EXPECT_NEAR(polygon.Depth(begin + along + 0.07 * across), -0.02, 1e-14);
    EXPECT_NEAR(polygon.Depth(begin + along - 0.04 * across), 0.01, 1e-14);
    EXPECT_NEAR(polygon.Depth(begin + 0.03 * along), 0.01, 1e-14);
    EXPECT_NEAR(polygon.Depth(begin + 1.99 * along), -0.01, 1e-14);
  }
}

// Feet that are nearly in line make a thin triangle or a line, with at most four edges.
TEST(SupportPolygon, OfFeetNearlyInLineHasFourEdgesAtMost) {
  RandomStream random(7);
  for (int n = 0; n < 1000; ++n) {
    Feet feet(static_cast<std::size_t>(3 + n % 2));
    for (Eigen::Vector2d& foot : feet) foot << random.Uniform(), 2e-6 * random.Uniform();
    const SupportPolygon polygon(feet, 0.03, 0);
    ASSERT_GE(polygon.edges().size(), 3) << n;
    ASSERT_LE(polygon.edges().size(), 4) << n;
  }
  EXPECT_EQ(SupportPolygon(Feet{{0, 0}, {1, 0}, {0.5, 0.9e-6}}, 0.03, 0).edges().size(), 4) << "a line";
  EXPECT_EQ(SupportPolygon(Feet{{0, 0}, {1, 0}, {0.5, 1.1e-6}}, 0.03, 0).edges().size(), 3) << "a triangle";
}

TEST(SupportPolygon, OfOneFootIsASquareAboutIt) {
  const SupportPolygon polygon(Feet{{1, 2}, {1, 2}}, 0.03, 0.02);
  EXPECT_NEAR(polygon.Depth({1, 2}), 0.03, 1e-15);
  EXPECT_NEAR(polygon.Depth({1.05, 2.01}), -0.02, 1e-15);
  EXPECT_NEAR(polygon.Depth({1, 1.98}), 0.01, 1e-15);
}

TEST(SupportPolygon, IsEmptyIfTheMarginIsTooLarge) {
  const SupportPolygon polygon(Feet{{0, 0}, {1, 0}, {0, 1}}, 0.03, 0.4);
  for (double x = -1; x < 2; x += 0.05)
    for (double y = -1; y < 2; y += 0.05) EXPECT_LT(polygon.Depth({x, y}), 0);
}

/// A point is in the hull of up to four points if and only if it is in one of their triangles.
TEST(SupportPolygon, IsTheUnionOfTheTriangles) {
  RandomStream random(1);
  const auto point = [&] { return Eigen::Vector2d(random.Uniform(-1, 1), random.Uniform(-1, 1)); };
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a[0] * b[1] - a[1] * b[0];
  };
  int inside = 0;
  for (int n = 0; n < 100; ++n) {
    Feet feet;
    for (int i = 0; i < 3 + n % 2; ++i) feet.push_back(point());
    const SupportPolygon polygon(feet, 0.01, 0);
    for (int m = 0; m < 30; ++m) {
      const Eigen::Vector2d p = point();
      bool expected = false;
      for (std::size_t out = 0; out < (feet.size() == 4 ? 4 : 1); ++out) {
        Feet corner = feet;
        if (feet.size() == 4) corner.erase(corner.begin() + static_cast<long>(out));
        std::array<double, 3> side;
        for (std::size_t i = 0; i < 3; ++i) side[i] = cross(corner[(i + 1) % 3] - corner[i], p - corner[i]);
        expected = expected || std::all_of(side.begin(), side.end(), [](double s) { return s > 0; }) ||
                   std::all_of(side.begin(), side.end(), [](double s) { return s < 0; });
      }
      EXPECT_EQ(polygon.Depth(p) > 0, expected) << n << " " << m;
      inside += expected;
    }
  }
  EXPECT_GT(inside, 300);
}

TEST(SupportPolygon, WithoutEdgesIsThePlane) {
  EXPECT_GT(SupportPolygon().Depth({1e6, -1e6}), 1e300);
}

TEST(SupportPolygon, RefusesNoFeetAndFive) {
  EXPECT_TRUE(Throws<Error>([] { SupportPolygon(Feet{}, 0.1, 0); }, "0 feet"));
  EXPECT_TRUE(Throws<Error>([] { SupportPolygon(Feet(5, {0, 0}), 0.1, 0); }, "5 feet"));
}

}  // namespace tenon::support_polygon_test
