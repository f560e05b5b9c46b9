#pragma once

#include <span>

#include "identify/extended_fit.h"

namespace uiclink {

/// How well an extension predicts what it was not fitted to, against the model without it.
struct HeldOut {
  bool known = false;     ///< there was something to hold out
  double rms_before = 0;  ///< [m], held-out readings, model without
  double rms_after = 0;   ///< [m], model with
  int folds = 0;
  bool by_time = false;  ///< one record only: its later part was held out

  double Gain() const { return 1 - rms_after / rms_before; }
};

/// Leaves out one record after the other (at most five groups of them): the shared parameters of the effects are fitted
/// to the others and stay as they are; in the record that is left out only its start is fitted, and its link, where the
/// records do not share one. A single record is fitted to its first 60 % and predicted to its end.
/// @param before, after  fits of all records, of which those without a record start.
HeldOut PredictHeldOut(std::span<const FitData> data, Sharing sharing, const Extension& without,
                       const ExtendedState& before, const Extension& with, const ExtendedState& after, int threads);

}  // namespace uiclink
