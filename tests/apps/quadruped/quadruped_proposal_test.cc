#include <tenon/apps/quadruped/quadruped_proposal.h>
#include <tenon/plants/legged/quadruped_clearance.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/temporary_path.h>

#include <fmt/format.h>

#include <regex>

namespace tenon::quadruped_proposal_test {

using internal::LinkAxis, ::testing::Contains, ::testing::HasSubstr, ::testing::Not;

namespace fs = std::filesystem;

std::string ReadUrdf(const std::string& robot) {
  return ReadText(std::string(TENON_ROBOTS_DIR) + "/" + robot + ".urdf");
}
std::string Replaced(const std::string& text, const std::string& from, const std::string& to) {
  const std::regex what(from);
  EXPECT_TRUE(std::regex_search(text, what)) << from;
  return std::regex_replace(text, what, to);
}

/// A directory with one URDF, and its proposal.
class QuadrupedProposalTest : public ::testing::Test {
 protected:
  QuadrupedProposalTest() { fs::create_directories(directory_); }
  ~QuadrupedProposalTest() override { fs::remove_all(directory_); }

  QuadrupedProposal Propose(const std::string& urdf, const UrdfLegsOptions& options = {}) {
    std::ofstream(directory_ / "robot.urdf") << urdf;
    return ProposeQuadruped(directory_ / "robot.urdf", options);
  }
  QuadrupedDescription Load(const QuadrupedProposal& proposal) {
    std::ofstream(directory_ / "robot.yaml") << proposal.yaml;
    return LoadQuadruped(directory_ / "robot.yaml");
  }

