#include <tenon/apps/common/columns.h>
#include <tenon/systems/report/internal/run_log.h>

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <numbers>

namespace tenon::apps {

namespace logged {

LoggedPart PartOf(const Source& port) {
  return {port.path(), port.spec().elements};
}

LoggedPart MemberOf(const LoggedPart& part, const internal::TypeInfo& type, std::size_t offset,
                    const internal::TypeInfo& member) {
  const auto field = std::ranges::find_if(
      type.fields, [&](const Field& each) { return each.offset == offset && &each.type() == &member; });
  if (field == type.fields.end())
    throw BuildError(
        fmt::format("'{}' has no column for a member of {} that its Fields() lacks: describe the "
                    "member, or read another one",
                    part.name, TypeName(type)));
  return {part.name + "." + field->name, field->elements};
}

LoggedPart ItemOf(const LoggedPart& part, std::size_t item) {
  // The items of a list have the names that a log gives them.
  const std::vector<double> list(item + 1);
  const std::vector<Element> items =
      internal::ListElements(internal::TypeInfoOf<std::vector<double>>(), &list, Spec("", "", part.items));
  return {part.name + "." + items.back().name, ""};
}

std::vector<std::size_t> Columns(const std::vector<std::string>& names, const std::string& signal) {
  std::vector<std::size_t> columns = internal::FindColumns(names, signal);
  if (columns.empty()) throw Error(fmt::format("the log has no signal '{}'", signal));
  return columns;
}

std::size_t Column(const std::vector<std::string>& names, const std::string& signal) {
  return Columns(names, signal).front();
}

}  // namespace logged

namespace {

/// The corners of a mesh that lie farthest out in 26 directions.
std::vector<Vec<3>> ExtremesOf(const TriangleMesh& mesh) {
  std::vector<Vec<3>> extremes;
  const auto corner = [](const std::array<float, 3>& each) { return Vec<3>(each[0], each[1], each[2]); };
  for (int i = 0; i < 27 && !mesh.corners.empty(); ++i) {
    const Vec<3> direction(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (!direction.isZero(0))
      extremes.push_back(corner(*std::ranges::max_element(
          mesh.corners, {}, [&](const auto& each) { return direction.dot(corner(each)); })));
  }
  return extremes;
}

/// The points of a shape in its own frame; none for a shape that is no body.
std::vector<Vec<3>> PointsOf(const Shape& shape) {
  std::vector<Vec<3>> points;
  const Vec<3>& size = shape.size;
  switch (shape.kind) {
    case ShapeKind::kBox:
      for (int i = 0; i < 8; ++i)
        points.push_back(0.5 * Vec<3>(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1).cwiseProduct(size));
      break;
    case ShapeKind::kCylinder:
      for (int i = 0; i < 16; ++i) {
        const double angle = i / 2 * std::numbers::pi / 4;
        points.emplace_back(size[0] * std::cos(angle), size[0] * std::sin(angle), (i % 2 - 0.5) * size[1]);
      }
      break;
    case ShapeKind::kCapsule:
      points = {Vec<3>(0, 0, size[1] / 2), Vec<3>(0, 0, -size[1] / 2)};
      break;
    case ShapeKind::kSphere:
    case ShapeKind::kSegment:
      points = {Vec<3>::Zero()};
      break;
    case ShapeKind::kMesh:
      if (shape.mesh != nullptr) points = ExtremesOf(*shape.mesh);
      break;
    case ShapeKind::kArrow:
    case ShapeKind::kTrace:
      break;
  }
  return points;
}

}  // namespace

AddedShapes::AddedShapes(const Geometry& shapes, std::size_t first) {
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const Shape& shape = shapes[i];
    if (shape.role == ShapeRole::kGround || shape.role == ShapeRole::kFixture) continue;
    const bool segment = shape.kind == ShapeKind::kSegment;
    const bool round = segment || shape.kind == ShapeKind::kSphere || shape.kind == ShapeKind::kCapsule;
    if (std::vector<Vec<3>> points = PointsOf(shape); !points.empty())
      surfaces_.push_back({shape.name, first + i, segment, round ? shape.size[0] : 0, std::move(points)});
  }
}

void AddedShapes::Begin(const std::vector<std::string>& names, const OutputPort<Geometry>& geometry) {
  for (Surface& surface : surfaces_) {
    surface.p_W = Columns(names, geometry, surface.shape, &Shape::p_W);
    surface.q_W = Columns(names, geometry, surface.shape, &Shape::q_W);
    surface.vector_W = Columns(names, geometry, surface.shape, &Shape::vector_W);
  }
}

void AddedShapes::Visit(std::span<const double> row, const Visitor& visit) const {
  for (const Surface& surface : surfaces_) {
    const Vec<3> p_W = VectorIn<3>(row, surface.p_W);
    const Vec<4> q = VectorIn<4>(row, surface.q_W);
    const Eigen::Quaterniond turn = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
    for (const Vec<3>& point : surface.points) visit(surface.name, p_W + turn * point, surface.radius);
    if (surface.segment) visit(surface.name, p_W + VectorIn<3>(row, surface.vector_W), surface.radius);
  }
}

}  // namespace tenon::apps
