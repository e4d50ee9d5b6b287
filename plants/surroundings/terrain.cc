#include <tenon/plants/model/vectors.h>
#include <tenon/plants/surroundings/terrain.h>
#include <tenon/systems/framework/block/random_stream.h>

#include <fmt/format.h>

#include <algorithm>

namespace tenon {
namespace {

constexpr double kMaxCells = 1e6;
constexpr double kMaxPlaces = 1e5;

/// The nearest point of a box to p, and the depth of a sphere there; p may be inside.
bool TouchBox(const TerrainBox& box, const Vec<3>& p, double radius, Vec<3>* normal, double* depth) {
  const Vec<2> half = box.size / 2;
  const double dx = p[0] - box.centre[0], dy = p[1] - box.centre[1], dz = p[2] - box.height;
  const double ox = std::max(0.0, std::abs(dx) - half[0]), oy = std::max(0.0, std::abs(dy) - half[1]);
  const double oz = std::max(0.0, dz);
  const double distance = std::sqrt(ox * ox + oy * oy + oz * oz);
  if (distance >= radius) return false;
  if (distance > 0) {
    *normal = Vec<3>(std::copysign(ox, dx), std::copysign(oy, dy), oz) / distance;
    *depth = radius - distance;
    return true;
  }
  // A centre inside the box leaves by the nearest face.
  const double to_x = half[0] - std::abs(dx), to_y = half[1] - std::abs(dy), to_top = -dz;
  const double out = std::min({to_x, to_y, to_top});
  *normal = out == to_top ? Vec<3>(0, 0, 1)
            : out == to_x ? Vec<3>(std::copysign(1, dx), 0, 0)
                          : Vec<3>(0, std::copysign(1, dy), 0);
  *depth = radius + out;
  return true;
}

void Insert(const Terrain::Contact& contact, Terrain::Contacts* contacts) {
  if (contacts->count < Terrain::kMaxContacts) {
    contacts->at[contacts->count++] = contact;
    return;
  }
  auto* shallowest = std::min_element(contacts->at.begin(), contacts->at.end(),
                                      [](const auto& a, const auto& b) { return a.depth < b.depth; });
  if (shallowest->depth < contact.depth) *shallowest = contact;
}

}  // namespace

void BoxField::Validate() const {
  if ((upper - lower).minCoeff() <= 0)
    throw ParameterError(
        fmt::format("upper_m is ({}, {}) m but must exceed lower_m, ({}, {}) m: the field has no area",
                    upper[0], upper[1], lower[0], lower[1]));
  const double places = ((upper - lower).array() / (size.array() + gap)).max(1).prod();
  if (!(places <= kMaxPlaces))
    throw ParameterError(fmt::format(
        "the field has {:.3g} places for boxes, more than {}; give a smaller area or larger boxes", places,
        kMaxPlaces));
  if (kinds.empty())
    throw ParameterError("the field has no kinds of boxes; list height_m and friction under kinds");
}

std::vector<TerrainBox> BoxField::Boxes() const {
  RandomStream random(seed);
  std::vector<TerrainBox> boxes;
  const Vec<2> pitch = size.array() + gap;
  // Drawn one after the other: compilers evaluate the arguments of a call in different orders.
  const double along_y = random.Uniform(0, 1), along_x = random.Uniform(0, 1);
  const Vec<2> first = lower + size / 2 - Vec<2>(along_x * pitch[0], along_y * pitch[1]);
  for (Vec<2> centre = first; centre[0] + size[0] / 2 <= upper[0]; centre[0] += pitch[0]) {
    for (centre[1] = first[1]; centre[1] + size[1] / 2 <= upper[1]; centre[1] += pitch[1]) {
      // Draws two numbers for every cell, so that cells do not depend on each other.
      const bool taken = random.Uniform(0, 1) < coverage;
      const double which = random.Uniform(0, static_cast<double>(kinds.size()));
      if (!taken || (centre - size / 2 - lower).minCoeff() < 0) continue;
      const BoxKind& kind = kinds[std::min(static_cast<std::size_t>(which), kinds.size() - 1)];
      boxes.push_back({centre, size, kind.height, kind.friction});
    }
  }
  return boxes;
}

std::vector<TerrainBox> Stairs::Boxes() const {
  std::vector<TerrainBox> boxes;
  const double half = (steps - 1) * run + landing / 2;  // from the first edge to the middle of the landing
  for (int k = 0; k < steps; ++k)
    boxes.push_back({begin + Vec<2>(half, 0), {2 * (half - k * run), width}, (k + 1) * rise, friction});
  return boxes;
}

void TerrainParams::Validate() const {
  CheckRanges(*this);
  if (field) field->Validate();
}

Terrain::Terrain(const TerrainParams& params) : friction_(params.friction), boxes_(params.boxes) {
  params.Validate();
  const Vec<3> normal = Vec<3>(-params.grade[0], -params.grade[1], 1).normalized();
  R_WS_ = RotationBetween(Eigen::Vector3d::UnitZ(), normal).toRotationMatrix();
  const auto add = [this](const auto& source) {
    if (!source) return;
    const std::vector<TerrainBox> boxes = source->Boxes();
    boxes_.insert(boxes_.end(), boxes.begin(), boxes.end());
  };
  add(params.field);
  add(params.stairs);
  if (boxes_.empty()) return;

  // The region in which a point has a box near it: up to the reach of a foot around the box, and below its
  // top. On a slope, the top is not directly above the footprint.
  const auto half_of = [&](const TerrainBox& box) -> Vec<2> {
    const Vec<2> aside = (box.height / normal[2] * R_WS_.row(2).head<2>().transpose()).cwiseAbs();
    return box.size / 2 + aside.cwiseMax(kMaxRadius);
  };
  corner_ = boxes_[0].centre;
  Vec<2> far = corner_;
  for (const TerrainBox& box : boxes_) {
    const Vec<2> half = half_of(box);
    corner_ = corner_.cwiseMin(box.centre - half);
    far = far.cwiseMax(box.centre + half);
    cell_ = &box == &boxes_[0] ? box.size.maxCoeff() : std::min(cell_, box.size.maxCoeff());
  }
  const Vec<2> extent = far - corner_;
  cell_ = std::max({cell_, kMaxRadius, std::sqrt(extent[0] * extent[1] / kMaxCells)});
  nx_ = static_cast<int>(extent[0] / cell_) + 1;
  ny_ = static_cast<int>(extent[1] / cell_) + 1;
  std::vector<std::vector<int>> cells(static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_));
  for (std::size_t b = 0; b < boxes_.size(); ++b) {
    const Vec<2> half = half_of(boxes_[b]);
    const Vec<2> from = (boxes_[b].centre - half - corner_) / cell_,
                 to = (boxes_[b].centre + half - corner_) / cell_;
    for (int j = static_cast<int>(from[1]); j <= std::min(ny_ - 1, static_cast<int>(to[1])); ++j)
      for (int i = static_cast<int>(from[0]); i <= std::min(nx_ - 1, static_cast<int>(to[0])); ++i)
        cells[i + nx_ * j].push_back(static_cast<int>(b));
  }
  for (const std::vector<int>& cell : cells) {
    starts_.push_back(static_cast<int>(members_.size()));
    members_.insert(members_.end(), cell.begin(), cell.end());
  }
  starts_.push_back(static_cast<int>(members_.size()));
}

