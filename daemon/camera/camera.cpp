#include "daemon/camera/camera.hpp"

#include <fmt/format.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <exception>
#include <system_error>
#include <utility>

#include "daemon/camera/camera_call.hpp"
#include "daemon/system/durable_file.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;

// Pictures give way to all other work.
constexpr int kCameraNiceness = 15;
// Time for with-camera to end a command that has run for its whole time, and to send what there is.
constexpr std::chrono::seconds kEndOfCommand{10};
// A time lapse of fewer pictures shows nothing.
constexpr std::size_t kFewestForFilm = 2;

void write_readable(const std::filesystem::path& path, const std::string& bytes) {
  NewFile file(path.parent_path());
  file.let_all_read();
  file.write(bytes);
  file.replace_for_now(path.filename().string());
}

std::string seconds_of(std::chrono::seconds time) {
  return std::to_string(time.count());
}

}  // namespace

Camera::Camera(EventLoop& loop, const Log& log, const PrinterConfig& config)
    : log_(log),
      camera_(config.camera),
      printer_(printable(config.name)),
      spool_(config.spool_folder),
      free_bytes_(config.min_free_disk_bytes),
      folders_(config.spool_folder),
      stop_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      shots_(loop, "contourd-camera", kCameraNiceness),
      films_(loop, "contourd-film", kCameraNiceness) {
  if (!stop_.valid()) throw std::system_error(errno, std::generic_category(), "cannot make an eventfd");
}

Camera::~Camera() {
  (void)::eventfd_write(stop_.get(), 1);
}

bool Camera::is_chosen(const CameraMoment& moment) const {
  const auto layers = std::max(moment.layers, 1);
  const auto fewest =
      (layers + static_cast<std::int32_t>(kMostPictures) - 1) / static_cast<std::int32_t>(kMostPictures);
  const std::int32_t each = std::max(camera_->every_layers, fewest);
  return (moment.layer + 1) % each == 0;
}

void Camera::look(const CameraMoment& moment) {
  if (!camera_ || !is_chosen(moment)) return;
  if (!figures_ || figures_->job != moment.job) figures_ = CameraFigures{.job = moment.job};
  if (figures_->last == moment.layer) return;
  if (std::exchange(shooting_, true)) {
    ++figures_->skipped;
    return;
  }
  shoot(moment);
}

void Camera::shoot(const CameraMoment& moment) {
  shots_.run([this, moment] { return shot(moment); },
             [this, moment](const Shot& shot) { shot_over(moment, shot); });
}

// On the camera's thread; reads only what does not change.
Camera::Shot Camera::shot(const CameraMoment& moment) const {
  const std::filesystem::path folder = folders_.current(moment.job);
  std::size_t pictures = 0;
  try {
    folders_.make(moment.job);
    const StoredPictures stored = pictures_in(folder);
    pictures = stored.layers.size();
    if (pictures >= kMostPictures || stored.bytes + kMostCameraBytes > kMostBytes)
      return {fmt::format("it has {} with {} MB, and a print keeps at most {} pictures and {} MB",
                          count_of(pictures, "picture", "pictures"), stored.bytes / 1'000'000, kMostPictures,
                          kMostBytes / 1'000'000),
              pictures};
    if (std::filesystem::space(folder).available < free_bytes_ + kMostCameraBytes)
      return {"the disk has no room for pictures", pictures};
    const auto limit = std::chrono::duration_cast<std::chrono::seconds>(camera_->time_limit);
    const CameraAnswer answer = call_camera(
        {.socket = camera_->socket,
         .variables = {{"CAMERA", "snapshot"},
                       {"PRINTER", printer_},
                       {"JOB", printable(moment.job)},
                       {"LAYER", std::to_string(moment.layer + 1)},
                       {"LAYERS", std::to_string(moment.layers)},
                       {"HEIGHT_MM", fmt::format("{:.3f}", to_millimeters(moment.height).count())},
                       {"TIME_LIMIT_S", seconds_of(limit)}},
         .patience = limit + kEndOfCommand},
        stop_.get());
    if (!answer.trouble.empty()) return {answer.trouble, pictures};
    if (!is_jpeg(answer.bytes)) return {"its command has made no JPEG picture", pictures};
    write_readable(picture_file(folder, moment.layer), answer.bytes);
    return {"", pictures_in(folder).layers.size()};
  } catch (const std::exception& error) {
    return {error.what(), pictures};
  }
}

void Camera::shot_over(const CameraMoment& moment, const Shot& shot) {
  shooting_ = false;
  if (!figures_ || figures_->job != moment.job) return;
  figures_->pictures = shot.pictures;
  if (shot.trouble.empty()) {
    figures_->last = moment.layer;
    return;
  }
  if (figures_->failed++ > 0) return;
  figures_->trouble = shot.trouble;
  log_.warning("camera",
               fmt::format("{}: no picture of layer {}: {}; the print goes on, and further failures are "
                           "only counted",
                           printable(moment.job), moment.layer + 1, printable(shot.trouble)),
               job_fields(moment.job));
}

void Camera::sum_up(const CameraFigures& figures) const {
  if (figures.pictures + figures.failed + figures.skipped == 0) return;
  log_.info("camera",
            fmt::format("{}: {}, {} failed, {} skipped because the one before was still being taken",
                        printable(figures.job), count_of(figures.pictures, "picture", "pictures"),
                        figures.failed, figures.skipped),
            job_fields(figures.job));
}

void Camera::job_filed(const std::string& job) {
  if (!camera_) return;
  // After the picture that may still be taken of it.
  shots_.run([] { return true; },
             [this, job](bool) {
               if (!job.empty() && figures_ && figures_->job == job) sum_up(*figures_);
               make_film(job);
             });
}

void Camera::make_film(const std::string& job) {
  films_.run(
      [this, job] {
        std::string told = job.empty() ? "" : film(job);
        try {
          folders_.tidy();
        } catch (const std::system_error& error) {
          told = fmt::format("its pictures stay in {}: {}", (spool_ / "pictures").string(), error.what());
        }
        return told;
      },
      [this, job](const std::string& told) {
        if (!told.empty())
          log_.info("camera", fmt::format("{}: {}", printable(job), printable(told)), job_fields(job));
      });
}

// On the film's thread; reads only what does not change.
std::string Camera::film(const std::string& job) const {
  const std::filesystem::path folder = folders_.current(job);
  const std::size_t pictures = pictures_in(folder).layers.size();
  if (pictures < kFewestForFilm) return "";
  const std::chrono::seconds limit = kFilmTime;
  const CameraAnswer answer = call_camera({.socket = camera_->socket,
                                           .variables = {{"CAMERA", "time-lapse"},
                                                         {"PRINTER", printer_},
                                                         {"JOB", printable(job)},
                                                         {"PICTURES", folder.string()},
                                                         {"COUNT", std::to_string(pictures)},
                                                         {"TIME_LIMIT_S", seconds_of(limit)}},
                                           .patience = limit + kEndOfCommand},
                                          stop_.get());
  if (!answer.trouble.empty()) return "no time lapse: " + answer.trouble;
  if (answer.bytes.empty()) return "";
  if (!is_mp4(answer.bytes)) return "no time lapse: its command has made no MP4 film";
  try {
    write_readable(film_file(folder), answer.bytes);
  } catch (const std::exception& error) {
    return fmt::format("no time lapse: {}", error.what());
  }
  return fmt::format("a time lapse of {}", count_of(pictures, "picture", "pictures"));
}

}  // namespace contourd
