#include "identify/symptom_inputs.h"

#include "identify/fit_problem.h"

namespace uiclink {

SymptomInputs::SymptomInputs(const Identification& identification) {
  for (const std::size_t i : identification.UsedIndices()) {
    const RecordResult& r = identification.records[i];
    const FitData data = r.Data();
    Levels levels;
    Shape shape;
    FromOscillator(r.link, &levels, &shape);
    const Linearisation linear = Linearise(data, levels, shape, r.start);

    auto held = std::make_unique<Held>();
    held->modelled.assign(r.record.y.begin() + static_cast<std::ptrdiff_t>(data.first),
                          r.record.y.begin() + static_cast<std::ptrdiff_t>(data.first + data.size));
    for (std::size_t j = 0; j < data.size; ++j)  // the residual is model minus reading, in units of sigma
      held->modelled[j] += data.sigma * linear.residuals[static_cast<Eigen::Index>(j)];
    const Eigen::Index starts = 3, link = linear.jacobian.cols() - starts;
    held->own = identification.shared ? Eigen::MatrixXd(linear.jacobian.rightCols(starts)) : linear.jacobian;
    if (identification.shared) held->common = linear.jacobian.leftCols(link);

    SymptomInput input;
    input.record = &r.record;
    input.first = data.first;
    input.size = data.size;
    input.modelled = held->modelled;
    input.sigma = data.sigma;
    input.quantum = r.noise.quantum;
    input.offset = r.start[2];
    input.link = r.link;
    input.sine = r.sine ? &*r.sine : nullptr;
    input.own = &held->own;
    input.common = identification.shared ? &held->common : nullptr;
    inputs_.push_back(input);
    held_.push_back(std::move(held));
  }
}

Symptoms FindSymptoms(const Identification& identification) {
  return FindSymptoms(SymptomInputs(identification).inputs(), identification.direction);
}

}  // namespace uiclink
