#include "vehicle/sweep/link_draws.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>

#include "data/input_error.h"
#include "vehicle/hunting/set_scatter.h"
#include "vehicle/sweep/counter_random.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {
namespace {

void Scatter(const RunSetup& setup, CounterRandom* random, DirectionParameters* link) {
  const double ln_variance = std::log1p(setup.scatter * setup.scatter);
  const auto factor = [&] { return std::exp(std::sqrt(ln_variance) * random->Normal() - 0.5 * ln_variance); };
  link->k *= factor();
  for (Slider<double>& slider : link->sliders) {
    slider.k *= factor();
    slider.T0 *= factor();
  }
}

/// What a set knows of its errors is left out; the spread between links stays.
void ForgetErrors(DirectionParameters* set) {
  if (set->covariance) set->covariance->order.clear(), set->covariance->matrix.clear();
}

/// The one draw of the run's sample.
SetScatter DrawSets(const RunSetup& setup, std::array<CornerLinks, kCorners> links) {
  if (!setup.draw_sets) {
    for (CornerLinks& corner : links) ForgetErrors(&corner.lateral), ForgetErrors(&corner.longitudinal);
  }
  const auto fail = [&](const std::string& message) {
    return InputError(fmt::format("set {}", fmt::join(setup.choice.sets, ", ")), 0, message);
  };
  try {
    SetScatter scatter(links, {.draws = 1,
                               .seed = CounterRandom(setup.seed, setup.sample, "draw").Bits(),
                               .sampling = Sampling::kRandom,
                               .corner = {.from_set = setup.draw_corners}});
    const auto is_factor = &UncertainParameter::is_factor;
    if (setup.draw_sets && std::ranges::all_of(scatter.parameters(), is_factor))
      throw fail("expected a covariance to draw from (identify writes one), found none");
    if (setup.draw_corners && std::ranges::none_of(scatter.parameters(), is_factor))
      throw fail(
          "expected a covariance with a spread between links (identify writes one where records do not share "
          "their link), found none");
    return scatter;
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& fault) {
    throw fail(fault.what());
  }
}

std::string ColumnOf(const UncertainParameter& parameter) {
  std::string column =
      fmt::format("{}_{}_{}", parameter.is_factor ? "factor" : "drawn", Name(parameter.direction), parameter.symbol);
  std::ranges::replace(column, '.', '_');
  if (std::ranges::find(parameter.corners, false) == parameter.corners.end()) return column;
  for (std::size_t corner = 0; corner < kCorners; ++corner)
    if (parameter.corners[corner]) column += fmt::format("_{}", kCornerNames[corner]);
  return column;
}

}  // namespace

std::array<CornerLinks, kCorners> DrawLinks(const RunSetup& setup, const std::array<CornerLinks, kCorners>& links) {
  std::array<CornerLinks, kCorners> drawn = links;
  if (setup.draw_sets || setup.draw_corners) {
    const SetScatter scatter = DrawSets(setup, links);
    const Eigen::VectorXd values = scatter.values().row(0).transpose();
    drawn = scatter.LinksAt(values);
  }
  ScatterLinks(setup, &drawn);
  return drawn;
}

std::vector<DrawnValue> ListDraws(const RunSetup& setup, const std::array<CornerLinks, kCorners>& links) {
  std::vector<DrawnValue> draws;
  if (!setup.draw_sets && !setup.draw_corners) return draws;
  const SetScatter scatter = DrawSets(setup, links);
  for (std::size_t i = 0; i < scatter.parameters().size(); ++i)
    draws.push_back({ColumnOf(scatter.parameters()[i]), scatter.values()(0, static_cast<Eigen::Index>(i))});
  return draws;
}

void ScatterLinks(const RunSetup& setup, std::array<CornerLinks, kCorners>* links) {
  if (!(setup.scatter > 0)) return;
  CounterRandom random(setup.seed, setup.sample, "scatter");
  for (CornerLinks& corner : *links) {
    Scatter(setup, &random, &corner.longitudinal);
    Scatter(setup, &random, &corner.lateral);
  }
}

}  // namespace uiclink
