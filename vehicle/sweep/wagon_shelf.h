#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "vehicle/sweep/link_draws.h"
#include "vehicle/sweep/memo.h"
#include "vehicle/sweep/sweep_axis.h"
#include "vehicle/wagon.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {

/// The wagons of a campaign. Every file is read once, so that its checksum is of what was used; contact tables and
/// wagons are made once and shared by the runs that ask for equal ones. For all threads.
class WagonShelf {
 public:
  /// @param folder  what relative paths are relative to.
  explicit WagonShelf(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// The files of a run, profiles and tables included, without computing anything.
  /// @throws InputError, UsageError as ReadWagonInputs does.
  std::vector<InputFile> Files(const RunSetup& setup);
  /// What has to be said about them (WagonInputs::notices).
  std::vector<std::string> Notices(const RunSetup& setup);
  /// What is drawn from the sets for this run. @throws InputError as ListDraws().
  std::shared_ptr<const std::vector<DrawnValue>> Draws(const RunSetup& setup);

  /// @throws InputError where the wheelset does not fit between the rails; as DrawLinks().
  std::shared_ptr<const Wagon> Get(const RunSetup& setup);

 private:
  using Part = std::shared_ptr<const WagonInputs>;

  Part Body(const RunSetup& setup);
  Part Links(const RunSetup& setup);
  Part Track(const RunSetup& setup);  ///< its files; the table only where it is one
  Part Table(const RunSetup& setup);  ///< with the table
  Wagon Make(const RunSetup& setup);  ///< with the links as in their sets
  std::string Locate(const std::string& text) const;
  std::string LocateSet(const std::string& text) const;

  std::filesystem::path folder_;
  Memo<WagonInputs> bodies_, links_, tracks_;
  Memo<InputFile> profiles_;
  Memo<WagonInputs> tables_{64};  // 0.3 MB each
  Memo<std::vector<DrawnValue>> draws_{64};
  Memo<Wagon> undrawn_{32}, wagons_{32};
};

}  // namespace uiclink
