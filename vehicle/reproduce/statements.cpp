// Sections of chapter 10, and what its summary says in words.

#include "vehicle/reproduce/item.h"

namespace uiclink::reproduce {

const std::vector<Section>& Sections() {
  static const std::vector<Section> sections{
      {"10.1", "Method",
       "The wagon is the thesis's: parabolic vertical springs, links with sliders, guidance, inertias and centre of "
       "mass as its appendix G prints them; the misprints of its equations are corrected. What is not published is "
       "the contact table. With rails and wheels where the text has them (nominal-1435) the linear critical speed of "
       "the empty wagon is a third of the published one; thesis-equivalent moves each rail outwards by one adjusted "
       "number, so that it is 18.4 m/s, and changes nothing else. Half the greatest width of the rail head in place "
       "of the gauge point, or a back-to-back distance of 1357 mm, would have nearly the same effect: 2.5 m/s per "
       "millimetre of gauge. The -rigid variants have contact that jumps, for the wheelset's own weight. Speeds "
       "asked of nominal-1435 lie elsewhere in its diagram; differences there are marked so and not looked into "
       "further."},
      {"10.2.1", "Set 1: critical velocities", ""},
      {"10.2.2", "Set 1: guidance impact behaviour",
       "The thesis does not say from which start its histories were run. Ours hunt at a higher speed first and are "
       "handed down in steps, as its traces are. Set 1 has several motions at one speed for water and packed wagons, "
       "so that another start may lead elsewhere."},
      {"10.3.1", "Set 2: critical velocities", ""},
      {"10.3.2", "Set 2: guidance impact behaviour", ""},
      {"10.4", "Frequency analysis",
       "Lines of the last 20 s of 150 s. Motions whose left and right halves are alike have even multiples of the "
       "lateral frequency lengthwise, so that twice the frequency is what locks."},
      {"10.5", "Summary", ""}};
  return sections;
}

const std::vector<Statement>& Statements() {
  const std::string type_tried =
      "Decided within 0.1 mm by the contact table: ours turns over with the size of the cycle that is asked.";
  const auto higher = [](const std::string& what) {
    return Row{.what = what,
               .theirs = "above 1",
               .place = "10.5",
               .value = "linear_critical_speed",
               .digits = 3,
               .met_range = {{1.0, 100}}};
  };
  static const std::vector<Statement> statements{
      {{.what = "set 1 empty: the Hopf point is supercritical",
        .theirs = "supercritical",
        .place = "10.5",
        .value = "type",
        .met_words = {"supercritical"},
        .tried = type_tried},
       "fig-10.2"},
      {{.what = "set 2 packed: the Hopf point is supercritical",
        .theirs = "supercritical",
        .place = "10.5",
        .value = "type",
        .met_words = {"supercritical"},
        .tried = type_tried},
       "fig-10.24"},
      {{.what = "the trace is late: onset, set 1 empty [m/s]",
        .theirs = "1.6 (18.4 to 20)",
        .place = "10.2.1, 10.5",
        .value = "onset_delay",
        .published = 1.6,
        .met_within = 0.5,
        .why = "Depends on the disturbance at each step, which is not published."},
       "fig-10.1a"},
      {higher("load raises the linear critical speed: set 1, water over empty"), "critical-set1-water", "fig-10.2"},
      {higher("... packed over empty"), "critical-set1-packed", "fig-10.2"},
      {{.what = "load leaves the nonlinear critical speed: death, water over empty",
        .theirs = "about 1",
        .place = "10.5",
        .value = "death",
        .published = 1,
        .met_within = 0.1},
       "fig-10.1c",
       "fig-10.1a"},
      {{.what = "worst between the critical speeds: largest amplitude, set 1 empty, at [m/s]",
        .theirs = "9 to 18.4",
        .place = "10.5",
        .value = "largest_at",
        .met_range = {{9, 18.4}}},
       "fig-10.1a"},
      {{.what = "no lateral impact at high speed: set 1 empty, 40 m/s",
        .theirs = "none",
        .place = "10.5",
        .value = "impacts",
        .met_words = {"none"}},
       "fig-10.7"},
      {{.what = "no lateral impact with set 2: empty, whole trace",
        .theirs = "none",
        .place = "10.5",
        .value = "impacts",
        .met_words = {"none"}},
       "fig-10.22"},
      {higher("linear critical speed: set 2 over set 1, empty"), "critical-set2-empty", "fig-10.2"},
      {higher("... packed"), "fig-10.24", "critical-set1-packed"},
      {{.what = "friction leaves a new equilibrium: set 2 empty after a lap [mm]",
        .theirs = "yes",
        .place = "10.5",
        .value = "shift_after_lap",
        .digits = 4,
        .met_range = {{1e-3, 1}}},
       "fig-10.22"},
      {{.what = "components keep in step: set 1 empty, 24 m/s",
        .theirs = "yes",
        .place = "10.5",
        .value = "in_step",
        .met_words = {"yes"}},
       "table-10.1-empty"}};
  return statements;
}

}  // namespace uiclink::reproduce
