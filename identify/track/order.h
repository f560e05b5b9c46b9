#pragma once

#include <span>
#include <vector>

namespace uiclink::track {

/// The motion along its axis, one value a picture that was used, in their order.
struct MotionSeries {
  std::vector<double> t;      ///< [s], increasing
  std::vector<double> x;      ///< [pixel]
  std::vector<double> sigma;  ///< standard deviation of x [pixel]
};

/// How much the samples scatter about a smooth motion beyond their own standard deviation [pixel], one value a sample:
/// sqrt(max(0, scatter^2 - sigma^2)) over half a second about it, scatter being what a polynomial of degree five leaves
/// of every ten samples. A codec that moves a picture's blocks by whole quarters of a pixel leaves no residual in
/// the picture; this is where it shows. Errors that last for many pictures do not.
std::vector<double> CalcExcessScatter(const MotionSeries& motion);

/// Samples whose picture repeats the one before: the patch stands still for one step between steps of the same
/// direction. A recorder that drops a picture and fills its place does that; the reading belongs to an earlier time.
std::vector<std::size_t> FindRepeated(const MotionSeries& motion);

/// From sample `at` on, pictures are missing (or doubled) that the time stamps do not know of.
struct HiddenGap {
  std::size_t at = 0;
  int pictures = 0;  ///< missing; negative: too many
};

/// Places where a smooth motion (a polynomial of degree five through five samples on both sides) needs a shift of time
/// by whole steps: without it the residual exceeds four standard deviations, with it it falls to a fifth or less. A
/// missing picture near a reversal moves nothing and is not found.
///
/// @param step  of the even rate [s].
std::vector<HiddenGap> FindHiddenGaps(const MotionSeries& motion, double step);

}  // namespace uiclink::track
