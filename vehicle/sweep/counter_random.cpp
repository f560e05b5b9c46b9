#include "vehicle/sweep/counter_random.h"

#include <cmath>
#include <numbers>

namespace uiclink {
namespace {

std::uint32_t High(std::uint64_t word) { return static_cast<std::uint32_t>(word >> 32); }
std::uint32_t Low(std::uint64_t word) { return static_cast<std::uint32_t>(word); }

/// FNV-1a, 64 bits: purposes are a handful of fixed words.
std::uint64_t Hash(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return hash;
}

}  // namespace

std::array<std::uint32_t, 4> CalcPhilox(std::array<std::uint32_t, 4> counter, std::array<std::uint32_t, 2> key) {
  constexpr int kRounds = 10;
  constexpr std::uint64_t kMultiplier0 = 0xD2511F53, kMultiplier1 = 0xCD9E8D57;
  constexpr std::uint32_t kWeyl0 = 0x9E3779B9, kWeyl1 = 0xBB67AE85;
  for (int round = 0; round < kRounds; ++round) {
    const std::uint64_t a = kMultiplier0 * counter[0], b = kMultiplier1 * counter[2];
    counter = {High(b) ^ counter[1] ^ key[0], Low(b), High(a) ^ counter[3] ^ key[1], Low(a)};
    key = {key[0] + kWeyl0, key[1] + kWeyl1};
  }
  return counter;
}

CounterRandom::CounterRandom(std::uint64_t seed, std::uint32_t sample, std::string_view purpose)
    : key_{Low(seed), High(seed)}, counter_{0, sample, Low(Hash(purpose)), High(Hash(purpose))} {}

std::uint64_t CounterRandom::Bits() {
  const std::array<std::uint32_t, 4> words = CalcPhilox(counter_, key_);
  ++counter_[0];
  return static_cast<std::uint64_t>(words[0]) << 32 | words[1];
}

double CounterRandom::Uniform() { return (static_cast<double>(Bits() >> 12) + 0.5) * 0x1p-52; }

double CounterRandom::Normal() {
  const double radius = std::sqrt(-2 * std::log(Uniform()));
  return radius * std::cos(2 * std::numbers::pi * Uniform());
}

}  // namespace uiclink
