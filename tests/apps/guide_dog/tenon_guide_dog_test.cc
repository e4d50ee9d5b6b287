// The figures of tenon-guide-dog, and the scenarios that it refuses.

#include <tenon/tests/apps/run_app.h>

namespace tenon::tenon_guide_dog_test {

using ::testing::HasSubstr;

class TenonGuideDogTest : public test::AppTest {
 protected:
  TenonGuideDogTest() : AppTest(TENON_GUIDE_DOG) {}
};

TEST_F(TenonGuideDogTest, FiguresCountFromWhenTheWalkIsJudged) {
  Run("C3 --duration 0.3 --set walk.judged_from_s=0.5");
  EXPECT_THAT(Summary(), HasSubstrs("\"com_error_max_m\": null", "\"heading_error_deg\": null"));
}

// The mean counts from the time at which the leash has the desired tension, which for this robot is 104 N
// instead of 30 N. Counted from 30 N it would be 102 N.
TEST_F(TenonGuideDogTest, FiguresAreOfTheTensionsThatAreScaled) {
  Run("C1 --set robot=b2 --set scale_forces=true --duration 5");
  EXPECT_THAT(Summary(), HasSubstrs("\"tension_mean_N\": 11", "\"tension_max_N\": 1"));
}

TEST_F(TenonGuideDogTest, WarnsOfAMeshThatIsMissing) {
  std::string urdf = ReadText(TENON_ROBOTS_DIR "/a1.urdf");
  const std::string link = "<link name=\"trunk\">";
  urdf.insert(urdf.find(link) + link.size(),
              "<visual><geometry><mesh filename=\"no.stl\"/></geometry></visual>");
  Write("a1.urdf", urdf);
  const std::string robot = Write("a1.yaml", ReadText(TENON_ROBOTS_DIR "/a1.yaml"));
  EXPECT_THAT(Run("C1 --duration 0.1 --set robot=" + robot), HasSubstrs("warning: ", "'no.stl'"));
}

TEST_F(TenonGuideDogTest, ReportShowsPersonAndObstacles) {
  Run("C3 --duration 0.1");
  EXPECT_THAT(ReadText(out / "report.html"), HasSubstrs("path of the person", "obstacle 0"));
}

TEST_F(TenonGuideDogTest, WalksByTheEstimatedState) {
  Run("C2 --duration 2 --set walk.state=estimated");
  EXPECT_THAT(Signals(), HasSubstr("loop.estimator.estimate"));
}

// A collision does not end a run: the verdict names both bodies. The robot starts at the origin with its
// front legs at x = 0.3 m, the person stands at x = -1.7 m.
TEST_F(TenonGuideDogTest, ACollisionFailsTheRunFromItsFirstInstant) {
  const std::string run = "C3 --duration 0.01 --set ";
  for (const auto& [settings, names] : {
           std::pair<std::string, std::string>{
               "'surroundings.obstacles=[{centre_m: [0.1, 0], radius_m: 0.1}]'",
               "the trunk and obstacle 0 collided: "},
           {"surroundings.obstacles.0.centre_m=[-1.7,0.3]", "the person and obstacle 0 collided: "},
           {"surroundings.obstacles.0.centre_m=[-1,0.1]", "the leash and obstacle 0 collided: "},
           {"person.start_m=[0,0]", "the trunk and the person collided: "},
           {"person.start_m=[0.8,0] --set person.hand_height_m=0.1", "the leash and the trunk collided: "},
       }) {
    Run(run + settings, 3);
    EXPECT_THAT(Summary(), HasSubstrs("\"finished\": false", names)) << settings;
  }
}

// The leash passes over a pillar of 0.8 m, and a robot beside one is not in it.
TEST_F(TenonGuideDogTest, ANearMissIsNoCollision) {
  Run("C3 --duration 0.01 --set person.hand_height_m=1.3 --set surroundings.obstacles.0.centre_m=[-1.3,0]");
  Run("C3 --duration 0.01 --set surroundings.obstacles.0.centre_m=[0.3,0.55]");
  EXPECT_THAT(Summary(), HasSubstr("\"obstacle_clearance_min_m\": 0."));
}

TEST_F(TenonGuideDogTest, RefusesBadUsage) {
  ExpectRefused({{"flat", "run tenon-quadruped flat"},
                 {"C1 --set person.phases.1.speed_m_per_s=-1", "C1.yaml:21:7: person.phases.1: "},
                 {"C3 --set surroundings.obstacles.0.radius_m=0", "surroundings.obstacles.0.radius_m: "}});
  ExpectSettingsRefused("C1", {"walk.judged_from_s=76", "fall.min_height_ratio=2", "leash.stiffness=3",
                               "supervisor.release_N=60"});
}

}  // namespace tenon::tenon_guide_dog_test
