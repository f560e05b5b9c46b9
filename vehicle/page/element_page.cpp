// The pages of `wagon element` and `wagon inertia`.

#include <fmt/format.h>

#include "vehicle/inertia.h"
#include "vehicle/inertia_report.h"
#include "vehicle/page/pages.h"

namespace uiclink {

std::string ComposeElementPage(const ElementReport& report, const WagonInputs& inputs, const PageOrigin& origin) {
  WagonBook book(report.title, origin);
  book.Answer(report.answer);
  book.Notices(inputs.notices);
  for (const auto& [name, figure] : report.figures) book.Draw(name, figure, figure.title);
  book.page().Table("The runs", report.table);
  for (const std::string& remark : report.remarks) book.page().Paragraph(remark);
  return book.Finish(inputs.files);
}

std::string ComposeInertiaPage(const WagonInputs& inputs, std::span<const Freight> freights, const PageOrigin& origin) {
  WagonBook book("Mass and inertia: " + inputs.data.name, origin);
  const InertiaOptions& options = inputs.choice.inertia;
  std::string answer;
  for (const Freight& freight : freights) {
    const BodyInertia body = CalcBodyInertia(inputs.data, freight, options);
    answer += fmt::format(
        "{}With freight \"{}\" the car body has {:.2f} t, its centre of mass {:.2f} m above the underframe.",
        answer.empty() ? "" : " ", freight.name, 1e-3 * body.m, body.h);
  }
  book.Answer(answer);
  book.Notices(inputs.notices);
  book.page().Table("With freight", MakeFreightTable(inputs.data, freights, options));
  book.page().Table("Parts of the empty body", MakePartTable(inputs.data, options));
  book.page().Paragraph(DescribeInertiaOptions(options));
  return book.Finish(inputs);
}

}  // namespace uiclink
