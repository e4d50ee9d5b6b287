#include <tenon/systems/simulation/internal/sundials_solver.h>

#include <nvector/nvector_serial.h>

#include <cstring>

namespace tenon::internal {
namespace {

/// z = c[0] X[0] + c[1] X[1] + ..., added in this order.
template <std::size_t num_vectors>
int Combine(double* c, N_Vector* vectors, N_Vector z) {
  double* const __restrict__ out = NV_DATA_S(z);
  std::array<const double*, num_vectors> x;
  for (std::size_t i = 0; i < num_vectors; ++i) {
    x[i] = NV_DATA_S(vectors[i]);
    if (x[i] == out) return N_VLinearCombination_Serial(num_vectors, c, vectors, z);
  }
  const sunindextype size = NV_LENGTH_S(z);
  for (sunindextype k = 0; k < size; ++k) {
    double sum = c[0] * x[0][k];
    for (std::size_t i = 1; i < num_vectors; ++i) sum += c[i] * x[i][k];
    out[k] = sum;
  }
  return 0;
}

int LinearCombination(int num_vectors, double* c, N_Vector* vectors, N_Vector z) {
  if (num_vectors == 2) return Combine<2>(c, vectors, z);
  if (num_vectors == 3) return Combine<3>(c, vectors, z);
  if (num_vectors == 4) return Combine<4>(c, vectors, z);
  if (num_vectors == 5) return Combine<5>(c, vectors, z);
  return N_VLinearCombination_Serial(num_vectors, c, vectors, z);
}

void Scale(double c, N_Vector x, N_Vector z) {
  if (c != 1) return N_VScale_Serial(c, x, z);
  if (x != z)
    std::memcpy(NV_DATA_S(z), NV_DATA_S(x), sizeof(double) * static_cast<std::size_t>(NV_LENGTH_S(x)));
}

double WrmsNorm(N_Vector x, N_Vector weights) {
  constexpr sunindextype kLanes = 8;
  const double *const value = NV_DATA_S(x), *const weight = NV_DATA_S(weights);
  const sunindextype size = NV_LENGTH_S(x);
  std::array<double, kLanes> sums{};
  sunindextype i = 0;
  for (; i + kLanes <= size; i += kLanes) {
    for (sunindextype lane = 0; lane < kLanes; ++lane) {
      const double weighted = value[i + lane] * weight[i + lane];
      sums[static_cast<std::size_t>(lane)] += weighted * weighted;
    }
  }
  double rest = 0;
  for (; i < size; ++i) {
    const double weighted = value[i] * weight[i];
    rest += weighted * weighted;
  }
  const double sum =
      ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
  return std::sqrt((sum + rest) / static_cast<double>(size));
}

}  // namespace

void UseFastOperations(N_Vector vector) {
  vector->ops->nvlinearcombination = LinearCombination;
  vector->ops->nvscale = Scale;
  vector->ops->nvwrmsnorm = WrmsNorm;
}

}  // namespace tenon::internal
