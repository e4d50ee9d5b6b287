#include <tenon/apps/quadruped/log_estimator.h>
#include <tenon/systems/analysis/matrix_functions.h>
#include <tenon/systems/yaml/resources.h>

#include <fmt/core.h>
#include <nlopt.hpp>

namespace tenon::apps {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Identification::Sample {
  LeggedState state;
  Vec<12> torque = Vec<12>::Zero();
  FootForces forces;
  WrenchEstimate wrench;
  ImuMeasurement inertial;
  Vec<12> command = Vec<12>::Zero();

  static FieldList Fields() {
    return {{"state", &Sample::state},   {"torque", &Sample::torque},     {"forces", &Sample::forces},
            {"wrench", &Sample::wrench}, {"inertial", &Sample::inertial}, {"command", &Sample::command}};
  }
};

/// The rows of the log as samples; the signals follow each other as the members do.
class Identification::Samples final : public LogSink {
 public:
  void Row(std::span<const double> row) override {
    Sample& sample = all.emplace_back();
    numbers_.resize(internal::CountScalars(internal::TypeInfoOf<Sample>(), &sample));  // 0 for commands
    std::copy(row.begin() + 1, row.end(), numbers_.begin());
    internal::FromDoubles(internal::TypeInfoOf<Sample>(), &sample, numbers_.data());
  }
  std::vector<Sample> all;

 private:
  std::vector<double> numbers_;
};

namespace {

using Sample = Identification::Sample;
using Samples = std::vector<Sample>;

constexpr double kFrictionSpeed = 0.1;  // as of QuadrupedPlant [rad/s]
constexpr double kNear = 1.2;        // torque and speed of a drive near its limits, times this, exceed them
constexpr double kLoadPeriod = 0.5;  // over which wrenches are averaged [s]

/// A parameter, with bounds, and its estimate.
struct Unknown {
  const char* key;  // of a figure, with its unit
  double lower, upper;
  double resolution;  // two deviations that are small enough, if a fifth of the value is not [unit]
  double value = 0, deviation = std::numeric_limits<double>::infinity();

  bool determined() const { return 2 * deviation <= std::max(resolution, 0.2 * std::abs(value)); }
};

/// Residuals as a function of the parameters' values.
using Residuals = std::function<VectorXd(const VectorXd&)>;

/// A bounded least-squares problem in parameters scaled to 0 … 1.
class LeastSquares {
 public:
  LeastSquares(Residuals residuals, std::vector<Unknown>& parameters)
      : residuals_(std::move(residuals)), parameters_(parameters) {}

  /// Solves the problem by NLopt's SLSQP, and sets values and deviations. Residuals of `block` rows in
  /// succession may be correlated.
  void Solve(Index block) {
    std::vector<double> u(parameters_.size(), 0.3);
    nlopt::opt optimizer(nlopt::LD_SLSQP, static_cast<unsigned>(u.size()));
    optimizer.set_lower_bounds(0.0);
    optimizer.set_upper_bounds(1.0);
    optimizer.set_xtol_rel(1e-9);
    optimizer.set_maxeval(200);
    scale_ = At(u).squaredNorm();
    if (!(scale_ > 0)) return;
    optimizer.set_min_objective(
        [](const std::vector<double>& u_now, std::vector<double>& gradient, void* self) {
          return static_cast<LeastSquares*>(self)->Cost(u_now, gradient);
        },
        this);
    double cost = 0;
    try {
      optimizer.optimize(u, cost);
    } catch (const nlopt::roundoff_limited&) {  // converged to rounding
    }
    const VectorXd r = At(u);
    const MatrixXd J = Jacobian(u);
    const MatrixXd normal = J.transpose() * J;
    const VectorXd sizes = SymmetricEigenvalues(normal);
    MatrixXd spread = MatrixXd::Zero(J.cols(), J.cols());
    for (Index begin = 0; begin < r.size(); begin += block) {
      const Index size = std::min(block, r.size() - begin);
      const VectorXd sum = J.middleRows(begin, size).transpose() * r.segment(begin, size);
      spread += sum * sum.transpose();
    }
    const bool enough = r.size() / block > 3 * J.cols() && sizes.minCoeff() > 1e-12 * sizes.maxCoeff();
    for (std::size_t i = 0; i < u.size(); ++i) {
      Unknown& parameter = parameters_[i];
      parameter.value = Value(i, u[i]);
      if (!enough) continue;
      const VectorXd row = SolveLinear(normal, VectorXd::Unit(J.cols(), static_cast<Index>(i)));
      parameter.deviation = (parameter.upper - parameter.lower) * std::sqrt(row.dot(spread * row));
    }
  }

