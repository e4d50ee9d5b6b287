#include <tenon/apps/cdpr/cdpr_scenario.h>
#include <tenon/apps/guide_dog/guide_dog_scenario.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/controllers/cdpr/broken_cable_detector.h>
#include <tenon/controllers/cdpr/goal_path.h>
#include <tenon/controllers/guide_dog/reference_admittance.h>
#include <tenon/controllers/legged/deployment/deployment.h>
#include <tenon/controllers/legged/observers/ground_force_observer.h>
#include <tenon/controllers/legged/planning/thesis_planner.h>
#include <tenon/controllers/legged/planning/trajectory_planner.h>
#include <tenon/controllers/legged/planning/walk_drive.h>
#include <tenon/diagrams/cdpr/cdpr_messages.h>
#include <tenon/diagrams/evaluation/leg_errors.h>
#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/diagrams/evaluation/walk_view.h>
#include <tenon/diagrams/legged/foot_forces_of_legs.h>
#include <tenon/diagrams/legged/quadruped_messages.h>
#include <tenon/docs/catalogue/catalogue.h>
#include <tenon/plants/cdpr/cable_fault.h>
#include <tenon/plants/cdpr/gusts.h>
#include <tenon/plants/cdpr/hanging_load.h>
#include <tenon/plants/cdpr/platform_pull.h>
#include <tenon/plants/legged/joint_drives.h>
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
#include <tenon/systems/primitives/gain.h>
#include <tenon/systems/primitives/held_lag.h>
#include <tenon/systems/primitives/integrator.h>
#include <tenon/systems/primitives/jittered_delay.h>
#include <tenon/systems/primitives/low_pass_filter.h>
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
#include <tenon/systems/primitives/unit_delay.h>
#include <tenon/systems/primitives/zero_order_hold.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/systems/yaml/yaml.h>

#include <array>
#include <typeinfo>

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

/// The name of the class without namespace and template arguments.
template <class Block>
std::string NameOf() {
  std::string name = internal::Demangled(typeid(Block).name());
  name = name.substr(0, name.find('<'));
  return name.substr(name.rfind(':') + 1);
}

template <class Block, class... Args>
Entry MakeTitled(std::string title, const Args&... params) {
  Entry entry{std::move(title), NameOf<Block>(), std::unique_ptr<System>(new Block(params...))};
  entry.build = [params...](const auto& change) {
    DiagramBuilder builder;
    if constexpr (requires { typename Block::Params; }) {
      typename Block::Params changed{params...};
      if (change) change(&changed);
      builder.Add<Block>("block", changed);
    } else {
      builder.Add<Block>("block", params...);
    }
    return builder.BuildWithOpenInputs();
  };
  if constexpr (requires { Block::Params::Fields(); })
    entry.ranges = internal::FieldsOf<typename Block::Params>();
  return entry;
}

template <class Block, class... Params>
Entry Make(const Params&... params) {
  return MakeTitled<Block>(NameOf<Block>(), params...);
}

/// Makes the entry of a class template with one type parameter.
template <class Block, class... Params>
Entry MakeOfType(const Params&... params) {
  Entry entry = MakeTitled<Block>(NameOf<Block>() + "<T>", params...);
  entry.placeholders = {{"Vec<7>", "T"}};
  return entry;
}

