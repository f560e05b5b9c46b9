#include "vehicle/hunting/parameter_slopes.h"

#include <stdexcept>
#include <utility>

#include "vehicle/wagon_rate.h"

namespace uiclink {
namespace {

LinkStates Transfer(const LinkStates& links, const Wagon& wagon) {
  LinkStates moved;
  for (std::size_t i = 0; i < kLinks; ++i) LinkAt(moved, i) = LinkAt(links, i).In(LinkAt(wagon, i));
  return moved;
}

}  // namespace

ParameterSlopes::ParameterSlopes(std::shared_ptr<const Wagon> below, std::shared_ptr<const Wagon> above, double width)
    : below_(std::move(below)), above_(std::move(above)), width_(width) {
  if (!(width > 0)) throw std::invalid_argument("ParameterSlopes: expected a width above 0");
}

void ParameterSlopes::SetMode(const LinkStates& links) {
  links_below_ = Transfer(links, *below_);
  links_above_ = Transfer(links, *above_);
}

void ParameterSlopes::CalcRate(double V, const StateVector<double>& x, StateVector<double>* slope) const {
  StateVector<double> low, high;
  uiclink::CalcRate(*below_, V, links_below_, x, &low);
  uiclink::CalcRate(*above_, V, links_above_, x, &high);
  for (std::size_t i = 0; i < below_->size(); ++i) (*slope)[i] = (high[i] - low[i]) / width_;
}

ParameterSlopes::Deflection ParameterSlopes::CalcDeflection(std::size_t link, const StateVector<double>& x) const {
  const auto low = uiclink::CalcDeflection(*below_, x, link % kCorners);
  const auto high = uiclink::CalcDeflection(*above_, x, link % kCorners);
  if (link < kCorners) return {(high.dx - low.dx) / width_, (high.vx - low.vx) / width_};
  return {(high.dy - low.dy) / width_, (high.vy - low.vy) / width_};
}

double ParameterSlopes::CalcReach(ForceLaw law, const SliderPlace& place, double side, double v) const {
  const auto reach = [&](const Wagon& wagon) {
    const Link& link = LinkAt(wagon, place.link);
    return (link.*law)(place.joint, side, v) / link.sliders()[place.joint].k + link.gap(place.joint);
  };
  return (reach(*above_) - reach(*below_)) / width_;
}

}  // namespace uiclink
