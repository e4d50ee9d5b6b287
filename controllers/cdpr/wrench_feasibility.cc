#include <fmt/core.h>
#include <tenon/controllers/cdpr/wrench_feasibility.h>
#include <tenon/controllers/optimization/infinity.h>
#include <tenon/controllers/optimization/small_product.h>
#include <tenon/systems/framework/errors.h>

#include <algorithm>
#include <cmath>

namespace tenon {
namespace {

constexpr double kSmallestPivot = 1e-12;  // pivots below this, relative to the largest entry
constexpr int kRowsOfCross = 3;           // rows that two columns leave a cross product of
constexpr int kLanes = 4;                 // numbers that are computed side by side

int Choose(int n, int k) {
  double choices = 1;
  for (int i = 1; i <= k; ++i) choices = choices * (n - k + i) / i;
  return static_cast<int>(std::lround(choices));
}

int WholeLanes(int size) {
  return (size + kLanes - 1) / kLanes * kLanes;
}

}  // namespace

WrenchFeasibility::WrenchFeasibility(int rows, int num_cables)
    : rows_(rows), num_cables_(num_cables), width_(WholeLanes(num_cables + rows)) {
  if (rows < 2 || num_cables < rows) {
    throw ParameterError(
        fmt::format("wrench feasibility of {} cables with {} rows of wrenches: needs two rows or more and at "
                    "least as many "
                    "cables; with fewer, wrenches fill no volume",
                    num_cables, rows));
  }
  levels_.emplace_back(std::max(rows, kRowsOfCross) * width_);
  for (int left = rows - 1; left >= kRowsOfCross; --left) levels_.emplace_back(left * width_);
  const int chosen = rows - 1;
  num_facets_ = Choose(num_cables, chosen);
  cables_.resize(chosen, num_facets_);
  Eigen::VectorXi choice = Eigen::VectorXi::LinSpaced(chosen, 0, chosen - 1);
  for (int facet = 0; facet < num_facets_; ++facet) {
    cables_.col(facet) = choice;
    int last = chosen - 1;
    while (last > 0 && choice[last] == num_cables - chosen + last) --last;
    ++choice[last];
    for (int k = last + 1; k < chosen; ++k) choice[k] = choice[k - 1] + 1;
  }
  const int size = WholeLanes(num_facets_) + kLanes;
  cross_.setZero(size, 3);
  normals_.setZero(size, rows);
  sum_.setZero(size);
  absolute_sum_.setZero(size);
  norm_.setZero(size);
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
  facets_done_ = 0;
  Eliminate(0, 0);
  SkipFacets(static_cast<int>(sum_.size()) - num_facets_);
}

/// Chooses a column from `first` on, and eliminates it from the rows of this level.
TENON_VECTOR_CLONES void WrenchFeasibility::Eliminate(int level, int first) {
  const int rows = rows_ - level;
  const double* from = levels_[level].data();
  if (rows <= kRowsOfCross) return AddFacets(from, Cross(from, first));
  // The rest of the columns, rows - 2 of them, come after this one.
  for (int column = first; column + rows - 2 < num_cables_; ++column) {
    int pivot = 0;
    for (int r = 1; r < rows; ++r) {
      if (std::abs(from[r * width_ + column]) > std::abs(from[pivot * width_ + column])) pivot = r;
    }
    const double* pivot_row = from + pivot * width_;
    if (!(std::abs(pivot_row[column]) > smallest_pivot_)) {
      SkipFacets(Choose(num_cables_ - column - 1, rows - 2));
      continue;
    }
    const double scale = 1 / pivot_row[column];
    double* __restrict to = levels_[level + 1].data();
    for (int r = 0; r < rows; ++r) {
      if (r == pivot) continue;
      const double* row = from + r * width_;
      const double factor = row[column] * scale;
      for (int i = 0; i < width_; i += kLanes)
        for (int l = i; l < i + kLanes; ++l) to[l] = row[l] - factor * pivot_row[l];
      to += width_;
    }
    Eliminate(level + 1, column + 1);
  }
}

/// Into cross_, what is normal to each two columns from `first` on, in the space of the three rows that are
/// left; where wrenches have two rows, to each column. How many there are.
TENON_VECTOR_CLONES int WrenchFeasibility::Cross(const double* rows, int first) {
  const double *a = rows, *b = a + width_, *c = b + width_;
  double *x = &cross_(0, 0), *y = &cross_(0, 1), *z = &cross_(0, 2);
  if (rows_ < kRowsOfCross) {
    for (int k = 0; k < num_cables_; ++k) {
      x[k] = -b[k];
      y[k] = a[k];
    }
    return num_cables_;
  }
  int count = 0;
  for (int j = first; j + 1 < num_cables_; ++j) {
    const double aj = a[j], bj = b[j], cj = c[j];
    // What is written beyond the last pair is overwritten by the next ones.
    for (int k = j + 1, to = count; k < num_cables_; k += kLanes, to += kLanes) {
      double out[3][kLanes];
      for (int l = 0; l < kLanes; ++l) {
        out[0][l] = bj * c[k + l] - cj * b[k + l];
        out[1][l] = cj * a[k + l] - aj * c[k + l];
        out[2][l] = aj * b[k + l] - bj * a[k + l];
      }
      std::copy_n(out[0], kLanes, x + to);
      std::copy_n(out[1], kLanes, y + to);
      std::copy_n(out[2], kLanes, z + to);
    }
    count += num_cables_ - 1 - j;
  }
  return count;
}

/// The facets of which cross_ has the normals in the space of these rows.
TENON_VECTOR_CLONES void WrenchFeasibility::AddFacets(const double* rows, int count) {
  const double *a = rows, *b = a + width_, *c = b + width_;
  double sum[3] = {};
  for (int i = 0; i < num_cables_; ++i) {
    sum[0] += a[i];
    sum[1] += b[i];
    sum[2] += c[i];
  }
  for (int facet = 0; facet < count; facet += kLanes) {
    double x[kLanes], y[kLanes], z[kLanes], total[kLanes], absolute[kLanes] = {}, square[kLanes] = {};
    std::copy_n(&cross_(facet, 0), kLanes, x);
    std::copy_n(&cross_(facet, 1), kLanes, y);
    std::copy_n(&cross_(facet, 2), kLanes, z);
    for (int i = 0; i < num_cables_; ++i)
      for (int l = 0; l < kLanes; ++l) absolute[l] += std::abs(x[l] * a[i] + y[l] * b[i] + z[l] * c[i]);
    const int to = facets_done_ + facet;
    for (int k = num_cables_; k < num_cables_ + rows_; ++k) {
      double normal[kLanes];
      for (int l = 0; l < kLanes; ++l) {
        normal[l] = x[l] * a[k] + y[l] * b[k] + z[l] * c[k];
        square[l] += normal[l] * normal[l];
      }
      std::copy_n(normal, kLanes, &normals_(to, k - num_cables_));
    }
    for (int l = 0; l < kLanes; ++l) {
      total[l] = x[l] * sum[0] + y[l] * sum[1] + z[l] * sum[2];
      square[l] = std::sqrt(square[l]);
    }
    std::copy_n(total, kLanes, &sum_[to]);
    std::copy_n(absolute, kLanes, &absolute_sum_[to]);
    std::copy_n(square, kLanes, &norm_[to]);
  }
  facets_done_ += count;
}

/// Facets of dependent columns and what fills up the last lanes: with the normal 0.
void WrenchFeasibility::SkipFacets(int count) {
  normals_.middleRows(facets_done_, count).setZero();
  sum_.segment(facets_done_, count).setZero();
  absolute_sum_.segment(facets_done_, count).setZero();
  norm_.segment(facets_done_, count).setZero();
  facets_done_ += count;
}

TENON_VECTOR_CLONES WrenchMargins WrenchFeasibility::Margins(const WrenchBox& required, double tension_min,
                                                             double tension_max) const {
  const double mid = (tension_max + tension_min) / 2, half = (tension_max - tension_min) / 2;
  double capacity[kLanes], tension[kLanes], worst[kLanes] = {};
  std::fill_n(capacity, kLanes, kInfinity);
  std::fill_n(tension, kLanes, kInfinity);
  for (int facet = 0; facet < num_facets_; facet += kLanes) {
    double offset[kLanes], width[kLanes] = {};
    for (int l = 0; l < kLanes; ++l) offset[l] = mid * sum_[facet + l];
    for (int k = 0; k < rows_; ++k) {
      const double centre = required.centre[k], half_width = required.half_width[k];
      const double* c = &normals_(facet, k);
      for (int l = 0; l < kLanes; ++l) {
        offset[l] -= c[l] * centre;
        width[l] += half_width * std::abs(c[l]);
      }
    }
    for (int l = 0; l < kLanes; ++l) {
      // Of c and of -c, whichever is worse. Without a normal 0 / 0, which is not less than anything.
      const double gap = half * absolute_sum_[facet + l] - width[l] - std::abs(offset[l]);
      const double by_norm = gap / norm_[facet + l], by_sum = gap / absolute_sum_[facet + l];
      capacity[l] = by_norm < capacity[l] ? by_norm : capacity[l];
      worst[l] = by_sum < tension[l] ? facet + l : worst[l];
      tension[l] = by_sum < tension[l] ? by_sum : tension[l];
    }
  }
  const int lane = static_cast<int>(std::min_element(tension, tension + kLanes) - tension);
  const double least = *std::min_element(capacity, capacity + kLanes);
  if (least == kInfinity) return {-kInfinity, -kInfinity, 0};  // all columns parallel
  return {tension[lane], least, static_cast<int>(worst[lane])};
}

}  // namespace tenon
