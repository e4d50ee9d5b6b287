#include <tenon/controllers/cdpr/wrench_feasibility.h>
#include <tenon/controllers/optimization/infinity.h>
#include <tenon/controllers/optimization/lanes/small_product.h>

#include <fmt/core.h>

#include <algorithm>

namespace tenon {
namespace {

constexpr double kSmallestPivot = 1e-12;  // pivots below this, relative to the largest entry
constexpr int kRowsOfCross = 3;           // rows in which two columns have a cross product
constexpr double kLargest = std::numeric_limits<double>::max();
constexpr int kLanes = 4;  // numbers computed at a time, see Lanes

using internal::Lanes;
using internal::PacketAt;
using internal::Padded;
typedef long long Bits __attribute__((vector_size(32)));

/// Computes sum += |numbers| by clearing the sign bits.
TENON_INLINE void AddAbsolute(const Lanes& numbers, Lanes& sum) {
  const Bits bits = (Bits)numbers & 0x7fff'ffff'ffff'ffff;
  sum += (Lanes)bits;
}

/// The smallest quotient in each lane, and its index. Quotients are compared without division, which would
/// take a fifth of the time that a pose takes.
struct Least {
  Lanes over = {kLargest, kLargest, kLargest, kLargest}, under = {1, 1, 1, 1};
  Bits which = {};

