#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <tenon/systems/framework/fields.h>

namespace tenon {

/// Matrices of constraints: one constraint a row, rows contiguous.
using ConstraintMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// min 1/2 x^T H x + g^T x   subject to   A_eq x = b_eq,   A_in x >= b_in.
///
/// H is symmetric and positive definite; its lower triangle is what is read. Blocks of larger matrices
/// serve as they are, without copies, as long as H is stored by columns and the constraints by rows.
struct QuadraticProgram {
  Eigen::Ref<const Eigen::MatrixXd> H;
  Eigen::Ref<const Eigen::VectorXd> g;
  Eigen::Ref<const ConstraintMatrix> A_eq;
  Eigen::Ref<const Eigen::VectorXd> b_eq;
  Eigen::Ref<const ConstraintMatrix> A_in;
  Eigen::Ref<const Eigen::VectorXd> b_in;
};

enum class QpStatus {
  kSolved,
  kInfeasible,      ///< no x meets `constraint` and the other ones together
  kNotConvex,       ///< H is not positive definite: its leading block that ends with row `constraint` is not
  kNotFinite,       ///< a number of the problem is NaN or infinite
  kIterationLimit,  ///< constraints were exchanged too often
  kInaccurate,      ///< ended, but not within the tolerance: H or the constraints are nearly singular
};

constexpr auto EnumNames(QpStatus) {
  return std::array{Named{QpStatus::kSolved, "solved"},
                    Named{QpStatus::kInfeasible, "infeasible"},
                    Named{QpStatus::kNotConvex, "not_convex"},
                    Named{QpStatus::kNotFinite, "not_finite"},
                    Named{QpStatus::kIterationLimit, "iteration_limit"},
                    Named{QpStatus::kInaccurate, "inaccurate"}};
}

struct QpReport {
  QpStatus status = QpStatus::kSolved;
  int constraint = -1;  ///< which one the status is about; equalities first, then inequalities
  int iterations = 0;   ///< constraints that were added or dropped after the start
  int restarts = 0;     ///< factorisations after the first one that did not yield an end

  bool ok() const { return status == QpStatus::kSolved; }
  /// One sentence: what happened and what to do.
  std::string Message() const;
};

/// Solver of strictly convex, dense quadratic programs for control loops: a dual active set method
/// (Goldfarb and Idnani, Math. Programming 27, 1983). It begins at a minimum over some of the constraints and
/// adds violated ones, dropping those whose multipliers would turn negative; the cost rises at each step, so
/// it ends after finitely many, at the solution or at a constraint that contradicts the others.
///
/// With H = L L^T and V = L^-1 A^T for the active constraints, V = Q (R; 0). Unlike the paper, which updates
/// J = L^-T Q, this keeps L and Q apart: the start at a guessed active set is one Householder factorisation
/// without forming Q, and a solve whose guess is right ends there. Zeros at the beginning of the rows of H
/// stay zeros in L and cost nothing; so do zeros at the end of the first equalities where H leaves them.
///
/// The guess is pruned of dependent constraints and of those with negative multipliers, so any guess is safe
/// and only the number of iterations depends on it. The solution is refined from its residuals; if they stay
/// above the tolerance, or if the problem seems infeasible after updates of Q, it starts again from fresh
/// factors. Redundant constraints do no harm, equalities included.
///
/// Everything is allocated by the constructor, nothing by Solve(). Copies are independent.
class DualActiveSet {
 public:
  /// Tolerance of the residuals, relative to the terms that they are made of.
  static constexpr double kTolerance = 1e-10;

  /// For up to `max_variables` and so many equalities and inequalities together.
  DualActiveSet(int max_variables, int max_constraints, int max_iterations = 200);

  /// Minimises. `guess` holds indices of inequalities that may be active: those of the last, similar
  /// problem, or none. Throws ParameterError if sizes do not fit together, or exceed what this was made for.
  QpReport Solve(const QuadraticProgram& qp, std::span<const int> guess = {});

  /// Of the last Solve() that was ok: the minimiser,
  auto x() const { return x_.head(n_); }
  /// the multipliers of the equalities, then of the inequalities (>= 0, zero if not active), with
  /// H x + g = A^T multipliers,
  auto multipliers() const { return multipliers_.head(num_equalities_ + num_inequalities_); }
  /// and the active inequalities, the guess for a similar problem.
  std::span<const int> active() const { return active_inequalities_; }

 private:
  struct Outcome {
    QpStatus status;
    int constraint = -1;
  };
  void CheckSizes(const QuadraticProgram& qp) const;
  int FactorCost(const QuadraticProgram& qp);
  void Start(const QuadraticProgram& qp);
  bool Append(const QuadraticProgram& qp, int constraint, double independence);
  Outcome Iterate(const QuadraticProgram& qp, int* iterations);
  int MostViolated(const QuadraticProgram& qp);
  Outcome AddViolated(const QuadraticProgram& qp, int constraint, int* iterations);
  void Drop(int position);
  int Refine(const QuadraticProgram& qp);
  void SolveActive(const Eigen::Ref<const Eigen::VectorXd>& g);
  auto Reflector(int k) const {
    return reflectors_.col(k).segment(k, ends_[static_cast<std::size_t>(k)] - k);
  }
  void FormQ();
  void ApplyQTransposed(Eigen::VectorXd& v);
  void ApplyQ(Eigen::VectorXd& v);
  void SolveL(Eigen::VectorXd& v) const;
  void SolveLTransposed(Eigen::VectorXd& v) const;

  int max_constraints_, max_iterations_;
  int n_ = 0, num_equalities_ = 0, num_inequalities_ = 0;
  int num_active_ = 0, num_active_equalities_ = 0;
  bool q_is_formed_ = false;

  ConstraintMatrix L_;            // its diagonal holds reciprocals
  std::vector<int> first_;        // first column of each row of L that is not zero
  Eigen::MatrixXd R_;             // upper triangle
  Eigen::MatrixXd reflectors_;    // column k: the reflector that made column k of R, from row k on,
  std::vector<int> ends_;         // before row ends_[k]; what follows is zero
  Eigen::MatrixXd Q_;             // once formed
  Eigen::VectorXd column_norms_;  // of V
  std::vector<int> active_;       // constraints in the order of R's columns
  std::vector<int> active_inequalities_, guess_;
  std::vector<char> is_active_;
  Eigen::VectorXd x_, u_, multipliers_, b_, residual_, slack_, row_norms_;
  Eigen::VectorXd v_, d_, w_, r_, dx_, du_;
};

}  // namespace tenon
