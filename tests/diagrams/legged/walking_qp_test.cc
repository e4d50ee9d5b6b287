// The quadratic programmes of the whole-body controller in a walk, against a solver in exact arithmetic.

#include <tenon/controllers/legged/whole_body/whole_body_qp.h>
#include <tenon/tests/controllers/optimization/exact_qp.h>
#include <tenon/tests/controllers/optimization/qp_certificate.h>
#include <tenon/tests/diagrams/legged/trot_recording.h>
#include <tenon/tests/testing/matchers.h>

#include <gtest/gtest.h>

namespace tenon::walking_qp_test {
namespace {

TEST(WalkingQp, AgreesWithExactArithmetic) {
  const test::TrotLoop trot;
  const WholeBodyController& controller = trot.loop->locomotion.whole_body;
  WholeBodyQpParams reduced = controller.params.gains.qp, full = reduced;
  // With little friction the pyramid constraints are active.
  reduced.friction = full.friction = 0.08;
  full.eliminate = false;
  const Vec<12> limit = WholeBodyController::TorqueLimit(controller.params.robot);
  WholeBodyQp in_twelve(limit), in_thirty(limit);
  WholeBodySolution solution;
  int solved = 0, swinging = 0, with_active = 0;
  const std::vector<test::TrotTick> ticks = test::RecordTrot(trot, 3);
  for (std::size_t n = 1000; n < ticks.size(); n += 39) {
    const auto [dynamics, task] = test::MakeTask(controller, ticks[n]);
    for (WholeBodyQp* qp : {&in_twelve, &in_thirty}) {
      const WholeBodyQpParams& params = qp == &in_twelve ? reduced : full;
      const QpReport report = qp->Solve(dynamics, task, params, &solution);
      const auto exact = test::SolveExactly(qp->problem());
      ASSERT_EQ(report.ok(), exact.has_value()) << "tick " << n << ": " << report.Message();
      if (!exact) continue;
      EXPECT_TRUE(test::IsOptimal(qp->problem(), qp->solver())) << n;
      EXPECT_THAT(qp->solver().x(), IsNear(*exact, 1e-8 * (1 + exact->norm()))) << "tick " << n;
      with_active += solution.num_active > 0;
    }
    EXPECT_TRUE(in_twelve.eliminated());
    ++solved;
    swinging += !task.stance[kFrontLeft] || !task.stance[kFrontRight];
  }
  EXPECT_GE(solved, 50);
  EXPECT_GT(swinging, 10);
  EXPECT_GT(with_active, 20);
}

}  // namespace
}  // namespace tenon::walking_qp_test
