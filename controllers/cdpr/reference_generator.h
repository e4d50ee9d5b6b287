#pragma once

#include <tenon/controllers/cdpr/equilibrium_path.h>
#include <tenon/systems/block.h>
#include <tenon/systems/geometry.h>

namespace tenon {

struct ReferenceGeneratorParams {
  /// The path and its equilibria, computed once before the run and shared by several blocks and contexts.
  std::shared_ptr<const EquilibriumPath> path;
  Rate rate = Hz(1000);
  void Validate() const { Demand(path != nullptr, "no path given: make an EquilibriumPath and share it"); }
};

/// Outputs the reference along an EquilibriumPath: position, velocity and acceleration of the CoM, and the
/// attitude, cable lengths and tensions of the static equilibrium there.
///
/// A connected `path` replaces the parameter, see GoalPath.
class ReferenceGenerator final : public LeafSystem<ReferenceGeneratorParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<FollowedPath> path{this, {"path"}, FollowedPath{}};
  OutputPort<CdprReference> reference{this,
                                      {"reference"},
                                      params.path->At(0),
                                      Sampled{params.rate},
                                      Uses(time, path),
                                      &ReferenceGenerator::CalcReference};
  OutputPort<Geometry> geometry{this,
                                {"geometry"},
                                {Shape::Trace(ShapeRole::kReference, "reference", 0.03)},
                                Uses(reference),
                                &ReferenceGenerator::CalcGeometry};

 private:
  void CalcReference(const double& t, const FollowedPath& followed, CdprReference* out) const {
    (followed.path ? *followed.path : *params.path).At(t, out);
  }
  void CalcGeometry(const CdprReference& r, Geometry* out) const { out->front().p_W = r.position; }
};

}  // namespace tenon
