#pragma once

#include <tenon/controllers/optimization/lanes/packed_algebra.h>

#include <algorithm>
#include <type_traits>
#include <utility>

namespace tenon::internal {

/// A size that is a constant, for which the compiler unrolls loops.
template <int n>
using KnownSize = std::integral_constant<int, n>;

/// Factorisation H = L D L^T of a symmetric, positive definite matrix, and J = L^-T D^-1/2, by elimination in
/// the rows of H and of an identity matrix beside it. J has the same diagonal blocks as H, and zeros outside
/// of the blocks are skipped. Leading variables that H does not couple with others are blocks of size one.
/// Sizes are int or KnownSize; with KnownSize, H is treated as one block.
class CostFactor {
 public:
  explicit CostFactor(int max_size) {
    const int padded = Padded(max_size);
    rows_.Resize(padded * padded);
    elimination_.Resize(2 * padded * padded);
    diagonal_.Resize(padded);
    pivots_.Resize(padded);
    roots_.Resize(padded);
    block_begin_.resize(static_cast<std::size_t>(padded));
    block_end_.resize(static_cast<std::size_t>(padded));
    row_end_.resize(static_cast<std::size_t>(padded));
  }

  /// Factors H from its lower triangle. Returns the row at which it is not positive definite, or -1.
  template <class Size>
  TENON_INLINE int Factor(const double* H, std::ptrdiff_t stride, double negligible, Size n) {
    FindBlocks(H, stride, n);
    const int N = Padded(n), width = 2 * N, singles = Singles(n);
    double* const T = elimination_.data();
    double* const rows = rows_.data();
    double* const pivots = pivots_.data();
    double* const roots = roots_.data();
    for (int j = 0; j < singles; ++j) {
      diagonal_[j] = pivots[j] = H[j * stride + j];
      if (!(pivots[j] > negligible * pivots[j])) return j;
    }
    for (int first = singles; first < n; first += 4) {
      const int begin = Begin(first, n), end = End(first, n);
      for (int j = first; j < first + 4; ++j) {
        for (int i = begin; i < end; i += 4) *PacketAt(rows + j * N + i) = Lanes{};
        for (int i = begin; i < first + 4; i += 4) *PacketAt(T + j * width + N + i) = Lanes{};
        T[j * width + N + j] = 1;
      }
    }
    for (int j = singles; j < n; ++j) {
      const double* const column = H + j * stride;
      const int end = RowEnd(j, n), group = PaddedDown(j);
      rows[j * N + j] = column[j];
      for (int i = j + 1; i < end; ++i) rows[j * N + i] = rows[i * N + j] = column[i];
      for (int i = group; i < End(group, n); i += 4) CopyPacket(column, i, n, T + j * width);
    }
    if (const int failed = Eliminate(negligible, n); failed >= 0) return failed;
    for (int i = n; i < N; ++i) pivots[i] = 1;
    for (int i = 0; i < N; ++i) roots[i] = std::sqrt(pivots[i]);
    for (int i = 0; i < N; i += 4) *PacketAt(roots + i) = Lanes{1, 1, 1, 1} / *PacketAt(roots + i);
    for (int first = singles; first < n; first += 4) {
      const int begin = Begin(first, n);
      for (int j = first; j < first + 4; ++j) {
        double* const column = T + j * width + N;
        const double root = roots[j];
        for (int i = begin; i < first + 4; i += 4) *PacketAt(column + i) = *PacketAt(column + i) * root;
      }
    }
    return -1;
  }

  /// product = H x. The arguments of this and the following functions are padded.
  template <class Size>
  TENON_INLINE void Multiply(const double* x, double* product, Size n) const {
    const int N = Padded(n);
    for (int i = 0; i < Singles(n); i += 4)
      *PacketAt(product + i) = *PacketAt(diagonal_.data() + i) * *PacketAt(x + i);
    for (int first = Singles(n); first < n; first += 4)
      Dots(rows_.data() + first * N, N, x, Begin(first, n), End(first, n), product + first);
    for (int i = n; i < N; ++i) product[i] = 0;
  }

  /// v = J^T a, where a is zero from `end` on, a multiple of four. Returns the index from which v is zero.
  template <class Size>
  TENON_INLINE int MultiplyTransposed(const double* a, double* v, int end, Size n) const {
    const int N = Padded(n), singles = Singles(n);
    if (end <= singles) {
      for (int i = 0; i < end; i += 4) *PacketAt(v + i) = *PacketAt(roots_.data() + i) * *PacketAt(a + i);
      for (int i = end; i < N; i += 4) *PacketAt(v + i) = Lanes{};
      return end;
    }
    MultiplyTransposed(a, v, n);
    return N;
  }
  template <class Size>
  TENON_INLINE void MultiplyTransposed(const double* a, double* v, Size n) const {
    const int N = Padded(n), width = 2 * N;
    for (int i = 0; i < Singles(n); i += 4)
      *PacketAt(v + i) = *PacketAt(roots_.data() + i) * *PacketAt(a + i);
    for (int first = Singles(n); first < n; first += 4)
      Dots(elimination_.data() + first * width + N, width, a, Begin(first, n), first + 4, v + first);
    for (int i = n; i < N; ++i) v[i] = 0;
  }

  /// x = J y
  template <class Size>
  TENON_INLINE void MultiplyFactor(const double* y, double* x, Size n) const {
    const int N = Padded(n), width = 2 * N;
    for (int i = 0; i < Singles(n); i += 4)
      *PacketAt(x + i) = *PacketAt(roots_.data() + i) * *PacketAt(y + i);
    for (int i = Singles(n); i < N; i += 4) *PacketAt(x + i) = Lanes{};
    for (int first = Singles(n); first < n; first += 4)
      AddColumns(elimination_.data() + first * width + N, width, y + first, x, Begin(first, n), first + 4);
  }

