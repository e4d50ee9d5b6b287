#include <tenon/controllers/guide_dog/reference_admittance.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::reference_admittance_test {

class ReferenceAdmittanceTest : public ::testing::Test {
 protected:
  void Pull(double tension) {
    rig_.Fix(block_.body, body_).Fix(block_.wrench, WrenchEstimate{.force_W = tension * -forward_});
  }
  static ReferenceAdmittanceGains Gains() {
    ReferenceAdmittanceGains gains;
    gains.damping[0] = 2 * std::sqrt(gains.mass[0] * gains.stiffness[0]);  // critical
    return gains;
  }
  const double yaw_ = 0.7;
  const Vec<3> forward_{std::cos(yaw_), std::sin(yaw_), 0};
  BodyReference body_ = [this] {
    BodyReference body;
    body.com_W << 1, 2, 0.5;
    body.q_WB = QuaternionFromEuler({0, 0, yaw_});
    return body;
  }();
  TestRig<ReferenceAdmittance> rig_{Gains()};
  const ReferenceAdmittance& block_ = rig_.system();
};

TEST_F(ReferenceAdmittanceTest, TheDesiredForceChangesNothing) {
  Pull(30);
  EXPECT_THAT(rig_.RunTo(1)[block_.modified].com_W, IsNear(body_.com_W, 1e-12));
}

// The critically damped response to a step of 20 N: x = F / K (1 - (1 + w t) e^(-w t)).
TEST_F(ReferenceAdmittanceTest, LagsBehindWhileTheLeashPullsMore) {
  Pull(50);
  const double w = std::sqrt(1000.0 / 8);
  for (double t : {0.05, 0.2, 3.0}) {
    const BodyReference now = rig_.RunTo(t)[block_.modified];
    const double e = std::exp(-w * t), x = -0.02 * (1 - (1 + w * t) * e);
    EXPECT_THAT(now.com_W, IsNear(Vec<3>(body_.com_W + x * forward_), 1e-5)) << t;
    EXPECT_THAT(now.com_velocity_W, IsNear(Vec<3>(-0.02 * w * w * t * e * forward_), 1e-4)) << t;
    EXPECT_THAT(now.com_acceleration_W, IsNear(Vec<3>(-0.02 * w * w * (1 - w * t) * e * forward_), 1e-3))
        << t;
  }
}

// Matrices of the thesis: an axis of its own for each entry.
TEST_F(ReferenceAdmittanceTest, AxesHaveGainsOfTheirOwn) {
  ReferenceAdmittanceGains gains = Gains();
  gains.stiffness << 500, 2000, 4000;
  rig_.Set(block_.gains, gains);
  const Vec<3> left(-forward_[1], forward_[0], 0);
  rig_.Fix(block_.body, body_)
      .Fix(block_.wrench, WrenchEstimate{.force_W = -30 * forward_ + 10 * left + Vec<3>(0, 0, 8)});
  EXPECT_THAT(rig_.RunTo(5)[block_.x], IsNear((Vec<6>() << 0, 0.005, 0.002, 0, 0, 0).finished(), 1e-6));
  EXPECT_TRUE(Refuses<ReferenceAdmittance>(
      [] {
        ReferenceAdmittanceGains wrong;
        wrong.mass[1] = 0;
        return wrong;
      }(),
      "mass"));
}

}  // namespace tenon::reference_admittance_test
