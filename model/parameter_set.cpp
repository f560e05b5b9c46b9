#include "model/parameter_set.h"

namespace uiclink {

const char* Name(Direction direction) { return direction == Direction::kLateral ? "lateral" : "longitudinal"; }

double DirectionParameters::SumOfSliderStiffness() const {
  double sum = 0;
  for (const Slider<double>& slider : sliders) sum += slider.k;
  return sum;
}

double DirectionParameters::SumOfSliderForce() const {
  double sum = 0;
  for (const Slider<double>& slider : sliders) sum += slider.T0;
  return sum;
}

const std::optional<DirectionParameters>& ParameterSet::operator[](Direction direction) const {
  return direction == Direction::kLateral ? lateral : longitudinal;
}

std::vector<std::string> ParameterSymbols(int n) {
  std::vector<std::string> symbols = {"k"};
  for (int i = 1; i <= n; ++i) symbols.push_back("k" + std::to_string(i));
  for (int i = 1; i <= n; ++i) symbols.push_back("T0" + std::to_string(i));
  return symbols;
}

}  // namespace uiclink
