// Poses of a cable robot per second on one core, with kinematics, structure matrix, facets and margins of
// each pose; and cells per second, with a proof over the whole cell.

#include <tenon/controllers/cdpr/cdpr_workspace.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>

#include <benchmark/benchmark.h>

#include <random>

namespace tenon {
namespace {

std::vector<Eigen::Vector3d> Places() {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-2, 2);
  std::vector<Eigen::Vector3d> places;
  for (int i = 0; i < 1000; ++i)
    places.emplace_back(uniform(random), uniform(random), 2 + uniform(random) / 2);
  return places;
}

void Margins(benchmark::State& state, const std::string& name) {
  const CdprDescription robot = LoadCdpr(FindResource("robots", name));
  PoseFeasibility feasibility(robot, RequiredWrenches(robot, {.load = 10, .acceleration = 1}));
  const std::vector<Eigen::Vector3d> places = Places();
  std::size_t i = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(feasibility.At(places[i++ % places.size()], Eigen::Matrix3d::Identity()));
  state.SetItemsProcessed(state.iterations());
}

void Proofs(benchmark::State& state, const std::string& name) {
  const CdprDescription robot = LoadCdpr(FindResource("robots", name));
  PoseFeasibility feasibility(robot, RequiredWrenches(robot, {}));
  const std::vector<Eigen::Vector3d> places = Places();
  std::size_t i = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(feasibility.Over({.p_WB = places[i++ % places.size()], .distance = 0.05}));
  state.SetItemsProcessed(state.iterations());
}

BENCHMARK_CAPTURE(Margins, cdpr_6, "cdpr_6");
BENCHMARK_CAPTURE(Margins, cogiro, "cogiro");
BENCHMARK_CAPTURE(Margins, ipanema_3, "ipanema_3");
BENCHMARK_CAPTURE(Margins, c4, "c4");
BENCHMARK_CAPTURE(Proofs, cogiro, "cogiro");
BENCHMARK_CAPTURE(Proofs, ipanema_3, "ipanema_3");

}  // namespace
}  // namespace tenon
