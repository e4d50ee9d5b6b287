#pragma once

#include <tenon/systems/framework/types/fields.h>

#include <cstdint>

namespace tenon {

/// A stream of random numbers whose whole state is 48 bytes of the context, so that saved, cloned and
/// repeated runs are identical bit for bit on every platform (the standard library's distributions are not
/// portable).
///
/// The generator is xoshiro256++ (Blackman and Vigna, "Scrambled linear pseudorandom number generators", ACM
/// Trans. Math. Softw. 47, 2021), seeded by SplitMix64. Normal numbers use the polar method of Marsaglia and
/// Bray (SIAM Review 6, 1964).
class RandomStream {
 public:
  explicit RandomStream(std::uint64_t seed = 0);
  /// The stream of the block at `path` in a run with `seed`. Streams of different blocks are independent.
  RandomStream(std::uint64_t seed, std::string_view path);

  std::uint64_t Next();                     ///< 64 random bits
  double Uniform();                         ///< uniform in [0, 1)
  double Uniform(double low, double high);  ///< uniform in [low, high)
  double Normal();                          ///< mean 0, standard deviation 1

  static FieldList Fields() {
    return {{"state", &RandomStream::state_},
            {"spare", &RandomStream::spare_},
            {"has_spare", &RandomStream::has_spare_}};
  }

 private:
  std::array<std::uint64_t, 4> state_;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace tenon
