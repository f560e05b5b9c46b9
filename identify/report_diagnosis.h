#pragma once

#include <string>

#include "identify/diagnosis.h"

namespace uiclink {

/// "0.0180" with as many digits as two significant ones of its uncertainty need.
std::string Round(double value, double uncertainty);

/// The answer of a diagnosis in one paragraph: the verdict, what is missing, and what it gains.
std::string FormatAnswer(const Diagnosis& diagnosis);

}  // namespace uiclink
