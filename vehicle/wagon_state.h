#pragma once

#include <array>
#include <cstddef>

namespace uiclink {

/// Where the motions are in the state vector: table 2.2 of the thesis, y1..y30, counted from zero.  SI units; x
/// forward, y left, z up; roll, pitch, yaw about x, y, z by the right hand. A wheelset has a block of 11, the car body
/// one of 8.
namespace wheelset {
enum Index : std::size_t { kX, kXRate, kY, kYRate, kZ, kZRate, kPhi, kPhiRate, kBeta, kPsi, kPsiRate, kSize };
}
namespace body {
enum Index : std::size_t { kY, kYRate, kZ, kZRate, kPhi, kPhiRate, kPsi, kPsiRate, kSize };
}

enum class Axle : std::size_t { kFront, kRear };
/// Corners in the order of the thesis: front left, front right, rear left, rear right. Wheels, axle boxes, links,
/// springs and guidance are counted so.
inline constexpr std::size_t kAxles = 2;
inline constexpr std::size_t kCorners = 4;
constexpr std::size_t AxleOf(std::size_t corner) { return corner / 2; }
constexpr double SideOf(std::size_t corner) { return corner % 2 == 0 ? 1.0 : -1.0; }  ///< +1 left, -1 right
constexpr double EndOf(std::size_t corner) { return corner < 2 ? 1.0 : -1.0; }        ///< +1 front, -1 rear

inline constexpr std::size_t kRearWheelset = wheelset::kSize;  ///< the front one begins at 0
inline constexpr std::size_t kBody = 2 * wheelset::kSize;
inline constexpr std::size_t kMotions = kBody + body::kSize;   ///< 30
inline constexpr std::size_t kLeafForces = kMotions;           ///< with leaf springs: their forces, by corner [N]
inline constexpr std::size_t kMaxState = kMotions + kCorners;  ///< 34
static_assert(kMotions == 30);

/// The names of the places, for files and messages: "front_y", "front_y_rate", ..., "body_psi_rate",
/// "front_left_leaf". Units: m, m/s, rad, rad/s, N.
extern const std::array<const char*, kMaxState> kStateNames;
extern const std::array<const char*, kMaxState> kStateUnits;

/// Motions by scalar; the four leaf forces are used with leaf springs only.
template <typename T>
using StateVector = std::array<T, kMaxState>;

}  // namespace uiclink
