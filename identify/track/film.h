#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "identify/track/image.h"

namespace uiclink::track {

/// The pictures of a film, one after the other, in grey.
class FilmReader {
 public:
  /// @throws InputError when the file is no film that can be decoded.
  explicit FilmReader(const std::filesystem::path& path);
  ~FilmReader();

  /// Decodes the next picture. @returns false at the end.
  bool Next();

  GrayView gray() const;                     ///< valid until the next Next()
  std::optional<double> stamp() const;       ///< of this picture, by the container [s]; empty where it has none
  int width() const;                         ///< [pixel]
  int height() const;                        ///< [pixel]
  double nominal_rate() const;               ///< that the container states [Hz]; 0: none
  std::optional<std::size_t> count() const;  ///< pictures that the container states

 private:
  struct Capture;
  std::unique_ptr<Capture> capture_;
};

}  // namespace uiclink::track
