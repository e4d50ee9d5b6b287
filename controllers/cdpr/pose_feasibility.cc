#include <tenon/controllers/cdpr/pose_feasibility.h>
#include <tenon/controllers/optimization/infinity.h>
#include <tenon/plants/model/platform_springs.h>
#include <tenon/plants/model/vectors.h>

#include <Eigen/Cholesky>
#include <fmt/core.h>

#include <algorithm>
#include <numbers>

namespace tenon {
namespace {

constexpr double kPoint = 1e-9;     // distance below which an attachment counts as at the CoM [m]
constexpr double kRounding = 1e-9;  // rounding of tensions, relative to their upper bound
constexpr int kTighterBounds = 7;   // number of trials, each with half of the previous distance
constexpr double kAway = 0.7;       // fraction of the largest possible distance from the bounds

double Lever(const CdprDescription& robot) {
  double lever = 0;
  for (const CableDescription& cable : robot.cables) lever = std::max(lever, cable.attachment_B.norm());
  for (const SpringDescription& spring : robot.springs) lever = std::max(lever, spring.attachment_B.norm());
  return lever;
}

/// The motions that the cables must govern, as entries of a wrench, forces first.
Eigen::VectorXi Motions(const CdprDescription& robot) {
  std::vector<int> motions{0, 1, 2, 3, 4, 5};
  if (const auto plane = PlaneOf(robot)) motions.assign(plane->motions.begin(), plane->motions.end());
  if (Lever(robot) <= kPoint) std::erase_if(motions, [](int motion) { return motion > 2; });
  if (robot.num_cables() < std::ssize(motions)) {
    throw ParameterError(fmt::format(
        "robot '{}' has {} cables, too few for a wrench-feasible workspace, which takes {}: with fewer the "
        "platform's attitude cannot be prescribed, and it rests at single attitudes; take another robot, or "
        "let tenon-cdpr find them along a path",
        robot.name, robot.num_cables(), motions.size()));
  }
  return Eigen::Map<Eigen::VectorXi>(motions.data(), std::ssize(motions));
}

/// Returns the longest chord between two points of a unit sphere that are at most `angle` apart.
double Chord(double angle) {
  return 2 * std::sin(std::min(angle, std::numbers::pi) / 2);
}

}  // namespace

void PlatformDemand::Validate() const {
  for (const auto& [value, name] :
       {std::pair{load, "load [kg]"}, std::pair{acceleration, "acceleration [m/s^2]"},
        std::pair{force, "force [N]"}, std::pair{torque, "torque [N m]"}}) {
    if (!(value >= 0) || !std::isfinite(value))
      throw ParameterError(
          fmt::format("the {} that a platform needs is {}: give a finite number, 0 or more", name, value));
  }
}

WrenchBox RequiredWrenches(const CdprDescription& robot, const PlatformDemand& demand) {
  demand.Validate();
  const double mass = robot.mass + demand.load;
  WrenchBox box{-GravityWrench(robot) * (mass / robot.mass), Eigen::VectorXd(6)};
  box.half_width.head(3).setConstant(mass * demand.acceleration + demand.force);
  box.half_width.tail(3).setConstant(demand.torque);
  return box;
}

PoseFeasibility::PoseFeasibility(const CdprDescription& robot, const WrenchBox& required)
    : robot_(robot),
      low_(robot.tension_min()),
      high_(robot.tension_max()),
      inner_low_(low_),
      inner_high_(high_),
      lever_(Lever(robot)),
      motions_(Motions(robot)),
      rows_(static_cast<int>(motions_.size())),
      forces_(static_cast<int>((motions_.array() < 3).count())),
      up_(static_cast<int>(std::find(motions_.begin(), motions_.end(), 2) - motions_.begin())),
      asked_{required.centre(motions_), required.half_width(motions_)},
      by_springs_(Eigen::VectorXd::Zero(rows_)),
      wrenches_(rows_, low_, high_),
      distributor_(robot.num_cables()),
      interference_(robot),
      structure_(rows_, robot.num_cables()),
      turn_(robot.num_cables()),
      change_(robot.num_cables()),
      remainder_(robot.num_cables()),
      derivative_(static_cast<std::size_t>(robot.num_cables()), Matrix6d::Zero()),
      gain_(robot.num_cables()),
      spread_(robot.num_cables()) {
  robot_.RemovePulleys();
  if (turns()) {
    asked_.centre.tail(rows_ - forces_) /= lever_;
    asked_.half_width.tail(rows_ - forces_) /= lever_;
  } else if (required.centre.tail(3).norm() > 0 || required.half_width.tail(3).norm() > 0) {
    throw ParameterError(fmt::format(
        "robot '{}' has all attachments at its CoM and cannot produce torques: require none", robot.name));
  }
  required_ = asked_;
}

/// Returns false if a cable has no length at the centre.
bool PoseFeasibility::Move(const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB) {
  try {
    CalcCableKinematics(robot_, p_WB, R_WB, &cables_);
  } catch (const RunError&) {
    return false;
  }
  structure_ = cables_.structure.topRows(rows_);
  for (int k = 0; k < rows_; ++k)
    if (motions_[k] != k) structure_.row(k) = cables_.structure.row(motions_[k]);
  if (turns()) structure_.bottomRows(rows_ - forces_) /= lever_;
  if (robot_.springs.empty()) return true;
  Vector6d wrench = CalcSpringWrench(robot_.springs, p_WB, R_WB);
  if (turns()) wrench.tail(3) /= lever_;
  for (int k = 0; k < rows_; ++k) required_.centre[k] = asked_.centre[k] - wrench[motions_[k]];
  required_.half_width = asked_.half_width;
  return true;
}

WrenchMargins PoseFeasibility::At(const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB) {
  margins_ = {-kInfinity, -kInfinity, 0};
  if (!Move(p_WB, R_WB)) return margins_;
  wrenches_.SetStructure(structure_);
  margins_ = wrenches_.Margins(required_);
  return margins_;
}

/// Returns false if a cable may have no length within the set.
bool PoseFeasibility::BoundChanges(const PoseBall& poses) {
  const double chord = Chord(poses.angle);
  for (int i = 0; i < cables_.num_cables(); ++i) {
    const double arm = cables_.arm_W.col(i).norm();
    const double sine = (poses.distance + chord * arm) / cables_.length[i];
    if (!(sine < 1)) return false;
    turn_[i] = Chord(std::asin(sine));
    // arm' x lambda' - arm x lambda = arm' x (lambda' - lambda) + (arm' - arm) x lambda
    const double torque = turns() ? arm * (turn_[i] + chord) / lever_ : 0;
    change_[i] = std::hypot(turn_[i], torque);
  }
  return true;
}

void PoseFeasibility::BoundSprings(const PoseBall& poses) {
  const double chord = Chord(poses.angle);
  by_springs_.setZero();
  for (const SpringDescription& spring : robot_.springs) {
    const Eigen::Vector3d arm_W = poses.R_WB * spring.attachment_B;
    const double arm = arm_W.norm(), move = poses.distance + chord * arm,
                 length = (spring.anchor_W - poses.p_WB - arm_W).norm(),
                 pull = spring.stiffness * std::abs(length - spring.rest_length);
    double steepest = 1;
    if (spring.rest_length > 0)
      steepest = move < length ? std::max(1.0, spring.rest_length / (length - move) - 1) : kInfinity;
    const double change = spring.stiffness * steepest * move;
    by_springs_.head(forces_).array() += change;
    if (turns()) by_springs_.tail(rows_ - forces_).array() += arm * (change + chord * pull) / lever_;
  }
}

/// The derivatives of [lambda; arm x lambda / lever], see CalcWrenchJacobian(), and half of a bound of its
/// second derivative along any curve in the set. With the attachment b and s = |db|, the second derivative of
/// a unit vector is bounded by |lambda''| <= (1 + sqrt 5) / 2 s^2 / l^2 + |b''| / l.
void PoseFeasibility::Differentiate(const PoseBall& poses) {
  distance_ = poses.distance;
  angle_ = poses.angle;
  for (int i = 0; i < cables_.num_cables(); ++i) {
    const Eigen::Vector3d lambda = cables_.direction.col(i), arm_W = cables_.arm_W.col(i);
    const double length = cables_.length[i], arm = arm_W.norm();
    const Eigen::Matrix3d P = (Eigen::Matrix3d::Identity() - lambda * lambda.transpose()) / length,
                          X = CrossMatrix(arm_W);
    Matrix6d& derivative = derivative_[i];
    derivative.topLeftCorner<3, 3>() = -P;
    derivative.topRightCorner<3, 3>() = P * X;
    if (turns()) {
      derivative.bottomLeftCorner<3, 3>() = -X * P / lever_;
      derivative.bottomRightCorner<3, 3>() = (X * P * X + CrossMatrix(lambda) * X) / lever_;
    }
    for (int k = 0; k < rows_; ++k)
      if (motions_[k] != k) derivative.row(k) = derivative.row(motions_[k]);
    const double nearest = length - distance_ - Chord(angle_) * arm, move = distance_ + angle_ * arm;
    const double first = move / nearest;
    const double second = std::numbers::phi * first * first + angle_ * angle_ * arm / nearest;
    const double torque = turns() ? arm * (angle_ * angle_ + 2 * angle_ * first + second) / lever_ : 0;
    remainder_[i] = std::hypot(second, torque) / 2;
  }
}

/// Returns the largest |row . [dp; dtheta]| over the set.
double PoseFeasibility::OverBall(const Eigen::Matrix<double, 1, 6>& row) const {
  return row.head<3>().norm() * distance_ + row.tail<3>().norm() * angle_;
}

/// Returns the largest change of c . w_i over the set for a unit vector c.
double PoseFeasibility::ChangeAlong(const SmallVector& c, int cable) const {
  const Matrix6d& derivative = derivative_[cable];
  const Eigen::Matrix<double, 1, 6> row = c.transpose() * derivative.topRows(rows_);
  return std::min(change_[cable], OverBall(row) + remainder_[cable]);
}

PoseVerdict PoseFeasibility::Over(const PoseBall& poses) {
  At(poses.p_WB, poses.R_WB);
  if (!std::isfinite(margins_.tension) || !BoundChanges(poses)) return PoseVerdict::kUndecided;
  Differentiate(poses);
  const WrenchMargins centre = margins_;
  if (!robot_.springs.empty()) {
    BoundSprings(poses);
    if (!by_springs_.allFinite()) return PoseVerdict::kUndecided;
    required_.half_width += by_springs_;
    margins_ = wrenches_.Margins(required_);
  }
  const bool holds = HoldsOver();
  margins_ = centre;
  if (holds) return PoseVerdict::kHolds;
  return FailsOver() ? PoseVerdict::kFails : PoseVerdict::kUndecided;
}

/// Returns an upper bound of the sum of tensions that produce a required wrench [N]: at the centre for 0,
/// over the whole set for 1. The bound is infinite unless all cables pull upwards.
double PoseFeasibility::TensionSum(double turned) const {
  if (up_ == rows_) return kInfinity;
  double least = kInfinity;
  for (int i = 0; i < cables_.num_cables(); ++i)
    least = std::min(least, cables_.direction(2, i) - turned * turn_[i]);
  return least > 0 ? (required_.centre[up_] + required_.half_width[up_]) / least : kInfinity;
}

bool PoseFeasibility::HoldsOver() {
  if (!(margins_.tension > 0)) return false;
  const SmallMatrix gram = structure_ * structure_.transpose();
  const Eigen::LLT<SmallMatrix> llt(gram);
  if (llt.info() != Eigen::Success) return false;
  const SmallMatrix inverse = llt.solve(SmallMatrix::Identity(rows_, rows_));
  for (int i = 0; i < robot_.num_cables(); ++i) gain_[i] = SmallVector(inverse * structure_.col(i)).norm();
  const double contraction = change_.dot(gain_);
  if (!(contraction < 1)) return false;
  return HoldsByMargin(gain_.maxCoeff() / (1 - contraction)) || HoldsByTensions(inverse, contraction);
}

/// `gain` times sum_j u_j d_j bounds the change of a tension.
bool PoseFeasibility::HoldsByMargin(double gain) const {
  const double rounding = kRounding * high_.maxCoeff();
  if (gain * TensionSum(0) * change_.maxCoeff() + rounding <= margins_.tension) return true;
  double share = 1, margin = margins_.tension;
  for (int i = 0; i <= kTighterBounds && margin > 0; ++i) {
    const double changes = ((1 - share) * low_ + share * high_).dot(change_) - margin * change_.sum();
    if (gain * changes + rounding <= margin) return true;
    share /= 2;
    margin = wrenches_.Margins(required_, share).tension;
  }
  return false;
}

bool PoseFeasibility::HoldsByTensions(const SmallMatrix& gram_inverse, double contraction) {
  const int n = robot_.num_cables();
  // Spread of the tensions over the box of required wrenches.
  double spread_max = 0, spread_change = 0;
  for (int i = 0; i < n; ++i) {
    SmallVector row = SmallVector::Zero(rows_);  // initialised because GCC 14 warns about the product
    row.noalias() = gram_inverse * structure_.col(i);
    spread_[i] = row.cwiseAbs().dot(required_.half_width);
    spread_max = std::max(spread_max, spread_[i]);
    spread_change += spread_[i] * change_[i];
  }
  const double away = kAway * margins_.tension + spread_max;
  if (!((high_ - low_).minCoeff() > 2 * away)) return false;
  Vector6d wrench = Vector6d::Zero();
  for (int k = 0; k < rows_; ++k) wrench[motions_[k]] = required_.centre[k];
  if (turns()) wrench.tail(3) *= lever_;
  inner_low_ = low_.array() + away;
  inner_high_ = high_.array() - away;
  const TensionDistribution& found = distributor_.Solve(cables_.structure, wrench, inner_low_, inner_high_);
  if (!found.feasible) return false;

  Matrix6d first_order = Matrix6d::Zero();
  for (int i = 0; i < n; ++i) first_order += found.tension[i] * derivative_[i];
  const double remainder = found.tension.dot(remainder_);
  double square = 0;
  for (int k = 0; k < rows_; ++k) square += std::pow(OverBall(first_order.row(k)), 2);
  const double missing = std::min(std::sqrt(square) + remainder, found.tension.dot(change_)) + spread_change;
  const double beyond = remainder + spread_change + missing * contraction / (1 - contraction);
  for (int i = 0; i < n; ++i) {
    const SmallVector row = gram_inverse * structure_.col(i);
    const Eigen::Matrix<double, 1, 6> gradient = row.transpose() * first_order.topRows(rows_);
    const double room = std::min(found.tension[i] - low_[i], high_[i] - found.tension[i]) - spread_[i];
    if (!(OverBall(gradient) + gain_[i] * beyond + kRounding * high_.maxCoeff() <= room)) return false;
  }
  return true;
}

bool PoseFeasibility::FailsOver() const {
  if (!(margins_.tension < 0)) return false;
  const auto& normal = wrenches_.normal(margins_.facet);
  // Selects the more violated of two opposite facets, and the required wrench that is farthest beyond it.
  double middle = 0;
  for (int i = 0; i < robot_.num_cables(); ++i)
    middle += (low_[i] + high_[i]) / 2 * normal.dot(structure_.col(i));
  const bool opposite = middle > normal.dot(required_.centre);
  const SmallVector c = normal * ((opposite ? -1 : 1) / normal.norm());
  SmallVector wrench = required_.centre;
  for (int k = 0; k < rows_; ++k) {
    const double half_width = required_.half_width[k] - 2 * by_springs_[k];
    wrench[k] += c[k] < 0 ? -half_width : half_width;
  }
  return FailsByFixedNormal(c, wrench) || FailsByMovingNormal(c, wrench);
}

bool PoseFeasibility::FailsByFixedNormal(const SmallVector& c, const SmallVector& wrench) const {
  double by_bounds = 0, at_least = 0, largest = 0;
  for (int i = 0; i < robot_.num_cables(); ++i) {
    const double x = c.dot(structure_.col(i)) + ChangeAlong(c, i);
    by_bounds += x * (x > 0 ? high_ : low_)[i];
    at_least += x * low_[i];
    largest = std::max(largest, x);
  }
  const double spare = TensionSum(1) - low_.sum();  // total tension above the lower bounds
  const double by_sum = largest > 0 ? at_least + std::max(spare, 0.0) * largest : at_least;
  return std::min(by_bounds, by_sum) + kRounding * high_.maxCoeff() < c.dot(wrench);
}

/// The normal c + e of the same cables at another pose satisfies (c + e) . (w_j + D_j) = 0 for the cables in
/// the facet, with e normal to c. Hence |e| <= |c . D| / (sigma - |d|), where |d| is the norm of their d_j
/// and sigma a lower bound of the smallest singular value of their columns A: 1 / sigma^2 is the trace of
/// (A^T A)^-1.
bool PoseFeasibility::FailsByMovingNormal(const SmallVector& c, const SmallVector& wrench) const {
  const auto facet = wrenches_.cables(margins_.facet);
  SmallMatrix columns(rows_, rows_ - 1);
  double square = 0, square_along = 0;
  for (int j = 0; j < rows_ - 1; ++j) {
    columns.col(j) = structure_.col(facet[j]);
    square += std::pow(change_[facet[j]], 2);
    square_along += std::pow(ChangeAlong(c, facet[j]), 2);
  }
  const SmallMatrix gram = columns.transpose() * columns;
  const Eigen::LLT<SmallMatrix> llt(gram);
  if (llt.info() != Eigen::Success) return false;
  const SmallMatrix inverse = llt.solve(SmallMatrix::Identity(rows_ - 1, rows_ - 1));
  const double sigma = 1 / std::sqrt(inverse.trace()), change = std::sqrt(square);
  if (!(change < sigma)) return false;
  const double turn = std::sqrt(square_along) / (sigma - change);
  double most = 0;
  for (int i = 0; i < robot_.num_cables(); ++i) {
    if ((facet.array() == i).any()) continue;
    const double x =
        c.dot(structure_.col(i)) + ChangeAlong(c, i) + turn * (structure_.col(i).norm() + change_[i]);
    most += x * (x > 0 ? high_ : low_)[i];
  }
  return most + kRounding * high_.maxCoeff() <
         c.dot(wrench) - turn * (wrench.norm() + 2 * by_springs_.norm());
}

PoseVerdict PoseFeasibility::IsClearOver(const PoseBall& poses, double diameter) {
  if (!Move(poses.p_WB, poses.R_WB) || !BoundChanges(poses)) {
    clearance_ = {};
    return PoseVerdict::kUndecided;
  }
  clearance_ = interference_.At(cables_, poses.R_WB);
  const double chord = Chord(poses.angle), move = 2 * (poses.distance + chord * lever_),
               turn = turn_.maxCoeff() + chord;
  if (clearance_.cables >= diameter && clearance_.platform - turn >= 0 &&
      (clearance_.cables - move >= diameter ||
       interference_.LeastDistance(cables_, poses.distance, chord) >= diameter))
    return PoseVerdict::kHolds;
  if (clearance_.cables + move < diameter || clearance_.platform + turn < 0) return PoseVerdict::kFails;
  return PoseVerdict::kUndecided;
}

}  // namespace tenon
