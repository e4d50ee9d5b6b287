#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/geometry.h>

namespace tenon::apps {

// The columns of a log are found by the port that was logged, and by the members of its value:
//
//     Columns(names, loop.errors.errors, &WalkingErrors::com)
//     Column(names, loop.locomotion.schedule, &ContactSchedule::legs, leg, &LegContact::state)
//
// If the port's block was replaced, the port of the new block counts, see FindCurrent.

/// Returns the ports that are now in the places of `ports`, without those that the new blocks lack.
template <class Port>
std::vector<const Port*> Present(const std::vector<const Port*>& ports) {
  std::vector<const Port*> present;
  for (const Port* port : ports)
    if (const Port* current = FindCurrent(*port)) present.push_back(current);
  return present;
}

/// Whether the port that is now in the place of `port` has named elements.
inline bool HasElements(const Source& port) {
  const Source* const current = FindCurrent(port);
  return current != nullptr && !current->spec().elements.empty();
}

namespace logged {

/// A part of a port's value: its name in logs, and the names of its items if it is an array.
struct LoggedPart {
  std::string name, items;
};
LoggedPart PartOf(const Source& port);
LoggedPart MemberOf(const LoggedPart& part, const internal::TypeInfo& type, std::size_t offset,
                    const internal::TypeInfo& member);
LoggedPart ItemOf(const LoggedPart& part, std::size_t item);

template <class Whole>
std::string NameOf(const LoggedPart& part) {
  return part.name;
}
template <class Whole, class Struct, class Member, class... Steps>
std::string NameOf(const LoggedPart& part, Member Struct::*member, Steps... steps) {
  static_assert(std::derived_from<Whole, Struct>, "the member belongs to another struct than the value");
  using internal::OffsetOf, internal::TypeInfoOf;
  const std::size_t offset = OffsetOf<Whole>(static_cast<Member Whole::*>(member));
  return NameOf<Member>(MemberOf(part, TypeInfoOf<Whole>(), offset, TypeInfoOf<Member>()), steps...);
}
template <class Whole, class... Steps>
std::string NameOf(const LoggedPart& part, std::size_t item, Steps... steps) {
  return NameOf<typename Whole::value_type>(ItemOf(part, item), steps...);
}

std::size_t Column(const std::vector<std::string>& names, const std::string& signal);
std::vector<std::size_t> Columns(const std::vector<std::string>& names, const std::string& signal);

}  // namespace logged

/// Returns the name in logs of a port's value, or of the part of it that the steps lead to: members of
/// structs, and indices of items. Throws BuildError if the block that replaced the port's block lacks the
/// port.
template <class T, class... Steps>
std::string SignalName(const OutputPort<T>& port, Steps... steps) {
  return logged::NameOf<T>(logged::PartOf(port.Current()), steps...);
}

/// Returns the column that holds a number. Throws Error if the port is not logged.
template <class T, class... Steps>
std::size_t Column(const std::vector<std::string>& names, const OutputPort<T>& port, Steps... steps) {
  return logged::Column(names, SignalName(port, steps...));
}
/// Returns the columns that hold the elements of a vector, or of any other part of a value. Throws Error if
/// the port is not logged.
template <class T, class... Steps>
std::vector<std::size_t> Columns(const std::vector<std::string>& names, const OutputPort<T>& port,
                                 Steps... steps) {
  return logged::Columns(names, SignalName(port, steps...));
}

/// Column and Columns for a port that may not exist: without a port, there are no columns.
template <class T, class... Steps>
std::optional<std::size_t> Column(const std::vector<std::string>& names, const OutputPort<T>* port,
                                  Steps... steps) {
  return port == nullptr ? std::nullopt : std::optional(Column(names, *port, steps...));
}
template <class T, class... Steps>
std::vector<std::size_t> Columns(const std::vector<std::string>& names, const OutputPort<T>* port,
                                 Steps... steps) {
  return port == nullptr ? std::vector<std::size_t>() : Columns(names, *port, steps...);
}

/// Returns the vector in the given columns of a row.
template <int N>
Vec<N> VectorIn(std::span<const double> row, const std::vector<std::size_t>& columns) {
  Vec<N> value;
  for (int i = 0; i < N; ++i) value[i] = row[columns[static_cast<std::size_t>(i)]];
  return value;
}

/// The value of a port, or of a member of it, in the rows of a log.
template <class T>
class Logged {
 public:
  /// Finds the columns. Without a port there is no value. Throws Error if the port is not logged.
  void Begin(const std::vector<std::string>& names, const OutputPort<T>* port) {
    first_ = Column(names, port);
  }
  template <class Whole>
  void Begin(const std::vector<std::string>& names, const OutputPort<Whole>* port, T Whole::*member) {
    first_ = Column(names, port, member);
  }
  explicit operator bool() const { return first_.has_value(); }
  T In(std::span<const double> row) const {
    T value{};
    internal::FromDoubles(internal::TypeInfoOf<T>(), &value, &row[*first_]);
    return value;
  }

 private:
  std::optional<std::size_t> first_;
};

/// The surfaces of bodies that were added to a robot (ExtendQuadruped, ExtendCdpr), from a log of the plant's
/// `geometry`. A surface is a set of points with a radius: corners of boxes and meshes, ends of capsules and
/// rods, edges of cylinders. Fixtures, arrows and traces are left out.
class AddedShapes {
 public:
  AddedShapes() = default;
  /// `shapes` with their constant members; `first` is the index of the first one in the plant's geometry.
  AddedShapes(const Geometry& shapes, std::size_t first);
  /// The shapes that were added to the plant that stands in the diagram, behind the `first` ones of its
  /// geometry; none for a plant of another class.
  template <class Plant>
  static AddedShapes Of(const Plant& plant, std::size_t first) {
    const Plant& shipped = CurrentAs(plant);
    return CurrentBlock(plant) == &shipped ? AddedShapes(shipped.additions.shapes, first) : AddedShapes();
  }

  bool empty() const { return surfaces_.empty(); }
  void Begin(const std::vector<std::string>& names, const OutputPort<Geometry>& geometry);
  using Visitor = std::function<void(const std::string& name, const Vec<3>& p_W, double radius)>;
  /// Visits all points, by the name of their shape.
  void Visit(std::span<const double> row, const Visitor& visit) const;

 private:
  struct Surface {
    std::string name;
    std::size_t shape;
    bool segment;
    double radius;                                      // [m]
    std::vector<Vec<3>> points;                         // in the shape's frame [m]
    std::vector<std::size_t> p_W{}, q_W{}, vector_W{};  // columns
  };
  std::vector<Surface> surfaces_;
};

}  // namespace tenon::apps
