#pragma once

#include <cmath>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

/// Four doubles in one AVX register or in two SSE2 registers. The compilers provide + - * / and access to a
/// lane by []; the other operations are here.
///
/// All functions are always inlined, so that they are compiled for the target of their caller (see
/// TENON_VECTOR_CLONES in small_product.h). They take and return Lanes by reference, because the calling
/// convention for values depends on the target. Pass references only to local variables, not to memory:
/// Clang 14 would assume that the memory is aligned.
namespace tenon::internal {

typedef double Lanes __attribute__((vector_size(32)));
/// Four doubles in memory, with the alignment of one double.
typedef double Packet __attribute__((vector_size(32), aligned(8), may_alias));

#define TENON_INLINE [[gnu::always_inline]] inline

TENON_INLINE const Packet* PacketAt(const double* first) {
  return reinterpret_cast<const Packet*>(first);
}
TENON_INLINE Packet* PacketAt(double* first) {
  return reinterpret_cast<Packet*>(first);
}

/// n rounded up and rounded down to a multiple of four.
constexpr int Padded(int n) {
  return (n + 3) / 4 * 4;
}
constexpr int PaddedDown(int n) {
  return n / 4 * 4;
}

/// Loads min(count, 4) >= 1 doubles; the other lanes are 0.
TENON_INLINE void LoadFirst(const double* from, int count, Lanes* lanes) {
  if (count >= 4)
    *lanes = *PacketAt(from);
  else
    *lanes = Lanes{from[0], count > 1 ? from[1] : 0, count > 2 ? from[2] : 0, 0};
}

TENON_INLINE void Sqrt(const Lanes& x, Lanes* root) {
#if defined(__SSE2__)
  const __m128d low = _mm_sqrt_pd(__builtin_shufflevector(x, x, 0, 1));
  const __m128d high = _mm_sqrt_pd(__builtin_shufflevector(x, x, 2, 3));
  *root = __builtin_shufflevector(low, high, 0, 1, 2, 3);
#else
  *root = Lanes{std::sqrt(x[0]), std::sqrt(x[1]), std::sqrt(x[2]), std::sqrt(x[3])};
#endif
}

/// Lane i of row j becomes lane j of row i.
TENON_INLINE void Transpose(Lanes (&rows)[4]) {
  const Lanes a = __builtin_shufflevector(rows[0], rows[1], 0, 4, 2, 6);
  const Lanes b = __builtin_shufflevector(rows[0], rows[1], 1, 5, 3, 7);
  const Lanes c = __builtin_shufflevector(rows[2], rows[3], 0, 4, 2, 6);
  const Lanes d = __builtin_shufflevector(rows[2], rows[3], 1, 5, 3, 7);
  rows[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
  rows[1] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
  rows[2] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
  rows[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}

/// Sine and cosine of angles [rad] up to a million, to three units in the last place; NaN for larger angles
/// and for angles that are not finite. By the polynomials of fdlibm (k_sin.c, k_cos.c) about the nearest
/// multiple of pi/2.
TENON_INLINE void SinCos(const Lanes& angle, Lanes* sine, Lanes* cosine) {
  typedef long long Bits __attribute__((vector_size(32)));
  constexpr double kLargest = 1e6, kPerTurn = 0.63661977236758134308;  // 2 / pi
  // pi/2 in parts of 33 bits, so that their products with a number of quarter turns are exact.
  constexpr double kQuarter[] = {1.57079632673412561417e+00, 6.07710050630396597660e-11,
                                 2.02226624879595063154e-21};
  constexpr double kRound = 6755399441055744.0;  // 1.5 2^52: adding it rounds to integers
  const Lanes shifted = angle * kPerTurn + kRound;
  const Bits quarters = (Bits)shifted;
  const Lanes turns = shifted - kRound;
  const Lanes r = ((angle - turns * kQuarter[0]) - turns * kQuarter[1]) - turns * kQuarter[2];
  const Lanes z = r * r;
  const Lanes s =
      r + r * z *
              (-1.66666666666666324348e-01 +
               z * (8.33333333332248946124e-03 +
                    z * (-1.98412698298579493134e-04 +
                         z * (2.75573137070700676789e-06 +
                              z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))));
  const Lanes c =
      1 -
      (0.5 * z - z * z *
                     (4.16666666666666019037e-02 +
                      z * (-1.38888888888741095749e-03 +
                           z * (2.48015872894767294178e-05 +
                                z * (-2.75573143513906633035e-07 +
                                     z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))))));
  const Bits valid = (angle <= kLargest) & (angle >= -kLargest);
  const Bits odd = -(quarters & 1);
  const Bits sine_sign = (quarters & 2) << 62, cosine_sign = ((quarters + 1) & 2) << 62;
  const Bits s_bits = (Bits)s, c_bits = (Bits)c;
  const Bits sine_bits = (((s_bits & ~odd) | (c_bits & odd)) ^ sine_sign) | ~valid;
  const Bits cosine_bits = (((c_bits & ~odd) | (s_bits & odd)) ^ cosine_sign) | ~valid;
  *sine = (Lanes)sine_bits;
  *cosine = (Lanes)cosine_bits;
}

}  // namespace tenon::internal
