#include "identify/diagnose_symptoms.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "identify/symptom_inputs.h"

namespace uiclink {
namespace {

constexpr double kRepaired = 0.5;  // |z| after / before, at most

/// Words of the catalogue for read-outs that have names of their own.
constexpr std::pair<std::string_view, std::string_view> kFamilies[] = {
    {"even_harmonics", "second_harmonic"}, {"odd_harmonics", "third_harmonic"},
    {"rolling_decay", "rolling_loss"},     {"backbone_in_time", "frequency_in_time"},
    {"residual_spectrum", "mains_line"},   {"residual_spectrum", "cross_axis_line"},
    {"residual_spectrum", "unknown_line"}, {"residual_spectrum", "motion_line"},
    {"residual_spectrum", "drift_line"},
};

/// The used records as an extended fit describes them.
class ExtendedInputs {
 public:
  ExtendedInputs(const Identification& identification, const ExtendedResult& extended) {
    const std::vector<std::size_t> used = identification.UsedIndices();
    for (std::size_t r = 0; r < used.size(); ++r) Add(identification.records[used[r]], extended, r);
  }
  std::span<const SymptomInput> inputs() const { return inputs_; }

 private:
  struct Held {
    std::vector<double> modelled;
    Eigen::MatrixXd own, common;
  };

  void Add(const RecordResult& record, const ExtendedResult& extended, std::size_t r) {
    const FitData data = record.Data();
    const ExtendedState& state = extended.outcome.state;
    const Linearisation linear = LineariseExtended(data, extended.extension, state, r);
    if (!linear.residuals.allFinite()) return;
    auto held = std::make_unique<Held>();
    const auto begin = record.record.y.begin() + static_cast<std::ptrdiff_t>(data.first);
    held->modelled.assign(begin, begin + static_cast<std::ptrdiff_t>(data.size));
    for (std::size_t j = 0; j < data.size; ++j)  // the residual is model minus reading, in units of sigma
      held->modelled[j] += data.sigma * linear.residuals[static_cast<Eigen::Index>(j)];
    // What passed for noise before may have been a tone that is named now.
    const double sigma = extended.structure.noise_of_record[r];
    SplitColumns(linear.jacobian * (data.sigma / sigma), extended, held.get());
    inputs_.push_back({.record = &record.record,
                       .first = data.first,
                       .size = data.size,
                       .modelled = held->modelled,
                       .sigma = sigma,
                       .quantum = record.noise.quantum,
                       .offset = state.link.starts[r][2],
                       .link = ToOscillator(state.link.LevelsOf(r), state.link.ShapeOf(r), data.g),
                       .sine = record.sine ? &*record.sine : nullptr,
                       .own = &held->own,
                       .common = held->common.cols() > 0 ? &held->common : nullptr});
    held_.push_back(std::move(held));
  }

  /// Columns of LineariseExtended: levels, shape, start, shared, own.
  static void SplitColumns(const Eigen::MatrixXd& jacobian, const ExtendedResult& extended, Held* held) {
    const auto shape = static_cast<Eigen::Index>(extended.outcome.state.link.shape.size());
    const auto shared = static_cast<Eigen::Index>(extended.extension.shared().size());
    const auto own = static_cast<Eigen::Index>(extended.extension.own().size());
    const bool one_link = extended.sharing == Sharing::kLink;
    std::vector<Eigen::Index> of_record, of_all;
    const auto add = [](Eigen::Index first, Eigen::Index size, std::vector<Eigen::Index>* list) {
      for (Eigen::Index i = 0; i < size; ++i) list->push_back(first + i);
    };
    add(0, kLevels, one_link ? &of_all : &of_record);
    add(kLevels, shape, extended.outcome.state.link.shapes.empty() ? &of_all : &of_record);
    add(kLevels + shape, kStart, &of_record);
    add(kLevels + shape + kStart, shared, &of_all);
    add(kLevels + shape + kStart + shared, own, &of_record);
    held->own = jacobian(Eigen::all, of_record);
    held->common = jacobian(Eigen::all, of_all);
  }

