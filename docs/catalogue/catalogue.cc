#include <tenon/apps/cdpr/cdpr_scenario.h>
#include <tenon/apps/guide_dog/guide_dog_scenario.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/controllers/cdpr/broken_cable_detector.h>
#include <tenon/controllers/cdpr/goal_path.h>
#include <tenon/controllers/legged/observers/ground_force_observer.h>
#include <tenon/controllers/legged/planning/walk_drive.h>
#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/diagrams/evaluation/walk_view.h>
#include <tenon/diagrams/legged/foot_forces_of_legs.h>
#include <tenon/docs/catalogue/catalogue.h>
#include <tenon/plants/cdpr/cable_fault.h>
#include <tenon/plants/cdpr/gusts.h>
#include <tenon/plants/cdpr/hanging_load.h>
#include <tenon/plants/cdpr/platform_pull.h>
#include <tenon/plants/legged/joint_lock.h>
#include <tenon/plants/legged/spring_pull.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/plants/sensors/shank_forces.h>
#include <tenon/systems/io/external_input.h>
#include <tenon/systems/network/udp.h>
#include <tenon/systems/primitives/adder.h>
#include <tenon/systems/primitives/concatenate.h>
#include <tenon/systems/primitives/constant.h>
#include <tenon/systems/primitives/discrete_derivative.h>
#include <tenon/systems/primitives/discrete_low_pass.h>
#include <tenon/systems/primitives/discrete_transfer_function.h>
#include <tenon/systems/primitives/gain.h>
#include <tenon/systems/primitives/gauss_markov.h>
#include <tenon/systems/primitives/held_lag.h>
#include <tenon/systems/primitives/integrator.h>
#include <tenon/systems/primitives/jittered_delay.h>
#include <tenon/systems/primitives/low_pass_filter.h>
#include <tenon/systems/primitives/matrix_gain.h>
#include <tenon/systems/primitives/multiport_switch.h>
#include <tenon/systems/primitives/mux.h>
#include <tenon/systems/primitives/noise.h>
#include <tenon/systems/primitives/pid.h>
#include <tenon/systems/primitives/pulse.h>
#include <tenon/systems/primitives/quantizer.h>
#include <tenon/systems/primitives/random_walk.h>
#include <tenon/systems/primitives/rate_limiter.h>
#include <tenon/systems/primitives/sample_delay.h>
#include <tenon/systems/primitives/saturation.h>
#include <tenon/systems/primitives/signal_fault.h>
#include <tenon/systems/primitives/sine.h>
#include <tenon/systems/primitives/state_space.h>
#include <tenon/systems/primitives/switch.h>
#include <tenon/systems/primitives/table.h>
#include <tenon/systems/primitives/trajectory.h>
#include <tenon/systems/primitives/transfer_function.h>
#include <tenon/systems/primitives/transport_delay.h>
#include <tenon/systems/primitives/uniform_noise.h>
#include <tenon/systems/primitives/unit_delay.h>
#include <tenon/systems/primitives/zero_order_hold.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/systems/yaml/yaml.h>

