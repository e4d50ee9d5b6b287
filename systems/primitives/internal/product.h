#pragma once

#include <tenon/systems/framework/types/errors.h>

#include <Eigen/Core>

namespace tenon::internal {

/// y = M v, or y += M v with `add`. Throws RunError that names M and v if their sizes do not match.
template <class Matrix, class V, class Y>
void Multiply(const char* m_name, const Matrix& m, const char* v_name, const V& v, Y* y, bool add = false) {
  if (m.cols() != v.size()) {
    throw RunError(std::string(v_name) + " has " + std::to_string(v.size()) + " elements, but " + m_name +
                   " has " + std::to_string(m.cols()) + " columns: make them equal");
  }
  if (add) {
    y->noalias() += m * v;
  } else {
    y->noalias() = m * v;
  }
}

}  // namespace tenon::internal
