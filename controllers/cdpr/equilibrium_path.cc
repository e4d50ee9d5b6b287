#include <tenon/controllers/cdpr/equilibrium_path.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/systems/framework/types/errors.h>

#include <Eigen/LU>
#include <Eigen/SparseLU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <string>

namespace tenon {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr int kNodesPerTurn = 720;
constexpr double kNodeInterval = 0.02;  // [s]
constexpr int kFewestIntervals = 100;
constexpr double kLargestJump = 0.1;    // largest change of the attitude between nodes of a branch [rad]
constexpr double kLargestDrift = 1e-6;  // largest drift of the attitude after one turn [rad]

void Require(bool good, const std::string& message) {
  if (!good) throw ParameterError(message);
}

void RequireFinite(const char* path, const char* what, const Eigen::Vector3d& p) {
  Require(p.allFinite(),
          fmt::format("{}: {} is ({:g}, {:g}, {:g}), which is not finite.", path, what, p.x(), p.y(), p.z()));
}

void RequirePositive(const char* path, const char* what, double value, const char* units) {
  Require(std::isfinite(value) && value > 0,
          fmt::format("{}: {} is {:g} {} and must be positive.", path, what, value, units));
}

// A quintic from position, velocity and acceleration at both ends of a piece of a spline.
Eigen::Matrix<double, 3, 6> HermiteQuintic(double h, const PathPoint& a, const PathPoint& b) {
  const Eigen::Vector3d d = b.position - a.position;
  const Eigen::Vector3d va = a.velocity * h, vb = b.velocity * h;
  const Eigen::Vector3d aa = a.acceleration * (h * h), ab = b.acceleration * (h * h);
  Eigen::Matrix<double, 3, 6> c;
  c.col(0) = a.position;
  c.col(1) = a.velocity;
  c.col(2) = a.acceleration / 2;
  c.col(3) = (20 * d - 8 * vb - 12 * va - 3 * aa + ab) / (2 * std::pow(h, 3));
  c.col(4) = (-30 * d + 14 * vb + 16 * va + 3 * aa - 2 * ab) / (2 * std::pow(h, 4));
  c.col(5) = (12 * d - 6 * vb - 6 * va - aa + ab) / (2 * std::pow(h, 5));
  return c;
}

}  // namespace

Path Path::Circle(const Eigen::Vector3d& center, double radius, double period, double ramp,
                  const Eigen::Vector3d& along, const Eigen::Vector3d& across) {
  RequireFinite("Path::Circle", "the centre", center);
  RequirePositive("Path::Circle", "the radius", radius, "m");
  RequirePositive("Path::Circle", "the period", period, "s");
  RequirePositive("Path::Circle", "the ramp", ramp, "s");
  Path path;
  path.center_ = center;
  path.radius_ = radius;
  path.period_ = period;
  path.ramp_ = ramp;
  path.along_ = along;
  path.across_ = across;
  return path;
}

Path Path::Line(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double duration) {
  RequireFinite("Path::Line", "the start", from);
  RequireFinite("Path::Line", "the end", to);
  RequirePositive("Path::Line", "the duration", duration, "s");
  return Spline({from, to}, {0, duration});
}

