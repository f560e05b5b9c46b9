#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/parameter_set.h"
#include "reports/csv.h"
#include "reports/figure.h"
#include "reports/text_table.h"
#include "vehicle/element_bench.h"
#include "vehicle/wagon_data.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {

/// The benches of `wagon element`.
enum class ElementBench { kLeafHarmonic, kLeafDrop, kParabolic, kGuidance, kDryFriction };

/// "leaf-harmonic", "leaf-drop", "parabolic", "guidance", "dry-friction": in the order of the enumeration.
const std::vector<std::pair<std::string, ElementBench>>& ElementBenches();
/// @throws std::invalid_argument that lists the names.
ElementBench FindElementBench(std::string_view name);

/// What the benches stand on. Zero and empty mean: as in the thesis.
struct ElementOptions {
  WagonData wagon = {};  ///< springs, parts of the body, g
  double mass = 0;       ///< on one spring [kg]; 0: a quarter of the empty body, and of that with 20 t of freight where
                         ///< both are shown
  std::vector<double> betas = {};  ///< decay constants of the leaf spring [m]; empty: those of figures 5.8 and 5.9
  double amplitude = 0;            ///< of leaf-harmonic [m]; 0: half of the static compression, and half of that
  double frequency = 1;            ///< of parabolic [Hz]
  double mu = 0.13;                ///< friction of the leaves [-]
  bool exaggerated = true;         ///< guidance: clearances of table 6.1 (figure 6.4) ...
  bool true_clearances = true;     ///< ... and true ones (figure 6.5); each by both laws
  double perturbation = 1e-6;      ///< guidance: of y at the start of the second run [m]
  double duration = 0;             ///< [s]; 0: that of each bench
  ParameterSet set = {};           ///< dry-friction
  Direction direction = Direction::kLateral;
  double pull = 0.045;  ///< dry-friction: release [m]
};

/// A table of numbers for a file of its own.
struct ElementSeries {
  std::string name;  ///< "leaf_drop_beta_1e-05"
  std::vector<DataColumn> columns;
};

struct ElementReport {
  std::string title;                                    ///< what was tested
  std::string answer;                                   ///< what came out, in a sentence or two
  TextTable table;                                      ///< a row for each run
  std::vector<std::string> remarks;                     ///< paragraphs about it
  std::string text;                                     ///< all of these but the answer, for the terminal
  std::string json;                                     ///< schema "wagon-element/1"
  std::vector<ElementSeries> series;                    ///< FormatCsv(series.columns) -> name.csv
  std::vector<std::pair<std::string, Figure>> figures;  ///< RenderSvg(figure) -> name.svg
};

/// Runs a bench and describes it. JSON:
///   { "schema": "wagon-element/1", "version", "inputs": { "files" }, "bench": "leaf-drop", "wagon",
///     "runs": [ { what was put in and came out, keys with their units } ] }
/// @param inputs  whose files stand behind the options; nothing else of it is looked at.
/// @throws std::invalid_argument for options that make no sense.
ElementReport MakeElementReport(ElementBench bench, const ElementOptions& options, const WagonInputs& inputs = {});

}  // namespace uiclink
