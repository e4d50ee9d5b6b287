#pragma once

#include <tenon/controllers/optimization/lanes/small_product.h>

#include <cstddef>
#include <vector>

/// Sums over rows and columns of doubles, four numbers at a time, compiled for the target of the caller (see
/// TENON_VECTOR_CLONES). Arguments `from` and `to` are multiples of four, and the storage is padded with
/// zeros.
namespace tenon::internal {

/// Result of a comparison of Lanes: all bits of a lane are set if it is true.
using Mask = decltype(Lanes{} < Lanes{});

/// An array of doubles, aligned to 32 bytes and initially zero.
class Numbers {
 public:
  void Resize(int count) { fours_.assign(static_cast<std::size_t>(count + 3) / 4, {}); }
  double* data() { return fours_.data()->values; }
  const double* data() const { return fours_.data()->values; }
  double& operator[](int i) { return data()[i]; }
  double operator[](int i) const { return data()[i]; }

 private:
  struct alignas(32) Four {
    double values[4]{};
  };
  std::vector<Four> fours_;
};

/// Copies the packet that begins at index i of `from`, which has n numbers without padding.
template <class Size>
TENON_INLINE void CopyPacket(const double* from, int i, Size n, double* to) {
  Lanes packet;
  LoadFirst(from + i, n - i, &packet);
  *PacketAt(to + i) = packet;
}

/// The sums over the lanes of four packets.
TENON_INLINE void Sums(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d, double* sums) {
  const Lanes ab = __builtin_shufflevector(a, b, 0, 4, 2, 6) + __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Lanes cd = __builtin_shufflevector(c, d, 0, 4, 2, 6) + __builtin_shufflevector(c, d, 1, 5, 3, 7);
  *PacketAt(sums) = __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}
TENON_INLINE double Sum(const Lanes& a) {
  return (a[0] + a[2]) + (a[1] + a[3]);
}

/// a . b
TENON_INLINE double Dot(const double* a, const double* b, int from, int to) {
  Lanes even = {}, odd = {};
  int i = from;
  for (; i + 8 <= to; i += 8) {
    even += *PacketAt(a + i) * *PacketAt(b + i);
    odd += *PacketAt(a + i + 4) * *PacketAt(b + i + 4);
  }
  if (i < to) even += *PacketAt(a + i) * *PacketAt(b + i);
  return Sum(even + odd);
}

/// Scalar products of four columns with x.
TENON_INLINE void Dots(const double* columns, std::ptrdiff_t stride, const double* x, int from, int to,
                       double* products) {
  Lanes a = {}, b = {}, c = {}, d = {};
  for (int i = from; i < to; i += 4) {
    const Lanes here = *PacketAt(x + i);
    a += *PacketAt(columns + i) * here;
    b += *PacketAt(columns + stride + i) * here;
    c += *PacketAt(columns + 2 * stride + i) * here;
    d += *PacketAt(columns + 3 * stride + i) * here;
  }
  Sums(a, b, c, d, products);
}

/// y += s a
TENON_INLINE void AddColumn(const double* a, double s, double* y, int from, int to) {
  for (int i = from; i < to; i += 4) *PacketAt(y + i) += *PacketAt(a + i) * s;
}

/// y += s[0] a + s[1] b + s[2] c + s[3] d of four columns.
TENON_INLINE void AddColumns(const double* columns, std::ptrdiff_t stride, const double* s, double* y,
                             int from, int to) {
  const double s0 = s[0], s1 = s[1], s2 = s[2], s3 = s[3];
  for (int i = from; i < to; i += 4) {
    *PacketAt(y + i) += (*PacketAt(columns + i) * s0 + *PacketAt(columns + stride + i) * s1) +
                        (*PacketAt(columns + 2 * stride + i) * s2 + *PacketAt(columns + 3 * stride + i) * s3);
  }
}

/// Applies the reflector I - tau w w^T to `count` columns; the first nonzero of w is in [from, from + 4).
TENON_INLINE void Reflect(const double* w, double tau, double* columns, std::ptrdiff_t stride, int count,
                          int from, int to) {
  int c = 0;
  for (; c + 4 <= count; c += 4, columns += 4 * stride) {
    alignas(32) double s[4];
    Dots(columns, stride, w, from, to, s);
    *PacketAt(s) = *PacketAt(s) * -tau;
    for (int i = from; i < to; i += 4) {
      const Lanes here = *PacketAt(w + i);
      *PacketAt(columns + i) += here * s[0];
      *PacketAt(columns + stride + i) += here * s[1];
      *PacketAt(columns + 2 * stride + i) += here * s[2];
      *PacketAt(columns + 3 * stride + i) += here * s[3];
    }
  }
  for (; c < count; ++c, columns += stride) AddColumn(w, -tau * Dot(w, columns, from, to), columns, from, to);
}

/// Computes a reflector I - tau w w^T that takes a column to alpha e_k from row k on and ends before row
/// `end`. `head` holds the column's numbers in the four rows around k, with zeros before k. It is used
/// instead of w, which differs from the column in row k and is available later.
struct Pivot {
  const double* w;
  Lanes head;
  double alpha, tau;
  int k, end;