Shelf Primitives() {
  Shelf shelf{"primitives", {}};
  const std::string number = "`T` is a double or a `Vec<N>`.", any = "`T` is any copyable type.",
                    numbers = "`T` is a double, a `Vec<N>` or a struct with `Fields()`.";

  shelf.Put(MakeOfType<Adder<T>>(AdderParams{.unit = "unit"}), number);
  shelf.Put(MakeTitled<Concatenate<double, double>>("Concatenate<Ts...>")).placeholders = {{"double", "Ts"}};
  shelf.Put(MakeTitled<Split<double, double>>("Split<Ts...>")).size = 2;
  shelf.entries.back().placeholders = {{"double", "Ts"}};
  shelf.Put(MakeOfType<ConstantSource<T>>(ConstantParams<T>{.unit = "unit"}), any);
  shelf
      .Put(
          MakeOfType<DiscreteDerivative<T>>(DiscreteDerivativeParams{.u_unit = "u_unit", .y_unit = "y_unit"}),
          number)
      .placeholders = {{"internal::FilteredDifference<Vec<7>>", "FilteredDifference<T>"}, {"Vec<7>", "T"}};
  shelf.Put(MakeOfType<DiscreteLowPass<T>>(DiscreteLowPassParams<T>{.unit = "unit"}), number);
  shelf.Put(Make<DiscreteTransferFunction>(DiscreteTransferFunctionParams{
                .denominator = {1, 0}, .u_unit = "u_unit", .y_unit = "y_unit"}),
            "The output depends directly on u if the numerator has as many coefficients as the denominator.");
  shelf.Put(MakeOfType<Gain<T>>(GainParams{.u_unit = "u_unit", .y_unit = "y_unit"}), number);
  shelf.Put(MakeOfType<GaussMarkov<T>>(GaussMarkovParams<T>{.unit = "unit"}), number);
  const std::string sized = "`T` is a double, a `Vec<N>` or an `Eigen::VectorXd` of the size of `initial`.";
  shelf.Put(MakeOfType<HeldLag<T>>(HeldLagParams<T>{.unit = "unit"}), sized);
  shelf.Put(MakeOfType<Integrator<T>>(IntegratorParams<T>{.u_unit = "u_unit", .y_unit = "y_unit"}), number);
  shelf.Put(MakeOfType<JitteredDelay<T>>(JitteredDelayParams<T>{.unit = "unit"}), sized);
  shelf.Put(MakeOfType<LowPassFilter<T>>(LowPassFilterParams<T>{.unit = "unit"}), number);
  shelf
      .Put(MakeTitled<MatrixGain<7, 5>>("MatrixGain<Rows, Cols>",
                                        MatrixGainParams<7, 5>{.u_unit = "u_unit", .y_unit = "y_unit"}),
           "The vectors of `MatrixGain<>` are `Eigen::VectorXd`, whose sizes are those of its matrix.")
      .placeholders = {{"Vec<7>", "Vec<Rows>"}, {"Vec<5>", "Vec<Cols>"}};
  shelf
      .Put(MakeTitled<MultiportSwitch<T>>("MultiportSwitch<T, Index>", MultiportSwitchParams{.unit = "unit"}),
           any + " `Index` is an integer or an enumeration.")
      .placeholders = {{"Vec<7>", "T"}, {"int", "Index"}};
  shelf.Put(MakeTitled<Mux<7>>("Mux<N>", MuxParams{.units = "units"})).placeholders = {{"Vec<7>", "Vec<N>"}};
  shelf.Put(MakeTitled<Demux<7>>("Demux<N>", MuxParams{.units = "units"})).placeholders = {
      {"Vec<7>", "Vec<N>"}};
  shelf.Put(MakeOfType<WhiteNoise<T>>(NoiseParams<T>{.unit = "unit"}), numbers);
  shelf.Put(MakeOfType<AddNoise<T>>(NoiseParams<T>{.unit = "unit"}), numbers);
  shelf.Put(MakeOfType<Pid<T>>(PidParams<T>{.y_unit = "y_unit", .u_unit = "u_unit"}), number);
  shelf.Put(MakeOfType<Pulse<T>>(PulseParams<T>{.unit = "unit"}), number);
  shelf.Put(MakeOfType<Quantizer<T>>(QuantizerParams<T>{.unit = "unit"}), number);
  shelf.Put(MakeOfType<RandomWalk<T>>(RandomWalkParams<T>{.unit = "unit"}), number);
  shelf.Put(MakeOfType<RateLimiter<T>>(RateLimiterParams<T>{.unit = "unit"}), number);
  shelf.Put(MakeOfType<SampleDelay<T>>(SampleDelayParams<T>{.unit = "unit"}),
            "`T` is any copyable type except bool.");
  shelf.Put(MakeOfType<Saturation<T>>(SaturationParams<T>{.unit = "unit"}), number);
  shelf.Put(MakeOfType<SignalFault<T>>(SignalFaultParams<T>{.unit = "unit"}), any);
  shelf.Put(MakeOfType<Sine<T>>(SineParams<T>{.unit = "unit"}), number);
  const Eigen::MatrixXd one = Eigen::MatrixXd::Ones(1, 1);
  const StateSpaceParams model{
      .A = one, .B = one, .C = one, .u_unit = "u_unit", .x_unit = "x_unit", .y_unit = "y_unit"};
  const std::string with_d = "The output depends directly on u if D is given.";
  shelf.Put(Make<StateSpace>(model), with_d).size = 1;
  shelf.Put(Make<DiscreteStateSpace>(DiscreteStateSpaceParams{.model = model}), with_d).size = 1;
  shelf.Put(MakeOfType<Switch<T>>(SwitchParams{.unit = "unit"}), any);
  shelf.Put(
      MakeOfType<ThresholdSwitch<T>>(ThresholdSwitchParams{.control_unit = "control_unit", .unit = "unit"}),
      any);
  const std::vector<T> two_values{T::Zero(), T::Ones()};
  shelf.Put(MakeOfType<Table<T>>(
                TableParams<T>{.u = {0, 1}, .y = two_values, .u_unit = "u_unit", .y_unit = "y_unit"}),
            number);
  shelf.Put(
      MakeOfType<Trajectory<T>>(TrajectoryParams<T>{.times = {0, 1}, .values = two_values, .unit = "unit"}),
      number);
  shelf
      .Put(MakeTitled<TransferFunction<7>>(
               "TransferFunction<Order>",
               TransferFunctionParams{
                   .denominator = {1, 0, 0, 0, 0, 0, 0, 1}, .u_unit = "u_unit", .y_unit = "y_unit"}),
           "The output depends directly on u if the numerator has as many coefficients as the denominator.")
      .placeholders = {{"Vec<7>", "Vec<Order>"}};
  shelf.Put(MakeOfType<TransportDelay<T>>(TransportDelayParams<T>{.unit = "unit"}), number);
  shelf.Put(MakeOfType<UniformNoise<T>>(UniformNoiseParams<T>{.unit = "unit"}), number);
  shelf.Put(MakeOfType<UnitDelay<T>>(UnitDelayParams<T>{.unit = "unit"}), any);
  shelf.Put(MakeOfType<ZeroOrderHold<T>>(ZeroOrderHoldParams{.unit = "unit"}), any);
  return shelf;
}

