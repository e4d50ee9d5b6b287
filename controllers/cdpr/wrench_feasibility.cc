#include <fmt/core.h>
#include <tenon/controllers/cdpr/wrench_feasibility.h>
#include <tenon/controllers/optimization/infinity.h>
#include <tenon/systems/framework/errors.h>

#include <cmath>
#include <limits>

namespace tenon {
namespace {

constexpr double kSmallestPivot = 1e-12;  // pivots below this, relative to the largest entry

int Choose(int n, int k) {
  double choices = 1;
  for (int i = 1; i <= k; ++i) choices = choices * (n - k + i) / i;
  return static_cast<int>(std::lround(choices));
}

}  // namespace

WrenchFeasibility::WrenchFeasibility(int rows, int num_cables)
    : rows_(rows), num_cables_(num_cables), width_(num_cables + rows) {
  if (rows < 2 || num_cables < rows) {
    throw ParameterError(
        fmt::format("wrench feasibility of {} cables with {} rows of wrenches: needs two rows or more and at "
                    "least as many "
                    "cables; with fewer, wrenches fill no volume",
                    num_cables, rows));
  }
  for (int level = 0; level < rows; ++level) levels_.emplace_back((rows - level) * width_);
  const int facets = Choose(num_cables, rows - 1);
  chosen_.setZero(rows - 1);
  normals_.resize(rows, facets);
  cables_.resize(rows - 1, facets);
  sum_.resize(facets);
  absolute_sum_.resize(facets);
  norm_.resize(facets);
}

void WrenchFeasibility::SetStructure(const Eigen::Ref<const Eigen::MatrixXd>& structure) {
  if (structure.rows() != rows_ || structure.cols() != num_cables_) {
    throw ParameterError(
        fmt::format("wrench feasibility: a structure matrix of {} x {} was given, {} x {} is expected",
                    structure.rows(), structure.cols(), rows_, num_cables_));
  }
  std::vector<double>& whole = levels_[0];
  for (int r = 0; r < rows_; ++r) {
    double* row = whole.data() + r * width_;
    for (int i = 0; i < num_cables_; ++i) row[i] = structure(r, i);
    for (int k = 0; k < rows_; ++k) row[num_cables_ + k] = k == r ? 1 : 0;
  }
  smallest_pivot_ = kSmallestPivot * structure.cwiseAbs().maxCoeff();
  num_facets_ = 0;
  Eliminate(0, 0);
}

/// Chooses a column from `first` on, and eliminates it from the rows of this level.
void WrenchFeasibility::Eliminate(int level, int first) {
  const int rows = rows_ - level;
  if (rows == 1) return AddFacet(levels_[level].data());
  const double* from = levels_[level].data();
  // The rest of the columns, rows - 2 of them, come after this one.
  for (int column = first; column + rows - 2 < num_cables_; ++column) {
    int pivot = 0;
    for (int r = 1; r < rows; ++r) {
      if (std::abs(from[r * width_ + column]) > std::abs(from[pivot * width_ + column])) pivot = r;
    }
    const double* pivot_row = from + pivot * width_;
    if (!(std::abs(pivot_row[column]) > smallest_pivot_)) continue;
    const double scale = 1 / pivot_row[column];
    double* to = levels_[level + 1].data();
    for (int r = 0; r < rows; ++r) {
      if (r == pivot) continue;
      const double* row = from + r * width_;
      const double factor = row[column] * scale;
      for (int i = 0; i < width_; ++i) to[i] = row[i] - factor * pivot_row[i];
      to += width_;
    }
    chosen_[level] = column;
    Eliminate(level + 1, column + 1);
  }
}

void WrenchFeasibility::AddFacet(const double* row) {
  double sum = 0, absolute = 0, square = 0;
  for (int i = 0; i < num_cables_; ++i) {
    sum += row[i];
    absolute += std::abs(row[i]);
  }
  for (int k = 0; k < rows_; ++k) {
    const double c = row[num_cables_ + k];
    normals_(k, num_facets_) = c;
    square += c * c;
  }
  cables_.col(num_facets_) = chosen_;
  sum_[num_facets_] = sum;
  absolute_sum_[num_facets_] = absolute;
  norm_[num_facets_] = std::sqrt(square);
  ++num_facets_;
}

WrenchMargins WrenchFeasibility::Margins(const WrenchBox& required, double tension_min,
                                         double tension_max) const {
  const double mid = (tension_max + tension_min) / 2, half = (tension_max - tension_min) / 2;
  WrenchMargins margins{kInfinity, kInfinity, 0};
  for (int j = 0; j < num_facets_; ++j) {
    const double* c = normals_.data() + j * rows_;
    double offset = mid * sum_[j], width = 0;
    for (int k = 0; k < rows_; ++k) {
      offset -= c[k] * required.centre[k];
      width += required.half_width[k] * std::abs(c[k]);
    }
    // Of c and of -c, whichever is worse.
    const double gap = half * absolute_sum_[j] - width - std::abs(offset);
    margins.capacity = std::min(margins.capacity, gap / norm_[j]);
    const double tension = gap / std::max(absolute_sum_[j], 1e-300);
    if (tension < margins.tension) {
      margins.tension = tension;
      margins.facet = j;
    }
  }
  if (num_facets_ == 0) margins = {-kInfinity, -kInfinity, 0};  // all columns parallel
  return margins;
}

}  // namespace tenon
