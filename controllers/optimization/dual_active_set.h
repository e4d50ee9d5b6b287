#pragma once

#include <tenon/controllers/optimization/lanes/cost_factor.h>
#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/framework/types/internal/border.h>

namespace tenon {

/// Matrices of constraints: one constraint a row, rows contiguous.
using ConstraintMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// min 1/2 x^T H x + g^T x   subject to   A_eq x = b_eq,   A_in x >= b_in.
///
/// H is symmetric and positive definite; only its lower triangle is read. Blocks of larger matrices are used
/// without copies if H is stored by columns and the constraints by rows.
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
  kInfeasible,      ///< no x satisfies `constraint` together with the others
  kNotConvex,       ///< H is not positive definite: its leading block that ends with row `constraint` is not
  kNotFinite,       ///< a number of the problem is NaN or infinite
  kIterationLimit,  ///< the iterations reached max_iterations
  kInaccurate,      ///< the residuals exceed the tolerance: H or the constraints are nearly singular
};

struct QpReport {
  QpStatus status = QpStatus::kSolved;
  int constraint = -1;  ///< index for the status; equalities first, then inequalities
  int iterations = 0;   ///< constraints that were added or dropped after the start
  int restarts = 0;     ///< repeated factorisations

  bool ok() const { return status == QpStatus::kSolved; }
  /// One sentence: what happened and what to do.
  std::string Message() const;
};

/// Solver of strictly convex, dense quadratic programs for control loops, a dual active set method (Goldfarb
/// and Idnani, Math. Programming 27, 1983). It starts at a minimum over some of the constraints, adds
/// violated constraints, and drops those whose multipliers would become negative. The cost increases at each
/// step, so the method ends after finitely many steps: at the solution, or at a constraint that contradicts
/// the others.
///
/// With H = L D L^T and J = L^-T D^-1/2, the columns V = J^T A^T of the active constraints (equalities, then
/// inequalities) are factored as Q (R; 0) by reflections; the minimiser is x = J Q y. There are two kinds of
/// steps:
///
/// - Several constraints at once, if few are violated: all violated constraints are added, and those that
/// then
///   have negative multipliers are dropped, as long as the cost increases. The reflections are applied
///   without forming Q. The start at a guessed active set is a step of this kind: if the guess is right, the
///   solution needs one factorisation.
/// - One constraint at a time, as in the paper, if many are violated, if constraints depend on each other, or
/// if
///   a step of the first kind did not increase the cost. Z = J Q, restricted to the inequalities, is updated
///   by reflections and rotations.
///
/// Zero blocks of H remain zero in J and cost nothing. Dependent constraints and those with negative
/// multipliers are removed from the guess, so any guess is valid and only the number of iterations depends on
/// it. The solution is refined by its residuals. If these exceed the tolerance, or if the problem seems
/// infeasible after updates, the method starts again with a new factorisation. Redundant constraints,
/// equalities included, do no harm.
///
/// The constructor allocates all memory; Solve() does not allocate. Copies are independent. The last digits
/// of results depend on the processor, see TENON_VECTOR_CLONES.
class DualActiveSet {
 public:
  /// Tolerance of the residuals, relative to the size of their terms.
  static constexpr double kTolerance = 1e-10;

  /// Constructs a solver for up to `max_variables` variables and for up to `max_constraints` equalities and
  /// inequalities together.
  DualActiveSet(int max_variables, int max_constraints, int max_iterations = 200);

  /// Minimises. `guess` holds indices of inequalities that may be active: those of the last, similar
  /// problem, or none. Throws ParameterError if sizes do not fit together, or exceed what this was made for.
  QpReport Solve(const QuadraticProgram& qp, std::span<const int> guess = {});

  /// The minimiser found by the last successful Solve().
  auto x() const { return Eigen::Map<const Eigen::VectorXd>(x_.data(), n_); }
  /// The multipliers of the equalities, then of the inequalities (>= 0, zero if not active), with
  /// H x + g = A^T multipliers.
  auto multipliers() const {
    return Eigen::Map<const Eigen::VectorXd>(multipliers_.data(), num_equalities_ + num_inequalities_);
  }
  /// The active inequalities at x(), a guess for a similar problem.
  std::span<const int> active() const { return {active_inequalities_.data(), num_solution_}; }