  /// Reflects `count` columns.
  TENON_INLINE void Reflect(double* columns, std::ptrdiff_t stride, int count) const {
    const int from = PaddedDown(k);
    int c = 0;
    for (; c + 4 <= count; c += 4, columns += 4 * stride) {
      double* const columns1 = columns + stride;
      double* const columns2 = columns1 + stride;
      double* const columns3 = columns2 + stride;
      Lanes s0 = head * *PacketAt(columns + from), s1 = head * *PacketAt(columns1 + from),
            s2 = head * *PacketAt(columns2 + from), s3 = head * *PacketAt(columns3 + from);
      for (int i = from + 4; i < end; i += 4) {
        const Lanes here = *PacketAt(w + i);
        s0 += *PacketAt(columns + i) * here;
        s1 += *PacketAt(columns1 + i) * here;
        s2 += *PacketAt(columns2 + i) * here;
        s3 += *PacketAt(columns3 + i) * here;
      }
      alignas(32) double s[4];
      Sums(s0, s1, s2, s3, s);
      const Lanes at_k = {columns[k], columns1[k], columns2[k], columns3[k]};
      *PacketAt(s) = (*PacketAt(s) - at_k * alpha) * -tau;
      for (int i = from; i < end; i += 4) {
        const Lanes here = *PacketAt(w + i);
        *PacketAt(columns + i) += here * s[0];
        *PacketAt(columns1 + i) += here * s[1];
        *PacketAt(columns2 + i) += here * s[2];
        *PacketAt(columns3 + i) += here * s[3];
      }
    }
    for (; c < count; ++c, columns += stride) {
      const double product = Sum(head * *PacketAt(columns + from)) + Dot(w, columns, from + 4, end);
      AddColumn(w, -tau * (product - alpha * columns[k]), columns, from, end);
    }
  }
};

/// products = A x for rows of n numbers, not padded; x may be read up to its padding.
template <class Size>
TENON_INLINE void Products(const double* rows, std::ptrdiff_t stride, int count, const double* x, Size n,
                           double* products) {
  const int whole = PaddedDown(n);
  int r = 0;
  for (; r + 4 <= count; r += 4, rows += 4 * stride) {
    Dots(rows, stride, x, 0, whole, products + r);
    for (int i = whole; i < n; ++i)
      for (int k = 0; k < 4; ++k) products[r + k] += rows[k * stride + i] * x[i];
  }
  for (; r < count; ++r, rows += stride) {
    double sum = Dot(rows, x, 0, whole);
    for (int i = whole; i < n; ++i) sum += rows[i] * x[i];
    products[r] = sum;
  }
}

/// Writes rows, stored as in Products(), as columns of `stride_out` numbers.
TENON_INLINE void Transpose(const double* rows, std::ptrdiff_t stride, int count, int n, double* columns,
                            std::ptrdiff_t stride_out) {
  const int whole = PaddedDown(n);
  int r = 0;
  for (; r + 4 <= count; r += 4, rows += 4 * stride) {
    for (int i = 0; i < whole; i += 4) {
      Lanes block[4];
      for (int k = 0; k < 4; ++k) block[k] = *PacketAt(rows + k * stride + i);
      Transpose(block);
      for (int k = 0; k < 4; ++k) *PacketAt(columns + (i + k) * stride_out + r) = block[k];
    }
    for (int i = whole; i < n; ++i)
      for (int k = 0; k < 4; ++k) columns[i * stride_out + r + k] = rows[k * stride + i];
  }
  for (; r < count; ++r, rows += stride)
    for (int i = 0; i < n; ++i) columns[i * stride_out + r] = rows[i];
}

/// y += A^T s for rows stored as in Products().
template <class Size>
TENON_INLINE void AddProducts(const double* rows, std::ptrdiff_t stride, int count, const double* s,
                              double* y, Size n) {
  const int whole = PaddedDown(n);
  int r = 0;
  for (; r + 4 <= count; r += 4, rows += 4 * stride) {
    AddColumns(rows, stride, s + r, y, 0, whole);
    for (int i = whole; i < n; ++i)
      for (int k = 0; k < 4; ++k) y[i] += rows[k * stride + i] * s[r + k];
  }
  for (; r < count; ++r, rows += stride) {
    AddColumn(rows, s[r], y, 0, whole);
    for (int i = whole; i < n; ++i) y[i] += rows[i] * s[r];
  }
}

/// The largest |y_i|.
TENON_INLINE double Largest(const double* y, int to) {
  Lanes largest = {};
  for (int i = 0; i < to; i += 4) {
    const Lanes here = *PacketAt(y + i), size = here > -here ? here : -here;
    largest = largest > size ? largest : size;
  }
  const double a = largest[0] > largest[1] ? largest[0] : largest[1];
  const double b = largest[2] > largest[3] ? largest[2] : largest[3];
  return a > b ? a : b;
}

}  // namespace tenon::internal