Terrain::Range Terrain::Near(const Vec<3>& p_S) const {
  const double i = std::floor((p_S[0] - corner_[0]) / cell_), j = std::floor((p_S[1] - corner_[1]) / cell_);
  if (!(i >= 0 && i < nx_ && j >= 0 && j < ny_)) return {nullptr, nullptr};
  const int cell = static_cast<int>(i) + nx_ * static_cast<int>(j);
  return {members_.data() + starts_[cell], members_.data() + starts_[cell + 1]};
}

Terrain::Surface Terrain::At(double x, double y) const {
  const Vec<3> normal = R_WS_.col(2);
  const double plane = -(normal[0] * x + normal[1] * y) / normal[2];
  Surface surface{plane, normal, friction_};
  const Vec<3> foot_S = R_WS_.transpose() * Vec<3>(x, y, plane), up_S = R_WS_.row(2) / normal[2];
  for (const int b : Near(foot_S)) {
    const TerrainBox& box = boxes_[b];
    const Vec<3> top_S = foot_S + box.height * up_S;
    const bool above = ((top_S.head<2>() - box.centre).cwiseAbs() - box.size / 2).maxCoeff() <= 0;
    const double height = plane + box.height / normal[2];
    if (above && height > surface.height) surface = {height, normal, box.friction};
  }
  return surface;
}

Terrain::Contacts Terrain::Touch(const Vec<3>& centre_W, double radius) const {
  Contacts contacts;
  const Vec<3> p_S = R_WS_.transpose() * centre_W;
  if (p_S[2] < radius) Insert({R_WS_.col(2), radius - p_S[2], friction_}, &contacts);
  for (const int b : Near(p_S)) {
    const TerrainBox& box = boxes_[b];
    Vec<3> normal_S;
    double depth = 0;
    if (TouchBox(box, p_S, radius, &normal_S, &depth))
      Insert({R_WS_ * normal_S, depth, box.friction}, &contacts);
  }
  return contacts;
}

}  // namespace tenon