Shelf Communication(const Shipped& shipped) {
  Shelf shelf{"communication", {}};
  const std::string numbers = "`T` is a number, a matrix, or a struct with `Fields()`.";
  shelf.Put(MakeOfType<ExternalInput<T>>(ExternalInputParams<T>{.unit = "unit"}),
            "`T` is any copyable type.");
  shelf.Put(MakeOfType<UdpPublisher<T>>(UdpPublisherParams{.name = "signal"}), numbers);
  shelf.Put(MakeOfType<UdpInput<T>>(UdpInputParams<T>{.name = "signal", .unit = "unit", .port = 0}), numbers);
  shelf.Put(MakeTitled<Slow<CdprMpc, &CdprMpc::plan>>(
                "Slow<Block, &Block::output>",
                SlowParams<CdprMpc>{*shipped.cdpr_mpc.mpc, {.time = 0.02, .jitter = 0.005}}),
            "The table is that of a `CdprMpc`, to whose ports `result` and `age` are added; see "
            "[slow.md](slow.md).");
  return shelf;
}

Shelf QuadrupedPlants(const Shipped& shipped) {
  const QuadrupedWorldParams& world = shipped.walk.world;
  Shelf shelf{"quadruped plants", {}};
  shelf.Put(Make<QuadrupedPlant>(world.plant));
  shelf.Put(Make<PulseForce>());
  shelf.Put(Make<SineForce>());
  shelf.Put(Make<RandomForce>(RandomForceParams{.robot = shipped.dog}));
  shelf.Put(Make<ForceBundle>(ForceBundleParams{.count = 2}));
  shelf.Put(Make<JointLock>());
  shelf.Put(Make<JointDrives>());
  shelf.Put(Make<FallMonitor>());
  shelf.Put(Make<DriveErrors>());
  shelf.Put(Make<SlidingLoad>(SlidingLoadParams{.mass = 1}));
  shelf.Put(Make<SpringPull>(SpringPullParams{.robot = shipped.dog}));
  shelf.Put(Make<Ropes>(RopesParams{shipped.ropes})).size = 1;
  shelf.Put(Make<JointEncoders>());
  shelf.Put(Make<JointTorqueSensor>());
  shelf.Put(Make<ShankForces>(ShankForcesParams{shipped.dog}));
  shelf.Put(Make<FootForceSensor>());
  shelf.Put(MakeTitled<TrunkImu>("TrunkImu"));
  shelf.Put(Make<ImuErrors>());
  shelf.Put(Make<CableSensors>());
  return shelf;
}

