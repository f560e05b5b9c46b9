#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "identify/report.h"
#include "reports/figure.h"

namespace uiclink {

/// What it takes to repeat a run.
struct Provenance {
  /// An input as it was read.
  struct Input {
    std::string file;
    std::string sha256;  ///< empty where it could not be read
  };
  std::string command;  ///< as it was typed
  std::string written;  ///< "2026-11-22 12:40 UTC"
  std::vector<Input> inputs;
  std::vector<std::pair<std::string, std::string>>
      options;  ///< name and value, the default's where none was given; empty: has none
};

/// A figure of the page, to be written as files of this name too.
struct PageFigure {
  std::string name;  ///< "lateral_records"
  Figure figure;
};

/// The report of a run: a page that needs nothing beside itself, and its figures.
struct ReportPage {
  std::string html;
  std::vector<PageFigure> figures;
};

/// What a report stands on. A view: everything must outlive it.
struct ReportInput {
  const RunResult* run = nullptr;
  /// What was written for the wagon: the identified set, and that of the plain model where causes were named.
  std::span<const ValidationSet> sets = {};
  std::span<const ReadingResiduals> residuals = {};  ///< CalcReadingResiduals(*run)
  const Provenance* provenance = nullptr;
  int threads = 0;               ///< 0: as many as the machine has
  std::string no_pictures = {};  ///< why there are none beside the page; the page says so, and links to none
};

/// Composes the page from what the run has found; every number is one of its JSON. Profiles of the likelihood are
/// fitted here (identify/profiles.h), nothing else is.
ReportPage ComposeReportPage(const ReportInput& input);

/// Writes out/report.html and each figure as out/figures/NAME.svg, .png and .csv, each whole or not at all. Pictures of
/// an earlier run that this one does not have are removed.
/// @returns why there are no pictures; empty where there are.
/// @throws InputError where a file cannot be written.
std::string WriteReportPage(const ReportInput& input, const std::filesystem::path& out);

}  // namespace uiclink
