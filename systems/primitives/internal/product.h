#pragma once

#include <Eigen/Core>
#include <string>

#include <tenon/systems/framework/errors.h>

namespace tenon::internal {

/// y = M v, or y += M v with `add`; throws RunError that names them if the sizes do not fit. A y of no size
/// yet takes that of the result.
template <class Matrix, class V, class Y>
void Multiply(const char* m_name, const Matrix& m, const char* v_name, const V& v, Y* y, bool add = false) {
  if (m.cols() != v.size()) {
    throw RunError(std::string(v_name) + " has " + std::to_string(v.size()) + " elements, but " + m_name +
                   " has " + std::to_string(m.cols()) + " columns: make them equal");
  }
  if (y->size() != 0 && m.rows() != y->size()) {
    throw RunError(std::string(m_name) + " has " + std::to_string(m.rows()) + " rows, but had " +
                   std::to_string(y->size()) + " when the block was made: keep its size");
  }
  if (add) {
    y->noalias() += m * v;
  } else {
    y->noalias() = m * v;
  }
}

}  // namespace tenon::internal
