#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/plants/surroundings/terrain.h>
#include <tenon/systems/geometry.h>

namespace tenon {

/// What a quadruped on terrain looks like: bodies by their meshes; without one the trunk as the uniform box
/// that has its mass and moments of inertia (wider if the legs are not within), links as capsules; the
/// payload as a uniform box, feet as spheres, the forces on the feet, forces of the surroundings, the path of
/// the trunk, and the terrain. An arrow for half the robot's weight is as long as the robot is high.
///
/// A level plane is not among the shapes, for viewers draw one at z = 0; a slope is a slab about the origin.
Geometry MakeQuadrupedGeometry(const QuadrupedDescription& robot, const RigidInertia& payload,
                               const TerrainParams& terrain);

/// Moves the shapes that MakeQuadrupedGeometry made for the same robot; allocates nothing. Forces on bodies
/// that are not there are not drawn.
void MoveQuadrupedGeometry(const QuadrupedDescription& robot, const RigidInertia& payload,
                           const LeggedState& x, const FootForces& feet, const ExternalForces& external,
                           Geometry* geometry);

/// The edges of the uniform box with the mass and the moments of inertia of a body [m]; 0 without mass.
Eigen::Vector3d UniformBox(const RigidInertia& body);

/// Of the capsules that stand for the links [m].
double LinkRadius(const QuadrupedDescription& robot);

}  // namespace tenon