  static constexpr Eigen::Index kLevels = 3, kStart = 3;
  std::vector<std::unique_ptr<Held>> held_;
  std::vector<SymptomInput> inputs_;
};

/// The named causes without those on the reading.
Extension KeepMechanical(const Extension& extension) {
  std::vector<const Effect*> kept;
  for (const Effect* effect : extension.effects())
    if (effect->stage == ReadingStage::kNone) kept.push_back(effect);
  return Extension(kept);
}

/// A record as a sensor without the named effects on the reading would have given it.
Record FreeFromReadingEffects(const RecordResult& record, const ExtendedResult& extended, std::size_t r) {
  Record freed = record.record;
  const FitData data = record.Data();
  const ExtendedState& state = extended.outcome.state;
  const Extension mechanical = KeepMechanical(extended.extension);
  const std::vector<double> all = CalcExtendedResiduals(data, extended.extension, state, r);
  const std::vector<double> without =
      CalcExtendedResiduals(data, mechanical, Convert(extended.extension, state, mechanical), r);
  if (all.size() != data.size || without.size() != data.size) return freed;
  for (std::size_t i = 0; i < data.size; ++i) freed.y[data.first + i] += without[i] - all[i];
  return freed;
}

/// Along the plain link, or where causes are named along that of the extended fit, on readings freed from what the
/// named causes do to the reading.
MissingForce FindForceLeft(const Identification& plain, const Diagnosis& diagnosis) {
  std::vector<Record> freed;
  std::vector<MissingForceInput> inputs;
  const ExtendedState& state = diagnosis.extended.outcome.state;
  const std::vector<std::size_t> used = plain.UsedIndices();
  for (std::size_t r = 0; r < used.size(); ++r)
    if (diagnosis.HasCauses()) freed.push_back(FreeFromReadingEffects(plain.records[used[r]], diagnosis.extended, r));
  for (std::size_t r = 0; r < used.size(); ++r) {
    const RecordResult& record = plain.records[used[r]];
    const FitData data = record.Data();
    const bool extended = diagnosis.HasCauses();
    const Start& start = extended ? state.link.starts[r] : record.start;
    inputs.push_back(
        {.record = extended ? &freed[r] : &record.record,
         .first = data.first,
         .size = data.size,
         .sigma = extended ? diagnosis.extended.structure.noise_of_record[r] : data.sigma,
         .offset = start[2],
         .link = extended ? ToOscillator(state.link.LevelsOf(r), state.link.ShapeOf(r), data.g) : record.link,
         .y0 = start[0],
         .t0 = start[1]});
  }
  return FindMissingForce(inputs);
}

const Symptom* FindSymptom(const Symptoms& symptoms, const std::string& id) {
  const auto found =
      std::find_if(symptoms.list.begin(), symptoms.list.end(), [&](const Symptom& s) { return s.id == id; });
  return found == symptoms.list.end() ? nullptr : &*found;
}

void FindRepairs(const Symptoms& before, const Symptoms& after, Cause* cause) {
  for (const Symptom& symptom : before.list) {
    const auto means = [&](std::string_view word) { return IsRepairOf(word, symptom.id); };
    if (!symptom.IsSignificant() || std::none_of(cause->effect->repairs.begin(), cause->effect->repairs.end(), means))
      continue;
    ++cause->repairable;
    const Symptom* left = FindSymptom(after, symptom.id);
    // A line that is gone has no read-out any more.
    if (left == nullptr || std::abs(left->z) <= kRepaired * std::abs(symptom.z)) cause->repaired.push_back(symptom.id);
  }
}

/// A cause must put right at least one of the read-outs that it should. Where none of the causes does, what they
/// explain they explain by accident: nothing is named.
void WithdrawIdleCauses(Diagnosis* diagnosis) {
  const auto is_idle = [](const Cause& cause) { return cause.repairable > 0 && cause.repaired.empty(); };
  for (const Cause& cause : diagnosis->causes)
    if (is_idle(cause))
      diagnosis->notices.push_back(std::string(cause.effect->id) +
                                   " puts none of the read-outs right that it should; it fits for another reason");
  if (!std::all_of(diagnosis->causes.begin(), diagnosis->causes.end(), is_idle)) return;
  diagnosis->causes.clear();
  diagnosis->extended = diagnosis->plain;
  diagnosis->symptoms_left = {};
  diagnosis->verdict = Verdict::kUnexplained;
}

}  // namespace

bool IsRepairOf(std::string_view word, std::string_view symptom) {
  if (symptom.starts_with(word)) return true;
  return std::any_of(std::begin(kFamilies), std::end(kFamilies),
                     [&](const auto& family) { return family.first == word && family.second == symptom; });
}

void DescribeSymptoms(const Identification& plain, Diagnosis* diagnosis) {
  diagnosis->symptoms = FindSymptoms(plain);
  if (diagnosis->HasCauses()) {
    const ExtendedInputs left(plain, diagnosis->extended);
    diagnosis->symptoms_left = FindSymptoms(left.inputs(), plain.direction);
    for (Cause& cause : diagnosis->causes) FindRepairs(diagnosis->symptoms, diagnosis->symptoms_left, &cause);
    WithdrawIdleCauses(diagnosis);
  }
  const bool is_open = diagnosis->verdict == Verdict::kUnexplained || diagnosis->verdict == Verdict::kPartlyExplained;
  if (is_open) diagnosis->missing_force = FindForceLeft(plain, *diagnosis);
}

}  // namespace uiclink
