#include <tenon/controllers/cdpr/equilibrium_path.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/systems/block.h>

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

namespace tenon {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr int kNodesPerTurn = 720;
constexpr double kNodeInterval = 0.02;  // [s]
constexpr int kFewestIntervals = 100;
constexpr double kLargestJump = 0.1;    // largest change of the attitude between nodes of a branch [rad]
constexpr double kLargestDrift = 1e-6;  // largest drift of the attitude after one turn [rad]

}  // namespace

EquilibriumPath::EquilibriumPath(const CdprDescription& robot, const Path& path,
                                 const StaticsOptions& options, const std::optional<Path>& attitude)
    : robot_(robot), anchors_(robot), path_(path), options_(options) {
  options_.warm_start.reset();
  if (attitude) options_.attitude = attitude->At(attitude->start_time()).position;
  Demand(!attitude || !path.is_periodic(),
         "EquilibriumPath: on a circle the attitude is constant, give it in the options.");
  Demand(
      !anchors_.any() || !path.is_periodic(),
      fmt::format("The anchors of robot '{}' move, which a circle without end does not permit; give a path "
                  "that ends: a hold, a line, a spline, waypoints or a file.",
                  robot.name));
  double first = path.start_time(), last = path.end_time();
  if (anchors_.any()) {
    if (path.At(first).velocity.isZero(0)) first = std::min(first, anchors_.start_time());
    last = std::max(last, anchors_.end_time());
  }
  int intervals = 0;
  if (path.is_periodic()) {
    intervals = kNodesPerTurn;
    step_ = kTwoPi / intervals;
  } else if (const double duration = last - first; duration > 0) {
    intervals = std::max(kFewestIntervals, static_cast<int>(std::ceil(duration / kNodeInterval)));
    first_ = first;
    step_ = duration / intervals;
  }

  StaticsOptions each = options;
  values_.resize(3 + robot.num_cables(), intervals + 1);
  slopes_.setZero(values_.rows(), values_.cols());
  for (int i = 0; i <= intervals; ++i) {
    const double parameter = first_ + i * step_;
    const double time =  // for messages
        std::round((path.is_periodic() ? path.TimeOf(parameter) : parameter) * 1e6) / 1e6;
    StaticEquilibrium found;
    if (attitude) each.attitude = attitude->PositionOf(parameter);
    try {
      found = SolveInverseGeometricoStatic(anchors_.any() ? anchors_.RobotAt(robot, parameter) : robot,
                                           path.PositionOf(parameter), each);
    } catch (const ParameterError& error) {
      throw ParameterError(
          fmt::format("The path leaves the workspace at t = {:.4g} s. {}", time, error.what()));
    }
    if (i > 0) {
      const Eigen::Vector3d last = each.warm_start->euler;
      found.euler = EulerNear(found.euler, last);
      const double jump = (found.euler - last).norm();
      if (jump > kLargestJump) {
        const Eigen::Vector3d& p = found.p_WB;
        throw ParameterError(fmt::format(
            "The path leaves the workspace at t = {:.4g} s. The stable equilibria of robot '{}' that "
            "it follows end before ({:.4g}, {:.4g}, {:.4g}) m: the attitude would jump by {:.3g} deg.",
            time, robot.name, p.x(), p.y(), p.z(), jump * 180 / std::numbers::pi));
      }
    }
    values_.col(i) << found.euler, found.tension;
    each.warm_start = found;
  }
  if (path.is_periodic()) {
    const double drift = (values_.col(intervals) - values_.col(0)).head<3>().norm();
    Demand(drift < kLargestDrift,
           fmt::format(
               "The equilibria of robot '{}' along the circle do not close: after one turn, at t = {:.4g} "
               "s, the attitude is {:.3g} deg away from the first one.",
               robot.name, path.TimeOf(kTwoPi), drift * 180 / std::numbers::pi));
    values_.col(intervals) = values_.col(0);
  }
  FitSlopes();
}

