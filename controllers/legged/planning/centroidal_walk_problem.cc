#include <tenon/controllers/legged/planning/centroidal_walk_problem.h>
#include <tenon/plants/model/vectors.h>

#include <Eigen/Geometry>

namespace tenon {
namespace {

constexpr int kC = 0, kV = 3, kE = 6, kL = 9, kP = 12;

}  // namespace

double CentroidalWalkProblem::StageCost(int k, const State& x, const Input& u) const {
  const Node& node = At(k);
  double cost = 0;
  for (int i = 0; i < kStates; ++i) cost += Q[i] * (x[i] - node.x[i]) * (x[i] - node.x[i]);
  for (int i = 0; i < kInputs; ++i) cost += node.R[i] * (u[i] - node.u[i]) * (u[i] - node.u[i]);
  return cost / 2;
}

void CentroidalWalkProblem::AddStageCost(int k, const State& x, const Input& u, double h, State& gx,
                                         Input& gu, StateMatrix& Hxx, InputMatrix& Huu) const {
  const Node& node = At(k);
  for (int i = 0; i < kStates; ++i) {
    gx[i] += h * Q[i] * (x[i] - node.x[i]);
    Hxx(i, i) += h * Q[i];
  }
  for (int i = 0; i < kInputs; ++i) {
    gu[i] += h * node.R[i] * (u[i] - node.u[i]);
    Huu(i, i) += h * node.R[i];
  }
}

double CentroidalWalkProblem::TerminalCost(const State& x) const {
  const auto& ref = nodes.back().x;
  double cost = 0;
  for (int i = 0; i < kStates; ++i) cost += Q_f[i] * (x[i] - ref[i]) * (x[i] - ref[i]);
  for (int i = 0; i < 2; ++i) {
    const double divergent = x[kC + i] + x[kV + i] - ref[kC + i] - ref[kV + i];
    cost += final_divergence * divergent * divergent;
  }
  return cost / 2;
}

void CentroidalWalkProblem::AddTerminalCost(const State& x, State& gx, StateMatrix& Hxx) const {
  const auto& ref = nodes.back().x;
  for (int i = 0; i < kStates; ++i) {
    gx[i] += Q_f[i] * (x[i] - ref[i]);
    Hxx(i, i) += Q_f[i];
  }
  for (int i = 0; i < 2; ++i) {
    const double divergent = x[kC + i] + x[kV + i] - ref[kC + i] - ref[kV + i];
    for (const int a : {kC + i, kV + i}) {
      gx[a] += final_divergence * divergent;
      for (const int b : {kC + i, kV + i}) Hxx(a, b) += final_divergence;
    }
  }
}

void CentroidalWalkProblem::Step(int k, StepMethod, double T, const State& x, const Input& u,
                                 State& next) const {
  const Node& node = At(k);
  const Vector v = x.segment<3>(kV), middle = x.segment<3>(kC) + T / 2 * v;
  Vector a = node.load.head<3>() - Vector::UnitZ(), tau = node.load.tail<3>();
  next.tail<2 * kNumLegs>() = x.tail<2 * kNumLegs>();
  for (int leg = 0; leg < kNumLegs; ++leg) {
    if (node.lands[leg]) {
      next.segment<2>(kP + 2 * leg) =
          x.head<2>() + T * v.head<2>() + node.nominal[leg] + node.heading * u.segment<2>(4 * leg);
    } else if (node.stands[leg] > 0) {
      const Vector f = Force(k, leg, u);
      a += f;
      tau += (Vector(x[kP + 2 * leg], x[kP + 2 * leg + 1], node.height[leg]) - middle).cross(f);
    }
  }
  const Vector L = x.segment<3>(kL);
  next.segment<3>(kC) = x.segment<3>(kC) + T * v + T * T / 2 * a;
  next.segment<3>(kV) = v + T * a;
  next.segment<3>(kE) = x.segment<3>(kE) + T * (node.inverse_inertia * (L + T / 2 * tau) - node.turn);
  next.segment<3>(kL) = L + T * tau;
}

void CentroidalWalkProblem::LinearizeSteps(StepMethod, int count, const double* steps, const State* states,
                                           const Input* inputs, Tangent* tangents, StepWorkspace&) const {
  for (int k = 0; k < count; ++k) {
    const Node& node = At(k);
    const double T = steps[k];
    const State& x = states[k];
    Tangent& D = tangents[k];
    D.setZero();
    for (int j = 0; j < kStates; ++j) D(j, j) = 1;
    const Vector middle = x.segment<3>(kC) + T / 2 * x.segment<3>(kV);
    Vector total = Vector::Zero();
    for (int leg = 0; leg < kNumLegs; ++leg) {
      const int p = kP + 2 * leg, u = kStates + 4 * leg;
      if (node.lands[leg]) {
        D.block<2, 2>(p, p).setZero();
        D.block<2, 2>(p, kC).setIdentity();
        D.block<2, 2>(p, kV).diagonal().setConstant(T);
        D.block<2, 2>(p, u) = node.heading;
      } else if (node.stands[leg] > 0) {
        const Vector f = Force(k, leg, inputs[k]);
        const Vector arm = Vector(x[p], x[p + 1], node.height[leg]) - middle;
        total += f;
        D.block<3, 2>(kL, p) = -T * CrossMatrix(f).leftCols<2>();
        D.block<3, 4>(kV, u) = T * node.stands[leg] * edges;
        D.block<3, 4>(kC, u) = T / 2 * D.block<3, 4>(kV, u);
        D.block<3, 4>(kL, u).noalias() = CrossMatrix(arm).lazyProduct(D.block<3, 4>(kV, u));
      }
    }
    D.block<3, 3>(kC, kV).diagonal().setConstant(T);
    D.block<3, 3>(kL, kC) = T * CrossMatrix(total);
    D.block<3, 3>(kL, kV) = T / 2 * D.block<3, 3>(kL, kC);
    const Eigen::Matrix3d turned = T / 2 * node.inverse_inertia;
    D.block<3, 6>(kE, kC) = turned.lazyProduct(D.block<3, 6>(kL, kC));
    D.block<3, kStates + kInputs - kP>(kE, kP) =
        turned.lazyProduct(D.block<3, kStates + kInputs - kP>(kL, kP));
    D.block<3, 3>(kE, kL) = 2 * turned;
  }
}

}  // namespace tenon
