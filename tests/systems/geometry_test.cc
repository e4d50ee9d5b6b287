#include <tenon/systems/framework/diagram/diagram.h>
#include <tenon/systems/geometry.h>
#include <tenon/systems/simulation/simulator.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tenon::geometry_test {
namespace {

using ::testing::ElementsAre;

/// A ball that rises with 1 m/s, sampled, and a wall.
class Ball final : public LeafSystem<void> {
 public:
  OutputPort<Geometry> geometry{
      this,
      {"geometry"},
      {Shape::Sphere(ShapeRole::kBody, "ball", 0.1), Shape::Box(ShapeRole::kGround, "wall", {0.1, 2, 1})},
      Sampled{Hz(10)},
      Uses(time),
      [](double t, Geometry* out) { out->front().p_W[2] = t; }};
};

TEST(GeometryTest, OnlyWhatMovesHasElements) {
  const Ball ball;
  std::vector<std::string> names;
  for (const Element& element : ball.geometry.elements()) names.push_back(element.name);
  ASSERT_EQ(names.size(), 24);
  names.resize(12);
  EXPECT_THAT(names, ElementsAre("0.p_W.x", "0.p_W.y", "0.p_W.z", "0.q_W.w", "0.q_W.x", "0.q_W.y", "0.q_W.z",
                                 "0.vector_W.x", "0.vector_W.y", "0.vector_W.z", "0.value", "0.visible"));
}

TEST(GeometryTest, ConstantsAndMotionSurviveSaveAndRestore) {
  DiagramBuilder builder;
  auto& ball = builder.Add<Ball>("ball");
  const auto diagram = builder.Build();
  Simulator simulator(*diagram);
  simulator.RunTo(0.35);
  const auto other = diagram->CreateContext();
  other->Restore(simulator.context().Save());
  const Geometry& geometry = other->Eval(ball.geometry);
  ASSERT_EQ(geometry.size(), 2);
  EXPECT_EQ(geometry[0].p_W[2], 0.3);
  EXPECT_EQ(geometry[0].size[0], 0.1);
  EXPECT_EQ(geometry[1].name, "wall");
  EXPECT_EQ(geometry[1].kind, ShapeKind::kBox);
}

TEST(GeometryTest, ShapesSayWhatTheyAre) {
  const Shape arrow = Shape::Arrow(ShapeRole::kEstimate, "estimate", 0.01);
  EXPECT_EQ(arrow.kind, ShapeKind::kArrow);
  EXPECT_EQ(arrow.scale, 0.01);
  EXPECT_EQ(arrow.q_W, (Vec<4>{1, 0, 0, 0}));
  EXPECT_TRUE(arrow.visible);
  const Shape cable = Shape::Segment(ShapeRole::kLine, "cable", 0.02, "N");
  EXPECT_EQ(cable.size[0], 0.02);
  EXPECT_EQ(cable.unit, "N");
  const Shape leg = Shape::Capsule(ShapeRole::kBody, "leg", 0.03, 0.3);
  EXPECT_EQ(leg.size[1], 0.3);
  const auto triangle =
      std::make_shared<const TriangleMesh>(TriangleMesh{{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});
  const Shape mesh = Shape::Mesh(ShapeRole::kBody, "trunk", triangle);
  EXPECT_EQ(mesh.kind, ShapeKind::kMesh);
  EXPECT_EQ(mesh.mesh, triangle);
  EXPECT_EQ(Shape::Trace(ShapeRole::kReference, "path", 0.05).size[0], 0.05);
}

}  // namespace
}  // namespace tenon::geometry_test