// The slopes m of the spline with two continuous derivatives: m[i-1] + 4 m[i] + m[i+1] =
// 3 (y[i+1] - y[i-1]) / h. At the ends of a path that starts and stops at rest they are zero; a path that
// starts in motion begins with the slope between its first two nodes. The influence of an end decays by a
// factor of 3.7 per node, so the nodes of a circle are continued beyond both ends until the influence is
// below rounding.
void EquilibriumPath::FitSlopes() {
  const int last = num_nodes() - 1;
  if (last == 0) return;
  const bool periodic = path_.is_periodic();
  const int margin = periodic ? 40 : 0;
  const auto value = [&](int i) { return values_.col(periodic ? (i + last) % last : i); };

  const int count = last + 1 + 2 * margin;
  Eigen::MatrixXd slope = Eigen::MatrixXd::Zero(values_.rows(), count);
  std::vector<double> upper(count, 0.0);
  if (!periodic &&
      (!path_.At(first_).velocity.isZero(0) || (anchors_.any() && first_ > anchors_.start_time())))
    slope.col(0) = (value(1) - value(0)) / step_;
  for (int c = 1; c + 1 < count; ++c) {
    const int i = c - margin;
    const double pivot = 4 - upper[c - 1];
    upper[c] = 1 / pivot;
    slope.col(c) = (3 / step_ * (value(i + 1) - value(i - 1)) - slope.col(c - 1)) / pivot;
  }
  for (int c = count - 2; c > 0; --c) slope.col(c) -= upper[c] * slope.col(c + 1);
  slopes_ = slope.middleCols(margin, last + 1);
}

void EquilibriumPath::At(double time, CdprReference* reference) const {
  const int n = robot_.num_cables();
  const PathPoint point = path_.At(time);
  Path::Parameter parameter = path_.ParameterAt(time);
  reference->position = point.position;
  reference->velocity = point.velocity;
  reference->acceleration = point.acceleration;

  const int last = num_nodes() - 1;
  if (anchors_.any()) {
    const double end = first_ + last * step_;
    parameter = {std::clamp(time, first_, end), time >= first_ && time < end ? 1.0 : 0.0, 0};
  }
  if (last == 0) {
    reference->euler = values_.col(0).head<3>();
    reference->euler_rate.setZero();
    reference->tension = values_.col(0).tail(n);
  } else {
    double s = parameter.value - first_;
    if (path_.is_periodic()) s -= kTwoPi * std::floor(s / kTwoPi);
    const int i = std::clamp(static_cast<int>(s / step_), 0, last - 1);
    const double x = s / step_ - i, y = 1 - x;
    const auto value = y * y * (1 + 2 * x) * values_.col(i) + x * x * (1 + 2 * y) * values_.col(i + 1) +
                       step_ * x * y * (y * slopes_.col(i) - x * slopes_.col(i + 1));
    const auto slope = 6 * x * y / step_ * (values_.col(i + 1) - values_.col(i)) +
                       y * (1 - 3 * x) * slopes_.col(i) + x * (1 - 3 * y) * slopes_.col(i + 1);
    reference->euler = value.head<3>();
    reference->euler_rate = slope.head<3>() * parameter.rate;
    reference->tension = value.tail(n);
  }
  robot_.LimitTension(&reference->tension);

  const Eigen::Matrix3d R_WB = RotationFromEuler(reference->euler);
  Vector6d twist;
  twist << reference->velocity, EulerRateMatrix(reference->euler) * reference->euler_rate;
  reference->length.resize(n);
  reference->length_rate.resize(n);
  for (int i = 0; i < n; ++i) {
    const CableLine line = CalcCableLine(robot_, i, reference->position, R_WB, anchors_, time);
    reference->length[i] = line.length;
    reference->length_rate[i] = (-line.wrench).dot(twist);
    if (anchors_.any()) reference->length_rate[i] += line.anchor_rate;
  }
}

CdprReference EquilibriumPath::At(double time) const {
  CdprReference reference;
  At(time, &reference);
  return reference;
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::CdprReference);
