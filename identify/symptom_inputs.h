#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "identify/identification.h"
#include "identify/symptoms.h"

namespace uiclink {

/// The used records of an identification as FindSymptoms reads them: modelled readings of the final fit and its
/// tangents.  Holds what the inputs point to; the identification must outlive it.
class SymptomInputs {
 public:
  explicit SymptomInputs(const Identification& identification);
  std::span<const SymptomInput> inputs() const { return inputs_; }

 private:
  struct Held {
    std::vector<double> modelled;
    Eigen::MatrixXd own, common;
  };
  std::vector<std::unique_ptr<Held>> held_;
  std::vector<SymptomInput> inputs_;
};

/// What the plain fit gets wrong.
Symptoms FindSymptoms(const Identification& identification);

}  // namespace uiclink
