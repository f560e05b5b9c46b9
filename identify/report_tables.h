#pragma once

#include <string>
#include <vector>

#include "identify/report.h"
#include "reports/text_table.h"

namespace uiclink {

/// Tables and sentences of a result that are the same wherever they are shown.

/// "lateral_01.txt" of "measurements/lateral_01.txt".
std::string FileName(const std::string& path);

TextTable MakeRecordTable(const Identification& id);     ///< used records: frequency method and fit
TextTable MakeParameterTable(const Identification& id);  ///< of the plain model, beside the frequency method
TextTable MakeBiasTable(const Identification& id);       ///< of the published method; no rows where there is none
TextTable MakeChoiceTable(const Identification& id);     ///< of the number of sliders; no rows where it was not asked

/// The published k against the fit, in a sentence; empty where the method found nothing.
std::string DescribeBias(const Identification& id);
std::string DescribeSharing(const Identification& id);
/// Scattered starts, rms against noise, what is not determined.
std::vector<std::string> DescribeTrust(const Identification& id);

TextTable MakeLinkTable(const Identification& id, const Diagnosis& diagnosis);  ///< plain against extended values
TextTable MakeEffectTable(const std::vector<EffectEstimate>& effects);
TextTable MakeGainTable(const Identification& id, const Diagnosis& diagnosis);
TextTable MakeCandidateTable(const Diagnosis& diagnosis);
std::string DescribeCandidates();  ///< what its columns mean

/// Which effects do as well in its place, and what would separate them.
std::string DescribeRivals(const Cause& cause);
/// A named cause: its signature, its probability, its rivals and what would separate them, what it repairs.
std::string DescribeCause(const Diagnosis& diagnosis, const Cause& cause);
/// Why effects that fit cannot be; empty where none is impossible.
std::string DescribeImpossible(const Diagnosis& diagnosis);
/// Effects that such records cannot show, a sentence each.
std::vector<std::string> DescribeUnseen();
std::string DescribeMissingForce(const Diagnosis& diagnosis);
/// What the plain model gets wrong, surest first, and biases of the method; at most `most` of the former.
struct SymptomWords {
  std::vector<std::string> of_model, of_method;
  std::size_t more = 0;  ///< left out
};
SymptomWords DescribeSymptoms(const Diagnosis& diagnosis, std::size_t most);
/// What became of the records' scatter with the causes in the model; empty where nothing changed.
std::string DescribeSharingChange(const Identification& id, const ExtendedResult& extended);

/// "friction of the rolling joints (rolling_friction)"
std::string NameOf(const Effect& effect);
/// "T_r = 0.00030 (95 %: 0.00029 to 0.00031), ..."
std::string ListParameters(const std::vector<EffectEstimate>& parameters);
/// "49.4", "1.00"
std::string FormatRatio(double ratio);
std::string FormatMm(double metres);
std::string FormatP(double p);

TextTable MakeWagonTable(const Validation& validation);
/// What rows and columns mean, what has to be said about the sets, what the missing cause costs: a paragraph each.
std::vector<std::string> DescribeWagon(const Validation& validation);

}  // namespace uiclink