Shelf Surroundings(const Shipped& shipped) {
  Shelf shelf{"surroundings", {}};
  shelf.Put(Make<Person>(shipped.guide_dog.person));
  shelf.Put(Make<Leash>());
  shelf.Put(Make<ObstacleDetector>());
  shelf.Put(Make<TerrainMapper>(TerrainMapperParams()));
  return shelf;
}

Shelf CdprPlants(const Shipped& shipped) {
  const CdprDescription& robot = shipped.cdpr_pd.robot;
  Shelf shelf{"cable robot plants", {}};
  shelf.Put(Make<CdprPlant>(
      CdprPlantParams{.robot = robot, .initial_tension = CableVector::Zero(robot.num_cables())}));
  shelf.Put(Make<WinchErrors>());
  shelf.Put(Make<CableFault>(CableFaultParams{.num_cables = robot.num_cables()}));
  shelf.Put(Make<PayloadSchedule>());
  shelf.Put(Make<Gusts>());
  shelf.Put(Make<HangingLoad>());
  shelf.Put(Make<PlatformPull>());
  shelf.Put(Make<CdprMonitor>(CdprMonitorParams{.robot = robot}));
  shelf.Put(Make<PoseSensor>());
  shelf.Put(MakeTitled<Imu>("Imu"));
  return shelf;
}

Shelf QuadrupedControllers(const Shipped& shipped) {
  const LeggedLocomotionParams& locomotion = shipped.walk.locomotion;
  const DisturbanceObserverParams& observer = shipped.walk.observer;
  Shelf shelf{"quadruped controllers", {}};
  shelf.Put(Make<WalkSchedule>(shipped.walk.walk));
  shelf.Put(Make<WalkDrive>());
  shelf.Put(
      Make<Pacer>(PacerParams{.robot = locomotion.whole_body.robot, .gaits = locomotion.scheduler.gaits}));
  shelf.Put(Make<StepTimingAdapter>(locomotion.step_timing));
  shelf.Put(Make<FootScheduler>(locomotion.scheduler));
  shelf.Put(Make<GroundEstimator>(locomotion.ground));
  shelf.Put(Make<MappedGround>(MappedGroundParams{.robot = locomotion.ground.robot}));
  shelf.Put(Make<ComPlanner>(locomotion.com_planner));
  shelf.Put(Make<ThesisPlanner>(locomotion.com_planner));
  shelf.Put(Make<TrajectoryPlanner>(TrajectoryPlannerParams{.robot = locomotion.whole_body.robot}));
  shelf.Put(Make<SwingPlanner>(locomotion.swing_planner));
  shelf.Put(Make<TrunkPlanner>(locomotion.trunk_planner));
  shelf.Put(Make<CentroidalMpc>(CentroidalMpcParams{.robot = locomotion.whole_body.robot}));
  shelf.Put(Make<WholeBodyController>(locomotion.whole_body),
            "Ends the run if the number of consecutive failed solves exceeds `max_failures_in_a_row`.");
  shelf.Put(Make<RopeTensions>(RopeTensionsParams{.robot = shipped.dog, .ropes = shipped.ropes})).size = 1;
  shelf.Put(Make<JointPd>(shipped.stand.pd));
  shelf.Put(Make<Deployment>(DeploymentParams{.robot = shipped.dog}));
  shelf.Put(Make<LegMomentumObserver>(observer.legs));
  shelf.Put(Make<ComObserver>(observer.com));
  shelf.Put(Make<NonlinearDisturbanceObserver>(observer.ndo));
  LeggedStateEstimatorParams estimator;
  estimator.robot = shipped.dog;
  shelf.Put(Make<LeggedStateEstimator>(estimator));
  shelf.Put(Make<FootForceEstimate>(FootForceEstimateParams{.robot = shipped.dog}));
  shelf.Put(Make<GroundForceObserver>(GroundForceObserverParams{.robot = shipped.dog}));
  shelf.Put(Make<Supervisor>());
  shelf.Put(Make<AdmittanceFilter>());
  shelf.Put(Make<ReferenceAdmittance>());
  shelf.Put(Make<LegErrors>(LegErrorsParams{.robot = shipped.dog}));
  shelf.Put(Make<TrackingError>(TrackingErrorParams{.robot = shipped.dog}));
  shelf.Put(Make<WalkView>(WalkViewParams{.robot = shipped.dog}));
  shelf.Put(Make<QuadrupedMessages>(QuadrupedMessagesParams{.robot = shipped.dog}));
  return shelf;
}