Path Path::Spline(const std::vector<Eigen::Vector3d>& points, const std::vector<double>& times) {
  const int n = static_cast<int>(points.size());
  Require(n >= 2, fmt::format("Path::Spline: {} points, and it takes at least 2.", n));
  Require(times.size() == points.size(),
          fmt::format("Path::Spline: {} points but {} times.", points.size(), times.size()));
  for (int i = 0; i < n; ++i) {
    RequireFinite("Path::Spline", fmt::format("point {} of {}", i + 1, n).c_str(), points[i]);
    Require(std::isfinite(times[i]) && (i == 0 || times[i] > times[i - 1]),
            fmt::format("Path::Spline: time {} of {} is {:g} s; the times must be finite and increase.",
                        i + 1, n, times[i]));
  }

  // Solves for velocities and accelerations of the inner points such that jerk and snap are continuous there.
  // For a piece of duration h between a and b, with the difference d of its ends:
  //
  //     jerk(a) h^3 = 60 d - 36 va h - 24 vb h - 9 aa h^2 + 3 ab h^2
  //     snap(a) h^4 / 12 = -30 d + 16 va h + 14 vb h + 3 aa h^2 - 2 ab h^2
  //
  // jerk(b) results from jerk(a) by exchanging va with vb, and aa with -ab; snap(b) likewise, with opposite
  // sign.
  const int inner = n - 2;
  std::vector<Eigen::Triplet<double>> system;  // banded
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(2 * inner, 3);
  const auto add = [&](int row, int point, double of_velocity, double of_acceleration) {
    if (point == 0 || point == n - 1) return;  // at rest
    system.emplace_back(row, 2 * (point - 1), of_velocity);
    system.emplace_back(row, 2 * (point - 1) + 1, of_acceleration);
  };
  for (int i = 1; i + 1 < n; ++i) {
    const int jerk = 2 * (i - 1), snap = jerk + 1;
    const double h = times[i] - times[i - 1], k = times[i + 1] - times[i];
    add(jerk, i - 1, -24 / (h * h), -3 / h);
    add(jerk, i, -36 / (h * h) + 36 / (k * k), 9 / h + 9 / k);
    add(jerk, i + 1, 24 / (k * k), -3 / k);
    add(snap, i - 1, -14 / std::pow(h, 3), -2 / (h * h));
    add(snap, i, -16 / std::pow(h, 3) - 16 / std::pow(k, 3), 3 / (h * h) - 3 / (k * k));
    add(snap, i + 1, -14 / std::pow(k, 3), 2 / (k * k));
    const Eigen::Vector3d before = points[i] - points[i - 1], after = points[i + 1] - points[i];
    right.row(jerk) = 60 * (after / std::pow(k, 3) - before / std::pow(h, 3)).transpose();
    right.row(snap) = -30 * (after / std::pow(k, 4) + before / std::pow(h, 4)).transpose();
  }
  Eigen::MatrixXd solution = right;
  if (inner > 0) {
    Eigen::SparseMatrix<double> matrix(2 * inner, 2 * inner);
    matrix.setFromTriplets(system.begin(), system.end());
    solution = Eigen::SparseLU<Eigen::SparseMatrix<double>>(matrix).solve(right);
  }

  std::vector<PathPoint> knots(n);
  for (int i = 0; i < n; ++i) {
    knots[i].position = points[i];
    if (i == 0 || i == n - 1) continue;
    knots[i].velocity = solution.row(2 * (i - 1));
    knots[i].acceleration = solution.row(2 * (i - 1) + 1);
  }
  Path path;
  path.times_ = times;
  path.center_ = points.back();
  for (int i = 0; i + 1 < n; ++i) {
    path.pieces_.push_back(HermiteQuintic(times[i + 1] - times[i], knots[i], knots[i + 1]));
  }
  return path;
}

Path Path::Waypoints(const std::vector<Eigen::Vector3d>& points, const std::vector<double>& times) {
  const std::size_t n = points.size();
  if (n < 2 || times.size() != n) return Spline(points, times);  // throws with the reason
  Path path;
  path.times_ = times;
  path.center_ = points.back();
  for (std::size_t first = 0; first + 1 < n;) {
    std::size_t last = first + 1;
    const bool rests = points[first] == points[last];
    while (!rests && last + 1 < n && points[last + 1] != points[last]) ++last;
    const auto part = [&](const auto& all) {
      return std::vector(all.begin() + static_cast<std::ptrdiff_t>(first),
                         all.begin() + static_cast<std::ptrdiff_t>(last + 1));
    };
    const Path moves = Spline(part(points), part(times));  // constant for a single point
    path.pieces_.insert(path.pieces_.end(), moves.pieces_.begin(), moves.pieces_.end());
    first = last;
  }
  return path;
}

Path Path::Move(const PathPoint& from, double start, const Eigen::Vector3d& to, double end) {
  RequireFinite("Path::Move", "the start", from.position);
  RequireFinite("Path::Move", "the end", to);
  RequirePositive("Path::Move", "the duration", end - start, "s");
  Path path;
  path.times_ = {start, end};
  path.center_ = to;
  path.pieces_.push_back(HermiteQuintic(end - start, from, {.position = to}));
  return path;
}

Path Path::Hold(const Eigen::Vector3d& position) {
  RequireFinite("Path::Hold", "the position", position);
  Path path;
  path.center_ = position;
  return path;
}

double Path::end_time() const {
  return is_periodic() ? std::numeric_limits<double>::infinity() : times_.back();
}