 private:
  double Value(std::size_t i, double u) const {
    return parameters_[i].lower + u * (parameters_[i].upper - parameters_[i].lower);
  }
  VectorXd At(const std::vector<double>& u) const {
    VectorXd values(static_cast<Index>(u.size()));
    for (std::size_t i = 0; i < u.size(); ++i) values[static_cast<Index>(i)] = Value(i, u[i]);
    return residuals_(values);
  }
  MatrixXd Jacobian(std::vector<double> u) const {
    constexpr double kStep = 1e-4;
    MatrixXd J;
    for (std::size_t i = 0; i < u.size(); ++i) {
      const double at = u[i], low = std::max(at - kStep, 0.0), high = std::min(at + kStep, 1.0);
      u[i] = high;
      const VectorXd above = At(u);
      u[i] = low;
      if (i == 0) J.resize(above.size(), static_cast<Index>(u.size()));
      J.col(static_cast<Index>(i)) = (above - At(u)) / (high - low);
      u[i] = at;
    }
    return J;
  }
  double Cost(const std::vector<double>& u, std::vector<double>& gradient) const {
    const VectorXd r = At(u);
    if (!gradient.empty())
      Eigen::Map<VectorXd>(gradient.data(), std::ssize(gradient)) = 2 / scale_ * Jacobian(u).transpose() * r;
    return r.squaredNorm() / scale_;
  }