 private:
  struct Outcome {
    QpStatus status;
    int constraint = -1;
  };

  void CheckSizes(const QuadraticProgram& qp) const;
  // The number of variables n is an int or a KnownSize, for which the compiler unrolls loops.
  template <class Size>
  QpReport Run(const QuadraticProgram& qp, Size n);
  template <class Size>
  void Start(const QuadraticProgram& qp, Size n);
  template <class Size>
  int FindContradiction(const QuadraticProgram& qp, Size n) const;
  template <class Size>
  Outcome Iterate(const QuadraticProgram& qp, int* iterations, Size n);
  template <class Size>
  bool FindViolated(const QuadraticProgram& qp, Size n);
  template <class Size>
  void MultiplyColumns(const double* x, Size n, double* products) const;
  // Several at once
  template <class Size>
  bool MakePivot(const double* column, int end, double independence, int k, Size n, internal::Pivot* pivot);
  template <class Size>
  void FactorEqualities(const QuadraticProgram& qp, Size n);
  template <class Size>
  void MakeColumns(const QuadraticProgram& qp, int first, int count, Size n);
  template <class Size>
  void FactorColumns(int first, int count, Size n);
  void MoveColumn(int from, int to, int padded);
  template <class Size>
  void SolveR(double* t, double* u, Size n) const;
  template <class Size>
  int Join(const QuadraticProgram& qp, int first, int count, Size n);
  // One at a time
  template <class Size>
  void FormZ(const QuadraticProgram& qp, Size n);
  template <class Size>
  void MultiplyZTransposed(const double* a, double* products, Size n) const;
  template <class Size>
  void AddZ(const double* s, int first, int last, double* sum, Size n) const;
  template <class Size>
  Outcome AddViolated(const QuadraticProgram& qp, int constraint, int* iterations, Size n);
  template <class Size>
  void Drop(int position, Size n);
  // The end
  template <class Size>
  int Refine(const QuadraticProgram& qp, Size n);
  template <class Size>
  void SolveEqualityMultipliers(const double* slope, Size n);
  template <class Size>
  void Correct(const QuadraticProgram& qp, Size n);

  using Numbers = internal::Numbers;
  int max_variables_, max_constraints_, max_iterations_;
  int n_ = 0, num_equalities_ = 0, num_inequalities_ = 0;

  internal::CostFactor cost_;
  // Pivots of the factorisation: the independent equalities, then the active inequalities.
  int num_independent_ = 0, num_active_ = 0;
  std::vector<int> independent_, active_;
  Numbers reflectors_, tau_;  // reflections I - tau w w^T; columns w have nonzeros from their pivots to ends_
  std::vector<int> ends_, column_ends_;
  Numbers R_equalities_, inverse_alpha_;  // R of the equalities, and the inverse of R's whole diagonal
  Numbers R_, inverse_;                   // R of the inequalities, and the inverse of its diagonal
  Numbers columns_, norms2_;              // J^T a of the active inequalities, reflected by the equalities
  Numbers bounds_;              // bounds of the active inequalities, minus the contribution of the equalities
  Numbers work_, work_bounds_;  // columns and bounds that are being added to R
  Numbers y_, y_equalities_;    // y of x = J Q y, and its part due to the equalities
  Numbers slope_, slope_equalities_;  // (J Q)^T g, and J^T g after the reflections of the equalities
  double gain_ = 0;                   // twice the cost increase by the active inequalities
  bool z_is_formed_ = false;
  Numbers Z_;           // columns of J Q that belong to no equality, if z_is_formed_
  Numbers transposed_;  // columns of A_in, if z_is_formed_

  Numbers x_, u_, lambda_, multipliers_;
  Numbers g_, slack_, residual_, pull_, misses_, lengths2_;
  Numbers row_, d_, r_, z_, w_;
  std::size_t num_solution_ = 0;  // active inequalities at the last solution
  int num_guess_ = 0, num_violated_ = 0;
  std::vector<int> active_inequalities_, guess_, violated_;
  std::vector<char> is_active_;
};

}  // namespace tenon