  /// Compares the quotients a / b from index `i` on; b >= 0, and 0 / 0 is never the least.
  TENON_INLINE void Take(const Lanes& a, const Lanes& b, int i) {
    const Bits less = a * under < over * b;
    over = less ? a : over;
    under = less ? b : under;
    which = less ? Bits{i, i, i, i} : which;
  }
};

int Choose(int n, int k) {
  double choices = 1;
  for (int i = 1; i <= k; ++i) choices = choices * (n - k + i) / i;
  return static_cast<int>(std::lround(choices));
}

}  // namespace

WrenchFeasibility::WrenchFeasibility(int rows, const CableVector& tension_min, const CableVector& tension_max)
    : rows_(rows),
      num_cables_(static_cast<int>(tension_min.size())),
      width_(Padded(num_cables_ + rows) + kLanes),
      low_(tension_min),
      half_((tension_max - tension_min) / 2),
      most_(half_.size() > 0 ? half_.maxCoeff() : 0) {
  const int num_cables = num_cables_;
  if (rows < 2 || num_cables < rows) {
    throw ParameterError(
        fmt::format("wrench feasibility of {} cables with {} rows of wrenches: needs two rows or more and at "
                    "least as many "
                    "cables; with fewer, wrenches fill no volume",
                    num_cables, rows));
  }
  if (!(half_.allFinite() && half_.minCoeff() > 0 && low_.allFinite()))
    throw ParameterError("wrench feasibility: the tension bounds must be finite, the lower below the upper");
  levels_.emplace_back((std::max(rows, kRowsOfCross) + 1) * width_);
  for (int left = rows - 1; left >= kRowsOfCross; --left) levels_.emplace_back((left + 1) * width_);
  double* weights = levels_[0].data() + std::max(rows, kRowsOfCross) * width_;
  for (int i = 0; i < num_cables; ++i) weights[i] = half_[i] / most_;
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
  const int size = Padded(num_facets_) + kLanes;
  cross_.setZero(size, 3);
  normals_.setZero(size, rows);
  low_wrench_.setZero(rows);
  half_wrench_.setZero(rows);
  absolute_sum_.setZero(size);
  half_sum_.setZero(size);
  square_.setZero(size);
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
  low_wrench_.noalias() = structure * low_;
  half_wrench_.noalias() = structure * half_;
  smallest_pivot_ = kSmallestPivot * structure.cwiseAbs().maxCoeff();
  facets_done_ = 0;
  Eliminate(0, 0);
  SkipFacets(static_cast<int>(square_.size()) - num_facets_);
}

/// Chooses each column from `first` on, eliminates it from the rows of this level, and continues with the
/// next.
TENON_VECTOR_CLONES void WrenchFeasibility::Eliminate(int level, int first) {
  const int rows = rows_ - level, columns = num_cables_ - level, width = width_;
  const double* from = levels_[level].data();
  if (rows <= kRowsOfCross) return AddFacets(from, columns, Cross(from, columns, first));
  // The remaining rows - 2 columns come after this one.
  for (int column = first; column + rows - 2 < columns; ++column) {
    int pivot = 0;
    for (int r = 1; r < rows; ++r)
      if (std::abs(from[r * width + column]) > std::abs(from[pivot * width + column])) pivot = r;
    const double* pivot_row = from + pivot * width;
    if (!(std::abs(pivot_row[column]) > smallest_pivot_)) {
      SkipFacets(Choose(columns - column - 1, rows - 2));
      continue;
    }
    const double scale = 1 / pivot_row[column];
    double* to = levels_[level + 1].data();
    for (int r = 0; r < rows; ++r) {
      if (r == pivot) continue;
      const double* row = from + r * width;
      const double factor = row[column] * scale;
      // Omits the column itself. Entries beyond it are overwritten later.
      for (int i = 0; i < column; i += kLanes)
        *PacketAt(to + i) = *PacketAt(row + i) - factor * *PacketAt(pivot_row + i);
      for (int i = column; i < columns + rows_ - 1; i += kLanes)
        *PacketAt(to + i) = *PacketAt(row + i + 1) - factor * *PacketAt(pivot_row + i + 1);
      to += width;
    }
    const double* weights = from + rows * width;
    for (int i = 0; i + 1 < columns; ++i) to[i] = weights[i < column ? i : i + 1];
    Eliminate(level + 1, column);
  }
}

/// Writes to cross_ the normals of all pairs of columns from `first` on, in the space of the three remaining
/// rows (of single columns if wrenches have two rows). Returns their number.
TENON_VECTOR_CLONES int WrenchFeasibility::Cross(const double* rows, int columns, int first) {
  const double *a = rows, *b = a + width_, *c = b + width_;
  double *x = &cross_(0, 0), *y = &cross_(0, 1), *z = &cross_(0, 2);
  if (rows_ < kRowsOfCross) {
    for (int k = 0; k < columns; ++k) {
      x[k] = -b[k];
      y[k] = a[k];
    }
    return columns;
  }
  int count = 0;
  for (int j = first; j + 1 < columns; ++j) {
    // Entries beyond the last pair are overwritten by the next pairs.
    for (int k = j + 1, to = count; k < columns; k += kLanes, to += kLanes) {
      const Lanes ak = *PacketAt(a + k), bk = *PacketAt(b + k), ck = *PacketAt(c + k);
      *PacketAt(x + to) = b[j] * ck - c[j] * bk;
      *PacketAt(y + to) = c[j] * ak - a[j] * ck;
      *PacketAt(z + to) = a[j] * bk - b[j] * ak;
    }
    count += columns - 1 - j;
  }
  return count;
}

/// Adds the facets whose normals in the space of these rows are in cross_.
TENON_VECTOR_CLONES void WrenchFeasibility::AddFacets(const double* rows, int columns, int count) {
  const double *a = rows, *b = a + width_, *c = b + width_, *weights = c + width_;
  for (int facet = 0; facet < count; facet += kLanes) {
    const Lanes x = *PacketAt(&cross_(facet, 0)), y = *PacketAt(&cross_(facet, 1)),
                z = *PacketAt(&cross_(facet, 2));
    Lanes absolute = {}, weighted = {}, square = {};
    for (int i = 0; i < columns; ++i) {
      const Lanes along = x * a[i] + y * b[i] + z * c[i];
      AddAbsolute(along, absolute);
      AddAbsolute(weights[i] * along, weighted);
    }
    const int to = facets_done_ + facet;
    for (int k = 0; k < rows_; ++k) {
      const Lanes normal = x * a[columns + k] + y * b[columns + k] + z * c[columns + k];
      *PacketAt(&normals_(to, k)) = normal;
      square += normal * normal;
    }
    *PacketAt(&absolute_sum_[to]) = absolute;
    *PacketAt(&half_sum_[to]) = weighted;
    *PacketAt(&square_[to]) = square;
  }
  facets_done_ += count;
}

/// Facets of dependent columns, and the padding of the last lanes, have the normal 0.
void WrenchFeasibility::SkipFacets(int count) {
  normals_.middleRows(facets_done_, count).setZero();
  absolute_sum_.segment(facets_done_, count).setZero();
  half_sum_.segment(facets_done_, count).setZero();
  square_.segment(facets_done_, count).setZero();
  facets_done_ += count;
}

TENON_VECTOR_CLONES WrenchMargins WrenchFeasibility::Margins(const WrenchBox& required, double share) const {
  const double most = share * most_;
  Least capacity, tension;  // capacity is squared, with its sign
  for (int facet = 0; facet < num_facets_; facet += kLanes) {
    Lanes offset = {}, width = {}, distance = {};
    for (int k = 0; k < rows_; ++k) {
      const Lanes c = *PacketAt(&normals_(facet, k));
      Lanes absolute = {};
      AddAbsolute(c, absolute);
      offset += (low_wrench_[k] + share * half_wrench_[k] - required.centre[k]) * c;
      width += required.half_width[k] * absolute;
    }
    // The worse one of the facets c and -c.
    AddAbsolute(offset, distance);
    const Lanes square = *PacketAt(&square_[facet]), absolute = *PacketAt(&absolute_sum_[facet]);
    const Lanes gap = most * *PacketAt(&half_sum_[facet]) - width - distance;
    Lanes size = {};
    AddAbsolute(gap, size);
    const Lanes signed_square = gap * size;
    capacity.Take(signed_square, square, facet);
    tension.Take(gap, absolute, facet);
  }
  const Lanes capacities = capacity.over / capacity.under, tensions = tension.over / tension.under;
  int lane = 0;
  double least = capacities[0];
  for (int l = 1; l < kLanes; ++l) {
    if (tensions[l] < tensions[lane]) lane = l;
    least = std::min(least, static_cast<double>(capacities[l]));
  }
  if (least == kLargest) return {-kInfinity, -kInfinity, 0};  // all columns parallel
  return {std::min(static_cast<double>(tensions[lane]), share * half_.minCoeff()),
          std::copysign(std::sqrt(std::abs(least)), least), static_cast<int>(tension.which[lane]) + lane};
}

}  // namespace tenon
