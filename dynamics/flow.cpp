#include "dynamics/flow.h"

namespace uiclink {

std::vector<int> FreeComponents(const Passage& passage) {
  std::vector<bool> fixed(static_cast<std::size_t>(passage.end.size()), false);
  for (const std::vector<int>* set : {&passage.held, &passage.slaved_start})
    for (const int i : *set) fixed[static_cast<std::size_t>(i)] = true;
  std::vector<int> free;
  for (std::size_t i = 0; i < fixed.size(); ++i)
    if (!fixed[i]) free.push_back(static_cast<int>(i));
  return free;
}

}  // namespace uiclink
