#include "vehicle/hunting/variation.h"

#include <Eigen/QR>
#include <algorithm>
#include <utility>

#include "vehicle/wagon_rate.h"

namespace uiclink {
namespace {

using Eigen::Index;

/// W is brought to fewer columns after so many steps, and each time twice as many later, up to the most. A column is
/// dropped when it is this small beside the largest.
constexpr int kFirstCompression = 16;
constexpr int kCompressEvery = 128;
constexpr double kNegligible = 1e-14;

/// At an event the slopes of the step's own side count, which are had so long after its begin or before its end [s]: a
/// thousand times what the integrator's search for events may be off.
constexpr double kInside = 1e-9;

StateVector<double> MoveInside(StateVector<double> x, const StateVector<double>& rate, double time) {
  for (std::size_t i = 0; i < kMaxState; ++i) x[i] += time * rate[i];
  return x;
}

Index At(std::size_t i) { return static_cast<Index>(i); }

/// Columns for so many of W and that of the parameter, in whole vectors of four.
Index CountColumns(Index rank) { return (rank + 4) / 4 * 4; }

/// Deflections of all links where the motions, or their rates, are x.
void CalcLinkDeflections(const Wagon& wagon, const StateVector<double>& x, Index column, Eigen::MatrixXd* d,
                         Eigen::MatrixXd* v) {
  for (std::size_t corner = 0; corner < kCorners; ++corner) {
    const CornerDeflection<double> at = CalcDeflection(wagon, x, corner);
    (*d)(At(corner), column) = at.dx;
    (*v)(At(corner), column) = at.vx;
    (*d)(At(kCorners + corner), column) = at.dy;
    (*v)(At(kCorners + corner), column) = at.vy;
  }
}

}  // namespace

std::vector<SliderPlace> ListSliders(const Wagon& wagon) {
  std::vector<SliderPlace> sliders;
  for (std::size_t link = 0; link < kLinks; ++link)
    for (std::size_t joint = 0; joint < LinkAt(wagon, link).sliders().size(); ++joint)
      sliders.push_back({.link = link, .joint = joint});
  return sliders;
}

Variation::Variation(const Wagon& wagon, double V, const Eigen::VectorXd& scales, ParameterSlopes* parameter)
    : wagon_(wagon),
      V_(V),
      scales_(scales),
      motions_(At(wagon.size())),
      sliders_(ListSliders(wagon)),
      parameter_(parameter) {
  d_ = v_ = Eigen::MatrixXd::Zero(At(kLinks), motions_);
  // Deflections are linear in the motions.
  for (Index i = 0; i < motions_; ++i) {
    StateVector<double> unit{};
    unit[static_cast<std::size_t>(i)] = 1;
    CalcLinkDeflections(wagon, unit, i, &d_, &v_);
  }
}

void Variation::Resize(Index rank) {
  rank_ = rank;
  const Index columns = CountColumns(rank);
  deviations_.setZero(motions_ + At(sliders_.size()), columns);
  forcing_.setZero(At(kLinks), columns);
  step_.Reserve(static_cast<std::size_t>(columns));
}

void Variation::Begin(const Eigen::MatrixXd& from) {
  Resize(from.cols());
  deviations_.leftCols(rank_) = from;
  weights_ = Eigen::MatrixXd::Identity(rank_, rank_);
  largest_rank_ = 0;
}

void Variation::LoadForcing(const LinkStates& links) {
  if (parameter_ != nullptr) parameter_->SetMode(links);
  forcing_.setZero();
  for (std::size_t i = 0; i < sliders_.size(); ++i) {
    const SliderPlace& place = sliders_[i];
    const Link& link = LinkAt(wagon_, place.link);
    const LinkState::Joint& joint = LinkAt(links, place.link).joints[place.joint];
    if (joint.slides != 0 || (joint.engaged == 0 && link.gap(place.joint) > 0)) continue;
    const double stiffness = link.load() * link.sliders()[place.joint].k;
    forcing_.row(At(place.link)) += stiffness * deviations_.row(motions_ + At(i));
  }
}

void Variation::CalcSlopes(const LinkStates& links, const StateVector<double>& x, std::size_t place) {
  CalcRateSlopes(wagon_, V_, links, x, &slopes_[place]);
  if (parameter_ != nullptr) parameter_->CalcRate(V_, x, &by_parameter_[place]);
}

void Variation::MakeStep(const RecordedRun::Step& step, const LinkStates& links, bool begin_known, bool ends_at_event) {
  const double h = step.t1 - step.t0;
  if (begin_known) {
    std::swap(begin_, end_);
  } else {
    CalcRate(wagon_, V_, links, step.x0, &end_rate_);
    CalcSlopes(links, MoveInside(step.x0, end_rate_, std::min(kInside, 0.01 * h)), begin_);
  }
  const StateVector<double> begin_rate = end_rate_;
  CalcRate(wagon_, V_, links, step.x1, &end_rate_);
  StateVector<double> middle;
  for (std::size_t i = 0; i < kMaxState; ++i)
    middle[i] = 0.5 * (step.x0[i] + step.x1[i]) + 0.125 * h * (begin_rate[i] - end_rate_[i]);
  CalcSlopes(links, middle, middle_);
  const double inside = ends_at_event ? -std::min(kInside, 0.01 * h) : 0;
  CalcSlopes(links, MoveInside(step.x1, end_rate_, inside), end_);

  DeviationStep::ParameterRates by_parameter{};
  if (parameter_ != nullptr)
    by_parameter = {by_parameter_[begin_].data(), by_parameter_[middle_].data(), by_parameter_[end_].data()};
  step_.Make(
      {slopes_[begin_], slopes_[middle_], slopes_[end_]}, h, wagon_.size(),
      {.stride = static_cast<std::size_t>(deviations_.cols()), .parameter_column = static_cast<std::size_t>(rank_)},
      forcing_.data(), deviations_.data(), by_parameter);
}

/// A joint that breaks out from a static peak: its force falls, and what deviates meets the event earlier or later.
/// Both boxes of a wheelset do it together, but deviations part them: each has its own fall and its own moment.
void Variation::BreakOut(const SliderPlace& place, std::size_t slider, const LinkStates& before,
                         const LinkStates& after, const StateVector<double>& x) {
  StateVector<double> old_rate, new_rate;
  CalcRate(wagon_, V_, before, x, &old_rate);
  LinkStates fallen = before;
  LinkAt(fallen, place.link) = LinkAt(after, place.link);
  CalcRate(wagon_, V_, fallen, x, &new_rate);
  const Eigen::Map<const Eigen::VectorXd> flow(old_rate.data(), motions_);
  const Eigen::VectorXd fall = Eigen::Map<const Eigen::VectorXd>(new_rate.data(), motions_) - flow;
  // h = d - p -+ (gap + limit), the limit linear in the velocity.
  const Index link = At(place.link);
  const Link& law = LinkAt(wagon_, place.link);
  const double side = LinkAt(after, place.link).joints[place.joint].slides;
  const double v = v_.row(link) * Eigen::Map<const Eigen::VectorXd>(x.data(), motions_);
  const double growth = (law.CalcBreakoutForce(place.joint, side, v) - law.CalcBreakoutForce(place.joint, side, 0)) /
                        (law.sliders()[place.joint].k * side * v);
  const Eigen::RowVectorXd gradient = d_.row(link) - growth * v_.row(link);
  const double approach = gradient * flow;
  if (approach == 0) return;
  Eigen::RowVectorXd h = gradient * motions() - deviations_.row(motions_ + At(slider));
  if (parameter_ != nullptr) {
    const ParameterSlopes::Deflection moved = parameter_->CalcDeflection(place.link, x);
    h[rank_] += moved.d - growth * moved.v - side * parameter_->CalcBreakoutReach(place, side, v);
  }
  motions() += fall / approach * h;
}

/// The moment of it does not matter: the place at which the spring is relaxed stands still there.
void Variation::Stick(const SliderPlace& place, std::size_t slider, const LinkStates& before, const LinkStates& after,
                      const StateVector<double>& x) {
  const Index link = At(place.link);
  double turn = 0;  // how much sooner or later it sticks, by the velocity [s]
  const double v = v_.row(link) * Eigen::Map<const Eigen::VectorXd>(x.data(), motions_);
  if (LinkAt(wagon_, place.link).needs_acceleration()) {
    StateVector<double> rate;
    CalcRate(wagon_, V_, before, x, &rate);
    const double a = v_.row(link) * Eigen::Map<const Eigen::VectorXd>(rate.data(), motions_);
    if (a != 0) turn = v / a;
  }
  deviations_.row(motions_ + At(slider)) = (d_.row(link) - turn * v_.row(link)) * motions();
  if (parameter_ == nullptr) return;
  const double slid = LinkAt(before, place.link).joints[place.joint].slides;
  const double d = d_.row(link) * Eigen::Map<const Eigen::VectorXd>(x.data(), motions_);
  const double side = slid != 0 ? slid : d > LinkAt(after, place.link).joints[place.joint].p ? 1 : -1;
  const double along = side * std::max(0.0, side * v);
  const double reach =
      slid != 0 ? parameter_->CalcSlidingReach(place, side, along) : parameter_->CalcBreakoutReach(place, side, along);
  const ParameterSlopes::Deflection moved = parameter_->CalcDeflection(place.link, x);
  deviations_(motions_ + At(slider), rank_) += moved.d - turn * moved.v - side * reach;
}

void Variation::PassEvent(const LinkStates& before, const LinkStates& after, const StateVector<double>& x) {
  for (std::size_t i = 0; i < sliders_.size(); ++i) {
    const SliderPlace& place = sliders_[i];
    const LinkState::Joint& was = LinkAt(before, place.link).joints[place.joint];
    const LinkState::Joint& is = LinkAt(after, place.link).joints[place.joint];
    if (was.slides == 0 && is.slides != 0) {
      if (LinkAt(wagon_, place.link).needs_acceleration()) BreakOut(place, i, before, after, x);
    } else if (is.slides == 0 && (was.slides != 0 || was.p != is.p)) {
      Stick(place, i, before, after, x);
    }
  }
}

/// W keeps how large its directions have become, so that what dies out slowly is seen to do so from one compression to
/// the next.
void Variation::Compress() {
  if (rank_ == 0) return;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scales_.cwiseInverse().asDiagonal() * deviations_.leftCols(rank_));
  qr.setThreshold(kNegligible);
  const Index kept = std::max<Index>(qr.rank(), 1);
  if (largest_rank_ == 0) largest_rank_ = kept;
  if (CountColumns(kept) == deviations_.cols()) return;
  const Eigen::MatrixXd Q = qr.householderQ() * Eigen::MatrixXd::Identity(deviations_.rows(), kept);
  Eigen::MatrixXd R = qr.matrixQR().topRows(kept).triangularView<Eigen::Upper>();
  const Eigen::VectorXd sizes = R.rowwise().norm();
  R = sizes.cwiseInverse().asDiagonal() * R;
  weights_ = (R * qr.colsPermutation().inverse()) * weights_;
  const Eigen::VectorXd by_parameter = end_by_parameter();
  Resize(kept);
  deviations_.leftCols(kept) = scales_.asDiagonal() * Q * sizes.asDiagonal();
  deviations_.col(kept) = by_parameter;
}

void Variation::Follow(const RecordedRun& run, const Eigen::MatrixXd& from) {
  Begin(from);
  std::size_t mode = 0;
  int steps = 0, compress_at = kFirstCompression;
  LoadForcing(run.modes[mode]);
  for (std::size_t i = 0; i < run.steps.size(); ++i) {
    const RecordedRun::Step& step = run.steps[i];
    const bool same = step.mode == mode;
    for (; mode != step.mode; ++mode) PassEvent(run.modes[mode], run.modes[mode + 1], step.x0);
    const bool compress = ++steps == compress_at;
    if (compress) {
      Compress();
      compress_at += std::min(steps, kCompressEvery);
    }
    if (!same || compress) LoadForcing(run.modes[mode]);
    const bool goes_on = i + 1 < run.steps.size() && run.steps[i + 1].mode == mode;
    MakeStep(step, run.modes[mode], same && steps > 1, !goes_on);
  }
  for (; mode + 1 < run.modes.size(); ++mode) PassEvent(run.modes[mode], run.modes[mode + 1], run.steps.back().x1);
}

}  // namespace uiclink
