// The page of `wagon stability`.

#include <fmt/format.h>

#include <algorithm>

#include "vehicle/page/pages.h"

namespace uiclink {
namespace {

const Crossing* FindCritical(const StabilityRun& run) {
  const auto found = std::ranges::find_if(
      run.result.crossings, [&](const Crossing& crossing) { return run.result.linear_critical_speed == crossing.V; });
  return found == run.result.crossings.end() ? nullptr : &*found;
}

std::string DescribeType(const StabilityRun& run, const Crossing& critical) {
  const auto at = static_cast<std::size_t>(&critical - run.result.crossings.data());
  if (at >= run.types.size()) return "";
  const std::string& type = run.types[at].type;
  if (type == "subcritical")
    return "It sets in with a jump (a subcritical Hopf bifurcation), so that a push can make the wagon hunt below this "
           "speed already: wagon bifurcation says from where on.";
  if (type == "supercritical")
    return "It sets in gently (a supercritical Hopf bifurcation): just above this speed hunting is small. That does "
           "not "
           "rule out larger hunting below it, which a push may set off: wagon bifurcation looks for that.";
  return "";
}

std::string DescribeBounds(const PageBounds& bounds) {
  if (bounds.scatter == nullptr || bounds.all->empty() || !bounds.all->front().exists()) return "";
  const ScalarBounds& speed = bounds.all->front();
  return fmt::format("With what is known of the links, 95 % of the draws have it between {:.4g} and {:.4g} m/s.",
                     speed.low.value, speed.high.value);
}

std::string DescribeStability(const StabilityRun& run, const PageBounds& bounds) {
  const std::string wagon = DescribeLoadedWagon(run.inputs);
  if (const Crossing* const critical = FindCritical(run)) {
    return JoinSentences(
        {fmt::format("Up to {} {} runs straight by itself: every small disturbance dies out. Above, small disturbances "
                     "grow to hunting, at first {:.2f} times a second.",
                     FormatSpeedTwice(critical->V), wagon, critical->frequency_hz),
         DescribeType(run, *critical), DescribeBounds(bounds)});
  }
  if (run.result.unstable_at_start > 0)
    return fmt::format("{} does not run straight by itself even at {}, the lowest speed that was tried.",
                       wagon == "the empty wagon" ? "The empty wagon" : "The wagon",
                       FormatSpeedTwice(run.options.from));
  return fmt::format("From {:g} m/s to {} {} runs straight by itself: every small disturbance dies out.",
                     run.options.from, FormatSpeedTwice(run.result.searched_to), wagon);
}

}  // namespace

std::string ComposeStabilityPage(const StabilityRun& run, const std::vector<LinearMode>& modes, double V,
                                 const PageBounds& bounds, const PageOrigin& origin) {
  WagonBook book("Stability: " + DescribeWagonOnRails(run.inputs), origin);
  book.Answer(DescribeStability(run, bounds));
  book.page().Paragraph(
      fmt::format("This is about small disturbances, with every joint of the links stuck; {:g} to {:g} m/s were "
                  "searched in steps of {:g} m/s. A steady wagon may still be pushed into hunting.",
                  run.options.from, run.result.searched_to, run.options.step),
      "quiet");
  book.Notices(run.inputs.notices);
  book.page().Heading(2, "Eigenvalues against speed", "root-locus");
  book.Draw("root_locus", RootLocusFigure(run),
            "The slow eigenvalues. Above zero (orange-red) a motion grows; grey lines are the speeds at which one "
            "begins to grow or to die out.");
  if (!run.result.crossings.empty()) book.page().Table("Speeds at which that changes", MakeCrossingTable(run));
  if (!modes.empty()) {
    book.page().Heading(2, "Modes", "modes");
    book.page().Paragraph(fmt::format("How the wagon vibrates by itself at {:.4g} m/s. Negative damping grows.", V));
    book.Draw("modes", ModeFigure(run, modes, V),
              "Shapes from above, enlarged: solid now, dashed a quarter of a period later. Grey lines are the rails.");
    book.page().Table("Amplitudes relative to the largest (metres beside radians), with phases", MakeModeTable(modes));
  }
  book.Bounds("linear critical speed, " + run.inputs.freight.name, bounds);
  return book.Finish(run.inputs);
}

}  // namespace uiclink
