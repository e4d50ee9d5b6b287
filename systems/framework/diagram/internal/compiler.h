#pragma once

#include <tenon/systems/framework/block/system.h>
#include <tenon/systems/framework/diagram/internal/program.h>

#include <unordered_set>

namespace tenon::internal {

class Assembly;

/// Compiles blocks and connections into a Program. The steps run in the order of the functions below.
class Compiler {
 public:
  /// Throws BuildError: unconnected inputs (unless they may stay open), algebraic loops, states without
  /// derivative, offsets without initial value, uses of other blocks' ports, different units or sizes.
  static Program Compile(const std::vector<std::unique_ptr<System>>& blocks, bool open_inputs);

 private:
  Compiler(const std::vector<std::unique_ptr<System>>& blocks, bool open_inputs);

  // compiler.cc: contents and order of the program
  void Collect(const std::vector<std::unique_ptr<System>>& blocks);
  void MergeShared();
  void Order();
  void OrderPublishes();
  void Visit(Source& source, std::vector<const Source*>& trail);
  void AddCalculation(Source& source);
  [[noreturn]] void ThrowLoop(const std::vector<const Source*>& trail, const Source& again) const;
  void DeclareSizes();
  void LayOut();
  void Place(Source& source, std::size_t& end);
  void FillArguments();

  // compiler_checks.cc: checks; all faults are reported together
  void ResolveInputs();
  void CheckMembers(const System& block);
  void CheckSpec(const Source& source);
  void CheckReplacement(const System& block);
  void CheckConnections();
  void CheckDeclarations();
  void CheckArguments(const Source& calculation);
  void Fault(std::string text);
  void ThrowFaults() const;

  // compiler_plans.cc: lists of calculations for ticks, updates and the integrator
  void FindGroups();
  void FindFeeders();
  void MakePlans();
  std::unordered_set<const System*> FindVaryingBlocks(bool derivatives_alone) const;
  std::vector<const Source*> FindKinks() const;
  void FindJumps();

  bool open_inputs_;
  Program program_;
  std::vector<std::string> faults_;
  std::vector<Source*> sources_;               ///< sources of all leaves, in order
  std::vector<Source*> ports_;                 ///< ports of subdiagrams
  std::vector<const System*> replacements_;    ///< blocks that replaced others
  std::vector<const Source*> default_inputs_;  ///< read but not connected; they have a default
};

}  // namespace tenon::internal
