#include "identify/slider_choice.h"

#include <cmath>
#include <limits>

#include "identify/joint_fit.h"

namespace uiclink {
namespace {

/// Independent observations of a record: those of the richest model, whose residuals are nearest to noise, so that all
/// numbers of sliders are judged with the same weight.
std::vector<double> EffectiveSizes(const Identification& richest) {
  std::vector<double> sizes;
  for (const std::size_t i : richest.UsedIndices()) sizes.push_back(richest.records[i].information.effective_size);
  return sizes;
}

double Penalise(const Identification& fit, const std::vector<double>& effective) {
  constexpr int kChoices = kMaxFittedSliders;
  const std::vector<std::size_t> used = fit.UsedIndices();
  double deviance = 0, observations = 0;
  for (std::size_t r = 0; r < used.size(); ++r) {
    const double rms = fit.records[used[r]].rms;
    deviance += effective[r] * std::log(rms * rms);
    observations += effective[r];
  }
  const double levels = 3.0 * (fit.shared ? 1.0 : static_cast<double>(used.size()));
  const double unknowns = levels + 2.0 * (fit.sliders - 1) + 3.0 * static_cast<double>(used.size());
  return deviance + unknowns * std::log(observations) + (fit.sliders > 1 ? 2 * std::log(kChoices) : 0.0);
}

/// rms on records whose levels and starts are fitted, but whose shape comes from the others: every second record is
/// held out, then the rest.
double CalcHeldOutRms(const Identification& fit) {
  const std::vector<std::size_t> used = fit.UsedIndices();
  if (used.size() < 2) return std::numeric_limits<double>::quiet_NaN();
  double squares = 0, samples = 0;
  for (std::size_t fold = 0; fold < 2; ++fold) {
    std::vector<FitData> fitted;
    FitState state;
    state.shape = fit.records[used[1 - fold]].own.state.shape;
    for (std::size_t r = 1 - fold; r < used.size(); r += 2) {
      const RecordResult& record = fit.records[used[r]];
      fitted.push_back(record.Data());
      state.levels.push_back(record.own.state.levels[0]);
      state.starts.push_back(record.own.state.starts[0]);
    }
    const FitOutcome others =
        Fit(fitted, Sharing::kShape, state,
            {.max_iterations = kSloppyIterations, .function_tolerance = kSloppyTolerance, .threads = 1});
    for (std::size_t r = fold; r < used.size(); r += 2) {
      const RecordResult& record = fit.records[used[r]];
      const FitData data = record.Data();
      FitState held = record.own.state;
      held.shape = others.state.shape;
      const FitOutcome outcome =
          Fit({&data, 1}, Sharing::kLink, held,
              {.fix_shape = true, .max_iterations = kSloppyIterations, .function_tolerance = kSloppyTolerance});
      squares += outcome.chi2 * data.sigma * data.sigma;
      samples += static_cast<double>(data.size);
    }
  }
  return std::sqrt(squares / samples);
}

}  // namespace

void ChooseSliders(const IdentifyOptions& options, Identification* result) {
  std::vector<Identification> fits;
  for (int n = 1; n <= kMaxFittedSliders; ++n) {
    fits.push_back(*result);
    fits.back().sliders = n;
    FitAll(options, &fits.back());
  }
  const std::vector<double> effective = EffectiveSizes(fits.back());
  std::vector<SliderChoice> choices;
  for (const Identification& fit : fits)
    choices.push_back({.sliders = fit.sliders,
                       .penalised = Penalise(fit, effective),
                       .held_out_rms = fit.sliders == 1 ? fit.rms : CalcHeldOutRms(fit)});
  std::size_t best = 0;
  for (std::size_t i = 1; i < choices.size(); ++i) {
    const bool likely = choices[i].penalised < choices[best].penalised;
    const bool predicts =
        !(choices[i].held_out_rms >= choices[best].held_out_rms);  // NaN with one record: no objection
    if (likely && predicts) best = i;
  }
  choices[best].chosen = true;
  int evaluations = 0;
  for (const Identification& fit : fits) evaluations += fit.evaluations;
  *result = std::move(fits[best]);
  result->choices = choices;
  result->evaluations = evaluations;
}

}  // namespace uiclink
