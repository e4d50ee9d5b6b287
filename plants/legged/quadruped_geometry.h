#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/plants/surroundings/terrain.h>

namespace tenon {

/// Geometry of a quadruped on terrain for visualisation. Bodies are drawn by their meshes; without meshes,
/// the trunk is the uniform box of its mass and moments of inertia (widened to the legs) and links are
/// capsules. The shapes of QuadrupedClearance are drawn beside those that differ, with a role of their own.
/// The payload is a uniform box, feet are spheres. Further shapes are the forces on the feet, external
/// forces, the path of the trunk and the terrain. An arrow for half the robot's weight is as long as the
/// robot is high.
///
/// Viewers draw a level plane at z = 0, so it is not among the shapes; a slope is a slab at the origin.
Geometry MakeQuadrupedGeometry(const QuadrupedDescription& robot, const RigidInertia& payload,
                               const TerrainParams& terrain);

/// Updates the shapes of MakeQuadrupedGeometry for this robot. Does not allocate. Forces on invalid bodies
/// are hidden.
void MoveQuadrupedGeometry(const QuadrupedDescription& robot, const RigidInertia& payload,
                           const LeggedState& x, const FootForces& feet, const ExternalForces& external,
                           Geometry* geometry);

/// Edges of the uniform box with the mass and the moments of inertia of a body [m]; 0 without mass.
Eigen::Vector3d UniformBox(const RigidInertia& body);

/// The box that spans the first joints of the legs, with the height of the trunk's collision shapes, or
/// without them that of the uniform box.
RoundedBox BoxBetweenHips(const QuadrupedDescription& robot);

/// Radius of the capsules that represent the links [m].
double LinkRadius(const QuadrupedDescription& robot);

}  // namespace tenon
