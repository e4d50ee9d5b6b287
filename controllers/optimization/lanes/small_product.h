#pragma once

#include <tenon/controllers/optimization/lanes/lanes.h>

#include <Eigen/Core>

/// Compiles a function for AVX2 with FMA in addition to the target of the build; the loader picks one when
/// the library is loaded. The last digits of results therefore depend on the processor, and on nothing else.
/// Empty for compilers other than GCC, under sanitizers, and with -D TENON_VECTOR_CLONES=OFF for CMake.
#if !defined(TENON_NO_VECTOR_CLONES) && defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    __GNUC__ >= 12 && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) &&                   \
    defined(__OPTIMIZE__)
#define TENON_VECTOR_CLONES __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define TENON_VECTOR_CLONES
#endif

namespace tenon::internal {

/// C = A B for matrices of a size that the compiler knows, stored by columns with the leading dimensions lda,
/// ldb, ldc; C overlaps neither A nor B. Two columns of C at a time stay in registers. Eigen hands products
/// of this size (above 20 in the sum of their dimensions) to its kernel for large matrices, which packs them
/// first. Always inlined, so that it is compiled for the target of its caller.
template <int rows, int inner, int columns>
TENON_INLINE void Product(const double* A, int lda, const double* B, int ldb, double* __restrict C, int ldc) {
  constexpr int packets = rows / 4, rest = 4 * packets;
  constexpr int width = columns % 4 == 0 && packets <= 3 ? 4 : columns % 2 == 0 ? 2 : 1;  // columns at a time
  for (int j = 0; j < columns; j += width) {
    Lanes c[width][packets + 1] = {};
    double tail[width][4] = {};
    for (int k = 0; k < inner; ++k) {
      const double* a = A + k * lda;
      for (int w = 0; w < width; ++w) {
        const double b = B[(j + w) * ldb + k];
        for (int p = 0; p < packets; ++p) c[w][p] += *PacketAt(a + 4 * p) * b;
        for (int r = rest; r < rows; ++r) tail[w][r - rest] += a[r] * b;
      }
    }
    for (int w = 0; w < width; ++w) {
      double* out = C + (j + w) * ldc;
      for (int p = 0; p < packets; ++p) *PacketAt(out + 4 * p) = c[w][p];
      for (int r = rest; r < rows; ++r) out[r] = tail[w][r - rest];
    }
  }
}

/// The lower triangle of C = A B: columns in groups of four, the last group first, from the diagonal down.
/// Parts of the upper triangle are overwritten.
template <int size, int inner, int first = 0>
TENON_INLINE void LowerProduct(const double* A, const double* B, double* __restrict C) {
  constexpr int group = size - first < 4 ? size - first : 4;
  if constexpr (first + group < size) LowerProduct<size, inner, first + group>(A, B, C);
  Product<size - first, inner, group>(A + first, size, B + first * inner, inner, C + first * size + first,
                                      size);
}

/// C = A B
template <class MA, class MB, class MC>
TENON_INLINE void Multiply(const MA& A, const MB& B, MC& C) {
  constexpr int rows = MA::RowsAtCompileTime, inner = MA::ColsAtCompileTime, columns = MB::ColsAtCompileTime;
  if constexpr (rows != Eigen::Dynamic && inner != Eigen::Dynamic && columns != Eigen::Dynamic)
    Product<rows, inner, columns>(A.data(), rows, B.data(), inner, C.data(), rows);
  else
    C = A.lazyProduct(B);
}

/// The lower triangle of C = A B, C symmetric.
template <class MA, class MB, class MC>
TENON_INLINE void MultiplyLower(const MA& A, const MB& B, MC& C) {
  constexpr int size = MA::RowsAtCompileTime, inner = MA::ColsAtCompileTime;
  if constexpr (size != Eigen::Dynamic && inner != Eigen::Dynamic)
    LowerProduct<size, inner>(A.data(), B.data(), C.data());
  else
    C = A.lazyProduct(B);
}

/// B = A^T
template <class MA, class MB>
TENON_INLINE void Transpose(const MA& A, MB& B) {
  constexpr int rows = MA::RowsAtCompileTime, columns = MA::ColsAtCompileTime;
  const auto one_by_one = [&](Eigen::Index first_row, Eigen::Index first_column)
      __attribute__((always_inline)) {
    for (Eigen::Index c = 0; c < A.cols(); ++c)
      for (Eigen::Index r = c < first_column ? first_row : 0; r < A.rows(); ++r) B(c, r) = A(r, c);
  };
  if constexpr (rows != Eigen::Dynamic && columns != Eigen::Dynamic) {
    for (int c = 0; c + 4 <= columns; c += 4) {
      for (int r = 0; r + 4 <= rows; r += 4) {
        Lanes block[4];
        for (int i = 0; i < 4; ++i) block[i] = *PacketAt(A.data() + (c + i) * rows + r);
        Transpose(block);
        for (int i = 0; i < 4; ++i) *PacketAt(B.data() + (r + i) * columns + c) = block[i];
      }
    }
    if constexpr (rows % 4 != 0 || columns % 4 != 0) one_by_one(rows / 4 * 4, columns / 4 * 4);
  } else {
    one_by_one(0, 0);
  }
}

/// Copies the lower triangle of A to the upper one.
template <class M>
TENON_INLINE void Mirror(M& A) {
  constexpr int size = M::RowsAtCompileTime;
  const auto mirror = [&](Eigen::Index first, Eigen::Index end) __attribute__((always_inline)) {
    for (Eigen::Index c = first; c < end; ++c)
      for (Eigen::Index r = c + 1; r < end; ++r) A(c, r) = A(r, c);
  };
  if constexpr (size != Eigen::Dynamic && size % 4 == 0) {
    for (int c = 0; c < size; c += 4) {
      mirror(c, c + 4);
      for (int r = c + 4; r < size; r += 4) {
        Lanes block[4];
        for (int i = 0; i < 4; ++i) block[i] = *PacketAt(A.data() + (c + i) * size + r);
        Transpose(block);
        for (int i = 0; i < 4; ++i) *PacketAt(A.data() + (r + i) * size + c) = block[i];
      }
    }
  } else {
    mirror(0, A.rows());
  }
}

/// C = (1 - s) A + s B
template <class M>
void Interpolate(const M& A, const M& B, double s, M& C) {
  for (Eigen::Index i = 0; i < C.size(); ++i) C.data()[i] = (1 - s) * A.data()[i] + s * B.data()[i];
}

}  // namespace tenon::internal
