#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace uiclink {

/// Philox4x32-10: four random words that are a function of key and counter alone.
/// Source: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC11 (2011).
std::array<std::uint32_t, 4> CalcPhilox(std::array<std::uint32_t, 4> counter, std::array<std::uint32_t, 2> key);

/// The random numbers of one purpose ("speed", "scatter") of one sample of a campaign. They depend on nothing else: not
/// on the order of runs, on threads or on what other purposes take.
class CounterRandom {
 public:
  CounterRandom(std::uint64_t seed, std::uint32_t sample, std::string_view purpose);

  std::uint64_t Bits();  ///< 64 random bits
  double Uniform();      ///< 0 < u < 1, 52 random bits
  double Normal();       ///< mean 0, standard deviation 1 (Box and Muller)

 private:
  std::array<std::uint32_t, 2> key_;
  std::array<std::uint32_t, 4> counter_;
};

}  // namespace uiclink
