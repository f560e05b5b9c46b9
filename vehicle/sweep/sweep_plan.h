#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "vehicle/sweep/campaign.h"
#include "vehicle/sweep/wagon_shelf.h"

namespace uiclink {

/// The runs of a campaign: every point of the grid with every sample, numbered from 0. The grid's last axes change
/// fastest, so that runs that follow each other share a wagon. Constant; for all threads.
class SweepPlan {
 public:
  /// Reads all input files. @throws InputError, UsageError for one that cannot be used.
  explicit SweepPlan(Campaign campaign);

  std::size_t size() const { return size_; }
  const Campaign& campaign() const { return campaign_; }
  WagonShelf& shelf() const { return *shelf_; }
  const std::vector<InputFile>& files() const { return files_; }  ///< each once
  const std::vector<std::string>& notices() const { return notices_; }

  /// Values by axis; none: as in the files.
  std::vector<std::optional<AxisValue>> Values(std::size_t run) const;
  std::optional<std::uint32_t> Sample(std::size_t run) const;
  RunSetup Setup(std::size_t run) const;
  /// Columns of what is drawn from sets (link_draws.h), and a run's values in their order; none where its sets have no
  /// such parameter.
  const std::vector<std::string>& drawn_columns() const { return drawn_columns_; }
  std::vector<std::optional<double>> Drawn(std::size_t run) const;

  /// SHA-256 of everything that the run's result depends on: the values of all axes, checksums of all its files, kind
  /// and options, and where something is drawn the sample and its seed. Neither the number of the run nor other runs of
  /// the campaign have a part in it.
  std::string Id(std::size_t run) const;
  /// The text that this is the checksum of.
  std::string Identity(std::size_t run) const;

  /// Columns of the store: what varies, what [base] says, and what everybody asks for.
  std::vector<std::size_t> ShownAxes() const;

 private:
  struct Place {
    std::vector<std::size_t> grid;  ///< index of the value, by grid axis
    std::uint32_t sample = 0;
  };
  Place Find(std::size_t run) const;
  std::uint64_t Seed(const Place& place) const;
  void ReadFiles();
  const std::string& FilesText(const RunSetup& setup) const;

  Campaign campaign_;
  std::size_t size_ = 0;
  std::shared_ptr<WagonShelf> shelf_;
  std::vector<InputFile> files_;
  std::vector<std::string> notices_;
  std::vector<std::string> drawn_columns_;
  std::map<std::string, std::string> file_texts_;  ///< by FilesKey
};

}  // namespace uiclink
