#include <tenon/controllers/legged/planning/zmp_spline.h>
#include <tenon/systems/framework/block/system.h>

#include <fmt/core.h>

namespace tenon {
namespace {

constexpr int kCoefficients = 6;
// Gauss-Legendre quadrature with four points on [0, 1], exact up to degree seven.
constexpr std::array<double, 4> kGaussPoint{0.069431844202973712, 0.33000947820757187, 0.66999052179242813,
                                            0.93056815579702629};
constexpr std::array<double, 4> kGaussWeight{0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                                             0.17392742256872693};

}  // namespace

double HeightProfile::At(double t) const {
  if (t >= fade_duration) return rest;
  return rest + fade[0] + t * (fade[1] + t * (fade[2] + t * fade[3]));
}

double HeightProfile::Acceleration(double t) const {
  return t < fade_duration ? 2 * fade[2] + 6 * fade[3] * t : 0;
}

ZmpSpline::ZmpSpline()
    : maps_(kCoefficients * PlanarSpline::kMaxSegments, kMaxPerCoordinate + 2),
      H_(2 * kMaxPerCoordinate, 2 * kMaxPerCoordinate),
      g_(2 * kMaxPerCoordinate),
      b_eq_(4),
      b_in_(kMaxRows),
      A_eq_(4, 2 * kMaxPerCoordinate),
      A_in_(kMaxRows, 2 * kMaxPerCoordinate),
      solver_(2 * kMaxPerCoordinate, 4 + kMaxRows) {}

QuadraticProgram ZmpSpline::quadratic_program() const {
  const int n = 2 * n_;
  return {H_.topLeftCorner(n, n),        g_.head(n),       A_eq_.leftCols(n), b_eq_,
          A_in_.topLeftCorner(rows_, n), b_in_.head(rows_)};
}

QpReport ZmpSpline::Solve(const ZmpSplineProblem& problem, const ZmpSplineParams& params,
                          PlanarSpline* spline) {
  const auto phases = problem.phases.size();
  if (phases == 0 || phases > kMaxPhases)
    throw RunError(fmt::format("a spline over {} support phases: give one to {} phases", phases, kMaxPhases));
  segments_per_phase_ = params.order == SplineOrder::kCubic ? 2 : 1;
  free_ = params.order == SplineOrder::kCubic ? 1 : 3;
  MakeSegments(problem);
  AddCost(problem, params.path_weight);
  AddEnd(problem, params.end_weight);
  AddPolygons(problem);
  const QpReport report = solver_.Solve(quadratic_program());
  if (!report.ok()) return report;

  *spline = PlanarSpline();
  spline->origin = origin_;
  spline->num_segments = num_segments_;
  const auto solution = solver_.x();
  for (int k = 0; k < num_segments_; ++k) {
    PlanarSpline::Segment& segment = spline->segments[k];
    segment.duration = duration_[k];
    spline->duration += segment.duration;
    for (int i = 0; i < kCoefficients; ++i) {
      const auto row = maps_.row(kCoefficients * k + i);
      for (int axis = 0; axis < 2; ++axis)
        segment.coefficients[i][axis] = row[n_ + axis] + row.head(n_).dot(solution.segment(axis * n_, n_));
    }
  }
  return report;
}

/// Coefficients of each segment: three from the end of the previous one, the others from its variables.
void ZmpSpline::MakeSegments(const ZmpSplineProblem& problem) {
  num_segments_ = 0;
  for (const SupportPhase& phase : problem.phases)
    for (int i = 0; i < segments_per_phase_; ++i)
      duration_[num_segments_++] = phase.duration / segments_per_phase_;
  n_ = num_segments_ * free_;
  origin_ = problem.begin.position;
  maps_.setZero();
  for (int k = 0; k < num_segments_; ++k) {
    const double T = duration_[k];
    auto map = maps_.block(kCoefficients * k, 0, kCoefficients, n_ + 2);
    if (k == 0) {
      map.row(1).tail<2>() = T * problem.begin.velocity.transpose();
      map.row(2).tail<2>() = T * T / 2 * problem.begin.acceleration.transpose();
    } else {
      map.row(0) = Derivative(0, k - 1, 1);
      map.row(1) = T * Derivative(1, k - 1, 1);
      map.row(2) = T * T / 2 * Derivative(2, k - 1, 1);
    }
    for (int i = 0; i < free_; ++i)  // the second integral of u s^m is u s^(m + 2) / ((m + 1) (m + 2))
      map(3 + i, k * free_ + i) = T * T / ((i + 2) * (i + 3));
  }
}

/// x, x' or x'' at s in a segment, by `order`.
ZmpSpline::Functional ZmpSpline::Derivative(int order, int segment, double s) const {
  const auto map = maps_.block(kCoefficients * segment, 0, kCoefficients, n_ + 2);
  Functional f = Functional::Zero(n_ + 2);
  double power = std::pow(duration_[segment], -order);
  for (int i = order; i < 3 + free_; ++i, power *= s) {
    const int factor = order == 0 ? 1 : order == 1 ? i : i * (i - 1);
    f += factor * power * map.row(i);
  }
  return f;
}

/// Adds weight |f - target|^2 to the cost.
void ZmpSpline::AddSquare(const Functional& f, const Eigen::Vector2d& target, double weight) {
  const auto linear = f.head(n_);
  for (int i = 0; i < n_; ++i) {
    if (linear[i] == 0) continue;
    H_.col(i).segment(i, n_ - i) += 2 * weight * linear[i] * linear.tail(n_ - i).transpose();
  }
  for (int axis = 0; axis < 2; ++axis)
    g_.segment(axis * n_, n_) += 2 * weight * (f[n_ + axis] - target[axis]) * linear.transpose();
}

void ZmpSpline::AddCost(const ZmpSplineProblem& problem, double path_weight) {
  H_.setZero();
  g_.setZero();
  double begin = 0;
  for (int k = 0; k < num_segments_; ++k) {
    const double T = duration_[k];
    for (std::size_t i = 0; i < kGaussPoint.size(); ++i) {
      const double s = kGaussPoint[i], weight = kGaussWeight[i] * T;
      AddSquare(Derivative(2, k, s), Eigen::Vector2d::Zero(), weight);
      if (path_weight == 0) continue;
      const double t = begin + s * T;
      const Eigen::Vector2d path = (problem.regularized != nullptr ? problem.regularized->At(t).position
                                                                   : problem.path.At(t).position_W) -
                                   origin_;
      AddSquare(Derivative(0, k, s), path, path_weight * weight);
    }
    begin += T;
  }
}

void ZmpSpline::AddEnd(const ZmpSplineProblem& problem, double end_weight) {
  const int last = num_segments_ - 1;
  AddSquare(Derivative(2, last, 1), problem.end.acceleration, end_weight);
  H_.block(n_, n_, n_, n_) = H_.topLeftCorner(n_, n_);  // x and y have equal costs
  const Functional position = Derivative(0, last, 1), velocity = Derivative(1, last, 1);
  A_eq_.setZero();
  for (int axis = 0; axis < 2; ++axis) {
    A_eq_.row(2 * axis).segment(axis * n_, n_) = position.head(n_);
    A_eq_.row(2 * axis + 1).segment(axis * n_, n_) = velocity.head(n_);
    b_eq_[2 * axis] = problem.end.position[axis] - origin_[axis] - position[n_ + axis];
    b_eq_[2 * axis + 1] = problem.end.velocity[axis] - velocity[n_ + axis];
  }
}

void ZmpSpline::AddPolygons(const ZmpSplineProblem& problem) {
  rows_ = 0;
  double begin = 0;
  const auto bound = [&](const SupportPolygon& polygon, double t, int segment, double s) {
    const double ratio = problem.height.At(t) / (problem.gravity + problem.height.Acceleration(t));
    const Functional zmp = Derivative(0, segment, s) - ratio * Derivative(2, segment, s);
    for (const SupportPolygon::Edge& edge : polygon.edges()) {
      const Eigen::Vector2d normal(edge.a, edge.b);
      A_in_.row(rows_).head(n_) = edge.a * zmp.head(n_);
      A_in_.row(rows_).segment(n_, n_) = edge.b * zmp.head(n_);
      b_in_[rows_++] = -edge.c - normal.dot(origin_ + zmp.tail<2>().transpose());
    }
  };
  for (std::size_t p = 0; p < problem.phases.size(); ++p) {
    const SupportPhase& phase = problem.phases[p];
    const int first = static_cast<int>(p) * segments_per_phase_;
    if (p > 0) bound(phase.polygon, begin, first, 0);
    for (int i = 1; i <= kSamplesPerPhase; ++i) {
      const double in_segments = static_cast<double>(i * segments_per_phase_) / kSamplesPerPhase;
      const int segment = static_cast<int>(std::ceil(in_segments)) - 1;
      bound(phase.polygon, begin + i * phase.duration / kSamplesPerPhase, first + segment,
            in_segments - segment);
    }
    begin += phase.duration;
  }
}

}  // namespace tenon