Path::Parameter Path::ParameterAt(double time) const {
  if (!is_periodic()) {
    const bool moves = time >= times_.front() && time < times_.back();
    return {std::clamp(time, times_.front(), times_.back()), moves ? 1.0 : 0.0, 0};
  }
  const double full_rate = kTwoPi / period_;
  if (time <= 0) return {0, 0, 0};
  if (time >= ramp_) return {full_rate * (time - ramp_ / 2), full_rate, 0};
  const double x = time / ramp_, x3 = x * x * x;
  return {full_rate * ramp_ * x3 * x * (2.5 - 3 * x + x * x), full_rate * x3 * (10 - 15 * x + 6 * x * x),
          full_rate / ramp_ * 30 * x * x * (1 - x) * (1 - x)};
}

PathPoint Path::At(double time) const {
  PathPoint point;
  if (is_periodic()) {
    const Parameter angle = ParameterAt(time);
    const double c = radius_ * std::cos(angle.value), s = radius_ * std::sin(angle.value);
    const Eigen::Vector3d outwards = c * along_ + s * across_, onwards = c * across_ - s * along_;
    point.position = center_ + outwards;
    point.velocity = onwards * angle.rate;
    point.acceleration = onwards * angle.acceleration - outwards * (angle.rate * angle.rate);
    return point;
  }
  if (pieces_.empty() || time >= times_.back()) {
    point.position = center_;
    return point;
  }
  if (time < times_.front()) {
    point.position = pieces_.front().col(0);
    return point;
  }
  const auto piece = std::upper_bound(times_.begin(), times_.end(), time) - times_.begin() - 1;
  const Quintic& c = pieces_[piece];
  const double t = time - times_[piece];
  point.position =
      c.col(0) + t * (c.col(1) + t * (c.col(2) + t * (c.col(3) + t * (c.col(4) + t * c.col(5)))));
  point.velocity = c.col(1) + t * (2 * c.col(2) + t * (3 * c.col(3) + t * (4 * c.col(4) + t * 5 * c.col(5))));
  point.acceleration = 2 * c.col(2) + t * (6 * c.col(3) + t * (12 * c.col(4) + t * 20 * c.col(5)));
  return point;
}

Eigen::Vector3d Path::PositionOf(double parameter) const {
  if (!is_periodic()) return At(parameter).position;
  return center_ + radius_ * (std::cos(parameter) * along_ + std::sin(parameter) * across_);
}

double Path::TimeOf(double parameter) const {
  if (!is_periodic()) return std::clamp(parameter, times_.front(), times_.back());
  double low = 0, high = std::max(parameter, 0.0) * period_ / kTwoPi + ramp_;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (ParameterAt(middle).value < parameter ? low : high) = middle;
  }
  return high;
}

EquilibriumPath::EquilibriumPath(const CdprDescription& robot, const Path& path,
                                 const StaticsOptions& options, const std::optional<Path>& attitude)
    : robot_(robot), path_(path), options_(options) {
  options_.warm_start.reset();
  if (attitude) options_.attitude = attitude->At(attitude->start_time()).position;
  Require(!attitude || !path.is_periodic(),
          "EquilibriumPath: on a circle the attitude is constant, give it in the options.");
  int intervals = 0;
  if (path.is_periodic()) {
    intervals = kNodesPerTurn;
    step_ = kTwoPi / intervals;
  } else if (const double duration = path.end_time() - path.start_time(); duration > 0) {
    intervals = std::max(kFewestIntervals, static_cast<int>(std::ceil(duration / kNodeInterval)));
    first_ = path.start_time();
    step_ = duration / intervals;
  }

  StaticsOptions each = options;
  values_.resize(3 + robot.num_cables(), intervals + 1);
  slopes_.setZero(values_.rows(), values_.cols());
  for (int i = 0; i <= intervals; ++i) {
    const double parameter = first_ + i * step_;
    const double time = std::round(path.TimeOf(parameter) * 1e6) / 1e6;  // for messages
    StaticEquilibrium found;
    if (attitude) each.attitude = attitude->PositionOf(parameter);
    try {
      found = SolveInverseGeometricoStatic(robot, path.PositionOf(parameter), each);
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
    Require(drift < kLargestDrift,
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
  if (!periodic && !path_.At(path_.start_time()).velocity.isZero(0))
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
  const Path::Parameter parameter = path_.ParameterAt(time);
  reference->position = point.position;
  reference->velocity = point.velocity;
  reference->acceleration = point.acceleration;

  const int last = num_nodes() - 1;
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
    const CableLine line = CalcCableLine(robot_, i, reference->position, R_WB);
    reference->length[i] = line.length;
    reference->length_rate[i] = (-line.wrench).dot(twist);
  }
}

CdprReference EquilibriumPath::At(double time) const {
  CdprReference reference;
  At(time, &reference);
  return reference;
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::CdprReference);
