#pragma once

/// @file
/// Everything needed to write a block: ports, states, calculations, parameters.
///
///     #include <tenon/systems/block.h>
///
///     struct PdParams {
///       double kp = 10;  // N/m
///       double kd = 2;   // N s/m
///       tenon::Rate rate = tenon::Hz(1000);
///     };
///     class Pd final : public tenon::LeafSystem<PdParams> {
///      public:
///       using LeafSystem::LeafSystem;
///       tenon::InputPort<tenon::Vec<2>> x{this, {"x", "m, m/s"}};
///       tenon::InputPort<double> ref{this, {"ref", "m"}};
///       tenon::OutputPort<double> u{
///           this, {"u", "N"}, tenon::Sampled{params.rate}, tenon::Uses(x, ref), &Pd::CalcU};
///
///      private:
///       double CalcU(const tenon::Vec<2>& x, double ref) const {
///         return params.kp * (ref - x[0]) - params.kd * x[1];
///       }
///     };
///
/// The members of a block are documented in ports.h and state.h, diagrams in diagram_builder.h.

#include <tenon/systems/framework/block/external_port.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/publish.h>
