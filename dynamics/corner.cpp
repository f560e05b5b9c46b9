#include "dynamics/corner.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

namespace uiclink {
namespace {

constexpr double kFarther = 4;      // from one reach to the next
constexpr double kStraight = 0.9;   // cosine between the direction that was guessed and the branch that was found there
constexpr double kFarOff = 0.5;     // a correction longer than this part of the distance has met another branch
constexpr double kSamePart = 0.05;  // nearer to the old branch than this part of the distance: on it
constexpr double kOnPath = 0.25;    // part of the distance that must lie between the corner and the point behind it
constexpr double kBeyond = 4;       // distance of the point that is looked for, in reaches

class CornerTurner {
 public:
  CornerTurner(Flow& flow, BranchStepper* stepper, const BranchPoint& here)
      : flow_(flow), stepper_(stepper), here_(here) {}

  /// With the derivatives of passages that begin at a distance ahead: along the tangent, or if such a one strays over
  /// both sides, with the parameter as it is.
  std::optional<Corner> Try(double reach) {
    Place aside = here_.tangent;
    aside.lambda = 0;
    std::optional<Corner> corner = Try(reach, here_.tangent);
    return corner ? corner : Try(reach, aside);
  }

 private:
  std::optional<Corner> Try(double reach, const Place& direction) {
    try {
      const BranchPoint across = PointAcross(reach, direction);
      std::optional<Corner> best;
      for (const double side : {1.0, -1.0}) {
        std::optional<Corner> corner = Look(across, side, kBeyond * reach);
        if (corner && (!best || corner->distance > best->distance)) best = std::move(corner);
      }
      return best;
    } catch (const std::exception&) {
      return std::nullopt;
    }
  }

  /// `here` with the derivatives that hold on the other side.
  BranchPoint PointAcross(double reach, const Place& direction) {
    Place place = stepper_->Predict(here_.cycle, reach * direction);
    if (const auto forced = flow_.ForcedPeriod(place.lambda)) place.period = *forced;
    Cycle cycle = here_.cycle;
    cycle.passage = flow_.Pass(place.state, place.period, place.lambda, Flow::Derivatives::kAll);
    return stepper_->PointAt(std::move(cycle), here_.tangent);
  }

  std::optional<Corner> Look(BranchPoint from, double side, double distance) {
    from.tangent = side * from.tangent;
    try {
      BranchPoint beyond = stepper_->PointAhead(from, distance);
      const Passage& passage = beyond.cycle.passage;
      const Place way = PlaceOf(beyond.cycle) - PlaceOf(from.cycle);
      const double correction = stepper_->Length(passage, way - distance * from.tangent);
      const bool straight = stepper_->Product(passage, from.tangent, beyond.tangent) > kStraight;
      if (correction > kFarOff * distance || !straight || LiesBehind(beyond, way, distance)) return std::nullopt;
      return Intersect(std::move(beyond), way, distance);
    } catch (const std::exception&) {
      return std::nullopt;
    }
  }

  /// Is a point one of those by which the branch has come?
  bool LiesBehind(const BranchPoint& point, const Place& way, double distance) {
    const double back = -stepper_->Product(point.cycle.passage, way, here_.tangent);
    if (back <= 0) return false;
    BranchPoint from = here_;
    from.tangent = -1.0 * from.tangent;
    try {
      const BranchPoint old = stepper_->PointAhead(from, back);
      // Memory apart: a joint that has slipped a little on the way here keeps that for good.
      const Passage& fewer = FreeComponents(old.cycle.passage).size() < FreeComponents(point.cycle.passage).size()
                                 ? old.cycle.passage
                                 : point.cycle.passage;
      return stepper_->Length(fewer, PlaceOf(point.cycle) - PlaceOf(old.cycle)) < kSamePart * distance;
    } catch (const std::exception&) {
      return false;
    }
  }

  /// Both tangents come closest to each other at  here + a t  and  beyond - b u:  least squares for a and b. Nothing
  /// where that is not ahead of `here`, or not well behind `beyond`, whose tangent then leads to the corner.
  std::optional<Corner> Intersect(BranchPoint beyond, const Place& way, double distance) const {
    const Passage& passage = beyond.cycle.passage;
    const Place &t = here_.tangent, &u = beyond.tangent;
    const double tt = stepper_->Product(passage, t, t), tu = stepper_->Product(passage, t, u);
    const double wt = stepper_->Product(passage, way, t), wu = stepper_->Product(passage, way, u);
    const double determinant = tt - tu * tu;
    const double a = (wt - tu * wu) / determinant, b = (tt * wu - tu * wt) / determinant;
    if (!(a > -kOnPath * distance && b > kOnPath * distance)) return std::nullopt;
    const Place before = PlaceOf(here_.cycle) + a * t, after = PlaceOf(beyond.cycle) - b * u;
    return Corner{std::move(beyond), b, 0.5 * (before.lambda + after.lambda), 0.5 * (before.period + after.period)};
  }

  Flow& flow_;
  BranchStepper* stepper_;
  const BranchPoint& here_;
};

}  // namespace

std::optional<Corner> TurnCorner(Flow& flow, BranchStepper* stepper, const BranchPoint& here, double reach,
                                 double most) {
  CornerTurner turner(flow, stepper, here);
  for (; reach <= most; reach *= kFarther) {
    if (std::optional<Corner> corner = turner.Try(reach)) return corner;
  }
  return std::nullopt;
}

}  // namespace uiclink
