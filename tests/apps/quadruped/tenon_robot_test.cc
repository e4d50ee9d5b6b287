#include <tenon/tests/apps/run_app.h>

namespace tenon::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

namespace fs = std::filesystem;

class TenonRobotTest : public AppTest {
 protected:
  Result Run(const std::string& arguments) const { return RunCommand(TENON_ROBOT " " + arguments); }
};

// From a URDF alone to a robot that trots, all in one directory.
TEST_F(TenonRobotTest, MakesARobotWalk) {
  const Result run = Run(TENON_ROBOTS_DIR "/a1.urdf" + Out());
  EXPECT_EQ(run.exit_code, 0) << run.text;
  EXPECT_THAT(run.text,
              AllOf(HasSubstr("mass_kg                      12.78"),
                    HasSubstr("trots                        yes"), HasSubstr("foot_radius_m is guessed")));
  EXPECT_THAT(Read(out / "a1.yaml"), AllOf(HasSubstr("urdf: a1.urdf"), HasSubstr("front_left: FL_foot")));
  EXPECT_EQ(Read(out / "a1.urdf"), Read(TENON_ROBOTS_DIR "/a1.urdf"));
  EXPECT_THAT(Read(out / "a1.svg"), HasSubstr("<svg"));
  EXPECT_TRUE(fs::exists(out / "stand/report.html"));
  EXPECT_TRUE(fs::exists(out / "trot/summary.json"));
}

TEST_F(TenonRobotTest, SaysWhatIsWrong) {
  EXPECT_EQ(Run("nowhere.urdf" + Out()).exit_code, 2);
  const Result lock = Run(TENON_ROBOTS_DIR "/a1.urdf --lock FL_hip_joint=up" + Out());
  EXPECT_EQ(lock.exit_code, 2);
  EXPECT_THAT(lock.text, HasSubstr("--lock FL_hip_joint=up: write JOINT=ANGLE"));
  const Result legs = Run(TENON_ROBOTS_DIR "/a1.urdf --lock FL_hip_joint=0" + Out());
  EXPECT_EQ(legs.exit_code, 2);
  EXPECT_THAT(legs.text, AllOf(HasSubstr("found 3 chains of three joints"),
                               HasSubstr("FL_thigh_joint - FL_calf_joint (2)")));
  EXPECT_FALSE(fs::exists(out / "a1.yaml"));
}

}  // namespace
}  // namespace tenon::test
