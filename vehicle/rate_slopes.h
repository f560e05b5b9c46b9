#pragma once

#include <array>
#include <cstddef>

#include "vehicle/wagon.h"

namespace uiclink {

/// The derivatives of the rate, exactly, as they are sparse: accelerations by what they depend on. (The rates of
/// positions are the velocities; the spin beta of a wheelset is a velocity without position.)
///
/// By inputs, each with the rows that it acts on.
struct RateSlopes {
  /// x_rate, y_rate, z_rate, phi_rate, beta, psi_rate of a wheelset; two more keep a column whole.
  static constexpr std::size_t kAxleRows = 6;
  static constexpr std::size_t kAxleStride = 8;
  static constexpr std::array<std::size_t, kAxleRows> kAxleRow{
      wheelset::kXRate, wheelset::kYRate, wheelset::kZRate, wheelset::kPhiRate, wheelset::kBeta, wheelset::kPsiRate};
  /// Positions; the row after each is its velocity.
  static constexpr std::array<std::size_t, 5> kAxlePosition{wheelset::kX, wheelset::kY, wheelset::kZ, wheelset::kPhi,
                                                            wheelset::kPsi};
  /// Its inputs: its own motions, those of the body, forces of its longitudinal links (left, right) and of its lateral
  /// ones, forces of its leaf springs.
  static constexpr std::size_t kAxleLinks = std::size_t{wheelset::kSize} + body::kSize;
  static constexpr std::size_t kAxleLeaves = kAxleLinks + 4;
  static constexpr std::size_t kAxleInputs = kAxleLeaves + 2;
  using AxleColumn = std::array<double, kAxleStride>;
  std::array<std::array<AxleColumn, kAxleInputs>, kAxles> axles;

  /// y_rate, z_rate, phi_rate, psi_rate of the body. Inputs: all motions, the leaf springs, the longitudinal links, the
  /// lateral ones.
  static constexpr std::size_t kBodyRows = 4;
  static constexpr std::array<std::size_t, kBodyRows> kBodyRow{body::kYRate, body::kZRate, body::kPhiRate,
                                                               body::kPsiRate};
  static constexpr std::array<std::size_t, 4> kBodyPosition{body::kY, body::kZ, body::kPhi, body::kPsi};
  static constexpr std::size_t kBodyLinks = kMaxState;
  static constexpr std::size_t kBodyInputs = kBodyLinks + 2 * kCorners;
  using BodyColumn = std::array<double, kBodyRows>;
  std::array<BodyColumn, kBodyInputs> body;

  /// The rate of a leaf spring's force by z, z_rate, phi, phi_rate of its wheelset, the same of the body, and itself.
  static constexpr std::size_t kLeafInputs = 9;
  std::array<std::array<double, kLeafInputs>, kCorners> leaves;

  /// Rows of a wheelset by the speed; the body does not feel it.
  std::array<AxleColumn, kAxles> by_speed;
};

/// @param V  speed [m/s], > 0.
/// Where the rate has a bend (a guide or the stage of a spring just met), the side is that which CalcRate takes.
void CalcRateSlopes(const Wagon& wagon, double V, const LinkStates& links, const StateVector<double>& x,
                    RateSlopes* slopes);

/// All components by all others: jacobian[i][j] = d rate_i / d x_j.
using StateMatrix = std::array<StateVector<double>, kMaxState>;
StateMatrix SpreadOut(const RateSlopes& slopes);

}  // namespace uiclink
