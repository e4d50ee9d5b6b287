#pragma once

#include <Eigen/Core>

/// Compiles a function for AVX2 with FMA besides the target of the build; which one runs is decided when the
/// library is loaded. Last digits so depend on the processor, and on nothing else. GCC alone, not under
/// sanitizers.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && __GNUC__ >= 12 && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && defined(__OPTIMIZE__)
#define TENON_VECTOR_CLONES __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define TENON_VECTOR_CLONES
#endif

namespace tenon::internal {

/// C = A B for matrices of a size that the compiler knows, stored by columns with the leading dimensions lda,
/// ldb, ldc; C overlaps neither A nor B. Two columns of C at a time stay in registers. Eigen hands products
/// of this size (above 20 in the sum of their dimensions) to its kernel for large matrices, which packs them
/// first.
template <int rows, int inner, int columns>
[[gnu::always_inline]] inline void Product(const double* A, int lda, const double* B, int ldb,
                                           double* __restrict C, int ldc) {
  int j = 0;
  for (; j + 1 < columns; j += 2) {
    double c0[rows] = {}, c1[rows] = {};
    const double *b0 = B + j * ldb, *b1 = b0 + ldb;
    for (int k = 0; k < inner; ++k) {
      const double* a = A + k * lda;
      for (int r = 0; r < rows; ++r) {
        c0[r] += a[r] * b0[k];
        c1[r] += a[r] * b1[k];
      }
    }
    for (int r = 0; r < rows; ++r) {
      C[j * ldc + r] = c0[r];
      C[(j + 1) * ldc + r] = c1[r];
    }
  }
  for (; j < columns; ++j) {
    double c0[rows] = {};
    for (int k = 0; k < inner; ++k)
      for (int r = 0; r < rows; ++r) c0[r] += A[k * lda + r] * B[j * ldb + k];
    for (int r = 0; r < rows; ++r) C[j * ldc + r] = c0[r];
  }
}

/// C = A B where only the lower triangle of C counts: columns in groups of four, from the diagonal down. Some
/// of the upper triangle is written.
template <int size, int inner, int first = 0>
[[gnu::always_inline]] inline void LowerProduct(const double* A, const double* B, double* __restrict C) {
  constexpr int group = size - first < 4 ? size - first : 4;
  Product<size - first, inner, group>(A + first, size, B + first * inner, inner, C + first * size + first,
                                      size);
  if constexpr (first + group < size) LowerProduct<size, inner, first + group>(A, B, C);
}

/// C = A B
template <class MA, class MB, class MC>
[[gnu::always_inline]] inline void Multiply(const MA& A, const MB& B, MC& C) {
  constexpr int rows = MA::RowsAtCompileTime, inner = MA::ColsAtCompileTime, columns = MB::ColsAtCompileTime;
  if constexpr (rows != Eigen::Dynamic && inner != Eigen::Dynamic && columns != Eigen::Dynamic) {
    Product<rows, inner, columns>(A.data(), rows, B.data(), inner, C.data(), rows);
  } else {
    C = A.lazyProduct(B);
  }
}

/// The lower triangle of C = A B, C symmetric.
template <class MA, class MB, class MC>
[[gnu::always_inline]] inline void MultiplyLower(const MA& A, const MB& B, MC& C) {
  constexpr int size = MA::RowsAtCompileTime, inner = MA::ColsAtCompileTime;
  if constexpr (size != Eigen::Dynamic && inner != Eigen::Dynamic) {
    LowerProduct<size, inner>(A.data(), B.data(), C.data());
  } else {
    C = A.lazyProduct(B);
  }
}

}  // namespace tenon::internal