 private:
  const fs::path directory_ = test::TemporaryPath(
      std::string("tenon_proposal_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

// Names that YAML would read as something else are quoted.
TEST_F(QuadrupedProposalTest, QuotesNamesInYaml) {
  const QuadrupedProposal plain = Propose(ReadUrdf("dogbot"));
  EXPECT_THAT(plain.yaml, HasSubstr("front_left: front_left_foot,"));
  const auto stance = Load(plain).stance;
  const QuadrupedProposal made = Propose(Replaced(ReadUrdf("dogbot"), "front_left_foot", "12, #foot"));
  EXPECT_THAT(made.yaml, HasSubstr("front_left: \"12, #foot\","));
  EXPECT_EQ(Load(made).stance, stance);
}

// The URDF alone gives the feet of DogBot's YAML, with knees that point backward.
TEST_F(QuadrupedProposalTest, FindsDogBotsLegs) {
  const QuadrupedDescription made = Load(Propose(ReadUrdf("dogbot"))),
                             own = LoadQuadruped(std::string(TENON_ROBOTS_DIR) + "/dogbot.yaml");
  EXPECT_EQ(made.mass(), own.mass());
  for (int leg = 0; leg < kNumLegs; ++leg) {
    EXPECT_THAT(made.FootPosition(leg, own.stance), IsNear(own.FootPosition(leg, own.stance), 1e-12)) << leg;
    const Eigen::Vector3d hip = made.HipPosition(leg, made.stance),
                          foot = made.FootPosition(leg, made.stance);
    EXPECT_NEAR(foot.x(), hip.x(), 1e-3);
    EXPECT_NEAR(hip.z() - foot.z(), 0.7 * made.LegLength(leg), 1e-3);
    EXPECT_LT(made.stance[3 * leg + 2] * own.stance[3 * leg + 2] * -1, 0);
  }
  EXPECT_NEAR(made.contact.stiffness, own.contact.stiffness, 0.1 * own.contact.stiffness);
  EXPECT_NEAR(made.drive.stop_stiffness, own.drive.stop_stiffness, 0.1 * own.drive.stop_stiffness);
}

// A1 with inverted knee ranges of the hind legs, like in many robots.
TEST_F(QuadrupedProposalTest, KneesFollowTheirRanges) {
  std::string urdf = ReadUrdf("a1");
  const std::size_t hind = urdf.find("<joint name=\"RL_calf_joint\"");
  urdf.replace(hind, std::string::npos,
               Replaced(urdf.substr(hind), "lower=\"-2.6965\" upper=\"-0.9163\"",
                        "lower=\"0.9163\" upper=\"2.6965\""));
  const QuadrupedDescription robot = Load(Propose(urdf));
  EXPECT_LT(robot.stance[2], 0);
  EXPECT_GT(robot.stance[3 * kRearLeft + 2], 0);
  EXPECT_NEAR(robot.FootPosition(kRearLeft, robot.stance).x(), robot.HipPosition(kRearLeft, robot.stance).x(),
              1e-3);
}

// A1 with thighs 3 cm beside the axes of the abduction, which a trunk that rolls reaches at 0.25 rad. The
// axes of the right legs point forward or backward.
TEST_F(QuadrupedProposalTest, TurnsLegsOutwardsThatWouldTouchTheTrunk) {
  const std::string urdf = ReadUrdf("a1");
  std::string narrow = Replaced(urdf, "0\\.0838", "0.03");
  EXPECT_EQ(Load(Propose(urdf)).stance[0], 0);
  for (const bool reversed : {false, true}) {
    for (const char* joint : {"FR_hip_joint", "RR_hip_joint"})
      if (reversed) narrow.replace(narrow.find("1 0 0", narrow.find(joint)), 5, "-1 0 0");
    const QuadrupedProposal proposal = Propose(narrow);
    EXPECT_THAT(proposal.yaml, HasSubstr("turned outwards"));
    const QuadrupedDescription robot = Load(proposal);
    LeggedState rolled{.q = robot.stance};
    for (int leg = 0; leg < kNumLegs; ++leg) {
      const double splay = (robot.FootPosition(leg, robot.stance) - robot.HipPosition(leg, robot.stance)).y();
      EXPECT_GT(IsLeft(leg) ? splay : -splay, 0.02) << leg;
      rolled.q[3 * leg] += 0.5 * robot.joint(3 * leg).axis.x();
    }
    EXPECT_GT(QuadrupedClearance(robot, {}).At(rolled).trunk.distance, -1e-3);
  }
}

TEST_F(QuadrupedProposalTest, GuessesMissingLimitsWithANote) {
  const QuadrupedProposal proposal = Propose(
      Replaced(Replaced(ReadUrdf("a1"), "<limit [^/]*/>", ""), "type=\"revolute\"", "type=\"continuous\""));
  EXPECT_THAT(proposal.notes, Contains(HasSubstr("knee")));
  EXPECT_NEAR(Load(proposal).joint(2).torque_limit, 0.5 * 9.81 * 12.776 * 0.4, 1);
  // A revolute joint must have a range too.
  EXPECT_THAT(Propose(Replaced(ReadUrdf("a1"), "<limit [^/]*/>", "")).yaml,
              HasSubstr("range_rad: [-3.1416, 3.1416]"));
}

TEST_F(QuadrupedProposalTest, LocksJointsThatBelongToNoLeg) {
  const std::string arm =
      "<link name=\"arm\"/><joint name=\"shoulder\" type=\"continuous\"><parent link=\"trunk\"/>"
      "<child link=\"arm\"/><axis xyz=\"0 0 1\"/></joint></robot>";
  const QuadrupedProposal proposal = Propose(Replaced(ReadUrdf("a1"), "</robot>", arm));
  EXPECT_THAT(proposal.notes, Contains(HasSubstr("'shoulder'")));
  EXPECT_NEAR(Load(proposal).mass(), 12.776, 1e-9);
}

TEST_F(QuadrupedProposalTest, TakesTheSphereOfTheCollisionShape) {
  const std::string sphere =
      "$1<collision><origin xyz=\"0 0 0.01\"/><geometry><sphere radius=\"0.02\"/></geometry></collision>";
  const QuadrupedDescription robot =
      Load(Propose(Replaced(ReadUrdf("a1"), "(<link name=\".._foot\">)", sphere)));
  EXPECT_EQ(robot.foot_radius, 0.02);
  EXPECT_THAT(robot.legs[0].foot_J, IsNear(Eigen::Vector3d(0, 0, -0.19), 1e-12));
}

TEST_F(QuadrupedProposalTest, RefusesOtherRobots) {
  const auto refused = [&](const std::string& urdf, auto... parts) {
    return Throws<ParameterError>([&] { Propose(urdf); }, "robot.urdf", parts...);
  };
  EXPECT_TRUE(refused(
      Replaced(ReadUrdf("a1"), "\"FL_calf_joint\" type=\"revolute\"", "\"FL_calf_joint\" type=\"fixed\""),
      "FL_hip_joint - FL_thigh_joint (2)", "--lock"));
  EXPECT_TRUE(
      refused(Replaced(ReadUrdf("a1"), "<axis xyz=\"1 0 0\"/>", "<axis xyz=\"0 0 1\"/>"), "'FL_hip_joint'"));
  EXPECT_TRUE(refused(Replaced(Replaced(ReadUrdf("a1"), "<origin xyz=\"0 0 -0.2\"/>", ""),
                               "xyz=\"0 0.0838 0\"", "xyz=\"0 0.0838 -0.1\""),
                      "FL_hip_joint - FL_thigh_joint - FL_calf_joint"));
  EXPECT_TRUE(refused("<robot name=\"x\" xmlns:xacro=\"http://x\"><xacro:leg name=\"a\"/></robot>", "xacro ",
                      "robot_2.urdf"));
}

/// A1 with another root link, to which its trunk is fixed by `joint`.
std::string BelowRoot(const std::string& joint) {
  return Replaced(Replaced(ReadUrdf("a1"), "\"base\"", "\"inner\""), "</robot>",
                  "<link name=\"outer\"/><joint name=\"root\" " + joint +
                      "<parent link=\"outer\"/><child link=\"inner\"/></joint></robot>");
}
void ExpectLikeA1(const QuadrupedDescription& robot) {
  const QuadrupedDescription a1 = LoadQuadruped(std::string(TENON_ROBOTS_DIR) + "/a1.yaml");
  EXPECT_NEAR(robot.mass(), a1.mass(), 1e-12);
  for (int leg = 0; leg < kNumLegs; ++leg)
    EXPECT_THAT(robot.FootPosition(leg, a1.stance), IsNear(a1.FootPosition(leg, a1.stance), 1e-9)) << leg;
}

TEST_F(QuadrupedProposalTest, FindsTheAxesOfTheRobot) {
  ExpectLikeA1(Load(Propose(BelowRoot("type=\"floating\">"))));
  const QuadrupedProposal sideways =
      Propose(BelowRoot("type=\"fixed\"><origin rpy=\"0 0 1.5707963267948966\"/>"));
  EXPECT_THAT(sideways.notes, Contains(HasSubstr("robot faces is the axis 'y' of 'outer'")));
  ExpectLikeA1(Load(sideways));
  const QuadrupedProposal backward =
      Propose(BelowRoot("type=\"fixed\"><origin rpy=\"0 0 3.141592653589793\"/>"));
  EXPECT_THAT(backward.yaml, HasSubstr("forward: \"-x\""));
  ExpectLikeA1(Load(backward));
  const QuadrupedProposal upright =
      Propose(BelowRoot("type=\"fixed\"><origin rpy=\"-1.5707963267948966 0 0\"/>"));
  EXPECT_THAT(upright.yaml, HasSubstr("up: \"y\""));
  ExpectLikeA1(Load(upright));
  const QuadrupedProposal raised = Propose(BelowRoot("type=\"fixed\"><origin xyz=\"0 0 0.5\"/>"));
  EXPECT_THAT(raised.yaml, HasSubstr("trunk_link: trunk"));
  ExpectLikeA1(Load(raised));
}

/// Returns the URDF of the same robot with random zero angles of the legs' joints, below a root link in whose
/// frame it faces along `forward` and `up` points up.
std::string Turned(std::string urdf, RandomStream& random, LinkAxis forward, LinkAxis up) {
  const std::regex joint(
      R"re((type="(?:revolute|continuous)">\s*<parent[^>]*>\s*<child[^>]*>\s*<origin xyz="[^"]*")(/>\s*<axis xyz="([^"]*)"/>\s*<limit )(?:lower="([^"]*)" upper="([^"]*)")?)re");
  std::string turned;
  std::smatch found;
  for (; std::regex_search(urdf, found, joint); urdf = found.suffix()) {
    std::stringstream words(found[3]);
    Eigen::Vector3d axis;
    words >> axis[0] >> axis[1] >> axis[2];
    const double zero = random.Uniform(-3, 3);
    turned += fmt::format("{}{} rpy=\"{} {} {}\"{}", found.prefix().str(), found[1].str(), zero * axis[0],
                          zero * axis[1], zero * axis[2], found[2].str());
    if (found[4].matched)
      turned +=
          fmt::format("lower=\"{}\" upper=\"{}\"", std::stod(found[4]) - zero, std::stod(found[5]) - zero);
  }
  turned += urdf;
  EXPECT_TRUE(std::regex_search(turned, found, std::regex("<link name=\"([^\"]*)\"")));
  const Eigen::Vector3d ypr = internal::RotationOf(forward, up).eulerAngles(2, 1, 0);
  return Replaced(
      turned, "</robot>",
      fmt::format("<link name=\"root\"/><joint name=\"root\" type=\"fixed\"><parent link=\"root\"/>"
                  "<child link=\"{}\"/><origin rpy=\"{} {} {}\"/></joint></robot>",
                  found[1].str(), ypr[2], ypr[1], ypr[0]));
}

/// The CoM of a robot in its frame.
Eigen::Vector3d CenterOfMass(const QuadrupedDescription& robot, const Vec<kNumJoints>& q) {
  Eigen::Vector3d moment = robot.trunk.mass * robot.trunk.com;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const LegPose pose = robot.PoseOfLeg(leg, q);
    for (std::size_t i = 0; i < kJointsPerLeg; ++i) {
      const RigidInertia& body = robot.legs[static_cast<std::size_t>(leg)].bodies[i];
      moment += body.mass * (pose.p_BJ[i] + pose.R_BJ[i] * body.com);
    }
  }
  return moment / robot.mass();
}

// A zero pose is a convention of the file: it changes neither the axes, nor the legs, nor the stance.
TEST_F(QuadrupedProposalTest, IsTheSameRobotForAnyZeroPose) {
  RandomStream random(71);
  int seen = 0;
  for (const char* name : {"a1", "go2", "aliengo", "b2"}) {
    const QuadrupedDescription plain = Load(Propose(ReadUrdf(name)));
    for (int trial = seen++; trial < 24; trial += 4) {
      const auto forward = static_cast<LinkAxis>(trial % 6);
      auto up = LinkAxis::kZ;
      UrdfLegsOptions options;
      if (trial >= 12 || trial % 3 == 2) {  // nothing but an option says where up is
        up = static_cast<LinkAxis>((trial + 1 + trial / 6 % 2) % 6);
        options.up = up;
      }
      const QuadrupedDescription robot = Load(Propose(Turned(ReadUrdf(name), random, forward, up), options));
      EXPECT_NEAR(robot.mass(), plain.mass(), 1e-9);
      Vec<kNumJoints> moved = Vec<kNumJoints>::Zero();
      for (int pose = 0; pose < 2; ++pose) {  // in the stance, and beside it
        const Vec<kNumJoints> q = robot.stance + moved, q_plain = plain.stance + moved;
        EXPECT_THAT(CenterOfMass(robot, q), IsNear(CenterOfMass(plain, q_plain), 1e-9)) << name << trial;
        for (int leg = 0; leg < kNumLegs; ++leg)
          EXPECT_THAT(robot.FootPosition(leg, q), IsNear(plain.FootPosition(leg, q_plain), 1e-9))
              << name << trial;
        for (double& angle : moved) angle = random.Uniform(-1, 1);
      }
      for (int j = 0; j < kNumJoints; ++j)
        if (std::isfinite(plain.joint(j).upper))
          EXPECT_NEAR(robot.joint(j).upper - robot.stance[j], plain.joint(j).upper - plain.stance[j], 1e-9);
    }
  }
}

TEST_F(QuadrupedProposalTest, NotesNamesThatContradictTheirPlaces) {
  const std::string swapped =
      Replaced(Replaced(Replaced(ReadUrdf("a1"), "FL_", "XX_"), "FR_", "FL_"), "XX_", "FR_");
  EXPECT_THAT(Propose(swapped).notes, Contains(HasSubstr("contradict")));
  for (const std::string& note : Propose(ReadUrdf("a1")).notes)
    EXPECT_THAT(note, Not(HasSubstr("contradict")));
}

TEST_F(QuadrupedProposalTest, TreatsPlaceholdersAsMissing) {
  const QuadrupedProposal slow = Propose(Replaced(ReadUrdf("a1"), "velocity=\"21\"", "velocity=\"1.5\""));
  EXPECT_THAT(slow.notes, Contains(HasSubstrs("knee", "1.5 rad/s")));
  EXPECT_EQ(Load(slow).joint(2).torque_limit, 33.5);
  EXPECT_GT(Load(slow).joint(2).speed_limit, 10);
  const QuadrupedProposal strong = Propose(Replaced(ReadUrdf("a1"), "effort=\"33.5\"", "effort=\"1000\""));
  EXPECT_THAT(strong.notes, Contains(HasSubstrs("hip_pitch", "1000 N m")));
  EXPECT_LT(Load(strong).joint(1).torque_limit, 30);
  const std::string round = Replaced(ReadUrdf("a1"), "i([xyz])\\1=\"[^\"]*\"", "i$1$1=\"1\"");
  EXPECT_THAT(Propose(round).notes, Contains(HasSubstrs("'trunk'", "gyration")));
  EXPECT_LT(Load(Propose(round)).legs[0].bodies[1].inertia.trace(), 0.03);
  const std::string none = Replaced(ReadUrdf("a1"), "i[xyz]{2}=\"[^\"]*\"", "");
  EXPECT_TRUE(Throws<ParameterError>([&] { Propose(none); }, "robot.urdf", "ixx"));
}

TEST_F(QuadrupedProposalTest, GuessesFeetThatNothingShows) {
  const std::string bare =
      Replaced(ReadUrdf("a1"), "(_foot_fixed|_foot_joint)?\" type=\"fixed\">\\s*<parent link=\"(..)_calf\"/>",
               "$1\" type=\"fixed\"><parent link=\"trunk\"/>");
  const QuadrupedProposal proposal = Propose(bare);
  EXPECT_THAT(proposal.notes, Contains(HasSubstr("guessed as far from the knee")));
  EXPECT_NEAR(Load(proposal).legs[0].foot_J.norm(), 0.2, 1e-6);
}

TEST_F(QuadrupedProposalTest, SaysWhatIsNoQuadruped) {
  const auto refused = [&](const std::string& urdf, auto... parts) {
    return Throws<ParameterError>([&] { Propose(urdf); }, "robot.urdf", parts...);
  };
  EXPECT_TRUE(refused("<mujoco/>", "MJCF"));
  EXPECT_TRUE(refused("solid mesh\n", "not XML"));
  EXPECT_TRUE(refused("<sdf/>", "SDF"));
  EXPECT_TRUE(refused("<!DOCTYPE robot [<!ENTITY a \"b\">]><robot name=\"x\"/>", "DOCTYPE"));
  EXPECT_TRUE(refused(std::string("\xff\xfe<\0r\0", 6), "UTF-16"));
  const std::string two = Replaced(ReadUrdf("a1"), "(.._calf_joint\" type=)\"revolute\"", "$1\"fixed\"");
  EXPECT_TRUE(refused(two, "four legs of two joints"));
  EXPECT_TRUE(refused(Replaced(two, "(<joint name=\".._calf_joint\" type=)\"fixed\"", "$1\"prismatic\""),
                      "prismatic knee"));
  EXPECT_TRUE(refused(Replaced(ReadUrdf("a1"), "(\"FL_.*_joint\" type=)\"revolute\"", "$1\"fixed\""),
                      "three legs of three joints"));
  EXPECT_TRUE(refused(
      Replaced(ReadUrdf("a1"), "(<parent link=\".._thigh\"/>)", "<mimic joint=\"FL_thigh_joint\"/>$1"),
      "<mimic>"));
  EXPECT_TRUE(refused(Replaced(ReadUrdf("a1"), "</robot>",
                               "<joint name=\"rod\" type=\"fixed\"><parent link=\"FL_hip\"/><child "
                               "link=\"FL_calf\"/></joint></robot>"),
                      "loop", "'rod'"));
  EXPECT_TRUE(refused(Replaced(ReadUrdf("a1"), "<mass value=\"0\\.(595|888)\"/>", "<mass value=\"0\"/>"),
                      "'FL_hip'; 'FL_thigh'; 'FR_hip'"));
}

/// A1 with a wheel of 0.1 m beside each foot.
std::string WithWheels() {
  return Replaced(
      Replaced(ReadUrdf("a1"), "(type=)\"fixed\"(>\\s*<parent link=\".._calf\"/>)",
               "$1\"continuous\"$2<axis xyz=\"0 1 0\"/>"),
      "(<link name=\".._foot\">)",
      "$1<collision><origin xyz=\"0 0.045 0\" rpy=\"1.5707963267948966 0 0\"/><geometry><cylinder "
      "radius=\"0.1\" length=\"0.05\"/></geometry></collision>");
}

// The remedy of a message works.
TEST_F(QuadrupedProposalTest, LocksWheelsAsItsMessageSays) {
  std::string message;
  try {
    Propose(WithWheels());
  } catch (const ParameterError& error) {
    message = error.what();
  }
  EXPECT_THAT(message, HasSubstr("four legs of four joints"));
  UrdfLegsOptions options;
  std::smatch found;
  for (; std::regex_search(message, found, std::regex("--lock ([^=]*)=([^ ]*)")); message = found.suffix())
    options.locked[found[1]] = std::stod(found[2]);
  const QuadrupedDescription robot = Load(Propose(WithWheels(), options));
  EXPECT_EQ(robot.foot_radius, 0.1);
  EXPECT_THAT(robot.legs[0].foot_J, IsNear(Eigen::Vector3d(0, 0.045, -0.2), 1e-9));
}

// A spine between front and rear legs, and a gripper that slides, are locked within their ranges.
TEST_F(QuadrupedProposalTest, LocksSpinesAndGrippers) {
  const std::string urdf = Replaced(
      Replaced(ReadUrdf("a1"), "<parent link=\"trunk\"/>(\\s*<child link=\"R)", "<parent link=\"rear\"/>$1"),
      "</robot>",
      "<link name=\"rear\"/><joint name=\"spine\" type=\"continuous\"><parent link=\"trunk\"/><child "
      "link=\"rear\"/><axis xyz=\"0 0 1\"/></joint>"
      "<link name=\"finger\"><inertial><mass value=\"1\"/><inertia ixx=\"1e-3\" ixy=\"0\" ixz=\"0\" "
      "iyy=\"1e-3\" "
      "iyz=\"0\" izz=\"1e-3\"/></inertial></link><joint name=\"gripper\" type=\"prismatic\"><parent "
      "link=\"trunk\"/>"
      "<child link=\"finger\"/><axis xyz=\"0 1 0\"/><limit lower=\"0.1\" upper=\"0.2\"/></joint></robot>");
  const QuadrupedProposal proposal = Propose(urdf);
  EXPECT_THAT(proposal.notes, Contains(HasSubstr("--lock spine=")));
  EXPECT_THAT(proposal.yaml, HasSubstr("{joint: gripper, position_m: 0.1}"));
  const QuadrupedDescription robot = Load(proposal), a1 = Load(Propose(ReadUrdf("a1")));
  EXPECT_NEAR(robot.mass(), a1.mass() + 1, 1e-12);
  EXPECT_THAT(robot.trunk.mass * robot.trunk.com - a1.trunk.mass * a1.trunk.com,
              IsNear(Eigen::Vector3d(0, 0.1, 0), 1e-12));
  EXPECT_EQ(robot.stance, a1.stance);
}

TEST_F(QuadrupedProposalTest, NotesATrunkBelowTheHips) {
  EXPECT_THAT(Propose(Replaced(ReadUrdf("a1"), "0 0.0041 -0.0005", "0 0.0041 -0.5")).notes,
              Contains(HasSubstrs("'trunk'", "0.5 m below the hips")));
}

TEST_F(QuadrupedProposalTest, ChecksTheAxesThatAreGiven) {
  const auto refused = [&](const UrdfLegsOptions& options, auto... parts) {
    return Throws<ParameterError>([&] { Propose(ReadUrdf("a1"), options); }, "robot.urdf", parts...);
  };
  EXPECT_TRUE(refused({.forward = LinkAxis::kY}, "--forward y", "x or -x"));
  EXPECT_TRUE(refused({.up = LinkAxis::kX}, "--up x", "another axis"));
}

// Elements of simulators are not part of the robot.
TEST_F(QuadrupedProposalTest, SkipsElementsOfSimulators) {
  ExpectLikeA1(
      Load(Propose(Replaced(ReadUrdf("a1"), "</robot>",
                            "<gazebo><link name=\"x\"><inertial/></link><limit effort=\"many\"/></gazebo>"
                            "</robot>"))));
}

}  // namespace tenon::quadruped_proposal_test