  Residuals residuals_;
  std::vector<Unknown>& parameters_;
  double scale_ = 1;
};

/// Equations of the legs in swing: their columns belong to mass factor, rotor, damping and friction, the last
/// one is the torque.
MatrixXd SwingEquations(const LoadedLog& loaded, const Samples& samples) {
  QuadrupedDescription robot = loaded.walk.estimator->robot;
  robot.drive.rotor_inertia = 0;
  const QuadrupedModel model(robot, loaded.walk.estimator->gravity);
  const double h = loaded.log.rate.period();
  const auto steps = [&](double time) { return std::max<std::size_t>(1, std::lround(time / h)); };
  const std::size_t span = steps(0.003), window = std::max<std::size_t>(8, steps(0.04)), edge = steps(0.01);
  const double none = 0.04 * model.mass() * model.gravity();  // force of a foot in the air [N]
  std::array<std::size_t, kNumLegs> swing{};                  // samples so far
  std::vector<Vec<12>> p, rate, qd;
  std::vector<double> rows;
  QuadrupedDynamics dynamics;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const bool inner = k >= 2 * span && k + 2 * span < samples.size();
    LeggedState x = samples[k].state;
    const auto difference = [&](std::size_t by) -> Vec<12> {
      return samples[k + by].state.q - samples[k - by].state.q;
    };
    if (inner)  // of order 4
      x.qd = (8 * difference(span) - difference(2 * span)) / (12 * static_cast<double>(span) * h);
    if (inner) x.w_W = samples[k + 1].state.w_W;  // the estimate has that of the tick before
    model.Calc(x, &dynamics);
    p.push_back(dynamics.leg_momentum);
    rate.push_back(dynamics.leg_momentum_rate - dynamics.gravity.tail<12>());
    qd.push_back(x.qd);
    for (int leg = 0; leg < kNumLegs; ++leg) {
      std::size_t& since = swing[static_cast<std::size_t>(leg)];
      since = inner && samples[k].forces[leg].norm() < none ? since + 1 : 0;
      // A window ends `edge` samples ago, so that the foot is in the air before and after it.
      if (since < window + 2 * edge || (since - window - 2 * edge) % window != 0) continue;
      const std::size_t first = k - edge - window;
      for (int j = kJointsPerLeg * leg; j < kJointsPerLeg * (leg + 1); ++j) {
        std::array<double, 5> row{};
        for (std::size_t i = 0; i <= window; ++i) {
          const double share = std::numbers::pi * static_cast<double>(i) / static_cast<double>(window);
          const double phi = std::pow(std::sin(share), 2) * h;
          const double slope = std::numbers::pi * std::sin(2 * share) / static_cast<double>(window);
          const std::size_t at = first + i;
          row[0] += -slope * p[at][j] - phi * rate[at][j];
          row[1] += -slope * qd[at][j];
          row[2] += phi * qd[at][j];
          row[3] += phi * std::tanh(qd[at][j] / kFrictionSpeed);
          row[4] += phi * samples[at].torque[j];
        }
        rows.insert(rows.end(), row.begin(), row.end());
      }
    }
  }
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 5, Eigen::RowMajor>>(rows.data(),
                                                                                     std::ssize(rows) / 5, 5);
}

std::vector<Unknown> FitLegs(const LoadedLog& loaded, const Samples& samples) {
  const MeanLimits joints(loaded.walk.estimator->robot);
  std::vector<Unknown> parameters{
      {"leg_mass_ratio", 0.2, 5, 0},
      {"rotor_inertia_kg_m2", 0, joints.torque / 100, 0},
      {"damping_N_m_s_per_rad", 0, joints.torque / joints.speed, 0.002 * joints.torque / joints.speed},
      {"friction_N_m", 0, 0.5 * joints.torque, 0.002 * joints.torque}};
  const MatrixXd equations = SwingEquations(loaded, samples);
  if (equations.rows() > 0)
    LeastSquares(
        [&](const VectorXd& values) -> VectorXd { return equations.leftCols(4) * values - equations.col(4); },
        parameters)
        .Solve(kJointsPerLeg);
  return parameters;
}

/// Fits delay and time constant of the drives; their gains follow for each pair of these.
std::vector<Unknown> FitDrives(const LoadedLog& loaded, const Samples& samples, VectorXd* gains) {
  std::vector<Unknown> parameters{{"torque_delay_s", 0, 0.03, 2e-4}, {"torque_lag_s", 1e-4, 0.05, 0}};
  const QuadrupedDescription& robot = loaded.walk.world.plant.robot;
  const bool limit_speed = loaded.walk.world.plant.limit_speed;
  const auto& link = loaded.walk.world.hardware.command_delay;
  const double jitter = link ? link->jitter : 0, h = loaded.log.rate.period();
  const auto count = static_cast<Index>(samples.size());
  *gains = VectorXd::Ones(kNumJoints);
  const auto residuals = [&](const VectorXd& values) -> VectorXd {
    // Shares of the commands, newest first, in the mean that the drives hold during a tick.
    const double a = std::exp(-h / values[1]);
    std::vector<double> shares(static_cast<std::size_t>((values[0] + jitter) / h) + 2);
    for (const double part : {-0.8, -0.4, 0.0, 0.4, 0.8}) {  // of the jitter, which is uniform
      const double ticks = std::max(values[0] + part * jitter, 0.0) / h, whole = std::floor(ticks);
      shares[static_cast<std::size_t>(whole)] += (1 - ticks + whole) / 5;
      shares[static_cast<std::size_t>(whole) + 1] += (ticks - whole) / 5;
    }
    VectorXd all(count * kNumJoints);
    for (int j = 0; j < kNumJoints; ++j) {
      const auto command = [&](Index k) {
        return samples[static_cast<std::size_t>(std::max<Index>(k, 0))].command[j];
      };
      VectorXd modelled(count), measured(count);
      double y = command(0);
      for (Index k = 0; k < count; ++k) {
        const Sample& sample = samples[static_cast<std::size_t>(k)];
        // A drive near its limits follows no command.
        const bool free = std::abs(DriveTorque(kNear * y, kNear * sample.state.qd[j], robot.joint(j),
                                               robot.drive, limit_speed) -
                                   kNear * y) < 1e-9;
        modelled[k] = free ? y : 0;
        measured[k] = free ? sample.torque[j] : 0;
        double held = 0;
        for (std::size_t i = 0; i < shares.size(); ++i)
          held += shares[i] * command(k - static_cast<Index>(i));
        y = a * y + (1 - a) * held;
      }
      (*gains)[j] = modelled.dot(measured) / std::max(modelled.squaredNorm(), 1e-12);
      all.segment(j * count, count) = (*gains)[j] * modelled - measured;
    }
    return all;
  };
  LeastSquares(residuals, parameters).Solve(std::max<Index>(1, std::lround(0.25 / h)));
  residuals((VectorXd(2) << parameters[0].value, parameters[1].value).finished());  // sets the gains
  return parameters;
}

std::vector<Unknown> FitLoad(const LoadedLog& loaded, const Samples& samples) {
  const QuadrupedDescription& robot = loaded.walk.estimator->robot;
  const QuadrupedModel model(robot, loaded.walk.estimator->gravity);
  std::vector<Unknown> parameters{{"payload_kg", -0.9 * robot.mass(), 2 * robot.mass(), 0.01 * robot.mass()},
                                  {"payload_x_m", -1, 1, 0.01},
                                  {"payload_y_m", -1, 1, 0.01}};
  struct Mean {
    Vec<3> force = Vec<3>::Zero(), torque = Vec<3>::Zero(), specific = Vec<3>::Zero(), com = Vec<3>::Zero();
  };
  std::vector<Mean> means;
  const auto period = static_cast<std::size_t>(std::lround(kLoadPeriod * loaded.log.rate.hz()));
  QuadrupedDynamics dynamics;
  for (std::size_t k = period; k + period <= samples.size(); k += period) {  // the observer has settled
    Mean& mean = means.emplace_back();
    for (std::size_t i = k; i < k + period; ++i) {
      const Sample& sample = samples[i];
      const Eigen::Matrix3d R_BW = sample.state.R_WB().transpose() / static_cast<double>(period);
      model.Calc(sample.state, &dynamics);
      mean.force += R_BW * sample.wrench.force_W;
      mean.torque += R_BW * sample.wrench.torque_W;
      mean.com += R_BW * (dynamics.com_W - sample.state.p_WB);
      mean.specific += sample.inertial.specific_force_B / static_cast<double>(period);
    }
  }
  const double weight = robot.mass() * model.gravity(), length = ScaleOf(robot).length;
  const double height = loaded.scenario.payload.position_m.z();
  const auto residuals = [&](const VectorXd& values) -> VectorXd {
    VectorXd all(std::ssize(means) * 5);
    Index at = 0;
    for (const Mean& mean : means) {
      const Vec<3> force = -values[0] * mean.specific,
                   arm(values[1] - mean.com[0], values[2] - mean.com[1], height - mean.com[2]);
      all.segment<3>(at) = (force - mean.force) / weight;
      all.segment<2>(at + 3) = (arm.cross(force) - mean.torque).head<2>() / (weight * length);
      at += 5;
    }
    return all;
  };
  if (!means.empty()) LeastSquares(residuals, parameters).Solve(5);
  return parameters;
}

}  // namespace

