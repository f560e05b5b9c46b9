#include "identify/frequency_method_bias.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "identify/link_coordinates.h"

namespace uiclink {
namespace {

/// Sums over the arcs of all records.
struct Bias {
  double published = 0, fitted = 0;               // k [1/m]
  double excess = 0, deviation = 0, squares = 0;  // k_published/k - 1; the same over what is expected, less 1
  double arcs = 0;
  double of_noise = 0;  // variances of k_published/k from noise alone
  double first_k = 0, first_fit = 0, first_expected = 0, first_extremum = 0, records = 0;  // of the first arcs
  double least_extremum = std::numeric_limits<double>::infinity(), k_of_least = 0;

  void Add(const SineFit& sine, const Oscillator<double>& link, double sigma) {
    const double shift = CalcQuantity(link, SumOfFriction(link.size())) / link.k;
    for (const SlidingArc& arc : sine.arcs) {
      const double expected = CalcPublishedBias(arc.extremum, sine.cutoff, shift);
      const double difference = arc.k_published / (link.k * expected) - 1;
      published += arc.k_published, fitted += link.k, ++arcs;
      excess += arc.k_published / link.k - 1, deviation += difference, squares += difference * difference;
      // k ~ 1/(t2 - t1)^2, and the extremum's time is known to about sigma/a of a radian.
      const double of_arc = 2 * sigma / (arc.extremum * std::acos(sine.cutoff / arc.extremum));
      of_noise += of_arc * of_arc;
      if (arc.extremum < least_extremum) least_extremum = arc.extremum, k_of_least = arc.k_published;
    }
    const SlidingArc& first = sine.arcs[0];
    first_k += first.k_published, first_fit += link.k, first_extremum += first.extremum, ++records;
    first_expected += CalcPublishedBias(first.extremum, sine.cutoff, shift) - 1;
  }
};

}  // namespace

void FindFrequencyMethodBias(std::span<const SymptomInput> records, Symptoms* symptoms) {
  Bias bias;
  for (const SymptomInput& input : records)
    if (input.sine != nullptr && !input.sine->arcs.empty()) bias.Add(*input.sine, input.link, input.sigma);
  if (bias.arcs < 2) return;  // one arc has no scatter
  const double mean = bias.deviation / bias.arcs;
  const double scatter = std::max(0.0, bias.squares / bias.arcs - mean * mean) * bias.arcs / (bias.arcs - 1);
  const double variance = std::max(scatter, bias.of_noise / bias.arcs);  // few arcs may agree by chance
  const double error = std::sqrt(variance / bias.arcs);
  symptoms->list.push_back(
      {.id = "frequency_method_bias",
       .sentence = fmt::format(
           "the published frequency method reads k = {:.2f} 1/m at the first extremum ({:.0f} mm), {:.0f} % above the "
           "fit, where a sine about zero must read {:.0f} % too much; at {:.0f} mm it reads {:.2f} 1/m: a bias of the "
           "method, nothing that the link does",
           bias.first_k / bias.records, 1e3 * bias.first_extremum / bias.records,
           100 * (bias.first_k / bias.first_fit - 1), 100 * bias.first_expected / bias.records,
           1e3 * bias.least_extremum, bias.k_of_least),
       .measured = bias.published / bias.arcs,
       .modelled = bias.fitted / bias.arcs,
       .unit = "1/m",
       .z = bias.excess / bias.arcs / error,
       .of_model = false});
}

}  // namespace uiclink
