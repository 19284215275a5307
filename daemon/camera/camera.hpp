// The user's camera: at chosen layers a command of the user's takes a picture, and after the print another
// command joins the pictures to a time lapse. The print waits for neither. A picture that cannot be taken is
// counted, and the first one of a print is logged. Event loop's thread only; the commands and the disk are
// waited for on threads of their own.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "core/geometry/units.hpp"
#include "daemon/camera/picture_folders.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/system/event_loop.hpp"
#include "daemon/system/log.hpp"
#include "daemon/system/worker.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {

// The moment of a picture: the plate has been lifted after a layer, or has risen by one.
struct CameraMoment {
  std::string job;
  std::int32_t layer = 0, layers = 0;  // from 0, and their number
  Nanometers height{};                 // of the layer's upper side above the plate
};

// The pictures of a print.
struct CameraFigures {
  std::string job;
  std::uint64_t pictures = 0;             // taken, also before a power cut
  std::uint64_t failed = 0, skipped = 0;  // skipped: the one before was still being taken
  std::optional<std::int32_t> last{};     // the last picture's layer, from 0
  std::string trouble{};                  // why the first failed, a clause
};

class Camera {
 public:
  // Maximum number and size of one print's pictures. Of a print with more layers, fewer are chosen.
  static constexpr std::size_t kMostPictures = 1'000;
  static constexpr std::uintmax_t kMostBytes = std::uintmax_t{1} << 30U;
  // Time for a time lapse.
  static constexpr std::chrono::minutes kFilmTime{10};

  // Does nothing unless the configuration has a camera. All arguments must outlive the object.
  Camera(EventLoop& loop, const Log& log, const PrinterConfig& config);
  // Gives up the commands under way.
  ~Camera();
  Camera(const Camera&) = delete;
  Camera& operator=(const Camera&) = delete;

  // Takes a picture if this layer is chosen and the camera is free.
  void look(const CameraMoment& moment);
  // Files the pictures of a job that has ended, and was filed, with a time lapse. Also to be called at the
  // start, without a job, for those that the last process has left.
  void job_filed(const std::string& job);

  [[nodiscard]] bool exists() const { return camera_.has_value(); }
  // Returns the figures of the print of which a picture was due last; nullopt before the first.
  [[nodiscard]] const std::optional<CameraFigures>& figures() const { return figures_; }

 private:
  // A picture that was taken, or a clause that says why it was not, and how many there are.
  struct Shot {
    std::string trouble;
    std::size_t pictures = 0;
  };

  [[nodiscard]] bool is_chosen(const CameraMoment& moment) const;
  void shoot(const CameraMoment& moment);
  [[nodiscard]] Shot shot(const CameraMoment& moment) const;
  void shot_over(const CameraMoment& moment, const Shot& shot);
  void sum_up(const CameraFigures& figures) const;
  void make_film(const std::string& job);
  // Returns a sentence about the film; empty if there is nothing to tell.
  [[nodiscard]] std::string film(const std::string& job) const;

  const Log& log_;
  std::optional<CameraConfig> camera_;
  std::string printer_;
  std::filesystem::path spool_;
  std::uintmax_t free_bytes_;  // that have to stay free
  PictureFolders folders_;
  FileDescriptor stop_;  // readable when the calls have to end
  std::optional<CameraFigures> figures_;
  bool shooting_ = false;
  Worker shots_, films_;  // last: their threads end before what their tasks use
};

}  // namespace contourd
