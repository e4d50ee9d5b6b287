#include <tenon/plants/model/path.h>
#include <tenon/systems/block.h>

#include <Eigen/SparseLU>
#include <fmt/format.h>

#include <algorithm>
#include <numbers>

namespace tenon {

namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

void RequireFinite(const char* path, const char* what, const Eigen::Vector3d& p) {
  Demand(p.allFinite(),
         fmt::format("{}: {} is ({:g}, {:g}, {:g}), which is not finite.", path, what, p.x(), p.y(), p.z()));
}

void RequirePositive(const char* path, const char* what, double value, const char* units) {
  Demand(std::isfinite(value) && value > 0,
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
  Demand(n >= 2, fmt::format("Path::Spline: {} points, and it takes at least 2.", n));
  Demand(times.size() == points.size(),
         fmt::format("Path::Spline: {} points but {} times.", points.size(), times.size()));
  for (int i = 0; i < n; ++i) {
    RequireFinite("Path::Spline", fmt::format("point {} of {}", i + 1, n).c_str(), points[i]);
    Demand(std::isfinite(times[i]) && (i == 0 || times[i] > times[i - 1]),
           fmt::format("Path::Spline: time {} of {} is {:g} s; the times must be finite and increase.", i + 1,
                       n, times[i]));
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
  for (int i = 0; i + 1 < n; ++i)
    path.pieces_.push_back(HermiteQuintic(times[i + 1] - times[i], knots[i], knots[i + 1]));
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

MovingAnchors::MovingAnchors(const CdprDescription& robot) {
  const auto moves = [](const CableDescription& cable) { return cable.anchor_path.has_value(); };
  if (std::ranges::none_of(robot.cables, moves)) return;
  start_ = std::numeric_limits<double>::infinity();
  for (const CableDescription& cable : robot.cables) {
    paths_.emplace_back();
    if (!moves(cable)) continue;
    cable.anchor_path->Validate();
    paths_.back() = Path::Waypoints(cable.anchor_path->offsets, cable.anchor_path->times);
    start_ = std::min(start_, paths_.back()->start_time());
    end_ = std::max(end_, paths_.back()->end_time());
  }
}

CdprDescription MovingAnchors::RobotAt(const CdprDescription& robot, double time) const {
  CdprDescription at = robot;
  for (std::size_t i = 0; i < paths_.size(); ++i) {
    at.cables[i].anchor_W += At(static_cast<int>(i), time).position;
    at.cables[i].anchor_path.reset();
  }
  return at;
}

}  // namespace tenon
