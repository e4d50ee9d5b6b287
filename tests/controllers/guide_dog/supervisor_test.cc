#include <tenon/controllers/guide_dog/supervisor.h>
#include <tenon/tests/testing/block_test.h>

#include <numbers>

namespace tenon::supervisor_test {

using enum GuideMode;

const WalkCommand kTrot{.gait = Gait::kTrot, .forward = 0.12, .left = 0, .yaw_rate = 0.05};

double Radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

class Dog {
 public:
  explicit Dog(const SupervisorGains& gains = {}) : rig_(SupervisorParams{gains}) {
    Command(kTrot);
    Pull(30, Radians(180));
    Head(0);
  }
  void Command(const WalkCommand& command) { rig_.Fix(rig_->command, command); }
  /// A horizontal force on the robot, plus a vertical force that an observer may estimate.
  void Pull(double force, double yaw) {
    force_ = force * Vec<3>(std::cos(yaw), std::sin(yaw), 0) + Vec<3>(0, 0, -60);
    Feel(force_);
  }
  void Head(double yaw, double speed = 0) {
    rig_.Fix(rig_->state, {.q_WB = QuaternionFromRotationVector({0, 0, yaw}),
                           .v_W = speed * Vec<3>(std::cos(yaw), std::sin(yaw), 0)});
  }
  void Obstacle(bool there) { rig_.Fix(rig_->obstacle, there); }
  GuideMode Tick() { return rig_.Tick()[rig_->status].mode; }
  GuideMode Run(double seconds) {
    for (int n = 1; n < std::lround(100 * seconds); ++n) Tick();
    return Tick();
  }
  /// The mode after it has run with noise on the force, as through an observer of 20 rad/s; counts the
  /// changes.
  GuideMode RunNoisy(double seconds, double deviation, RandomStream& random, int* changes) {
    const double keep = std::exp(-0.2), gain = std::sqrt(1 - keep * keep);
    Vec<3> noise = Vec<3>::Zero();
    GuideMode mode = status().mode;
    for (int n = 0; n < std::lround(100 * seconds); ++n) {
      for (int i = 0; i < 3; ++i) noise[i] = keep * noise[i] + gain * deviation * random.Normal();
      Feel(force_ + noise);
      if (const GuideMode next = Tick(); next != mode) ++*changes, mode = next;
    }
    return mode;
  }
  /// Lets the robot stand, with the leash slack and the next pull free to count.
  void StandStill() {
    Pull(60, Radians(180));
    Run(1.2);
    Pull(0, 0);
    ASSERT_EQ(Run(1), kStop);
  }
  const GuideStatus& status() { return rig_[rig_->status]; }
  const WalkCommand& walk() { return rig_[rig_->walk]; }
  TestRig<Supervisor>& rig() { return rig_; }

