#include "model/oscillator.h"

#include <stdexcept>
#include <string>

namespace uiclink {

Oscillator<double> MakeOscillator(const DirectionParameters& parameters, double g) {
  if (parameters.sliders.size() > static_cast<std::size_t>(kMaxSliders))
    throw std::invalid_argument("MakeOscillator: " + std::to_string(parameters.sliders.size()) +
                                " sliders, must be at most " + std::to_string(kMaxSliders));
  Oscillator<double> oscillator;
  oscillator.k = parameters.k;
  oscillator.g = g;
  for (const Slider<double>& slider : parameters.sliders) oscillator.Add(slider);
  return oscillator;
}

}  // namespace uiclink