Shelf CdprControllers(const Shipped& shipped) {
  const CdprLoopParams& loop = shipped.cdpr_pd;
  Shelf shelf{"cable robot controllers", {}};
  shelf.Put(Make<ReferenceGenerator>(ReferenceGeneratorParams{.path = loop.path}));
  shelf.Put(Make<GoalPath>(GoalPathParams{.path = loop.path}));
  shelf.Put(Make<BrokenCableDetector>());
  shelf.Put(Make<CablePd>(CablePdParams{.robot = loop.robot,
                                        .stiffness_N_per_m = loop.pd_stiffness_N_per_m,
                                        .damping_N_s_per_m = loop.pd_damping_N_s_per_m}));
  shelf.Put(Make<CdprEstimator>());
  shelf.Put(Make<LoadEstimator>(LoadEstimatorParams{.robot = loop.robot}));
  shelf.Put(Make<ReferenceBalancer>(ReferenceBalancerParams{.robot = loop.robot}));
  shelf.Put(Make<CdprMpc>(*shipped.cdpr_mpc.mpc),
            "Ends the run if the number of consecutive failed solves exceeds `max_fallbacks_in_a_row`.");
  shelf.Put(Make<CdprMessages>());
  return shelf;
}

Shelf Diagrams(const Shipped& shipped) {
  Shelf shelf{"diagrams", {}};
  shelf.Put(Make<LeggedLocomotion>(shipped.walk.locomotion));
  shelf.Put(Make<DisturbanceObserver>(shipped.walk.observer));
  shelf.Put(Make<FootForcesOfLegs>(
      FootForcesOfLegsParams{.robot = shipped.dog, .initial = shipped.walk.world.plant.initial}));
  shelf.Put(Make<QuadrupedWorld>(shipped.walk.world));
  shelf.Put(Make<QuadrupedWalk>(shipped.walk));
  shelf.Put(Make<QuadrupedStand>(shipped.stand));
  shelf.Put(Make<GuideDog>(shipped.guide_dog));
  shelf.Put(Make<CdprLoop>(shipped.cdpr_pd),
            "With a model predictive controller instead of the PD controller, the diagram "
            "also outputs the command of that controller.");
  return shelf;
}

}  // namespace

std::vector<Shelf> MakeCatalogue() {
  const Shipped shipped;
  std::vector<Shelf> shelves;
  for (Shelf& shelf : std::array{Primitives(), Communication(shipped), QuadrupedPlants(shipped),
                                 Surroundings(shipped), CdprPlants(shipped), QuadrupedControllers(shipped),
                                 CdprControllers(shipped), Diagrams(shipped)})
    shelves.push_back(std::move(shelf));
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
  pictures.push_back({"deployment", DeploymentGraph()});
  return pictures;
}

}  // namespace tenon::docs