 private:
  void Feel(const Vec<3>& force) { rig_.Fix(rig_->wrench, {force, Vec<3>::Zero()}); }
  TestRig<Supervisor> rig_;
  Vec<3> force_;
};

// All modes and all combinations of events against the table of the header, row by row.
TEST(NextGuideModeTest, IsTheTable) {
  struct Row {
    GuideMode from;
    bool GuideEvents::*event;
    GuideMode to;
  };
  const Row table[] = {{kMove, &GuideEvents::pulled, kStop},  {kMove, &GuideEvents::obstacle, kStop},
                       {kTurn, &GuideEvents::pulled, kStop},  {kTurn, &GuideEvents::new_obstacle, kStop},
                       {kTurn, &GuideEvents::aligned, kMove}, {kStop, &GuideEvents::pulled, kTurn}};
  for (const GuideMode from : {kMove, kTurn, kStop}) {
    for (int bits = 0; bits < 16; ++bits) {
      const GuideEvents events{(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0, (bits & 8) != 0};
      GuideMode expected = from;
      for (const Row& row : table) {
        if (row.from != from || !(events.*row.event)) continue;
        expected = row.to;
        break;
      }
      EXPECT_EQ(NextGuideMode(from, events), expected) << static_cast<int>(from) << " " << bits;
    }
  }
}

TEST(SupervisorTest, LetsTheCommandPassBelowTheThreshold) {
  Dog dog;
  dog.Pull(49.9, 2);
  EXPECT_EQ(dog.Run(30), kMove);
  EXPECT_EQ(dog.walk().gait, Gait::kTrot);
  EXPECT_EQ(dog.walk().forward, 0.12);
  EXPECT_EQ(dog.walk().yaw_rate, 0.05);
  dog.Command({});
  dog.Tick();
  EXPECT_EQ(dog.walk().gait, Gait::kStand);
}

TEST(SupervisorTest, StopsWhenThePersonDoes) {
  Dog dog;
  dog.Run(2);
  dog.Pull(50.1, Radians(180));
  EXPECT_EQ(dog.Run(0.09), kMove);
  EXPECT_EQ(dog.Tick(), kStop);
  EXPECT_EQ(dog.walk().gait, Gait::kStand);
  EXPECT_EQ(dog.walk().forward, 0);
  EXPECT_EQ(dog.walk().yaw_rate, 0);
}

// The robot walks at 0.8 m/s; the person slows down with 1.3 m/s^2, so that the tension rises above 50 N.
TEST(SupervisorTest, TellsAPersonWhoSlowsDownFromOneWhoStops) {
  const double yaw = Radians(60), stiffness = 200;
  for (const double softer : {1.0, 1.5, 1 / 1.2}) {  // the leash that the supervisor knows, over the real one
    const auto mode_after = [&](const SupervisorGains& gains, double speed) {
      Dog dog(gains);
      dog.Head(yaw, 0.8);
      double tension = 30, person = 0.8;
      dog.Pull(tension, yaw + Radians(180));
      dog.Run(2);
      for (int n = 0; n < 90; ++n) {
        person = std::max(speed, person - 0.013);
        tension += 0.01 * stiffness / softer * (0.8 - person);
        dog.Pull(tension, yaw + Radians(180));
        dog.Tick();
      }
      EXPECT_GT(tension, 55);
      return dog.status().mode;
    };
    EXPECT_EQ(mode_after({.leash_stiffness = stiffness}, 0), kStop) << softer;
    EXPECT_EQ(mode_after({.leash_stiffness = stiffness}, 0.4), kMove) << softer;
    EXPECT_EQ(mode_after({}, 0.4), kStop) << "without the person's speed";
  }
}

TEST(SupervisorTest, EstimatesThePersonsSpeed) {
  Dog dog({.leash_stiffness = 200, .speed_filter = 0.05});
  dog.Head(0, 0.8);
  for (int n = 0; n < 100; ++n) {
    dog.Pull(10 + 0.3 * n, Radians(180));  // 30 N/s: the robot is faster by 0.15 m/s
    dog.Tick();
  }
  EXPECT_NEAR(dog.rig()[dog.rig()->progress].person_speed, 0.65, 1e-6);
}

TEST(SupervisorTest, OnePullIsOneCommand) {
  Dog dog;
  dog.Run(2);
  dog.Pull(55, Radians(180));
  EXPECT_EQ(dog.Run(60), kStop) << "the leash stays taut, but that is the pull that has stopped the robot";
  dog.Pull(45, Radians(180));
  EXPECT_EQ(dog.Run(10), kStop);
  dog.Pull(55, Radians(180));
  EXPECT_EQ(dog.Run(10), kStop) << "45 N are not below the release";
  dog.Pull(39, Radians(180));
  EXPECT_EQ(dog.Run(0.1), kStop);
  dog.Pull(55, Radians(180));
  EXPECT_EQ(dog.Run(0.29), kStop);
  EXPECT_EQ(dog.Tick(), kTurn);
  EXPECT_EQ(dog.Run(10), kTurn) << "nor does the pull that has started it stop it again";
}

TEST(SupervisorTest, GoesInTheDirectionOfThePull) {
  for (int degrees = -170; degrees <= 180; degrees += 25) {
    Dog dog;
    dog.StandStill();
    dog.Pull(60, Radians(degrees));
    EXPECT_EQ(dog.Run(0.29), kStop) << degrees;
    EXPECT_EQ(dog.Tick(), kTurn) << degrees;
    EXPECT_NEAR(std::remainder(dog.status().yaw - Radians(degrees), 2 * std::numbers::pi), 0, 1e-9);
    EXPECT_EQ(dog.walk().forward, 0.12);
  }
}

TEST(SupervisorTest, TurnsTheShorterWayAndGoesOn) {
  Dog dog;
  dog.Head(Radians(170));
  dog.StandStill();
  dog.Pull(60, Radians(-100));
  EXPECT_EQ(dog.Run(0.3), kTurn);
  EXPECT_DOUBLE_EQ(dog.walk().yaw_rate, 0.3) << "90 degrees to the left, across 180";
  dog.Pull(20, Radians(-100));
  dog.Head(Radians(-90));
  dog.Tick();
  EXPECT_NEAR(dog.walk().yaw_rate, Radians(-10), 1e-12) << "turn_gain times the error";
  dog.Head(Radians(-100) + 0.0201);
  EXPECT_EQ(dog.Run(10), kTurn);
  dog.Head(Radians(-100) - 0.0199);
  EXPECT_EQ(dog.Run(0.29), kTurn);
  EXPECT_EQ(dog.Tick(), kMove);
  EXPECT_EQ(dog.walk().yaw_rate, 0.05) << "as commanded";
}

// On uneven ground the yaw of the trunk passes the new direction before the path does.
TEST(SupervisorTest, AStumbleThroughTheNewDirectionDoesNotEndTheTurn) {
  Dog dog;
  dog.StandStill();
  dog.Pull(60, Radians(90));
  EXPECT_EQ(dog.Run(0.3), kTurn);
  dog.Pull(20, Radians(90));
  for (int n = 0; n < 10; ++n) {
    dog.Head(Radians(90));
    EXPECT_EQ(dog.Run(0.1), kTurn);
    dog.Head(Radians(82));
    EXPECT_EQ(dog.Run(0.1), kTurn);
  }
  dog.Head(Radians(90));
  EXPECT_EQ(dog.Run(0.3), kMove);
}

TEST(SupervisorTest, PullsDoNotCountBeforeTheDwellIsOver) {
  Dog dog;
  dog.Obstacle(true);
  EXPECT_EQ(dog.Run(0.01), kStop) << "an obstacle counts at once";
  dog.Pull(60, 1);
  EXPECT_EQ(dog.Run(0.99), kStop);
  EXPECT_EQ(dog.Tick(), kTurn);
  EXPECT_EQ(dog.Run(0.05), kTurn);
}

TEST(SupervisorTest, TurnsAwayFromTheObstacleThatStoppedIt) {
  Dog dog;
  dog.Obstacle(true);
  dog.Pull(10, Radians(180));
  dog.Run(2);
  dog.Pull(60, Radians(90));
  EXPECT_EQ(dog.Run(0.3), kTurn);
  dog.Pull(0, 0);
  EXPECT_EQ(dog.Run(2), kTurn) << "it is still ahead";
  dog.Obstacle(false);
  EXPECT_EQ(dog.Run(1), kTurn);
  dog.Obstacle(true);
  EXPECT_EQ(dog.Tick(), kStop) << "another one";
}

TEST(SupervisorTest, AnObstacleAtTheEdgeOfSightIsNotAnotherOne) {
  Dog dog;
  dog.Obstacle(true);
  dog.Pull(10, Radians(180));
  dog.Run(2);
  dog.Obstacle(false);  // pulled back by the leash
  dog.Pull(60, Radians(90));
  EXPECT_EQ(dog.Run(0.3), kTurn);
  dog.Pull(0, 0);
  for (int n = 0; n < 4; ++n) {
    dog.Obstacle(n % 2 == 0);
    EXPECT_EQ(dog.Run(0.2), kTurn) << n;
  }
  EXPECT_EQ(dog.Run(0.8), kTurn) << "out of sight for good";
  dog.Obstacle(true);
  EXPECT_EQ(dog.Tick(), kStop) << "another one";
}

TEST(SupervisorTest, AnObstacleThatWentBeforeThePullIsForgotten) {
  Dog dog;
  dog.Pull(10, Radians(180));
  dog.Obstacle(true);
  dog.Tick();
  dog.Obstacle(false);
  EXPECT_EQ(dog.Run(5), kStop);
  dog.Pull(60, Radians(90));
  EXPECT_EQ(dog.Run(0.3), kTurn);
  dog.Obstacle(true);
  EXPECT_EQ(dog.Tick(), kStop) << "another one";
}

TEST(SupervisorTest, DoesNotRunIntoAnObstacleOnCommand) {
  Dog dog;
  dog.Obstacle(true);
  dog.Pull(10, Radians(180));
  dog.Run(2);
  dog.Pull(60, 0);
  EXPECT_EQ(dog.Run(0.3), kTurn);
  EXPECT_EQ(dog.Run(0.3), kMove);
  EXPECT_EQ(dog.Tick(), kStop);
}

TEST(SupervisorTest, NoiseNeitherStartsNorStopsIt) {
  RandomStream random(7);
  for (const double tension : {0.0, 30.0, 42.0}) {
    Dog stands, moves;
    stands.StandStill();
    stands.Pull(tension, Radians(180));
    moves.Run(2);
    int changes = 0;
    EXPECT_EQ(stands.RunNoisy(60, 4, random, &changes), kStop);
    EXPECT_EQ(moves.RunNoisy(60, 4, random, &changes), kMove);
    EXPECT_EQ(changes, 0) << tension;
  }
}

TEST(SupervisorTest, FindsTheDirectionOfAPullInNoise) {
  RandomStream random(9);
  for (int i = 0; i < 20; ++i) {
    Dog dog;
    dog.StandStill();
    dog.Pull(60, Radians(90));
    int changes = 0;
    dog.RunNoisy(1, 4, random, &changes);
    EXPECT_EQ(changes, 1);
    EXPECT_NEAR(dog.status().yaw, Radians(90), Radians(5)) << i;
  }
}

TEST(SupervisorTest, JerksDoNotStartIt) {
  Dog dog;
  dog.StandStill();
  for (int i = 0; i < 60; ++i) {
    dog.Pull(200, Radians(90));
    EXPECT_EQ(dog.Run(0.2), kStop);
    dog.Pull(20, Radians(180));
    EXPECT_EQ(dog.Run(0.8), kStop);
  }
}

TEST(SupervisorTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<Supervisor>({{.release = 51}}, "release", "threshold"));
}

TEST(SupervisorTest, ASquatGoesOnInAllModes) {
  Dog dog;
  WalkCommand squat = kTrot;
  squat.height = {0.05, 0.1, -0.2};
  dog.Command(squat);
  EXPECT_EQ(dog.Tick(), kMove);
  EXPECT_EQ(dog.walk().height, squat.height);
  dog.Pull(60, Radians(180));
  EXPECT_EQ(dog.Run(1.2), kStop);
  EXPECT_EQ(dog.walk().gait, Gait::kStand);
  EXPECT_EQ(dog.walk().height, squat.height);
  Dog stands;
  squat.gait = Gait::kStand;
  stands.Command(squat);
  EXPECT_EQ(stands.Tick(), kMove);
  EXPECT_EQ(stands.walk().height, squat.height);
}

}  // namespace tenon::supervisor_test