  /// Copies J by columns.
  template <class Size>
  TENON_INLINE void CopyFactor(double* columns, Size n) const {
    const int N = Padded(n), width = 2 * N, singles = Singles(n);
    for (int i = 0; i < N * n; i += 4) *PacketAt(columns + i) = Lanes{};
    for (int j = 0; j < singles; ++j) columns[j * N + j] = roots_[j];
    for (int j = singles; j < n; ++j) {
      const int first = PaddedDown(j);
      const double* const column = elimination_.data() + j * width + N;
      for (int i = Begin(first, n); i < first + 4; i += 4)
        *PacketAt(columns + j * N + i) = *PacketAt(column + i);
    }
  }

 private:
  template <class Size>
  static constexpr bool kOneBlock = [] {
    if constexpr (std::is_same_v<Size, int>)
      return false;
    else
      return Size::value <= 16;
  }();

  // Ranges of the nonzeros in rows first to first + 3 of H, and in row j of L^T.
  template <class Size>
  TENON_INLINE int Begin(int first, Size) const {
    if constexpr (!kOneBlock<Size>) return block_begin_[first];
    return 0;
  }
  template <class Size>
  TENON_INLINE int End(int first, Size n) const {
    if constexpr (!kOneBlock<Size>) return block_end_[first];
    return Padded(n);
  }
  template <class Size>
  TENON_INLINE int Singles(Size) const {
    if constexpr (!kOneBlock<Size>) return num_single_;
    return 0;
  }
  template <class Size>
  TENON_INLINE int RowEnd(int j, Size n) const {
    if constexpr (!kOneBlock<Size>) return row_end_[j];
    return n;
  }

  template <class Size>
  TENON_INLINE int Eliminate(double negligible, Size n) {
    int failed = -1;
    if constexpr (!kOneBlock<Size>) {
      for (int first = Singles(n); first < n && failed < 0; first += 4)
        failed = EliminateGroup(first, negligible, n);
    } else {
      [&]<int... group>(std::integer_sequence<int, group...>) __attribute__((always_inline)) {
        static_cast<void>(
            ((failed = EliminateGroup(KnownSize<4 * group>(), negligible, n), failed < 0) && ...));
      }
      (std::make_integer_sequence<int, Padded(n) / 4>());
    }
    return failed;
  }
  // Eliminates the four rows that begin with the current `first`.
  template <class First, class Size>
  TENON_INLINE int EliminateGroup(First first, double negligible, Size n) {
    const int N = Padded(n), width = 2 * N, begin = Begin(first, n), end = End(first, n);
    double* const T = elimination_.data();
    const double* const rows = rows_.data();
    for (int j = first; j < std::min<int>(first + 4, n); ++j) {
      double* const pivot = T + j * width;
      if (!(pivot[j] > negligible * rows[j * N + j])) return j;
      pivots_[j] = pivot[j];
      const double inverse = 1 / pivot[j];
      const int last = RowEnd(j, n);
      for (int i = j + 1; i < last; ++i) {
        double* const row = T + i * width;
        const double factor = -pivot[i] * inverse;
        for (int k = first; k < end; k += 4) *PacketAt(row + k) += *PacketAt(pivot + k) * factor;
        for (int k = N + begin; k < N + first + 4; k += 4)
          *PacketAt(row + k) += *PacketAt(pivot + k) * factor;
      }
    }
    return -1;
  }

  TENON_INLINE static bool IsZero(const double* p, int from, int to) {
    Mask any = {};
    int i = from;
    for (; i + 4 <= to; i += 4) any |= *PacketAt(p + i) != Lanes{};
    for (; i < to; ++i) any[0] |= p[i] != 0;
    return (any[0] | any[1] | any[2] | any[3]) == 0;
  }

  template <class Size>
  TENON_INLINE void FindBlocks(const double* H, std::ptrdiff_t stride, Size n) {
    num_single_ = 0;
    if constexpr (!kOneBlock<Size>) {
      int begin = 0, end = 0;
      for (int j = 0; j < n; ++j) {
        if (j == end) begin = j;
        const double* const column = H + j * stride;
        int last = n;
        if (IsZero(column, std::max(j + 1, end), n)) last = j + 1;
        while (last > j + 1 && last > end && column[last - 1] == 0) --last;
        end = std::max(last, end);
        row_end_[j] = end;
        block_begin_[j] = begin;
        if (j == num_single_ && end == j + 1) ++num_single_;
      }
      num_single_ = PaddedDown(num_single_);
      // Extends the ranges to groups of four rows, from the begin of the first row's block to the end of the
      // last's.
      for (int first = Singles(n); first < n; first += 4) {
        int stop = row_end_[std::min(first + 4, n) - 1];
        while (row_end_[stop - 1] > stop) stop = row_end_[stop - 1];
        block_end_[first] = Padded(stop);
        block_begin_[first] = PaddedDown(block_begin_[first]);
      }
    }
  }

  Numbers rows_;         // rows of H
  Numbers elimination_;  // remaining rows of H, each beside its row of L^-1, which becomes a column of J
  Numbers diagonal_, pivots_, roots_;  // diagonals of H, D and D^-1/2
  int num_single_ = 0;  // number of leading blocks of size one, rounded down to a multiple of four
  std::vector<int> block_begin_, block_end_, row_end_;
};

}  // namespace tenon::internal