namespace tenon::docs {
namespace {

/// Stands for the template argument; no block has this size otherwise.
using T = Vec<7>;

template <class Scenario>
Scenario ReadScenario(const std::string& name) {
  return YamlDocument::Load(FindResource("scenarios", name).string()).Read<Scenario>();
}

/// Shipped robots and parameters.
struct Shipped {
  QuadrupedDescription dog = LoadQuadruped(FindResource("robots", "dogbot").string());
  apps::QuadrupedScenario flat = ReadScenario<apps::QuadrupedScenario>("flat");
  QuadrupedWalkParams walk = apps::MakeWalkParams(flat);
  std::vector<Rope> ropes{{.name = "rope", .anchor_W = {5, 0, 5}, .tension_max = 250}};
  QuadrupedStandParams stand = apps::MakeStandParams(ReadScenario<apps::QuadrupedScenario>("stand"));
  GuideDogParams guide_dog = apps::MakeGuideDogParams(ReadScenario<apps::GuideDogScenario>("C1"));
  CdprLoopParams cdpr_mpc = apps::MakeLoopParams(ReadScenario<apps::CdprScenario>("D1"));
  CdprLoopParams cdpr_pd = [this] {
    CdprLoopParams params = cdpr_mpc;
    params.mpc.reset();
    return params;
  }();
};

template <class Block, class... Params>
Entry Make(std::string name, Params&&... params) {
  return {name, name, std::make_unique<Block>(std::forward<Params>(params)...)};
}

/// Makes the entry of a class template with one type parameter.
template <class Block, class... Params>
Entry MakeOfType(const std::string& name, Params&&... params) {
  return {name + "<T>", name, std::make_unique<Block>(std::forward<Params>(params)...), {{"Vec<7>", "T"}}};
}

Entry WithNote(Entry entry, std::string note) {
  entry.note = std::move(note);
  return entry;
}

Shelf Primitives() {
  Shelf shelf{"primitives", {}};
  auto& entries = shelf.entries;
  const auto put = [&](Entry entry) { entries.push_back(std::move(entry)); };
  const std::string number = "`T` is a double or a `Vec<N>`.", any = "`T` is any copyable type.",
                    numbers = "`T` is a double, a `Vec<N>` or a struct with `Fields()`.";

  put(WithNote(MakeOfType<Adder<T>>("Adder", AdderParams{.unit = "unit"}), number));
  put({"Concatenate<Ts...>",
       "Concatenate",
       std::make_unique<Concatenate<double, double>>(),
       {{"double", "Ts"}}});
  put({"Split<Ts...>", "Split", std::make_unique<Split<double, double>>(), {{"double", "Ts"}}});
  put(WithNote(MakeOfType<ConstantSource<T>>("ConstantSource", ConstantParams<T>{.unit = "unit"}), any));
  put(WithNote(MakeOfType<DiscreteDerivative<T>>(
                   "DiscreteDerivative", DiscreteDerivativeParams{.u_unit = "u_unit", .y_unit = "y_unit"}),
               number));
  entries.back().placeholders.emplace_back("internal::FilteredDifference<Vec<7>>", "FilteredDifference<T>");
  put(WithNote(MakeOfType<DiscreteLowPass<T>>("DiscreteLowPass", DiscreteLowPassParams<T>{.unit = "unit"}),
               number));
  put(WithNote(
      Make<DiscreteTransferFunction>(
          "DiscreteTransferFunction",
          DiscreteTransferFunctionParams{.denominator = {1, 0}, .u_unit = "u_unit", .y_unit = "y_unit"}),
      "The output depends directly on u if the numerator has as many coefficients as the denominator."));
  put(WithNote(MakeOfType<Gain<T>>("Gain", GainParams{.u_unit = "u_unit", .y_unit = "y_unit"}), number));
  put(WithNote(MakeOfType<GaussMarkov<T>>("GaussMarkov", GaussMarkovParams<T>{.unit = "unit"}), number));
  const std::string sized = "`T` is a double, a `Vec<N>` or an `Eigen::VectorXd` of the size of `initial`.";
  put(WithNote(MakeOfType<HeldLag<T>>("HeldLag", HeldLagParams<T>{.unit = "unit"}), sized));
  entries.back().placeholders.emplace_back("HeldLagPart<Vec<7>>", "HeldLagPart<T>");
  put(WithNote(
      MakeOfType<Integrator<T>>("Integrator", IntegratorParams<T>{.u_unit = "u_unit", .y_unit = "y_unit"}),
      number));
  put(WithNote(MakeOfType<JitteredDelay<T>>("JitteredDelay", JitteredDelayParams<T>{.unit = "unit"}), sized));
  entries.back().placeholders.emplace_back("MessageLine<Vec<7>>", "MessageLine<T>");
  put(WithNote(MakeOfType<LowPassFilter<T>>("LowPassFilter", LowPassFilterParams<T>{.unit = "unit"}),
               number));
  put({"MatrixGain<Rows, Cols>",
       "MatrixGain",
       std::make_unique<MatrixGain<7, 5>>(MatrixGainParams<7, 5>{.u_unit = "u_unit", .y_unit = "y_unit"}),
       {{"Vec<7>", "Vec<Rows>"}, {"Vec<5>", "Vec<Cols>"}},
       "The vectors of `MatrixGain<>` are `Eigen::VectorXd`, whose sizes are those of its matrix."});
  put({"MultiportSwitch<T, Index>",
       "MultiportSwitch",
       std::make_unique<MultiportSwitch<T>>(MultiportSwitchParams{.unit = "unit"}),
       {{"Vec<7>", "T"}, {"int", "Index"}},
       any + " `Index` is an integer or an enumeration."});
  put({"Mux<N>", "Mux", std::make_unique<Mux<7>>(MuxParams{.units = "units"}), {{"Vec<7>", "Vec<N>"}}});
  put({"Demux<N>", "Demux", std::make_unique<Demux<7>>(MuxParams{.units = "units"}), {{"Vec<7>", "Vec<N>"}}});
  put(WithNote(MakeOfType<WhiteNoise<T>>("WhiteNoise", NoiseParams<T>{.unit = "unit"}), numbers));
  put(WithNote(MakeOfType<AddNoise<T>>("AddNoise", NoiseParams<T>{.unit = "unit"}), numbers));
  put(WithNote(MakeOfType<Pid<T>>("Pid", PidParams<T>{.y_unit = "y_unit", .u_unit = "u_unit"}), number));
  entries.back().placeholders.emplace_back("PidMemory<Vec<7>>", "PidMemory<T>");
  put(WithNote(MakeOfType<Pulse<T>>("Pulse", PulseParams<T>{.unit = "unit"}), number));
  put(WithNote(MakeOfType<Quantizer<T>>("Quantizer", QuantizerParams<T>{.unit = "unit"}), number));
  put(WithNote(MakeOfType<RandomWalk<T>>("RandomWalk", RandomWalkParams<T>{.unit = "unit"}), number));
  put(WithNote(MakeOfType<RateLimiter<T>>("RateLimiter", RateLimiterParams<T>{.unit = "unit"}), number));
  put(WithNote(MakeOfType<SampleDelay<T>>("SampleDelay", SampleDelayParams<T>{.unit = "unit"}),
               "`T` is any copyable type except bool."));
  entries.back().placeholders.emplace_back("std::vector<Vec<7>>", "std::vector<T>");
  put(WithNote(MakeOfType<Saturation<T>>("Saturation", SaturationParams<T>{.unit = "unit"}), number));
  put(WithNote(MakeOfType<SignalFault<T>>("SignalFault", SignalFaultParams<T>{.unit = "unit"}), any));
  put(WithNote(MakeOfType<Sine<T>>("Sine", SineParams<T>{.unit = "unit"}), number));
  const Eigen::MatrixXd one = Eigen::MatrixXd::Ones(1, 1);
  const StateSpaceParams model{
      .A = one, .B = one, .C = one, .u_unit = "u_unit", .x_unit = "x_unit", .y_unit = "y_unit"};
  const std::string with_d = "The output depends directly on u if D is given.";
  put(WithNote(Make<StateSpace>("StateSpace", model), with_d));
  put(WithNote(Make<DiscreteStateSpace>("DiscreteStateSpace", DiscreteStateSpaceParams{.model = model}),
               with_d));
  put(WithNote(MakeOfType<Switch<T>>("Switch", SwitchParams{.unit = "unit"}), any));
  put(WithNote(MakeOfType<ThresholdSwitch<T>>(
                   "ThresholdSwitch", ThresholdSwitchParams{.control_unit = "control_unit", .unit = "unit"}),
               any));
  const std::vector<T> two_values{T::Zero(), T::Ones()};
  put(WithNote(
      MakeOfType<Table<T>>(
          "Table", TableParams<T>{.u = {0, 1}, .y = two_values, .u_unit = "u_unit", .y_unit = "y_unit"}),
      number));
  put(WithNote(MakeOfType<Trajectory<T>>(
                   "Trajectory", TrajectoryParams<T>{.times = {0, 1}, .values = two_values, .unit = "unit"}),
               number));
  put({"TransferFunction<Order>",
       "TransferFunction",
       std::make_unique<TransferFunction<7>>(TransferFunctionParams{
           .denominator = {1, 0, 0, 0, 0, 0, 0, 1}, .u_unit = "u_unit", .y_unit = "y_unit"}),
       {{"Vec<7>", "Vec<Order>"}},
       "The output depends directly on u if the numerator has as many coefficients as the denominator."});
  put(WithNote(MakeOfType<TransportDelay<T>>("TransportDelay", TransportDelayParams<T>{.unit = "unit"}),
               number));
  entries.back().placeholders.emplace_back("TransportDelayLine<Vec<7>>", "TransportDelayLine<T>");
  put(WithNote(MakeOfType<UniformNoise<T>>("UniformNoise", UniformNoiseParams<T>{.unit = "unit"}), number));
  put(WithNote(MakeOfType<UnitDelay<T>>("UnitDelay", UnitDelayParams<T>{.unit = "unit"}), any));
  put(WithNote(MakeOfType<ZeroOrderHold<T>>("ZeroOrderHold", ZeroOrderHoldParams{.unit = "unit"}), any));
  return shelf;
}

Shelf Communication() {
  Shelf shelf{"communication", {}};
  auto& entries = shelf.entries;
  const std::string numbers = "`T` is a number, a matrix, or a struct with `Fields()`.";
  entries.push_back(
      WithNote(MakeOfType<ExternalInput<T>>("ExternalInput", ExternalInputParams<T>{.unit = "unit"}),
               "`T` is any copyable type."));
  entries.push_back(
      WithNote(MakeOfType<UdpPublisher<T>>("UdpPublisher", UdpPublisherParams{.name = "signal"}), numbers));
  entries.push_back(WithNote(
      MakeOfType<UdpInput<T>>("UdpInput", UdpInputParams<T>{.name = "signal", .unit = "unit", .port = 0}),
      numbers));
  return shelf;
}

Shelf QuadrupedPlants(const Shipped& shipped) {
  const QuadrupedWorldParams& world = shipped.walk.world;
  Shelf shelf{"quadruped plants", {}};
  auto& entries = shelf.entries;
  entries.push_back(Make<QuadrupedPlant>("QuadrupedPlant", world.plant));
  entries.push_back(Make<PulseForce>("PulseForce"));
  entries.push_back(Make<SineForce>("SineForce"));
  entries.push_back(Make<RandomForce>("RandomForce", RandomForceParams{.robot = shipped.dog}));
  entries.push_back(Make<ForceBundle>("ForceBundle", ForceBundleParams{.count = 2}));
  entries.push_back(Make<JointLock>("JointLock"));
  entries.push_back(Make<FallMonitor>("FallMonitor"));
  entries.push_back(Make<DriveErrors>("DriveErrors"));
  entries.push_back(Make<SlidingLoad>("SlidingLoad", SlidingLoadParams{.mass = 1}));
  entries.push_back(Make<SpringPull>("SpringPull", SpringPullParams{.robot = shipped.dog}));
  entries.push_back(Make<Ropes>("Ropes", RopesParams{shipped.ropes}));
  entries.push_back(Make<JointEncoders>("JointEncoders"));
  entries.push_back(Make<JointTorqueSensor>("JointTorqueSensor"));
  entries.push_back(Make<ShankForces>("ShankForces", ShankForcesParams{shipped.dog}));
  entries.push_back(Make<FootForceSensor>("FootForceSensor"));
  entries.push_back({"TrunkImu", "BasicImu", std::make_unique<TrunkImu>()});
  entries.push_back(Make<ImuErrors>("ImuErrors"));
  entries.push_back(Make<CableSensors>("CableSensors"));
  return shelf;
}

Shelf Surroundings(const Shipped& shipped) {
  Shelf shelf{"surroundings", {}};
  shelf.entries.push_back(Make<Person>("Person", shipped.guide_dog.person));
  shelf.entries.push_back(Make<Leash>("Leash"));
  shelf.entries.push_back(Make<ObstacleDetector>("ObstacleDetector"));
  shelf.entries.push_back(Make<TerrainMapper>("TerrainMapper", TerrainMapperParams()));
  return shelf;
}

Shelf CdprPlants(const Shipped& shipped) {
  const CdprDescription& robot = shipped.cdpr_pd.robot;
  Shelf shelf{"cable robot plants", {}};
  auto& entries = shelf.entries;
  entries.push_back(Make<CdprPlant>(
      "CdprPlant",
      CdprPlantParams{.robot = robot, .initial_tension = CableVector::Zero(robot.num_cables())}));
  entries.push_back(Make<WinchErrors>("WinchErrors"));
  entries.push_back(Make<CableFault>("CableFault", CableFaultParams{.num_cables = robot.num_cables()}));
  entries.push_back(Make<PayloadSchedule>("PayloadSchedule"));
  entries.push_back(Make<Gusts>("Gusts"));
  entries.push_back(Make<HangingLoad>("HangingLoad"));
  entries.push_back(Make<PlatformPull>("PlatformPull"));
  entries.push_back(Make<CdprMonitor>("CdprMonitor", CdprMonitorParams{.robot = robot}));
  entries.push_back(Make<PoseSensor>("PoseSensor"));
  entries.push_back({"Imu", "BasicImu", std::make_unique<Imu>()});
  return shelf;
}

Shelf QuadrupedControllers(const Shipped& shipped) {
  const LeggedLocomotionParams& locomotion = shipped.walk.locomotion;
  const DisturbanceObserverParams& observer = shipped.walk.observer;
  Shelf shelf{"quadruped controllers", {}};
  auto& entries = shelf.entries;
  entries.push_back(Make<WalkSchedule>("WalkSchedule", shipped.walk.walk));
  entries.push_back(Make<WalkDrive>("WalkDrive"));
  entries.push_back(Make<Pacer>(
      "Pacer", PacerParams{.robot = locomotion.whole_body.robot, .gaits = locomotion.scheduler.gaits}));
  entries.push_back(Make<FootScheduler>("FootScheduler", locomotion.scheduler));
  entries.push_back(Make<GroundEstimator>("GroundEstimator", locomotion.ground));
  entries.push_back(Make<MappedGround>("MappedGround", MappedGroundParams{.robot = locomotion.ground.robot}));
  entries.push_back(Make<ComPlanner>("ComPlanner", locomotion.com_planner));
  entries.push_back(Make<SwingPlanner>("SwingPlanner", locomotion.swing_planner));
  entries.push_back(Make<TrunkPlanner>("TrunkPlanner", locomotion.trunk_planner));
  entries.push_back(
      Make<CentroidalMpc>("CentroidalMpc", CentroidalMpcParams{.robot = locomotion.whole_body.robot}));
  entries.push_back(
      WithNote(Make<WholeBodyController>("WholeBodyController", locomotion.whole_body),
               "Ends the run if the number of consecutive failed solves exceeds `max_failures_in_a_row`."));
  entries.push_back(
      Make<RopeTensions>("RopeTensions", RopeTensionsParams{.robot = shipped.dog, .ropes = shipped.ropes}));
  entries.push_back(Make<JointPd>("JointPd", shipped.stand.pd));
  entries.push_back(Make<LegMomentumObserver>("LegMomentumObserver", observer.legs));
  entries.push_back(Make<ComObserver>("ComObserver", observer.com));
  entries.push_back(Make<NonlinearDisturbanceObserver>("NonlinearDisturbanceObserver", observer.ndo));
  LeggedStateEstimatorParams estimator;
  estimator.robot = shipped.dog;
  entries.push_back(Make<LeggedStateEstimator>("LeggedStateEstimator", estimator));
  entries.push_back(
      Make<FootForceEstimate>("FootForceEstimate", FootForceEstimateParams{.robot = shipped.dog}));
  entries.push_back(
      Make<GroundForceObserver>("GroundForceObserver", GroundForceObserverParams{.robot = shipped.dog}));
  entries.push_back(Make<Supervisor>("Supervisor"));
  entries.push_back(Make<AdmittanceFilter>("AdmittanceFilter"));
  entries.push_back(Make<TrackingError>("TrackingError", TrackingErrorParams{.robot = shipped.dog}));
  entries.push_back(Make<WalkView>("WalkView", WalkViewParams{.robot = shipped.dog}));
  return shelf;
}

Shelf CdprControllers(const Shipped& shipped) {
  const CdprLoopParams& loop = shipped.cdpr_pd;
  Shelf shelf{"cable robot controllers", {}};
  auto& entries = shelf.entries;
  entries.push_back(
      Make<ReferenceGenerator>("ReferenceGenerator", ReferenceGeneratorParams{.path = loop.path}));
  entries.push_back(Make<GoalPath>("GoalPath", GoalPathParams{.path = loop.path}));
  entries.push_back(Make<BrokenCableDetector>("BrokenCableDetector"));
  entries.push_back(Make<CablePd>("CablePd", CablePdParams{.robot = loop.robot,
                                                           .stiffness_N_per_m = loop.pd_stiffness_N_per_m,
                                                           .damping_N_s_per_m = loop.pd_damping_N_s_per_m}));
  entries.push_back(Make<CdprEstimator>("CdprEstimator"));
  entries.push_back(Make<LoadEstimator>("LoadEstimator", LoadEstimatorParams{.robot = loop.robot}));
  entries.push_back(
      Make<ReferenceBalancer>("ReferenceBalancer", ReferenceBalancerParams{.robot = loop.robot}));
  entries.push_back(
      WithNote(Make<CdprMpc>("CdprMpc", *shipped.cdpr_mpc.mpc),
               "Ends the run if the number of consecutive failed solves exceeds `max_fallbacks_in_a_row`."));
  return shelf;
}

Shelf Diagrams(const Shipped& shipped) {
  Shelf shelf{"diagrams", {}};
  auto& entries = shelf.entries;
  entries.push_back(Make<LeggedLocomotion>("LeggedLocomotion", shipped.walk.locomotion));
  entries.push_back(Make<DisturbanceObserver>("DisturbanceObserver", shipped.walk.observer));
  FootForcesOfLegsParams of_legs;
  of_legs.robot = shipped.dog;
  of_legs.initial = shipped.walk.world.plant.initial;
  entries.push_back(Make<FootForcesOfLegs>("FootForcesOfLegs", of_legs));
  entries.push_back(Make<QuadrupedWorld>("QuadrupedWorld", shipped.walk.world));
  entries.push_back(Make<QuadrupedWalk>("QuadrupedWalk", shipped.walk));
  entries.push_back(Make<QuadrupedStand>("QuadrupedStand", shipped.stand));
  entries.push_back(Make<GuideDog>("GuideDog", shipped.guide_dog));
  entries.push_back(WithNote(Make<CdprLoop>("CdprLoop", shipped.cdpr_pd),
                             "With a model predictive controller instead of the PD controller, the diagram "
                             "also outputs the command of that controller."));
  return shelf;
}

}  // namespace

std::vector<Shelf> MakeCatalogue() {
  const Shipped shipped;
  std::vector<Shelf> shelves;
  shelves.push_back(Primitives());
  shelves.push_back(Communication());
  shelves.push_back(QuadrupedPlants(shipped));
  shelves.push_back(Surroundings(shipped));
  shelves.push_back(CdprPlants(shipped));
  shelves.push_back(QuadrupedControllers(shipped));
  shelves.push_back(CdprControllers(shipped));
  shelves.push_back(Diagrams(shipped));
  return shelves;
}

std::vector<Picture> MakePictures() {
  const Shipped shipped;
  std::vector<Picture> pictures;
  const auto draw = [&]<class Block, class Params>(std::in_place_type_t<Block>, const std::string& name,
                                                   const std::string& block, const Params& params) {
    DiagramBuilder builder;
    builder.Add<Block>(block, params);
    pictures.push_back({name, builder.BuildWithOpenInputs()->Graphviz()});
  };
  draw(std::in_place_type<LeggedLocomotion>, "legged_locomotion", "locomotion", shipped.walk.locomotion);
  draw(std::in_place_type<DisturbanceObserver>, "disturbance_observer", "observer", shipped.walk.observer);
  draw(std::in_place_type<QuadrupedWorld>, "quadruped_world", "world", shipped.walk.world);
  draw(std::in_place_type<QuadrupedWalk>, "quadruped_walk", "walk", shipped.walk);
  draw(std::in_place_type<QuadrupedStand>, "quadruped_stand", "stand", shipped.stand);
  draw(std::in_place_type<GuideDog>, "guide_dog", "guide_dog", shipped.guide_dog);
  draw(std::in_place_type<CdprLoop>, "cdpr_loop_pd", "loop", shipped.cdpr_pd);
  draw(std::in_place_type<CdprLoop>, "cdpr_loop_mpc", "loop", shipped.cdpr_mpc);
  return pictures;
}

}  // namespace tenon::docs