Identification::Identification(const LoadedLog& loaded, const LogEstimator& blocks,
                               const OutputPort<Vec<12>>* command, Simulator& simulator)
    : loaded_(loaded), commanded_(command != nullptr), samples_(std::make_shared<Samples>()) {
  std::vector<const Source*> signals{&blocks.estimator.state, &blocks.torque, &blocks.foot_forces,
                                     &blocks.observer.wrench, &blocks.estimator.inertial};
  if (commanded_) signals.push_back(command);
  simulator.AddLog(loaded.log.rate, signals, {samples_});
}

void Identification::AddTo(Summary& summary, const std::filesystem::path& directory,
                           const QuadrupedScenario& given) const {
  const MeanLimits joints(loaded_.walk.estimator->robot);
  YamlDocument hardware = LoadResource("hardware/legged", given.hardware);
  QuadrupedScenario scenario = given;
  std::string intervals;
  const auto set = [&](const Unknown& parameter, const char* key, const auto& ratio) {
    std::vector<std::pair<std::string, std::optional<double>>> figure{{"value", std::nullopt},
                                                                      {"deviation", std::nullopt}};
    if (std::isfinite(parameter.deviation))
      figure = {{"value", parameter.value}, {"deviation", parameter.deviation}};
    summary.Set(parameter.key, figure);
    if (!parameter.determined()) {
      summary.Note(fmt::format("{} is not determined by this log", parameter.key));
    } else if (key != nullptr) {
      hardware.Set(key, fmt::format("{:.6g}", ratio(parameter.value)));
      intervals += fmt::format("# {}: {:.4g} ± {:.2g} (two deviations)\n", parameter.key, parameter.value,
                               2 * parameter.deviation);
    }
    return parameter.determined();
  };
  hardware.Set("description", "identified from a log");
  const std::vector<Unknown> legs = FitLegs(loaded_, samples_->all);
  set(legs[0], nullptr, std::identity());
  set(legs[1], "drives.rotor_acceleration_rad_per_s2",
      [&](double inertia) { return joints.torque / inertia; });
  set(legs[2], "drives.damping_ratio",
      [&](double damping) { return damping * joints.speed / joints.torque; });
  set(legs[3], "drives.friction_ratio", [&](double friction) { return friction / joints.torque; });
  if (commanded_) {
    VectorXd gains;
    const std::vector<Unknown> drives = FitDrives(loaded_, samples_->all, &gains);
    const auto& sensor = loaded_.walk.world.torque_sensor;
    const auto& link = loaded_.walk.world.hardware.command_delay;
    const double latency = sensor.latency * sensor.rate.period(), jitter = link ? link->jitter : 0;
    set(drives[0], "link.delay_s", [&](double delay) { return std::max(delay - latency, jitter); });
    set(drives[1], "drives.bandwidth_hz", [](double lag) { return 1 / (2 * std::numbers::pi * lag); });
    summary.Set("torque_gain_deviation", std::sqrt((gains.array() - gains.mean()).square().mean()));
  } else {
    summary.Note("delay and bandwidth of the torque are not determined: the log lacks /joint_commands");
  }
  const std::vector<Unknown> load = FitLoad(loaded_, samples_->all);
  if (set(load[0], nullptr, std::identity()) && load[0].value > load[0].resolution) {
    set(load[1], nullptr, std::identity());
    set(load[2], nullptr, std::identity());
    scenario.payload.mass_kg = load[0].value;
    scenario.payload.position_m.head<2>() << load[1].value, load[2].value;
  }
  if (directory.empty()) return;
  const std::filesystem::path file = std::filesystem::absolute(directory) / "hardware.yaml";
  scenario.hardware = YamlFile{file.string()};
  const int code = TryToWrite([&] {
    WriteFile(file, intervals + hardware.WithAbsolutePaths().Flow() + "\n");
    WriteFile(directory / "identified.yaml", WriteYaml(scenario));
  });
  if (code != kRan) summary.set_exit_code(code);
}

}  // namespace tenon::apps
