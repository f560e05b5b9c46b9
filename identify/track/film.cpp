#include "identify/track/film.h"

#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <system_error>

#include "data/input_error.h"

namespace uiclink::track {

struct FilmReader::Capture {
  cv::VideoCapture video;
  cv::Mat frame, grey;
  std::optional<double> stamp;
  std::size_t pictures = 0;
};

namespace {

void RequireFile(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw InputError(path.string(), 0, "expected a film, found no such file");
  if (std::filesystem::is_directory(status)) throw InputError(path.string(), 0, "expected a film, found a folder");
  if (std::filesystem::is_character_file(status)) throw InputError(path.string(), 0, "expected a film, found a device");
}

}  // namespace

FilmReader::FilmReader(const std::filesystem::path& path) : capture_(std::make_unique<Capture>()) {
  RequireFile(path);
  // Lines of OpenCV and FFmpeg are not for users; who wants them sets the variable.
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", /*overwrite=*/0);
  try {
    capture_->video.open(path.string(), cv::CAP_FFMPEG);
  } catch (const cv::Exception&) {
    capture_->video.release();
  }
  if (!capture_->video.isOpened() || width() < 1 || height() < 1) {
    throw InputError(path.string(), 0,
                     "expected a film (MP4, MKV, AVI, MOV, ... as FFmpeg reads them), found none; is the file whole?");
  }
}

FilmReader::~FilmReader() = default;

bool FilmReader::Next() {
  Capture& c = *capture_;
  if (!c.video.grab() || !c.video.retrieve(c.frame) || c.frame.empty()) return false;
  const double stamp = 1e-3 * c.video.get(cv::CAP_PROP_POS_MSEC);
  // OpenCV says 0 where it knows of no time stamp, as for the last pictures that a decoder holds back
  // (opencv/opencv#22141). The first picture may well be at 0.
  c.stamp = stamp > 0 || c.pictures == 0 ? std::optional(stamp) : std::nullopt;
  ++c.pictures;
  if (c.frame.channels() == 1) {
    c.grey = c.frame;
  } else {
    cv::cvtColor(c.frame, c.grey, cv::COLOR_BGR2GRAY);
  }
  return true;
}

GrayView FilmReader::gray() const {
  const cv::Mat& grey = capture_->grey;
  return {grey.data, grey.cols, grey.rows, static_cast<std::ptrdiff_t>(grey.step[0])};
}

std::optional<double> FilmReader::stamp() const { return capture_->stamp; }
int FilmReader::width() const { return static_cast<int>(capture_->video.get(cv::CAP_PROP_FRAME_WIDTH)); }
int FilmReader::height() const { return static_cast<int>(capture_->video.get(cv::CAP_PROP_FRAME_HEIGHT)); }

double FilmReader::nominal_rate() const {
  const double rate = capture_->video.get(cv::CAP_PROP_FPS);
  return rate > 0 && rate < 1e6 ? rate : 0;
}

std::optional<std::size_t> FilmReader::count() const {
  const double count = capture_->video.get(cv::CAP_PROP_FRAME_COUNT);
  return count >= 1 && count < 1e9 ? std::optional(static_cast<std::size_t>(count)) : std::nullopt;
}

}  // namespace uiclink::track
