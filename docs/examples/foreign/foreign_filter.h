#pragma once

#include <tenon/systems/block.h>

#include "filter.h"

#include <array>
#include <cstddef>
#include <cstring>
#include <new>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

/// Owns a handle. Contexts are cloned, so a copy has a handle of its own with the same state.
class FilterHandle {
 public:
  using State = std::array<double, FILTER_STATES>;
  explicit FilterHandle(double cutoff = 1, double period = 1e-3)
      : cutoff_(cutoff), period_(period), handle_(filter_create(cutoff, period)) {
    if (handle_ == nullptr) throw std::bad_alloc();
  }
  FilterHandle(const FilterHandle& other) : FilterHandle(other.cutoff_, other.period_) {
    SetState(other.state());
  }
  FilterHandle& operator=(const FilterHandle& other) {
    FilterHandle copy(other);
    std::swap(cutoff_, copy.cutoff_);
    std::swap(period_, copy.period_);
    std::swap(handle_, copy.handle_);
    return *this;
  }
  ~FilterHandle() { filter_destroy(handle_); }

  double Step(double u) { return filter_step(handle_, u); }
  State state() const {
    State state{};
    filter_get_state(handle_, state.data());
    return state;
  }
  void SetState(const State& state) { filter_set_state(handle_, state.data()); }

 private:
  double cutoff_, period_;
  filter* handle_;
};

/// Snapshots contain the state, not the handle.
template <>
struct tenon::SnapshotOf<FilterHandle> {
  static std::vector<std::byte> Save(const FilterHandle& filter) {
    const FilterHandle::State state = filter.state();
    const auto bytes = std::as_bytes(std::span(state));
    return {bytes.begin(), bytes.end()};
  }
  static void Load(std::span<const std::byte> bytes, FilterHandle& filter) {
    FilterHandle::State state{};
    if (bytes.size() != sizeof(state)) throw std::runtime_error("the state of a filter has another size");
    std::memcpy(state.data(), bytes.data(), sizeof(state));
    filter.SetState(state);
  }
};

struct ForeignFilterParams {
  double cutoff = 10;  ///< [rad/s]
  tenon::Rate rate = tenon::Hz(1000);
};

/// The C filter as a block: y[k] = filter_step(u[k]) at each tick.
class ForeignFilter final : public tenon::LeafSystem<ForeignFilterParams> {
 public:
  using LeafSystem::LeafSystem;
  tenon::InputPort<double> u{this, "u"};
  tenon::Scratch<FilterHandle> filter{this, "filter", FilterHandle(params.cutoff, params.rate.period())};
  tenon::OutputPort<double> y{this, "y", tenon::Sampled{params.rate}, Uses(filter, u),
                              [](FilterHandle& filter, double u) { return filter.Step(u); }};
};
