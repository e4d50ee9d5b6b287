#include <tenon/systems/geometry.h>
#include <tenon/systems/simulation/simulator.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tenon::geometry_test {

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

}  // namespace tenon::geometry_test
