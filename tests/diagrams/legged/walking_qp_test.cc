// The whole-body controller's quadratic programs of a walk with the plant, with and without elimination,
// against a solver in exact arithmetic.

#include <tenon/tests/controllers/legged/whole_body/full_whole_body_qp.h>
#include <tenon/tests/controllers/optimization/exact_qp.h>
#include <tenon/tests/diagrams/legged/trot_recording.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::walking_qp_test {

TEST(WalkingQp, AgreesWithExactArithmetic) {
  const test::TrotLoop trot;
  const WholeBodyController& controller = trot.loop->locomotion.whole_body;
  WholeBodyQpParams params = controller.params.gains.qp;
  params.friction = 0.08;  // brings feet to the edges of their pyramids
  const Vec<12> limit = WholeBodyController::TorqueLimit(controller.params.robot);
  WholeBodyQp qp(limit);
  DualActiveSet full_solver = test::FullWholeBodySolver();
  WholeBodySolution solution;
  int solved = 0, swinging = 0, with_active = 0;
  const std::vector<test::TrotTick> ticks = test::RecordTrot(trot, 3);
  for (std::size_t n = 1000; n < ticks.size(); n += 39) {
    const auto [dynamics, task] = test::MakeTask(controller, ticks[n]);
    const auto expect_exact = [&](const QuadraticProgram& problem, const DualActiveSet& solver,
                                  const QpReport& report) {
      const auto exact = test::SolveExactly(problem);
      ASSERT_EQ(report.ok(), exact.has_value()) << "tick " << n << ": " << report.Message();
      if (!exact) return;
      EXPECT_TRUE(test::IsOptimal(problem, solver)) << n;
      EXPECT_THAT(solver.x(), IsNear(*exact, 1e-8 * (1 + exact->norm()))) << "tick " << n;
      with_active += !solver.active().empty();
    };
    const QpReport report = qp.Solve(dynamics, task, params, &solution);
    expect_exact(qp.problem(), qp.solver(), report);
    const test::OwnedQp full = test::FullWholeBodyQp(dynamics, task, params, limit);
    expect_exact(full.view(), full_solver, full_solver.Solve(full.view(), qp.solver().active()));
    ++solved;
    swinging += !task.stance[kFrontLeft] || !task.stance[kFrontRight];
  }
  EXPECT_GE(solved, 50);
  EXPECT_GT(swinging, 10);
  EXPECT_GT(with_active, 20);
}

}  // namespace tenon::walking_qp_test
